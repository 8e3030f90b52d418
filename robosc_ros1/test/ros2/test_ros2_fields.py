"""Every sort of field: messages are made of data, and data of messages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from primitives import CHECK, STORED
from primitives import PRIMITIVES_OF_ROS2 as ALL
from reflecting import files
from ros2.bed import HERE
from ros2.ros2_support import Graph

STAMPS = """
from guarded_arm.ros_messages import compose
from geometry_msgs.msg import PoseStamped, Twist
from rclpy.clock import Clock
from std_msgs.msg import Header
class Path:  # as in nav_msgs, which the test bed has not
    def __init__(self):
        self.header, self.poses, self.seen = Header(), [], []
    @classmethod
    def get_fields_and_field_types(cls):
        poses, headers = "sequence<geometry_msgs/PoseStamped>", "sequence<std_msgs/Header, 2>"
        return {"header": "std_msgs/Header", "poses": poses, "seen": headers}
clock = Clock()
before = clock.now()
def is_now(stamp):
    return before.nanoseconds <= stamp.sec * 10**9 + stamp.nanosec <= clock.now().nanoseconds
pose = compose(PoseStamped(), {"header": {"frame_id": "map"}}, clock)
assert is_now(pose.header.stamp) and pose.header.frame_id == "map"
assert is_now(compose(PoseStamped(), None, clock).header.stamp)
given = compose(PoseStamped(), {"header": {"stamp": {"sec": 3}}}, clock)
assert given.header.stamp.sec == 3 and given.header.stamp.nanosec == 0
assert compose(PoseStamped(), PoseStamped(), clock).header.stamp.sec == 0
assert compose(Twist(), {"linear": {"x": 1.5}}, clock).linear.x == 1.5
poses = [{"pose": {}}, {"header": {"stamp": {"sec": 3}}}, PoseStamped()]
first, second, third = compose(Path(), {"poses": poses}, clock).poses
assert is_now(first.header.stamp)
assert (second.header.stamp.sec, third.header.stamp.sec) == (3, 0)
first, second = compose(Path(), {"seen": [{"frame_id": "map"}, {"stamp": {"sec": 3}}]}, clock).seen
assert is_now(first.stamp) and second.stamp.sec == 3
"""
ARRAYS = """
from guarded_arm.ros_messages import fill
from geometry_msgs.msg import Polygon, PoseArray, PoseWithCovariance
points = fill(Polygon(), {"points": [{"x": 1.0}, {"x": 2.0, "z": 3.0}]}).points
assert [(p.x, p.y, p.z) for p in points] == [(1.0, 0.0, 0.0), (2.0, 0.0, 3.0)]
pose = fill(PoseWithCovariance(), {"covariance": [0.5] * 36})
assert list(pose.covariance) == [0.5] * 36
assert fill(PoseArray(), {"poses": []}).poses == []
try:
    fill(PoseWithCovariance(), {"covariance": [0.5] * 35})
except ValueError as error:
    assert "covariance" in str(error)
else:
    raise AssertionError("35 of 36")
"""

EVERY_TYPE = f"""
from guarded_arm._runtime.core.operations import copied
from guarded_arm.ros_messages import compose, plain
from rclpy.clock import Clock
from rclpy.serialization import deserialize_message, serialize_message
from robosc_testing.msg import Primitives
PRIMITIVES = {ALL!r}
def there_and_back(data):
    sent = serialize_message(compose(Primitives(), data, Clock()))
    return plain(deserialize_message(sent, Primitives))
{CHECK}
{STORED}
"""

PARTS = """
from guarded_arm._runtime.core.operations import copied
from guarded_arm.ros_messages import compose, plain
from geometry_msgs.msg import Point, PoseWithCovariance, PoseWithCovarianceStamped, Vector3
from rclpy.clock import Clock
from rclpy.serialization import deserialize_message, serialize_message
from types import SimpleNamespace
def there_and_back(message):
    return plain(deserialize_message(serialize_message(message), type(message)))
pose = PoseWithCovariance()
pose.pose.position.x, pose.covariance[7] = 1.5, 0.25
pose = there_and_back(pose)
whole = there_and_back(compose(PoseWithCovarianceStamped(), {"pose": copied(pose)}, Clock()))
assert str(whole.pose) == str(pose) and whole.header.stamp.sec > 0
again = there_and_back(compose(PoseWithCovarianceStamped(), copied(whole), Clock()))
assert str(again) == str(whole)
header = there_and_back(compose(PoseWithCovarianceStamped(), {"header": whole.header}, Clock()))
assert header.header == whole.header
point = there_and_back(compose(Point(), Vector3(x=1.0, y=2.0), Clock()))
assert point == Point(x=1.0, y=2.0)
"""


@pytest.mark.parametrize(("place", "text"), files(ALL).items())
def test_the_definitions_have_every_type(place: str, text: str) -> None:
    file = HERE / "interfaces" / "robosc_testing" / place
    assert file.read_text(encoding="utf-8").partition("\n")[2] == text


@pytest.mark.parametrize(
    "code",
    [STAMPS, ARRAYS, EVERY_TYPE, PARTS],
    ids=["stamps", "arrays", "every type", "stored parts"],
)
def test_messages_are_made_of_data(graph: Graph, built: Any, tmp_path: Path, code: str) -> None:
    script = tmp_path / "check.py"
    script.write_text(code)
    done = graph.fork(script, **built.environment("guarded_arm"))
    assert done.wait() == 0, done.output
