"""Names that are remapped, of every kind, on a real roscore: topics, services and actions."""

from __future__ import annotations

from typing import Any
from xmlrpc.client import ServerProxy

import pytest
from ros1.stage import Stage

FLOAT, TWIST = "std_msgs/Float32", "geometry_msgs/Twist"
LIGHT = {"type": "robot_common/LightBulbService"}
GRAB = {"type": "robot_common/GrabberAction"}
IDLE = "nobody publishes /correction"
"""What the node says once it knows who is there: nobody plays this part of the robot."""

# What the node is told, with the names that its robot then has.
RULES = [
    ([], ("/distance", "/vel", "/set_light_state", "/grab")),
    (
        ["/distance:=/near", "/vel:=/a/vel", "/set_light_state:=/b/c/light", "/grab:=/base/grab"],
        ("/near", "/a/vel", "/b/c/light", "/base/grab"),
    ),
    (
        ["distance:=near", "vel:=a/vel", "set_light_state:=b/c/light", "grab:=base/grab"],
        ("/near", "/a/vel", "/b/c/light", "/base/grab"),
    ),
    (
        ["/distance:=~near", "/vel:=~vel", "/set_light_state:=~light", "/grab:=~grab"],
        ("/NODE/near", "/NODE/vel", "/NODE/light", "/NODE/grab"),
    ),
    (
        ["__ns:=/left", "/distance:=near", "/vel:=vel", "/set_light_state:=light", "/grab:=a/grab"],
        ("/left/near", "/left/vel", "/left/light", "/left/a/grab"),
    ),
]


def is_connected(missing: list[str], names: set[str]) -> bool:
    """Whether the node has looked who is there, and nothing is missing at these names."""
    return IDLE in missing and not any(names & set(text.split()) for text in missing)


@pytest.mark.parametrize("package", ["line_follower_controller", "line_follower_supervisor"])
@pytest.mark.parametrize(("rules", "names"), RULES)
def test_names_are_remapped_whatever_they_name(
    guarded: Stage, package: str, rules: list[str], names: tuple[str, ...]
) -> None:
    distance, vel, light, grab = (name.replace("NODE", package) for name in names)
    with guarded.puppet() as robot, guarded.puppet() as ear:
        robot.do("listen", topic=vel, type=TWIST)
        robot.do("service", name=light, **LIGHT)
        robot.do("action", name=grab, **GRAB, mode="hold")
        with guarded.controller(ear, package, rules) as node:
            robot.steadily(distance, FLOAT, 5.0)
            node.tells(lambda e: e["event"]["name"] == "distance")
            node.shows(lambda s: is_connected(s["unconnected"], {vel, light, grab}))
            state: Any = ServerProxy(guarded.master.uri).getSystemState("/stage")
            assert [f"{grab}/goal", [node.name]] in state[2][0]


@pytest.mark.parametrize("rule", ["/vel:=/supervised/vel", "/grab:=/supervised/grab"])
def test_a_supervisor_with_the_remappings_of_its_controller_ends_at_once(
    guarded: Stage, rule: str
) -> None:
    """It would feed itself with what it sends."""
    name = "line_follower_supervisor"
    done = guarded.workspace.run("rosrun", name, name, rule, master=guarded.master, check=False)
    assert done.returncode == 2
    told = rule.partition(":=")[2] + " is the same on both sides"
    assert told in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("name", "first"),
    [
        ("line_follower_controller", "/distance"),
        ("line_follower_controller", "/vel"),
        ("line_follower_controller", "/grab"),
        ("line_follower_supervisor", "/distance"),
        ("line_follower_supervisor", "/supervised/vel"),
    ],
)
def test_a_name_that_rospy_would_remap_twice_ends_the_node(
    guarded: Stage, name: str, first: str
) -> None:
    """A topic would be another one than its rule says, unseen: that of the other side, or swapped."""
    rules = [f"{first}:=/second", "/second:=/third"]
    done = guarded.workspace.run("rosrun", name, name, *rules, master=guarded.master, check=False)
    assert done.returncode == 2
    told = done.stdout + done.stderr
    assert f"{first} is remapped to /second, and that to /third" in told
    assert "Traceback" not in told
