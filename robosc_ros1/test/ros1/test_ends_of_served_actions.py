"""A node that ends while actionlib sends what it serves."""

from __future__ import annotations

import pytest
from ros1.stage import Stage

SCRIPT = """
import rospy
from actionlib_msgs.msg import GoalStatus
from missions_controller import ros_served_actions
from robot_common.msg import NavigateAction, NavigateResult

rospy.init_node("ends")
served = ros_served_actions.ServedAction("/ends", NavigateAction)
served.serve(lambda *_: None, lambda *_: None)
server = served._server

def ends():
    rospy.signal_shutdown("Ctrl-C, after actionlib and rospy looked whether the topic is open")
    return True

server.%s_pub.impl.has_connections = ends
%s
print("nothing is raised")
"""


@pytest.mark.parametrize(
    ("topic", "sends"),
    [
        ("status", "server.publish_status()"),
        ("result", "server.publish_result(GoalStatus(), NavigateResult())"),
    ],
)
def test_closed_topics_raise_nothing(topic: str, sends: str, stage: Stage) -> None:
    script = SCRIPT % (topic, sends)
    done = stage.workspace.run("python3", "-c", script, master=stage.master)
    assert done.stdout.endswith("nothing is raised\n"), done.stdout + done.stderr
