"""The random server of the courier's action: random_goals_node.py SEED GOALS LOG LISTENERS."""

import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import rclpy
from random_goals import RandomServer
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from robot_common.action import Navigate
from std_msgs.msg import Bool, Float32


def main(seed, goals, log, listeners):
    rclpy.init()
    node = rclpy.create_node("random_goals")
    server = RandomServer(int(seed), Path(log), int(goals))
    numbers = {}

    def asked(request):
        number = server.asked()
        if number is None:
            return GoalResponse.REJECT
        numbers[id(request)] = number
        return GoalResponse.ACCEPT

    def act(goal):
        number = numbers.pop(id(goal.request))
        end = server.carry_out(number, lambda: goal.is_cancel_requested)
        server.tell("end", number)
        if end == "cancel":
            goal.canceled()
        elif end == "abort":
            goal.abort()
        else:
            goal.succeed()
        return Navigate.Result()

    def cancelled(_):
        refused = server.random.random() < 0.3
        return CancelResponse.REJECT if refused else CancelResponse.ACCEPT

    ActionServer(
        node,
        Navigate,
        "/go",
        act,
        goal_callback=asked,
        cancel_callback=cancelled,
        callback_group=ReentrantCallbackGroup(),
    )
    place = node.create_publisher(Float32, "/place", 1000)
    wanted = node.create_publisher(Bool, "/wanted", 1000)
    executor = MultiThreadedExecutor(num_threads=8)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    while min(p.get_subscription_count() for p in (place, wanted)) < int(listeners):
        time.sleep(0.01)
    server.wishes(lambda x: place.publish(Float32(data=x)), lambda b: wanted.publish(Bool(data=b)))
    print("enough", flush=True)
    threading.Event().wait()


main(*sys.argv[1:5])
