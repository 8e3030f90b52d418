"""Messages through a generated controller on real rclpy, and what it tells about itself."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition, stopped

Start = Callable[..., Process]
READING = "robosc_testing/msg/Reading"
BOOL = "std_msgs/msg/Bool"
NEAR = {"valid": True, "distance": 0.5}
FAR = {"valid": True, "distance": 3.0}


def warned(robot: Peer) -> None:
    robot.expect("message", name="beacon")


def test_a_command_follows_the_input_that_allows_it(graph: Graph, controller: Start) -> None:
    controller()
    robot = graph.peer()
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.publish("person", READING, FAR)
    robot.publish("person", READING, NEAR)
    warned(robot)


def test_arrays_of_fixed_length_are_read(graph: Graph, controller: Start) -> None:
    controller()
    robot = graph.peer()
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.publish("person", READING, {**FAR, "vector": [0.0, 0.0, 5.0]})
    warned(robot)


def test_inputs_come_from_publishers_of_either_reliability(graph: Graph, controller: Start) -> None:
    controller(qos__zone__reliability="best_effort")  # the default
    reliable, other = graph.peer("reliable"), graph.peer("other")
    reliable.watch("guarded_arm")
    reliable.order("repeat", name="person", type=READING, data=NEAR, qos={})
    reliable.expect_state("guarded_arm", lambda s: s["variables"]["Person.where"] == "near")
    reliable.process.end()
    other.watch("guarded_arm")
    qos = {"reliability": "best_effort"}
    other.order("repeat", name="person", type=READING, data=FAR, qos=qos)
    other.expect_state("guarded_arm", lambda s: s["variables"]["Person.where"] == "far")


LATCHED = {"durability": "transient_local"}


def test_a_latched_command_that_may_be_forbidden_later_is_warned_of(
    graph: Graph, controller: Start
) -> None:
    node = controller(qos__warn__durability="transient_local")
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.expect_state("guarded_arm", lambda s: s)
    text = "parameter qos.warn.durability: ROS keeps what was sent last for who subscribes later"
    assert text in node.output
    assert "qos.speed.durability" not in node.output


@pytest.mark.parametrize("node", ["guarded_arm", "guarded_arm_supervisor"])
@pytest.mark.parametrize("given", [{}, LATCHED, {"durability": "volatile"}])
def test_what_was_latched_before_the_start_is_heard_unless_told_otherwise(
    graph: Graph, controller: Start, node: str, given: dict[str, str]
) -> None:
    robot = graph.peer()
    robot.watch(node)
    order = {"name": "go", "type": BOOL, "matched": 0}
    robot.order("publish", **order, data=[{"data": True}], qos=LATCHED)
    more = {f"qos__go__{policy}": value for policy, value in given.items()}
    controller(node, qos__go__reliability="best_effort", **more)
    if given == {"durability": "volatile"}:
        state = robot.expect_state(node, lambda s: s["counters"]["commands"] >= 0)
        assert not state["variables"]["Operator.wanted"]
    else:
        robot.expect_state(node, lambda s: s["variables"]["Operator.wanted"])
    if not given:  # another publisher comes, whose messages a latched subscription does not get
        other = graph.peer("other")
        other.order("repeat", name="go", type=BOOL, data={"data": False}, qos={})
        robot.expect_state(node, lambda s: not s["variables"]["Operator.wanted"])
    if node.endswith("supervisor") and given != {"durability": "volatile"}:
        late = graph.peer("late")
        late.order("subscribe", name="supervised/go", type=BOOL, qos=given)
        late.expect("message", name="supervised/go")


def counted(node: str, robot: Peer) -> int:
    """The inputs until the operator wants something, which is said last."""
    state = robot.expect_state(node, lambda s: s["variables"]["Operator.wanted"])
    return int(state["counters"]["inputs"])


@pytest.mark.parametrize("node", ["guarded_arm", "guarded_arm_supervisor"])
def test_what_was_latched_is_heard_beside_a_publisher_that_does_not_latch(
    graph: Graph, controller: Start, node: str
) -> None:
    robot, other = graph.peer("robot"), graph.peer("other")
    robot.watch(node)
    order = {"name": "go", "type": BOOL, "matched": 0}
    other.order("publish", **order, data=[], qos={})
    robot.order("publish", **order, data=[{"data": True}], qos=LATCHED)
    controller(node)
    assert counted(node, robot) == 1
    other.publish("go", BOOL, {"data": False})
    state = robot.expect_state(node, lambda s: not s["variables"]["Operator.wanted"])
    assert not [fault for fault in state["faults"] if "go" in fault]


@pytest.mark.parametrize("node", ["guarded_arm", "guarded_arm_supervisor"])
def test_a_change_of_what_publishers_offer_loses_nothing_and_repeats_nothing(
    graph: Graph, controller: Start, node: str
) -> None:
    """They begin to publish at once, so that the input finds out about them meanwhile."""
    controller(node, qos__go__reliability="reliable", qos__go__depth=1000)
    kinds = {"latched": LATCHED, "volatile": {}, "more": LATCHED}
    peers = {graph.peer(name): qos for name, qos in kinds.items()}
    robot = graph.peer("robot")
    robot.watch(node)
    messages = [{"data": False}] * 100
    with ThreadPoolExecutor() as pool:
        told = [
            pool.submit(
                peer.order, "publish", name="go", type=BOOL, data=messages, matched=1,
                qos={**qos, "depth": 1000}, rate=50.0,
            )
            for peer, qos in peers.items()
        ]  # fmt: skip
    for one in told:
        one.result()
    robot.publish("go", BOOL, {"data": True})
    assert counted(node, robot) == 100 * len(peers) + 1


def test_what_the_middleware_lost_is_counted(graph: Graph, controller: Start) -> None:
    node = controller(qos__go__reliability="best_effort")
    robot = graph.peer("robot")
    robot.watch("guarded_arm")

    def counted_as(counter: str) -> int:
        # What comes through shows the gap before it; the first may be lost like those before.
        robot.publish("go", BOOL, {"data": False}, reliability="best_effort")
        states = robot.events("message", name="guarded_arm/state")
        counts = [json.loads(s["data"]["data"])["counters"][counter] for s in states]
        return max(counts, default=0)

    # Before a first message the node may not know of its publisher, and of no gap.
    await_condition(lambda: counted_as("inputs"), "a message to come through")
    with stopped(node.popen.pid):
        robot.publish("go", BOOL, [{"data": False}] * 5000)
    lost = await_condition(
        lambda: counted_as("dropped"), "the messages that were lost to be counted"
    )
    assert lost < 5000
    text = "messages were lost: they came too fast, or a link was cut"
    await_condition(lambda: text in node.output, "a word of it")


@pytest.mark.parametrize(
    ("qos", "lack"),
    [
        ({"reliability": "best_effort"}, "reliable subscription does not hear a best-effort"),
        ({"deadline": 0.5}, "does not offer the deadline"),
        ({"liveliness": "manual_by_topic"}, "does not offer the liveliness"),
        ({"lease": 0.5}, "lease of the publisher"),
        ({"durability": "transient_local"}, "does not hear a volatile publisher"),
    ],
)
def test_every_incompatible_quality_of_service_is_a_fault(
    graph: Graph, controller: Start, qos: dict[str, Any], lack: str
) -> None:
    robot = graph.peer("robot")
    robot.watch("guarded_arm")
    if "reliability" in qos:
        robot.order("publish", name="go", type=BOOL, data=[], matched=0, qos=qos)
    else:
        robot.order("subscribe", name="beacon", type="std_msgs/msg/Empty", qos=qos)
    node = controller(qos__go__reliability="reliable")
    robot.expect_state("guarded_arm", lambda s: lack in str(s["faults"]))
    await_condition(lambda: lack in node.output, "the warning")


def test_quality_of_service_is_configured(graph: Graph, controller: Start) -> None:
    controller(qos__go__durability="transient_local", qos__warn__reliability="best_effort")
    robot = graph.peer()

    def quality(topic: str) -> list[str]:
        found: list[str] = robot.order("qos_of", node="guarded_arm", name=topic)
        return found

    assert quality("go") == ["RELIABLE", "TRANSIENT_LOCAL"]
    assert quality("beacon") == ["BEST_EFFORT", "VOLATILE"]
    assert quality("speed") == ["RELIABLE", "VOLATILE"]


def test_quality_of_service_is_that_of_sensors_unless_configured(
    graph: Graph, controller: Start
) -> None:
    controller("line_follower_controller")
    robot = graph.peer()
    found = robot.order("qos_of", node="line_follower_controller", name="/distance")
    assert found == ["BEST_EFFORT", "VOLATILE"]


def test_state_and_model_reach_those_who_come_late(graph: Graph, controller: Start) -> None:
    controller()
    robot = graph.peer()
    robot.publish("person", READING, NEAR)
    late = graph.peer("late")
    late.watch("guarded_arm")
    state = late.expect_state("guarded_arm", lambda s: s["variables"]["Person.where"] == "near")
    assert state["components"]["Arm"] == "resting"
    assert state["communications"] == {"lock": "idle", "reach": "idle"}
    late.subscribe("guarded_arm/model", "std_msgs/msg/String", durability="transient_local")
    model = json.loads(late.expect("message", name="guarded_arm/model")["data"]["data"])
    assert model["robot"] == "GuardedArm"


def test_events_are_told(graph: Graph, controller: Start) -> None:
    controller()
    robot = graph.peer()
    robot.subscribe("guarded_arm/events", "std_msgs/msg/String")

    def is_near(data: Any) -> bool:
        event: dict[str, Any] = json.loads(data["data"])["event"]
        return event == {"kind": "response", "name": "zone", "value": "near"}

    # Commands repeat at their rate, so an event shows that the subscription stands.
    robot.expect("message", name="guarded_arm/events")
    robot.publish("person", READING, NEAR)
    robot.expect("message", name="guarded_arm/events", where=is_near)


def test_diagnostics_are_told(graph: Graph, controller: Start) -> None:
    controller()
    robot = graph.peer()
    robot.subscribe("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    (status,) = robot.expect("message", name="/diagnostics")["data"]["status"]
    assert (status["name"], status["message"]) == ("guarded_arm: controller", "running")


def test_there_are_no_diagnostics_without_their_messages(graph: Graph, built: Any) -> None:
    code = "import sys; sys.modules['diagnostic_msgs'] = None;"
    code += "from guarded_arm.start import main; main()"
    node = graph.start(graph.bed.python, "-c", code, **built.environment("guarded_arm"))
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.expect_state("guarded_arm", lambda s: s["counters"]["commands"] > 0)
    assert "/diagnostics" not in robot.order("topics")
    node.signal(signal.SIGINT)
    assert node.wait() == 0


def test_two_nodes_of_one_name_are_told(graph: Graph, controller: Start) -> None:
    nodes = controller(), controller()
    told = "another node is called /guarded_arm, too"
    for node in nodes:
        await_condition(lambda node=node: told in node.output, "the warning", 60.0)


def test_who_else_is_on_its_topics_is_told(graph: Graph, controller: Start) -> None:
    node = controller(allowed_publishers="teleop")
    robot, teleop, stranger = graph.peer(), graph.peer("teleop"), graph.peer("stranger")
    robot.watch("guarded_arm")
    robot.subscribe("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    for peer in (teleop, stranger):
        peer.order("repeat", name="beacon", type="std_msgs/msg/Empty", data={}, qos={})
    (fault,) = robot.expect_state("guarded_arm", lambda s: s["faults"])["faults"]
    assert fault.startswith("/stranger also publishes /beacon")
    told = lambda data: data["status"][0]["message"] == fault  # noqa: E731
    robot.expect("message", name="/diagnostics", where=told)
    await_condition(lambda: fault in node.output, "the warning")
    missing = {"nobody publishes /person", "nobody subscribes to /speed"}
    robot.expect_state("guarded_arm", lambda s: missing <= set(s["unconnected"]))
    stranger.process.end()
    robot.expect_state("guarded_arm", lambda s: s["faults"] == [])


def test_a_message_that_changes_the_state_waits_for_who_hears_it(
    graph: Graph, controller: Start
) -> None:
    node = "watch_controller"
    controller(node)
    robot = graph.peer()
    robot.watch(node)
    unsent = robot.expect_state(node, lambda s: s["counters"]["failed"])
    assert unsent["components"]["Motor"] == "ready"
    robot.subscribe("/halt", "std_msgs/msg/Empty")
    robot.expect("message", name="/halt")
    robot.expect_state(node, lambda s: s["components"]["Motor"] == "rest")


STRANGER = """
import sys, time, rclpy
from std_msgs.msg import Empty
rclpy.init()
node = rclpy.create_node(sys.argv[1])
publisher = node.create_publisher(Empty, "beacon", 1)
time.sleep(600)
"""
LOOKING = """
import subprocess, sys
import rclpy
from guarded_arm import ros_watch
from guarded_arm.node import TABLES
ros_watch.PERIOD = 0.0  # it looks all the time, also before the name is known
rclpy.init()
watch = ros_watch.Watch(rclpy.create_node("guarded_arm"), TABLES, "")
told = set()
for name in ("first", "second", "third"):
    with subprocess.Popen([sys.executable, sys.argv[1], name]) as stranger:
        while not any(fault.startswith("/%s also" % name) for fault in watch.faults):
            watch.look()
            told.update(fault.partition(" also ")[0] for fault in watch.faults)
        stranger.kill()
print(sorted(told))
"""


def test_a_node_is_told_of_once_its_name_is_known(graph: Graph, built: Any, tmp_path: Path) -> None:
    """The graph has its publisher some tenths of a second earlier."""
    looking, stranger = tmp_path / "looking.py", tmp_path / "stranger.py"
    looking.write_text(LOOKING)
    stranger.write_text(STRANGER)
    environment = built.environment("guarded_arm")
    done = graph.fork(looking, stranger, **environment)
    assert done.wait() == 0, done.output
    assert "['/first', '/second', '/third']" in done.output, done.output


def test_a_message_that_the_model_cannot_read_stops_nothing(
    graph: Graph, controller: Start
) -> None:
    controller()
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.publish("person", READING, {"valid": True, "distance": float("nan")})
    robot.expect_state("guarded_arm", lambda s: s["counters"]["inputs"] == 1)
    robot.publish("person", READING, NEAR)
    warned(robot)


def test_namespace_and_name_are_the_launchers(graph: Graph, controller: Start) -> None:
    controller("guarded_arm", remap=["__ns:=/left", "__node:=arm", "beacon:=lamp"])
    robot = graph.peer()
    robot.subscribe("/left/lamp", "std_msgs/msg/Empty")
    robot.watch("/left/arm")
    robot.publish("/left/person", READING, NEAR)
    robot.expect("message", name="/left/lamp")
    robot.expect_state("/left/arm", lambda s: s["robot"] == "GuardedArm")


def test_wrong_parameters_are_refused_by_name(graph: Graph, controller: Start) -> None:
    wrong = {"rate": "fast", "qos__zone__depth": 0, "stop_command": "jump", "timeout__lock": True}
    wrong["near_by"] = "close"
    node = controller(qos__zone__reliability="always", **wrong)
    assert node.wait() == 2
    for complaint in (
        "parameter rate must be a number, not 'fast'",
        "parameter qos.zone.reliability must be one of reliable, best_effort, not 'always'",
        "parameter qos.zone.depth must be an integer of at least 1, not 0",
        "parameter timeout.lock must be a number, not True",
        "parameter near_by must be a number, not 'close'",
        "(lock, reach, warn, speed), not 'jump'",
    ):
        assert complaint in node.output
    assert "Traceback" not in node.output


@pytest.mark.once
def test_a_parameter_of_the_model_decides(graph: Graph, controller: Start) -> None:
    controller(near_by=4)  # an integer does for a double
    robot = graph.peer()
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.watch("guarded_arm")
    robot.publish("person", READING, FAR)
    warned(robot)
    state = robot.expect_state("guarded_arm", lambda s: s["variables"]["Person.where"] == "near")
    assert state["parameters"] == {"near_by": 4.0}


def test_simulated_time_is_a_switch(graph: Graph, controller: Start) -> None:
    node = controller(use_sim_time="perhaps")
    assert node.wait() == 2
    assert "parameter use_sim_time must be true or false, not 'perhaps'" in node.output


def test_unknown_parameters_are_warned_of(graph: Graph, controller: Start) -> None:
    node = controller(tate=2.0, timeout__lok=1.0, qos__zone__reliabilty="reliable")
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.expect_state("guarded_arm", lambda s: True)
    for name, near in (
        ("tate", "rate"),
        ("timeout.lok", "timeout.lock"),
        ("qos.zone.reliabilty", "qos.zone.reliability"),
    ):
        assert f"unknown parameter {name} is ignored; did you mean {near}?" in node.output


def test_parameters_are_fixed_once_the_node_runs(graph: Graph, controller: Start) -> None:
    controller(rate=5)
    robot = graph.peer()
    (reason,) = robot.order("set_parameter", node="guarded_arm", name="rate", value=2.0)
    assert "read-only" in reason


def test_topics_of_other_types_are_told_and_do_no_harm(graph: Graph, controller: Start) -> None:
    controller()
    robot, stranger = graph.peer(), graph.peer("stranger")
    robot.watch("guarded_arm")
    text = {"data": "go on"}
    stranger.order("repeat", name="go", type="std_msgs/msg/String", data=text, qos={})
    qos = {"reliability": "best_effort"}
    stranger.order("repeat", name="charge", type="std_msgs/msg/Int16", data={"data": 50}, qos=qos)
    state = robot.expect_state("guarded_arm", lambda s: len(s["faults"]) == 2)
    quality, type_ = state["faults"]
    assert quality.startswith("/stranger publishes /charge with another quality of service, so")
    assert quality.endswith("a reliable subscription does not hear a best-effort publisher")
    assert type_.startswith("/stranger publishes /go as std_msgs/msg/String, but this node has")
    stranger.process.end()
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    state = robot.expect_state("guarded_arm", lambda s: s["variables"]["Operator.wanted"])
    assert state["counters"]["inputs"] == 1
    robot.expect_state("guarded_arm", lambda s: s["faults"] == [])


def test_a_flood_is_taken_wholly_and_in_order(
    graph: Graph, controller: Start, tmp_path: Path
) -> None:
    log = tmp_path / "events.jsonl"
    controller(event_log=str(log), qos__charge__depth=2000, rate=0.1)
    robot = graph.peer()
    robot.watch("guarded_arm")
    charges = [number % 101 for number in range(2000)]
    flood = {"rate": 2000.0, "data": [{"data": charge} for charge in charges]}
    robot.order("publish", name="charge", type="std_msgs/msg/Int16", matched=1, qos={}, **flood)
    robot.expect_state("guarded_arm", lambda s: s["counters"]["inputs"] == 2000)

    def logged() -> list[Any]:
        events = [json.loads(line)["event"] for line in log.read_text().splitlines()]
        return [event["value"] for event in events if event["name"] == "charge"]

    await_condition(lambda: len(logged()) == 2000, "the log")
    assert logged() == charges


def test_every_sort_of_field_comes_and_goes(graph: Graph, controller: Start) -> None:
    controller("everything_controller", qos__heard__reliability="reliable")
    robot = graph.peer()
    robot.watch("everything_controller")
    every = "robosc_testing/msg/Everything"
    robot.subscribe("said", every)
    stamp = {"sec": -3, "nanosec": 7}
    data = {
        "wide": "größer 漢字 🤖", "short_name": "12345678", "tags": ["a", "b"], "raw": 200,
        "letter": 65, "octets": [1, 255], "letters": [1, 66], "flags": [False, True],
        "big": [-(2**63), 2**63 - 1], "small": [9, 8], "pair": [0.25, -0.5], "stamp": stamp,
        "inner": {"label": "in", "vector": [1.0, 2.0, 3.0]}, "count": -5,
        "both": [{"count": 1}, {"count": 2, "samples": [0.5, 1.5]}], "some": [{"valid": True}],
        "header": {"stamp": stamp, "frame_id": "map"},
    }  # fmt: skip
    robot.publish("heard", every, data)
    said = robot.expect("message", name="said", where=lambda d: d["count"] == -5)["data"]
    for name in ("wide", "short_name", "raw", "letter", "stamp"):
        assert said[name] == data[name], name
    assert (said["inner"]["distance"], said["inner"]["count"]) == (1.5 + 3.0 + -0.5, 255 + 66)
    assert said["header"] == data["header"]
    assert said["pair"] == [1.5, 2.5]  # the definition's default
    state = robot.expect_state("everything_controller", lambda s: s["variables"]["Echo.big"] > 0)
    variables = state["variables"]
    assert (variables["Echo.big"], variables["Echo.tag"]) == (2**63 - 1, "b")
    assert (variables["Echo.flag"], variables["Echo.some"]) == (True, True)


def test_what_no_message_can_carry_is_told_and_ends_nothing(
    graph: Graph, controller: Start
) -> None:
    node = controller("everything_controller", qos__heard__reliability="reliable")
    robot = graph.peer()
    robot.watch("everything_controller")
    every = "robosc_testing/msg/Everything"
    robot.publish("heard", every, {"short_name": "nine char"})  # which nobody may send
    robot.expect_state("everything_controller", lambda s: s["counters"]["failed"] > 0)
    assert "said could not be sent: short_name is 'nine char'" in node.output
    robot.publish("heard", every, {"short_name": "fits"})
    robot.subscribe("said", every)
    robot.expect("message", name="said", where=lambda d: d["short_name"] == "fits")


@pytest.mark.parametrize("value", [True, False])
def test_events_can_be_switched_off(graph: Graph, controller: Start, value: bool) -> None:
    controller(publish_events=value)
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.expect_state("guarded_arm", lambda s: True)
    assert ("/guarded_arm/events" in robot.order("topics")) is value
