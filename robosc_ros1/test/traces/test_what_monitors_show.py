"""What scripts show to supervisors and monitors: goals in the place of others, feedback, states."""

from __future__ import annotations

import re

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.golden_packages import GOLDEN
from emit.scripted_controllers import scripts_of, tells_apart

from robosc.traces.scripts import Traces, choose, requirement_rows, script

COURIER = (GOLDEN / "models" / "courier.rscd").read_text(encoding="utf-8")
HOIST = (GOLDEN / "models" / "hoist.rscd").read_text(encoding="utf-8")


def lines_of(traces: Traces) -> list[str]:
    """The lines of all scripts."""
    supervisor = traces.coverage.steps.supervisor
    return [t for run in traces.runs for t in script(supervisor, run, "run").splitlines()]


@pytest.mark.parametrize("follows", [False, True])
def test_a_goal_takes_the_place_of_another_one(follows: bool) -> None:
    """Also one that is not allowed to, after which the former one goes on."""
    traces = choose(supervisor_of(COURIER, supervises=True), follows=follows)
    busy, replaced = False, set()
    asked = ""
    for line in lines_of(traces):
        event = line.partition(" ")[0]
        if event == "go.request":
            asked = "asked" if busy else "first"
        elif line.startswith("expect sent") and asked:
            replaced |= {line == "expect sent go.request"} if asked == "asked" else set()
            busy |= follows or line == "expect sent go.request"
            asked = ""
        elif event in ("go.response", "go.error", "go.cancelled") or event == "#":
            busy = False
    assert replaced == {True, False}


def test_a_goal_in_the_place_of_another_one_is_not_rejected() -> None:
    """Its error has another reason then, since something was begun."""
    busy, is_second = False, False
    rejected = []
    for line in lines_of(choose(supervisor_of(COURIER, supervises=True))):
        if line == "expect sent go.request":
            busy, is_second = True, busy
        elif line.startswith("go.error"):
            rejected += [is_second] if line in ("go.error", "go.error reason: rejected") else []
            busy = False
        elif re.match("go.(response|cancelled)|# run", line):
            busy = False
    assert not any(rejected)


def test_monitors_are_shown_feedback() -> None:
    traces = choose(supervisor_of(COURIER, supervises=True), follows=True)
    assert any(line.startswith("go.feedback") for line in lines_of(traces))


def test_monitors_find_states() -> None:
    """A cabin that rises with an open door: what another controller may do, and ours never does."""
    supervisor = supervisor_of(HOIST, supervises=True)
    traces = choose(supervisor, follows=True, judges_states=True)
    text = "requirement never Cabin.moving and Cabin.open"
    is_open, found = False, []
    for line in lines_of(traces):
        if line.startswith(("# run", "door.response")):
            is_open = line == "door.response true"
        if line == f"expect violated {text}":
            found.append(is_open)
    assert found
    assert all(found)
    rows = {row[0]: row[2:] for row in requirement_rows(supervisor, traces)}
    assert all(runs for runs, _ in rows[text])
    unseen = choose(supervisor, follows=True)
    assert not any("violated" in line for line in lines_of(unseen))


ENDLESS = """
robot Endless {
    component Lamp {
        outgoing message go with type: boolean
        outgoing message more with type: boolean
        incoming message lit with type: boolean
        behaviour {
            variable on_: boolean = false
            variable also: boolean = false
            on response from go do on_ := value
            on response from more do also := value
            initial marked state one { transition if on_ and also goto two }
            state two { transition if also goto one }
        }
    }
    requirement lit needs Lamp.on_
    provide lit with Lamp.also
}
"""


def test_scripts_end_before_transitions_that_never_end() -> None:
    supervisor = supervisor_of(ENDLESS)
    scripts = scripts_of(supervisor)
    assert any("expect sent lit.request" in text for text in scripts)
    assert tells_apart(supervisor, scripts, controller_source(supervisor)) == []
    for text in scripts:
        events = re.findall("^(go|more).response (.*)$", text, re.MULTILINE)
        on_ = {"go": "false", "more": "false"}
        for name, value in events:
            on_[name] = value
            assert set(on_.values()) != {"true"}


SORTED = """
robot Sorted {
    interface batch use Batch from own_msgs
    datatype object Item { size: double label: string }
    datatype enum Sort from integer to { value = 0 -> nothing  value > 100 -> box  default -> other }
    datatype object Load { kind: Sort items: array(Item) }
    component Eye {
        outgoing message seen with type: Load links batch
        incoming message lamp with type: boolean
        behaviour {
            variable sort: Sort = nothing
            variable second: Item
            variable far: boolean = false
            initial marked state on_ {
                on response from seen do
                    sort := value.kind, second := value.items[1], far := value.items[0].size > 3.0
            }
        }
    }
    requirement lamp needs Eye.sort = box and Eye.far and Eye.second.size > 1.0
    provide lamp with true
}
"""


def test_what_enums_convert_is_sent_once() -> None:
    """Beside whatever else the message has; each number of the rules and those beside it."""
    (run,) = scripts_of(supervisor_of(SORTED))
    kinds = set(re.findall(r"^seen.response .*kind: (-?\d+)", run, re.MULTILINE))
    assert {"-1", "0", "1", "99", "100", "101"} <= kinds


CALLED = """
robot Called {
    component Desk {
        outgoing service order with type: std_srvs/SetBool
        behaviour {
            initial marked state free { on request from order if value.data goto taken }
            state taken { on response, error to order goto free }
        }
    }
    provide order with { success: true }
}
"""


def test_another_controller_does_not_answer_by_errors_on_ros_2() -> None:
    """Its service can only answer, and the answer would pass."""
    supervisor = supervisor_of(CALLED, supervises=True)
    told = [
        any(line == "order.error" for line in lines_of(choose(supervisor, mute=mute)))
        for mute in ((), ("Desk.order",))
    ]
    assert told == [True, False]
