"""Clients that users have, in place of a test's own: rosservice, SimpleActionClient; killed ones, too."""

from __future__ import annotations

from pathlib import Path

from ros1.stage import Node, Puppet, Stage, event
from ros1.test_calls_of_the_robot import DONE
from ros1.test_goals_of_the_robot import accepted, end, send, step
from ros1.test_goals_of_the_robot import node as missions  # noqa: F401
from ros_support import PYTHON

SIMPLE = """
import actionlib, rospy
from robot_common.msg import OrderAction, OrderGoal
rospy.init_node("simple", anonymous=True)
client = actionlib.SimpleActionClient("/mission", OrderAction)
assert client.wait_for_server(rospy.Duration(60))
def ended(x):
    client.send_goal(OrderGoal(x=[x], y=[0.0]))
    assert client.wait_for_result(rospy.Duration(60))
    return client.get_state(), client.get_goal_status_text()
state, text = ended(-1.0)
assert state == actionlib.GoalStatus.REJECTED and "value.x[0] > 0" in text, text
client.send_goal(OrderGoal(x=[1.0], y=[0.0]))
while client.get_state() != actionlib.GoalStatus.ACTIVE:
    rospy.sleep(0.01)
client.cancel_goal()
assert client.wait_for_result(rospy.Duration(60))
assert client.get_state() == actionlib.GoalStatus.PREEMPTED
client.send_goal(OrderGoal(x=[1.0], y=[0.0]))
print("sent", flush=True)
assert client.wait_for_result(rospy.Duration(60))
assert client.get_state() == actionlib.GoalStatus.SUCCEEDED
assert client.get_result().reached == 3
"""


def test_rosservice(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.controller(ear, "orders_controller") as node:
        puppet.publish("/door", "std_msgs/Bool", True)
        node.shows(lambda s: s["variables"]["Door.open"])
        call = ("rosservice", "call", "/order")
        done = stage.workspace.run(*call, "data: true", master=stage.master)
        assert "success: True" in done.stdout and DONE["message"] in done.stdout
        refused = stage.workspace.run(*call, "data: false", master=stage.master, check=False)
        assert refused.returncode != 0
        assert "Orders is in unwanted" in refused.stdout + refused.stderr


def test_a_simple_action_client(stage: Stage, puppet: Puppet, missions: Node) -> None:  # noqa: F811
    with stage.workspace.start(str(PYTHON), "-c", SIMPLE, master=stage.master) as process:
        missions.tells(event("error", "mission"))  # what it cancelled has ended
        missions.shows(lambda s: s["components"]["Missions"] == "running", since=missions.ear.mark)
        step(puppet, 3)
        log: Path = process.log  # type: ignore[attr-defined]
        assert process.wait(60) == 0, log.read_text()


def test_whoever_is_killed_while_its_goal_is_ending(
    stage: Stage,
    puppet: Puppet,
    missions: Node,  # noqa: F811
) -> None:
    for cancel in (False, True):
        mark = missions.ear.mark
        step(puppet, 0)
        missions.shows(lambda s: s["variables"]["Legs.steps"] == 0, since=mark)
        with stage.puppet() as caller:
            accepted(caller, missions)
            if cancel:
                caller.begin("cancel")
            caller.process.kill()
        step(puppet, 3)
        missions.shows(lambda s: s["communications"]["mission"] == "idle", since=missions.ear.mark)
    mark = send(puppet)
    assert end(puppet, mark)["result"]["reached"] == 3
