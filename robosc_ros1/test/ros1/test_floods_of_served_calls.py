"""Very many calls and goals at once: each is answered or refused, none twice, and nothing is kept."""

from __future__ import annotations

from typing import Any

import pytest
from actionlib_msgs.msg import GoalStatus
from ros1.stage import Node, Puppet, event
from ros1.test_calls_of_the_robot import DONE, ORDER
from ros1.test_goals_of_the_robot import GOAL, NAME, TYPE, step
from ros_support import await_condition, resident

CALLS = 500
AT_ONCE = 100
ROUNDS = 3


def ends(puppet: Puppet, since: int, key: str, name: str) -> list[dict[str, Any]]:
    """What came of ``AT_ONCE`` calls, once all have come."""

    def found() -> list[dict[str, Any]]:
        return [line for line in puppet.lines[since:] if line.get(key) == name]

    await_condition(lambda: len(found()) >= AT_ONCE, "all ends")
    return found()


def flood_calls(puppet: Puppet) -> int:
    """How many were answered; the others were refused."""
    mark = puppet.mark
    for _ in range(AT_ONCE):
        puppet.begin("call", **ORDER, fields={"data": True})
    answers = ends(puppet, mark, "answered", "/order")
    done = [a for a in answers if a.get("message") == DONE]
    refused = [a for a in answers if "is busy" in a.get("failure", "")]
    assert done and len(done) + len(refused) == AT_ONCE == len(answers)
    return len(done)


def flood_goals(puppet: Puppet) -> int:
    mark = puppet.mark
    puppet.do("flood", name=NAME, type=TYPE, fields=GOAL, count=AT_ONCE)
    all_ends = ends(puppet, mark, "ended", NAME)
    done = [e for e in all_ends if e["status"] == GoalStatus.SUCCEEDED]
    rejected = [e for e in all_ends if e["status"] == GoalStatus.REJECTED]
    assert done and len(done) + len(rejected) == AT_ONCE == len(all_ends)
    assert all("is busy" in e["text"] for e in rejected)
    return len(done)


@pytest.mark.parametrize("model", ["orders", "missions"])
def test_five_hundred_leave_nothing_behind(
    puppet: Puppet, nodes: tuple[Node, ...], model: str
) -> None:
    """The memory of nodes after each five hundred is that before, but for a tenth; the first have it
    grow to what it needs."""
    if model == "orders":
        flood, name = flood_calls, "order"
        puppet.publish("/door", "std_msgs/Bool", True)
    else:
        flood, name = flood_goals, "mission"
        step(puppet, 3)
    done, sizes = 0, []
    for _ in range(ROUNDS):
        done += sum(flood(puppet) for _ in range(CALLS // AT_ONCE))
        sizes.append([resident(node.process.pid) for node in nodes])
    assert all(after <= 1.1 * before for before, after in zip(*sizes[-2:], strict=True)), sizes
    counted = {"refused": ROUNDS * CALLS - done, "mismatches": 0}
    first = nodes[0]
    first.shows(lambda s: counted.items() <= s["counters"].items())
    answers = event("response", name, outcome="applied")
    await_condition(lambda: all(len(n.events(answers)) == done for n in nodes), "their events")
    for node in nodes:
        node.shows(lambda s: s["communications"][name] == "idle", since=node.ear.mark)
