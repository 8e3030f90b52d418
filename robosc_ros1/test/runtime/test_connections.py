"""Who else is on the topics of a model, and what of that is told."""

from __future__ import annotations

import pytest

from robosc.runtime.core.connections import Connections, ConnectionWatch

CONTROLLER = Connections("/c", heard=("/scan",), commanded=("/vel", "/horn"))


def test_a_second_publisher_of_a_command_is_named() -> None:
    publishers = {"/vel": ["/c", "/teleop"], "/horn": ["/c"], "/scan": ["/laser", "/fake"]}
    (fault,) = CONTROLLER.second_publishers(publishers)
    assert fault.startswith("/teleop also publishes /vel, on which this node commands")
    allowed = CONTROLLER._replace(allowed=("teleop",))
    assert list(allowed.second_publishers(publishers)) == []


def test_a_supervisor_guards_one_controller() -> None:
    guard = Connections("/g", (), ("/vel",), guarded=("/supervised/vel",))
    assert list(guard.second_publishers({"/supervised/vel": ["/one"], "/vel": ["/g"]})) == []
    (fault,) = guard.second_publishers({"/supervised/vel": ["/two", "/one"]})
    assert fault.startswith("/one and /two all publish /supervised/vel")


def test_several_servers_of_one_action_are_named() -> None:
    sender = CONTROLLER._replace(statuses=("/go/status",))
    assert "/go/status" in sender.topics
    assert list(sender.second_publishers({"/go/status": ["/base"]})) == []
    (fault,) = sender.second_publishers({"/go/status": ["/base", "/arm"]})
    assert fault.startswith("/arm and /base all publish /go/status: a goal goes to each")


def test_topics_with_nobody_at_the_other_end() -> None:
    publishers = {"/vel": ["/c"], "/horn": ["/c"]}
    assert list(CONTROLLER.unconnected(publishers, {"/horn": ["/robot"]})) == [
        "nobody publishes /scan",
        "nobody subscribes to /vel",
    ]


def test_who_is_missing_is_told_once_and_when_they_are_back() -> None:
    said: list[str] = []
    watch = ConnectionWatch(CONTROLLER, said.append)
    servers, laser, robot = {"/go", "/stop"}, ["/laser"], ["/robot"]
    watch.unserved = lambda: sorted(servers)

    def look() -> list[str]:
        watch.update((), {"/scan": laser}, {"/vel": robot, "/horn": ["/robot"]})
        found, said[:] = list(said), []
        return found

    assert look() == []  # it may still be starting
    assert watch.unconnected == [f"no server of {n} is connected" for n in ("/go", "/stop")]
    assert look() == watch.unconnected
    assert look() == []
    servers.remove("/go")
    laser.clear()
    robot.clear()
    assert look() == ["no longer: no server of /go is connected"]
    assert look() == ["nobody publishes /scan", "nobody subscribes to /vel"]
    assert look() == []
    servers.add("/go")
    laser.append("/laser")
    robot.append("/robot")
    assert look() == [f"no longer: nobody {d}" for d in ("publishes /scan", "subscribes to /vel")]
    assert look() == ["no server of /go is connected"]


@pytest.mark.parametrize("simulated", [False, True])
@pytest.mark.parametrize("clocks", [[], ["/gazebo"]])
def test_two_clocks_are_a_fault(simulated: bool, clocks: list[str]) -> None:
    said: list[str] = []
    node = CONTROLLER._replace(simulated=simulated)
    watch = ConnectionWatch(node, said.append)
    publishers = {"/scan": ["/laser"], "/clock": clocks}
    nodes = {"/vel": ["/robot"], "/horn": ["/robot"]}
    watch.update((), publishers, nodes)
    assert watch.faults == said == []  # whoever publishes it may still be starting
    watch.update((), publishers, nodes)
    assert len(watch.faults) == (simulated != bool(clocks))
    assert said == watch.faults
    if clocks and not simulated:
        assert watch.faults[0].startswith("/gazebo publishes /clock, but this node follows the")
