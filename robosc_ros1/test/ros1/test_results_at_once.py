"""A server that gives feedback and the result before the node has noted that the goal was sent."""

from __future__ import annotations

from ros1.stage import Stage

FEEDBACKS = 30
SCRIPT = f"""
import queue, time
import actionlib, rospy
from gauntlet_interfaces.msg import ReachAction, ReachFeedback, ReachResult
from probe_controller import ros_actions
from probe_controller.ros_backlog import watch_connections
from probe_controller.ros_connections import send_promptly

send_promptly()
watch_connections()
rospy.init_node("at_once")

def on_goal(handle):
    handle.set_accepted()
    for number in range({FEEDBACKS}):
        handle.publish_feedback(ReachFeedback())
    handle.set_succeeded(ReachResult())
    ended.put(True)

ended, told = queue.Queue(), queue.Queue()
server = actionlib.ActionServer("/at_once", ReachAction, on_goal, auto_start=False)
server.start()
action = ros_actions.Action("/at_once", ReachAction)
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
action.start({{}}, 1)
kinds = [told.get(timeout=60)]
while kinds[-1] != "response":
    kinds.append(told.get(timeout=60))
print("feedback before the result:", kinds.count("feedback"))
"""


def test_feedback_comes_before_the_result(stage: Stage) -> None:
    done = stage.workspace.run("python3", "-c", SCRIPT, master=stage.master)
    assert done.stdout.endswith(f"feedback before the result: {FEEDBACKS}\n"), done.stdout
