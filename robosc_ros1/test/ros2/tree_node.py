"""A behaviour tree that orders, as users of py_trees write one: tree_node.py.

Its leaves are clients of the action ``/mission``. An alarm has a higher priority than what is
ordered, so it interrupts that. Each leaf that ends, or is interrupted, is told on standard output
as a line of JSON. Runs under the test bed's Python. (py_trees_ros is not on PyPI.)
"""

import json

import py_trees
import rclpy
from action_msgs.msg import GoalStatus
from py_trees.common import Status
from rclpy.action import ActionClient
from robot_common.action import Order
from std_msgs.msg import Bool, Empty


def tell(leaf, status, message):
    print(json.dumps({"leaf": leaf, "status": status.name, "message": message}), flush=True)


class Alarm(py_trees.behaviour.Behaviour):
    """Whether somebody raises an alarm: it runs while that lasts."""

    def __init__(self, node):
        super().__init__("alarm")
        self.raised = False
        self._subscription = node.create_subscription(Bool, "/alarm", self._heard, 10)

    def _heard(self, message):
        self.raised = message.data

    def update(self):
        return Status.RUNNING if self.raised else Status.FAILURE


class Ordered(py_trees.behaviour.Behaviour):
    """An order to go to a place."""

    def __init__(self, name, node, x):
        super().__init__(name)
        self._client = ActionClient(node, Order, "/mission")
        self._x = x
        self._asked = self._goal = self._result = None

    def setup(self, **_):
        if not self._client.wait_for_server(60.0):
            raise TimeoutError("nobody takes orders")

    def initialise(self):
        self._goal = self._result = None
        self._asked = self._client.send_goal_async(Order.Goal(x=[self._x], y=[0.0]))

    def update(self):
        if self._goal is None and self._asked.done():
            self._goal = self._asked.result()
            if not self._goal.accepted:
                self.feedback_message = "rejected"
                return Status.FAILURE
            self._result = self._goal.get_result_async()
        if self._result is None or not self._result.done():
            return Status.RUNNING
        ended = self._result.result()
        self.feedback_message = ended.result.message
        succeeded = ended.status == GoalStatus.STATUS_SUCCEEDED
        return Status.SUCCESS if succeeded else Status.FAILURE

    def terminate(self, new_status):
        if self.status is Status.RUNNING and new_status is Status.INVALID:
            self._asked.add_done_callback(_cancel)  # it may not be accepted yet
        if self.status is Status.RUNNING:
            tell(self.name, new_status, self.feedback_message)


def _cancel(asked):
    if asked.result().accepted:
        asked.result().cancel_goal_async()


def main():
    rclpy.init()
    node = rclpy.create_node("tree")
    orders = py_trees.composites.Sequence("orders", memory=True)
    orders.add_children([Ordered("there", node, 2.5), Ordered("back", node, 1.0)])
    either = py_trees.composites.Selector("either", memory=True)
    either.add_children([Ordered("nowhere", node, -1.0), orders])
    root = py_trees.composites.Selector("root", memory=False)
    root.add_children([Alarm(node), either])
    tree = py_trees.trees.BehaviourTree(root)
    tree.setup(timeout=60.0)

    def tick(_):
        tree.tick()
        if root.status in (Status.SUCCESS, Status.FAILURE):
            tell("root", root.status, "")

    node.create_subscription(Empty, "/tick", tick, 10)
    rclpy.spin(node)


main()
