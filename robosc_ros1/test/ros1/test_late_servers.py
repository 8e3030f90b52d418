"""What was decided while its server was absent is sent only if it is allowed when that appears: the
server itself, which hears what is on the wire, judges."""

from __future__ import annotations

import pytest
from ros1.stage import Node, Puppet, Stage, event

SERVICE = {"name": "/ask", "type": "gauntlet_interfaces/SetLevel"}
ACTION = {"name": "/run", "type": "gauntlet_interfaces/ReachAction"}
BOOL = "std_msgs/Bool"
OPERATE = "/probe_controller/operate"


def is_busy(node: Node, name: str) -> None:
    node.shows(lambda s: s["communications"][name] == "busy")


def asked(puppet: Puppet) -> list[str]:
    with puppet._changed:
        return [line["asked"] for line in puppet.lines if "asked" in line]


@pytest.mark.parametrize("event_of", ["e-stop", "hold"])
def test_nothing_is_sent_that_is_not_allowed_any_more(
    stage: Stage, puppet: Puppet, ear: Puppet, event_of: str
) -> None:
    with stage.controller(ear, timeout__ask=30.0, timeout__run=30.0, operate=True) as node:
        puppet.publish("/ask_wanted", BOOL, True)
        puppet.publish("/run_wanted", BOOL, True)
        is_busy(node, "ask")
        is_busy(node, "run")
        mark = ear.mark
        if event_of == "hold":
            puppet.publish(OPERATE, "std_msgs/String", "hold")
            node.tells(event("error", "ask", reason="absent"), since=mark)
            node.tells(event("error", "run", reason="absent"), since=mark)
        else:
            puppet.publish("/ask_wanted", BOOL, False)
            puppet.publish("/run_wanted", BOOL, False)
            node.tells(event("cancelled", "run"), since=mark)
        puppet.do("service", **SERVICE, mode="answer")
        puppet.do("action", **ACTION, mode="succeed")
        if event_of == "e-stop":
            node.tells(event("error", "ask", reason="absent"), since=mark)
        else:
            mark = ear.mark
            puppet.publish(OPERATE, "std_msgs/String", "release")
            puppet.wait(lambda line: line.get("asked") == "/run", "the goal, after the release")
            node.tells(event("response", "run"), since=mark)
        assert asked(puppet).count("/ask") == 0 or event_of == "hold"
        assert "/run" not in asked(puppet) or event_of == "hold"


def test_a_step_calls_a_service_that_was_not_called_before(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    """The node has no connection to it yet."""
    puppet.do("service", **SERVICE, mode="answer")
    with stage.controller(ear, operate=True) as node:
        puppet.publish(OPERATE, "std_msgs/String", "hold")
        puppet.publish("/reading", "std_msgs/Float32", 40.0)
        node.shows(lambda s: s["variables"]["Switches.reading"] == "warm")  # which forbids halt
        puppet.publish("/ask_wanted", BOOL, True)
        node.shows(lambda s: s["stopped"] and s["variables"]["Switches.ask"])
        puppet.publish(OPERATE, "std_msgs/String", "step")
        node.tells(event("response", "ask"))
        assert asked(puppet) == ["/ask"]


def test_what_is_allowed_is_sent_when_its_server_appears(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear, timeout__ask=60.0) as node:
        puppet.publish("/ask_wanted", BOOL, True)
        is_busy(node, "ask")
        puppet.publish("/level", "std_msgs/Int16", 4)
        node.shows(lambda s: s["variables"]["Switches.height"] == 4)
        puppet.do("service", **SERVICE, mode="answer")
        node.tells(event("response", "ask"))
        first = puppet.wait(lambda line: line.get("asked") == "/ask", "the request")
        assert first["message"] == {"level": 4}, "the data of the moment"


def test_a_goal_of_somebody_else_makes_the_server_busy(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    puppet.do("action", **ACTION, mode="hold")
    with stage.controller(ear, timeout__run=60.0) as node:
        puppet.do("shout", name="/run", count=1)
        node.shows(lambda s: any("did not send" in fault for fault in s["faults"]))
        number = len(asked(puppet))
        puppet.publish("/run_wanted", BOOL, True)
        is_busy(node, "run")
        mark = puppet.mark
        puppet.do("finish", name="/run", mode="succeed")
        puppet.wait(lambda line: line.get("asked") == "/run", "the controller's goal", since=mark)
        assert len(asked(puppet)) == number + 1
        node.shows(lambda s: not s["faults"])


def test_many_goals_of_others_hide_nothing(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("action", **ACTION, mode="go on")
    with stage.controller(ear) as node:
        puppet.publish("/run_wanted", BOOL, True)
        puppet.wait(lambda line: line.get("asked") == "/run", "the controller's goal")
        puppet.do("shout", name="/run", count=20)
        puppet.publish("/run_wanted", BOOL, False)
        told = node.shows(lambda s: len(s["faults"]) == 2 and "17 more" in s["faults"][0])
        assert "did not send" in told["faults"][0] and "was cancelled" in told["faults"][1]


def test_a_message_that_changes_the_state_waits_for_who_hears_it(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear, "lantern_controller") as node:
        node.tells(event("request", "kindle", outcome="failed"))
        assert node.shows(lambda s: s["counters"]["failed"])["components"]["Flame"] == "cold"
        puppet.do("listen", topic="/kindle", type="std_msgs/Empty")
        puppet.hears("/kindle")
        node.enters("Flame", "burning")
