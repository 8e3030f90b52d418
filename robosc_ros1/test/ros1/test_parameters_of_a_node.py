"""Parameters: refused clearly if wrong, told if unknown, obeyed if right."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros1.stage import Puppet, Stage, event
from ros_support import Workspace, await_condition

from robosc.runtime.core.model import Communication
from robosc.runtime.core.settings import declared

INT = "std_msgs/Int16"
PROBE = (
    Communication("Oracle.ask", "ask", "service"),
    Communication("Runner.run", "run", "action"),
    Communication("Horn.blow", "blow", "incoming"),
    Communication("Horn.halt", "halt", "incoming"),
)
"""The communications of the robot that have parameters of their own."""


@pytest.mark.parametrize(
    ("parameter", "complaint"),
    [
        ("_rate:=fast", "parameter ~rate must be a number, not 'fast'"),
        ("_rate:=0", "parameter ~rate must be a number of at least 0.001, not 0"),
        ("_order:=alphabetical", "~order must be one of rotate, declared, random"),
        ("_stop_command:=jump", "(ask, run, blow, halt), not 'jump'"),
        ("_timeout/run:=true", "~timeout/run must be a number"),
        ("_loud:=very", "~loud must be an integer, not 'very'"),
        ("_loud:=10", "~loud must be an integer of at most 9, not 10"),
        ("_loud:=3.0", "~loud must be an integer, not 3.0"),
        ("_loud:=5000000000", "~loud must be an integer of at most 9, not 5000000000"),
        ("_order:=2020-01-01", "parameter ~order must be what ROS can carry, not '2020-01-01'"),
        ("_loud:=true", "~loud must be an integer, not True"),
        ("_shadow:=true", "a shadow is a mode of the monitor: generate that"),
        ("_rate/of_what:=3", "~rate must be a number, not a group with ~rate/of_what"),
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


@pytest.mark.once
def test_a_parameter_of_the_model_decides(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.controller(ear, loud=7) as node:
        state = node.shows(lambda s: True)
        assert state["parameters"] == {"loud": 7}
        puppet.publish("/level", INT, 7)
        state = node.shows(lambda s: s["variables"]["Switches.height"] == 7)
        enabled = {c["event"]["name"] for c in state["commands"] if c["enabled"]}
        assert enabled == {"halt"}
        puppet.publish("/level", INT, 8)
        node.tells(event("request", "blow"))


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


def test_there_must_be_parameters_below_the_name(stage: Stage) -> None:
    name = "probe_controller"
    stage.workspace.run("rosparam", "set", "/valued", "5", master=stage.master)
    done = stage.workspace.run(
        "rosrun", name, name, "__name:=valued", master=stage.master, check=False
    )
    assert done.returncode == 2
    assert "there must be parameters below the node's name, not 5" in done.stdout + done.stderr


TWO = """\
<launch>
  <group ns="left">
    <include file="$(find lantern_controller)/launch/lantern_controller.launch">
      <arg name="name" value="lantern"/>
      <arg name="remap" value="/brightness=/sun ~snuff:=/put_out"/>
    </include>
  </group>
  <group ns="right">
    <include file="$(find lantern_controller)/launch/lantern_controller.launch">
      <arg name="ns" value="far"/>
      <arg name="rate" value="20"/>
    </include>
  </group>
</launch>
"""


def test_two_controllers_in_namespaces_one_of_them_remapped(
    stage: Stage, puppet: Puppet, ear: Puppet, tmp_path: Path
) -> None:
    (tmp_path / "two.launch").write_text(TWO)
    left, right = "/left/lantern", "/right/far/lantern_controller"
    ear.do("listen", topic=f"{left}/state", type="std_msgs/String")
    ear.do("listen", topic=f"{right}/state", type="std_msgs/String")
    ear.do("listen", topic="/left/kindle", type="std_msgs/Empty")
    ear.do("listen", topic="/right/far/kindle", type="std_msgs/Empty")
    ear.do("listen", topic="/put_out", type="std_msgs/Bool")
    with stage.workspace.start("roslaunch", str(tmp_path / "two.launch"), master=stage.master):
        for node in (left, right):
            ear.hears(f"{node}/state", lambda s: s["components"]["Flame"] == "burning")
            stage.master.await_links(node)
        puppet.publish("/sun", INT, 99)
        ear.hears("/put_out")
        ear.hears(f"{left}/state", lambda s: s["components"]["Flame"] == "cold")
        # The other one listens to /brightness, and sends to a topic below its own name.
        ear.do("listen", topic=f"{right}/snuff", type="std_msgs/Bool")
        assert ear.all_heard(f"{right}/state")[-1]["components"]["Flame"] == "burning"
        puppet.publish("/brightness", INT, 99)
        ear.hears(f"{right}/state", lambda s: s["components"]["Flame"] == "cold")
        # What is lit now is lit on the topics of each namespace.
        mark = ear.mark
        for topic in ("/sun", "/brightness"):
            puppet.publish(topic, INT, 0)
        for topic in ("/left/kindle", "/right/far/kindle"):
            ear.hears(topic, since=mark)


def test_the_launch_file_gives_each_parameter_its_type(generated_workspace: Workspace) -> None:
    yaml = pytest.importorskip("yaml")
    given = {
        "rate/default": 3, "stop_command": "halt", "publish_values": True, "event_log": "123",
        "loud": 2, "operate": True, "tolerance": 0.5,
    }  # fmt: skip
    defaults = {p.name: p.default for p in declared(PROBE)} | {"loud": 5}
    del defaults["shadow"]  # of monitors
    defaults["rate/default"] = defaults.pop("rate")
    arguments = [
        f"{name.removesuffix('/default').replace('/', '_')}:={value}"
        for name, value in given.items()
    ]
    launch = ("probe_controller", "probe_controller.launch")
    for more in ([], ["ns:=far"], ["ns:=/far"]):
        done = generated_workspace.run("roslaunch", "--dump-params", *launch, *arguments, *more)
        above = "/far/probe_controller/" if more else "/probe_controller/"
        expected = {above + k: v for k, v in {**defaults, **given}.items()}
        assert yaml.safe_load(done.stdout) == expected
    done = generated_workspace.run("roslaunch", "--dump-params", *launch)
    expected = {"/probe_controller/" + k: v for k, v in defaults.items()}
    assert yaml.safe_load(done.stdout) == expected
