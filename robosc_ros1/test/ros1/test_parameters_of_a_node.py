"""Parameters: refused clearly if wrong, told if unknown, obeyed if right."""

from __future__ import annotations

import pytest
from ros1.stage import Puppet, Stage, event
from ros_support import await_condition

INT = "std_msgs/Int16"


@pytest.mark.parametrize(
    ("parameter", "complaint"),
    [
        ("_rate:=fast", "parameter ~rate must be a number, not 'fast'"),
        ("_rate:=0", "parameter ~rate must be a number of at least 0.001, not 0"),
        ("_order:=alphabetical", "~order must be one of rotate, declared, random"),
        ("_stop_command:=jump", "(ask, run, blow, halt), not 'jump'"),
        ("_timeout/run:=true", "~timeout/run must be a number"),
    ],
)
def test_a_wrong_value_is_refused_at_the_start(
    stage: Stage, parameter: str, complaint: str
) -> None:
    name = "probe_controller"
    # Each under its own name: parameters outlive their nodes.
    alias = f"__name:=refused_{abs(hash(parameter))}"
    done = stage.workspace.run(
        "rosrun", name, name, alias, parameter, master=stage.master, check=False
    )
    assert done.returncode == 2
    assert complaint in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_an_unknown_parameter_is_told_with_the_nearest(stage: Stage, ear: Puppet) -> None:
    with stage.controller(ear, timout__run=3.0) as node:
        await_condition(lambda: "did you mean ~timeout/run?" in node.log, "the warning")


def test_the_rate_is_kept(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.controller(ear, rate=50.0) as node:
        puppet.publish("/level", INT, 9)
        first = node.tells(event("request", "blow"))["time"]
        node.shows(lambda s: any(c["count"] >= 101 for c in s["commands"]))
        await_condition(
            lambda: len(node.events(event("request", "blow"))) >= 101, "a hundred repetitions"
        )
        spent = node.events(event("request", "blow"))[100]["time"] - first
        # Never faster, whatever the machine does.
        assert spent > 1.9


def test_a_controller_in_a_namespace_and_remapped(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    ear.do("listen", topic="/left/lantern/state", type="std_msgs/String")
    ear.do("listen", topic="/left/kindle", type="std_msgs/Empty")
    ear.do("listen", topic="/put_out", type="std_msgs/Bool")
    with stage.workspace.start(
        "roslaunch", "lantern_controller", "lantern_controller.launch", "ns:=left", "name:=lantern",
        "remap:=/brightness=/sun ~snuff=/put_out", master=stage.master,
    ):  # fmt: skip
        # It listens before the controller starts, so it gets the very first command.
        ear.hears("/left/kindle")
        ear.hears("/left/lantern/state", lambda s: s["components"]["Flame"] == "burning")
        puppet.publish("/sun", INT, 99)
        ear.hears("/put_out")
        ear.hears("/left/lantern/state", lambda s: s["components"]["Flame"] == "cold")
