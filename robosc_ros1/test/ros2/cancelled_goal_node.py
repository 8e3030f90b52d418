"""Cancels a goal whose acceptance comes in before what the cancel has left to the executor's thread.

Ends well if its server is watched nevertheless.
"""

import rclpy
from courier_controller.ros_actions import Action
from robot_common.action import Navigate


class Late:
    """An executor's thread that is given what is to be done when that is over."""

    def __init__(self):
        self.waiting, self.polls = [], {}

    def do(self, function):
        self.waiting.append(function)

    def poll(self, subject, look, pause=0.0):
        self.polls[subject] = look


rclpy.init()
node, executor = rclpy.create_node("client"), Late()
action = Action(node, executor, "go", Navigate)
action.report = lambda token, kind, payload=None: None
while not action.ready():
    rclpy.spin_once(node, timeout_sec=0.1)
action.start({"x": 1.0}, 1)
action.cancel(1)
while not executor.polls:
    rclpy.spin_once(node, timeout_sec=0.1)
watched = dict(executor.polls)
for function in executor.waiting:
    function()
assert executor.waiting and executor.polls == watched, executor.polls
