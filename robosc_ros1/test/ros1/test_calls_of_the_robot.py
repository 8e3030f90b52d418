"""Services of a generated controller: each call is answered once, or refused with the reason."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from ros1.stage import PATIENCE, Node, Puppet, Stage, event
from ros_support import await_condition

ORDER = {"name": "/order", "type": "std_srvs/SetBool"}
SWITCH = {"name": "/switch", "type": "std_srvs/SetBool"}
BOOL = "std_msgs/Bool"
DONE = {"success": True, "message": "done"}


@contextmanager
def served(stage: Stage, ear: Puppet) -> Iterator[Node]:
    with stage.controller(ear, "orders_controller") as node:
        yield node


def call(puppet: Puppet, of: dict[str, str], data: bool) -> dict[str, Any]:
    """Call, and wait for the answer."""
    mark = puppet.mark
    puppet.do("call", **of, fields={"data": data})
    return puppet.wait(lambda line: line.get("answered") == of["name"], "the answer", since=mark)


def order_and_wait(puppet: Puppet, node: Node) -> int:
    """Call what is not answered while the door is shut; the place of the answer to come."""
    mark = puppet.mark
    puppet.do("call", **ORDER, fields={"data": True})
    node.shows(lambda s: s["communications"]["order"] == "busy", since=node.ear.mark)
    return mark


@pytest.mark.once
def test_a_call_is_answered_when_its_requirement_holds(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with served(stage, ear) as node:
        mark = order_and_wait(puppet, node)
        state = node.shows(lambda s: s["communications"]["order"] == "busy")
        (answer,) = (c for c in state["commands"] if c["event"]["name"] == "order" and
                     c["event"]["kind"] == "response")  # fmt: skip
        assert "requirement order needs Door.open" in str(answer["blocked_by"])
        puppet.publish("/door", BOOL, True)
        answered = puppet.wait(lambda line: line.get("answered") == "/order", "it", since=mark)
        assert answered["message"] == DONE
        node.shows(lambda s: s["communications"]["order"] == "idle", since=ear.mark)
        assert call(puppet, ORDER, True)["message"] == DONE


def test_an_answer_that_does_not_fit_is_not_given(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    """As any other command it is counted as failed, and tried again."""
    with stage.controller(ear, "examiner_controller") as node:
        mark = puppet.mark
        puppet.do("call", name="/examine", type="diagnostic_msgs/SelfTest", fields={})
        node.tells(event("response", "examine", outcome="failed"))
        state = node.shows(lambda s: s["counters"]["failed"] > 0)
        assert state["communications"]["examine"] == "busy"
        puppet.publish("/mark", "std_msgs/Int16", 1)
        answered = puppet.wait(lambda line: line.get("answered") == "/examine", "it", since=mark)
        assert answered["message"]["passed"] == 1


def test_one_call_at_a_time(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with served(stage, ear) as node:
        mark = order_and_wait(puppet, node)
        with stage.puppet() as other:
            refused = call(other, ORDER, True)
            assert "order is busy: it serves one call at a time" in refused["failure"]
        told = node.tells(event("request", "order", outcome="refused"))
        assert told["detail"] == "order is busy: it serves one call at a time"
        puppet.publish("/door", BOOL, True)
        answered = puppet.wait(lambda line: line.get("answered") == "/order", "it", since=mark)
        assert answered["message"] == DONE
        state = node.shows(lambda s: s["communications"]["order"] == "idle", since=ear.mark)
        assert state["counters"]["refused"] == 1


def test_a_call_that_no_component_takes_is_refused_with_the_reason(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with served(stage, ear):
        assert "Switch is in ready" in call(puppet, SWITCH, False)["failure"]
        assert call(puppet, SWITCH, True)["message"]["success"] is True
        assert "switch is taken where" in call(puppet, SWITCH, True)["failure"]
        assert call(puppet, SWITCH, False)["message"]["success"] is False


def test_the_controller_answers_with_an_error(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with served(stage, ear) as node:
        assert "Orders is in unwanted" in call(puppet, ORDER, False)["failure"]
        node.tells(event("error", "order", outcome="applied"))


def test_a_caller_that_is_killed_leaves_the_service_to_others(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with served(stage, ear) as node:
        with stage.puppet() as caller:
            order_and_wait(caller, node)
        puppet.publish("/door", BOOL, True)
        node.tells(event("response", "order"))
        assert call(puppet, ORDER, True)["message"] == DONE


@pytest.mark.once
@pytest.mark.parametrize("waiting", [False, True])
def test_the_end_of_the_node_answers_what_waits(
    stage: Stage, puppet: Puppet, ear: Puppet, waiting: bool
) -> None:
    with served(stage, ear) as node:
        mark = order_and_wait(puppet, node) if waiting else 0
        node.process.send_signal(signal.SIGINT)
        assert node.process.wait(PATIENCE) == 0
        if waiting:
            answered = puppet.wait(lambda line: line.get("answered") == "/order", "it", since=mark)
            assert "failure" in answered


def test_a_flood_of_calls(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    """Whatever comes at once, each call is answered or refused, and none twice."""
    with served(stage, ear) as node:
        puppet.publish("/door", BOOL, True)
        mark = puppet.mark
        for _ in range(100):
            puppet.begin("call", **ORDER, fields={"data": True})

        def answers() -> list[dict[str, Any]]:
            return [line for line in puppet.lines[mark:] if line.get("answered") == "/order"]

        await_condition(lambda: len(answers()) == 100, "all answers")
        done = [a for a in answers() if a.get("message") == DONE]
        refused = [a for a in answers() if "is busy" in a.get("failure", "")]
        assert len(done) + len(refused) == 100 and done
        # Between a call and its answer the node may tell its state, too.
        counted = {"inputs": 1 + len(done), "commands": len(done), "refused": len(refused)}
        node.shows(lambda s: counted.items() <= s["counters"].items())
