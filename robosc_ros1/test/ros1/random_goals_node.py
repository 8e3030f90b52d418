"""The random server of the courier's action: random_goals_node.py SEED GOALS LOG LISTENERS."""

import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from random_goals import RandomServer
from robot_common.msg import NavigateAction
from std_msgs.msg import Bool, Float32

SETTERS = {"succeed": "set_succeeded", "abort": "set_aborted", "cancel": "set_canceled"}


def main(seed, goals, log, listeners):
    rospy.init_node("random_goals")
    server = RandomServer(int(seed), Path(log), int(goals))

    def on_goal(handle):
        number = server.asked()
        if number is None:
            handle.set_rejected()
            return
        handle.set_accepted()
        threading.Thread(target=act, args=(handle, number), daemon=True).start()

    def act(handle, number):
        preempting = GoalStatus.PREEMPTING
        end = server.carry_out(number, lambda: handle.get_goal_status().status == preempting)
        server.tell("end", number)
        getattr(handle, SETTERS[end])()

    actions = actionlib.ActionServer("/go", NavigateAction, on_goal, lambda _: None, False)
    actions.start()
    place = rospy.Publisher("/place", Float32, queue_size=1000)
    wanted = rospy.Publisher("/wanted", Bool, queue_size=1000)
    while min(place.get_num_connections(), wanted.get_num_connections()) < int(listeners):
        rospy.sleep(0.01)
    server.wishes(place.publish, wanted.publish)
    print("enough", flush=True)
    rospy.spin()


main(*sys.argv[1:5])
