"""Names that are remapped, of every kind, on real rclpy: topics, services and actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from ros2.launching import started
from ros2.ros2_support import Graph, Process

Start = Callable[..., Process]
SWITCH, MOVE, BOOL = "std_srvs/srv/SetBool", "robosc_testing/action/Move", "std_msgs/msg/Bool"

# What the node is told, with the names that its robot then has: of go, door/lock and reach.
RULES = [
    ([], ("/go", "/door/lock", "/reach")),
    (["go:=want", "door/lock:=gate", "reach:=base/reach"], ("/want", "/gate", "/base/reach")),
    (["/go:=/a/b", "/door/lock:=/c/d", "/reach:=/base/go"], ("/a/b", "/c/d", "/base/go")),
    (["go:=~/go", "door/lock:=~/lock", "reach:=~/r"], ("/NODE/go", "/NODE/lock", "/NODE/r")),
    (["__ns:=/left"], ("/left/go", "/left/door/lock", "/left/reach")),
    (
        ["__ns:=/left", "go:=want", "door/lock:=/gate", "reach:=base/reach"],
        ("/left/want", "/gate", "/left/base/reach"),
    ),
    (
        ["__ns:=/left", "/left/go:=/want", "/left/door/lock:=/l", "/left/reach:=/r"],
        ("/want", "/l", "/r"),
    ),
    (["reach/_action/send_goal:=/reach/_action/send_goal"], ("/go", "/door/lock", "/reach")),
    (["go:=want", "want:=no", "door/lock:=gate", "gate:=no", "reach:=r"], ("/want", "/gate", "/r")),
]


def is_connected(missing: list[str], go: str) -> bool:
    """Whether the node has looked who is there, and its switch is."""
    return any("nobody subscribes" in text for text in missing) and not any(
        text.endswith(f" {go}") for text in missing
    )


@pytest.mark.parametrize("node", ["guarded_arm", "guarded_arm_supervisor"])
@pytest.mark.parametrize(("rules", "names"), RULES)
def test_names_are_remapped_whatever_they_name(
    graph: Graph, controller: Start, node: str, rules: list[str], names: tuple[str, str, str]
) -> None:
    go, lock, reach = (name.replace("NODE", node) for name in names)
    guards = node.endswith("supervisor")
    if guards:  # what the controller uses has other names
        rules = [*rules, "supervised/door/lock:=/their/lock", "supervised/reach:=/their/reach"]
    controller(node, remap=rules)
    robot = graph.peer()
    robot.serve(lock, SWITCH, {"success": True})
    robot.act(reach, MOVE)
    robot.order("repeat", name=go, type=BOOL, data={"data": True}, qos={})
    shown = f"/left/{node}" if "__ns:=/left" in rules else f"/{node}"
    robot.watch(shown)
    robot.expect_state(shown, lambda s: s["variables"]["Operator.wanted"])
    if guards:
        other = graph.peer("other")
        other.order("call", name="/their/lock", type=SWITCH, data={"data": True})
        robot.expect_state(shown, lambda s: s["components"]["Door"] == "locked")
        other.order("send_goal", name="/their/reach", type=MOVE, data={"target": 2.0})
    assert robot.expect("goal", name=reach)["data"]["target"] == 2.0
    robot.expect_state(shown, lambda s: is_connected(s["unconnected"], go))


def test_an_action_whose_parts_are_remapped_is_told_by_its_own_name(
    graph: Graph, controller: Start
) -> None:
    """So a controller behind a supervisor says whom it misses: not the robot's own server."""
    parts = ("send_goal", "cancel_goal", "get_result", "feedback", "status")
    rules = [f"/reach/_action/{part}:=/supervised/reach/_action/{part}" for part in parts]
    controller("guarded_arm", remap=rules)
    robot = graph.peer()
    robot.act("reach", MOVE)
    robot.watch("/guarded_arm")
    shown = robot.expect_state(
        "/guarded_arm", lambda s: any("/reach is" in text for text in s["unconnected"])
    )
    assert "no server of /supervised/reach is connected" in shown["unconnected"]


@pytest.mark.parametrize("node", ["guarded_arm", "guarded_arm_supervisor"])
@pytest.mark.parametrize(("rules", "names"), RULES)
@pytest.mark.parametrize("sign", ["=", ":="])
def test_the_argument_of_the_launch_file_makes_the_same_rules(
    built: Any, node: str, rules: list[str], names: tuple[str, str, str], sign: str
) -> None:
    file = built.folder / "src" / node / "launch" / f"{node}.launch.py"
    pairs = [rule.split(":=") for rule in rules if not rule.startswith("__ns")]
    ns = "/left" if "__ns:=/left" in rules else ""
    remap = " ".join(sign.join(pair) for pair in pairs)
    started_node, *_ = started(file, lambda package: f"/share/{package}", remap=remap, ns=ns)
    assert started_node.remappings == [tuple(pair) for pair in pairs]
    assert started_node.namespace == ns
