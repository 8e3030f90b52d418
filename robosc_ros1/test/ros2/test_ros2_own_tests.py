"""What the generated tests of ROS 2 packages stand on: nothing is lost there, nothing turned round."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from ros2.ros2_support import Graph, Process

EARLY = """
import os
import threading
import rclpy
from action_client import Client
from rclpy.action import ActionServer
from rclpy.executors import MultiThreadedExecutor
from robosc_testing.action import Move

class Late:
    # What sends the requests, and returns only when the executor has the answer.
    def __init__(self, handle, answered):
        self._handle, self._answered = handle, answered

    def __getattr__(self, name):
        given = getattr(self._handle, name)
        if not name.startswith("send_"):
            return given
        def send(request):
            self._answered.clear()
            number = given(request)
            assert self._answered.wait(60)
            return number
        return send

class Early(Client):
    def __init__(self, *words):
        Client.__init__(self, *words)
        self.answered = threading.Event()
        self._client_handle = Late(self._client_handle, self.answered)

    async def execute(self, taken):
        if set(taken) & {"goal", "cancel", "result"}:
            self.answered.set()
        await Client.execute(self, taken)

rclpy.init()
node = rclpy.create_node("early")
server = ActionServer(node, Move, "reach", lambda goal: goal.succeed() or Move.Result(code=3))
client = Early(node, Move, "reach")
executor = MultiThreadedExecutor(num_threads=4)
executor.add_node(node)
threading.Thread(target=executor.spin, daemon=True).start()
assert client.wait_for_server(60)

def answer(send):
    future = client.ask(send)
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    assert future.done() or done.wait(20), "the answer is lost"
    return future.result()

goal = answer(lambda: client.send_goal_async(Move.Goal()))
answer(goal.cancel_goal_async)
assert answer(goal.get_result_async).result.code == 3
os._exit(0)  # with its threads
"""

ORDER = """
import os
import threading
import time
from collections import deque
import rclpy
from package_under_test import TABLES
from ros_robot import Robot
from rclpy.action import ActionClient
from rclpy.executors import MultiThreadedExecutor
from robosc_testing.action import Move

class Hesitant(deque):
    # The first request is noted late: after the second one, if that can be.
    def __init__(self):
        self.second = threading.Event()

    def append(self, goal):
        if goal.target == 1.0:
            self.second.wait(1.0)
        else:
            self.second.set()
        deque.append(self, goal)

rclpy.init()
node = rclpy.create_node("order")
robot = Robot(node, 1, TABLES)
robot.serve()
robot.random.random = lambda: 0.0  # which rejects
(key,) = [key for _, _, key in TABLES.actions]
requests = robot.requests[key] = Hesitant()
client = ActionClient(node, Move, "reach")
executor = MultiThreadedExecutor(num_threads=4)
executor.add_node(node)
threading.Thread(target=executor.spin, daemon=True).start()
assert client.wait_for_server(60)
for target in (1.0, 2.0):
    client.send_goal_async(Move.Goal(target=target))
end = time.monotonic() + 60
while len(requests) < 2 and time.monotonic() < end:
    time.sleep(0.01)
assert [goal.target for goal in requests] == [1.0, 2.0]
os._exit(0)  # with its threads
"""


def run(graph: Graph, built: Any, package: str, folder: Path, code: str) -> Process:
    """Start code that sees the test of a package."""
    script = folder / "script.py"
    script.write_text(code)
    environment = built.environment(package)
    tests = str(built.folder / "src" / package / "test")
    environment["PYTHONPATH"] = os.pathsep.join((tests, environment["PYTHONPATH"]))
    return graph.start(graph.bed.python, script, **environment)


@pytest.mark.parametrize(
    ("package", "code"),
    [("guarded_arm_supervisor", EARLY), ("guarded_arm_supervisor", ORDER)],
    ids=["answers that come at once", "goals that overtake"],
)
def test_nothing_is_lost_or_turned_round(
    graph: Graph, built: Any, tmp_path: Path, package: str, code: str
) -> None:
    done = run(graph, built, package, tmp_path, code)
    assert done.wait() == 0, done.output


@pytest.mark.parametrize(
    "package",
    [
        "hoist_controller",
        "sonar_controller",
        "courier_controller",
        "courier_supervisor",
        "courier_monitor",
        "sentry_controller",
        "sentry_supervisor",
        "mirror_controller",
        "mirror_supervisor",
        "mirror_monitor",
        "guarded_arm_monitor",
        "line_follower_monitor",
    ],
)
def test_what_a_node_does_is_judged(graph: Graph, built: Any, package: str) -> None:
    test = graph.start(
        graph.bed.python, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider",
        built.folder / "src" / package / "test",
        **built.environment(package), ROBOSC_SECONDS="4",
    )  # fmt: skip
    assert test.wait(240.0) == 0, test.output
