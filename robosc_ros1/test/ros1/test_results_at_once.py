"""A server that gives feedback and the result before the node has noted that the goal was sent."""

from __future__ import annotations

import pytest
from ros1.stage import Stage

FEEDBACKS = 30
CONTROLLER = """
action = ros_actions.Action("/at_once", types.ReachAction)

def start():
    action.start({}, 1)
"""
SUPERVISOR = """
from courier_supervisor import relayed_actions

class Engine:
    closing = False
    invoke = staticmethod(lambda do: do())

action = relayed_actions.ActionRelay("/guarded", "/at_once", types.NavigateAction, "go")
action.connect(Engine)

def start():
    goal = ros_actions.Goal(action._new_id())
    action.begin(goal, types.NavigateActionGoal(goal_id=goal.goal_id), 1)
"""
SCRIPT = f"""
import queue, time
import %(types)s as types
import actionlib, rospy
from %(package)s import ros_actions
from %(package)s.ros_backlog import watch_connections
from %(package)s.ros_connections import send_promptly

send_promptly()
watch_connections()
rospy.init_node("at_once")

def on_goal(handle):
    handle.set_accepted()
    for number in range({FEEDBACKS}):
        handle.publish_feedback(types.%(action)sFeedback())
    handle.set_succeeded(types.%(action)sResult())
    ended.put(True)

ended, told = queue.Queue(), queue.Queue()
server = actionlib.ActionServer("/at_once", types.%(action)sAction, on_goal, auto_start=False)
server.start()
%(start)s
action.report = lambda token, kind, payload=None: told.put(kind)
action.look = lambda: None
is_taken = ros_actions.is_taken

def taken_late(publisher):
    ended.get(timeout=60)  # its result is on the way, or has come
    time.sleep(0.1)
    return is_taken(publisher)

ros_actions.is_taken = taken_late
while not action.ready():
    time.sleep(0.01)
start()
kinds = [told.get(timeout=60)]
while kinds[-1] != "response":
    kinds.append(told.get(timeout=60))
print("feedback before the result:", kinds.count("feedback"))
"""


@pytest.mark.parametrize(
    "made",
    [
        {
            "package": "probe_controller",
            "types": "gauntlet_interfaces.msg",
            "action": "Reach",
            "start": CONTROLLER,
        },
        {
            "package": "courier_supervisor",
            "types": "robot_common.msg",
            "action": "Navigate",
            "start": SUPERVISOR,
        },
    ],
    ids=lambda made: str(made["package"]),
)
def test_feedback_comes_before_the_result(made: dict[str, str], stage: Stage) -> None:
    done = stage.workspace.run("python3", "-c", SCRIPT % made, master=stage.master)
    assert done.stdout.endswith(f"feedback before the result: {FEEDBACKS}\n"), done.stdout
