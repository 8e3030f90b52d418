"""Messages that a generated node makes of the data of a model: arrays, and stamps of headers."""

from __future__ import annotations

import json

from primitives import CHECK, STORED, definition
from primitives import PRIMITIVES_OF_ROS1 as ALL
from ros_support import Workspace

CODE = """
import json, rospy
from genpy.dynamic import generate_dynamic
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from lantern_controller.ros_messages import compose
from nav_msgs.msg import OccupancyGrid, Path
rospy.rostime.set_rostime_initialized(True)
before = rospy.Time.now()
def age(stamp):
    return "now" if before <= stamp <= rospy.Time.now() else stamp.to_sec()
pose = compose(PoseWithCovarianceStamped(), {"header": {"frame_id": "map"}})
ready_pose = PoseStamped()
given = compose(PoseWithCovarianceStamped(), {"header": {"stamp": {"secs": 3}}})
ready = compose(Path(), Path())
poses = [{"pose": {}}, {"header": {"stamp": {"secs": 3}}}, ready_pose, {"header": {}}]
path = compose(Path(), {"poses": poses})
Seen = generate_dynamic("testing/Seen", "std_msgs/Header[] seen\\n" + "=" * 80 + "\\nMSG: std_msgs/Header\\n"
    "uint32 seq\\ntime stamp\\nstring frame_id")["testing/Seen"]
seen = compose(Seen(), {"seen": [{"frame_id": "map"}, {"stamp": {"secs": 3}}]}).seen
print(json.dumps({
    "left out": age(pose.header.stamp),
    "frame": pose.header.frame_id,
    "given": age(given.header.stamp),
    "ready made": age(ready.header.stamp),
    "elements": [age(pose.header.stamp) for pose in path.poses],
    "headers as elements": [age(header.stamp) for header in seen],
    "no data": age(compose(Path(), None).header.stamp),
    "no header": compose(Twist(), {"linear": {"x": 1.5}}).linear.x,
}))
"""


def test_headers_get_the_time_of_sending(generated_workspace: Workspace) -> None:
    done = generated_workspace.run("/usr/bin/python3", "-c", CODE)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        "left out": "now",
        "frame": "map",
        "given": 3.0,
        "ready made": 0.0,
        "elements": ["now", 3.0, 0.0, "now"],
        "headers as elements": ["now", 3.0],
        "no data": "now",
        "no header": 1.5,
    }


ARRAYS = """
import io, json
from geometry_msgs.msg import Polygon, PoseArray, PoseWithCovariance
from lantern_controller.ros_messages import compose
from std_msgs.msg import MultiArrayLayout, UInt8MultiArray
points = compose(Polygon(), {"points": [{"x": 1.0}, {"x": 2.0, "z": 3.0}]})
pose = compose(PoseWithCovariance(), {"covariance": [0.5] * 36})
data = compose(UInt8MultiArray(), {"data": [1, 255], "layout": {"dim": [{"size": 2}]}})
for message in (points, pose, data):
    message.serialize(io.BytesIO())
print(json.dumps([
    [[p.x, p.y, p.z] for p in points.points],
    sum(pose.covariance),
    [list(data.data), data.layout.dim[0].size],
]))
"""


def test_arrays_become_lists_of_messages_and_of_plain_values(
    generated_workspace: Workspace,
) -> None:
    done = generated_workspace.run("/usr/bin/python3", "-c", ARRAYS)
    points = [[1.0, 0.0, 0.0], [2.0, 0.0, 3.0]]
    assert json.loads(done.stdout) == [points, 18.0, [[1, 255], 2]]


EVERY_TYPE = f"""
import io
from genpy.dynamic import generate_dynamic
from probe_controller._runtime.core.operations import copied
from lantern_controller.ros_messages import compose
Primitives = generate_dynamic("testing/Primitives", {definition(ALL)!r})["testing/Primitives"]
PRIMITIVES = {ALL!r}
def there_and_back(data):
    sent = io.BytesIO()
    compose(Primitives(), data).serialize(sent)
    return Primitives().deserialize(sent.getvalue())
{CHECK}
{STORED}
"""

PARTS = """
import io, rospy
from geometry_msgs.msg import Point, PoseStamped, Vector3
from probe_controller._runtime.core.operations import copied
from lantern_controller.ros_messages import compose
from move_base_msgs.msg import MoveBaseGoal
from nav_msgs.msg import Path
rospy.rostime.set_rostime_initialized(True)
def there_and_back(message):
    sent = io.BytesIO()
    message.serialize(sent)
    return type(message)().deserialize(sent.getvalue())
pose = PoseStamped()
pose.header.frame_id, pose.header.stamp, pose.pose.position.x = "map", rospy.Time(3), 1.5
pose = there_and_back(pose)
goal = there_and_back(compose(MoveBaseGoal(), {"target_pose": copied(pose)}))
assert goal.target_pose == pose, goal
path = there_and_back(compose(Path(), {"poses": [copied(pose), {"pose": copied(pose.pose)}]}))
assert path.poses[0] == pose and path.poses[1].pose == pose.pose, path
header = there_and_back(compose(PoseStamped(), {"header": copied(pose.header)}))
assert header.header == pose.header and there_and_back(compose(PoseStamped(), pose)) == pose
point = there_and_back(compose(Point(), Vector3(1.0, 2.0, 0.0)))
assert point == Point(1.0, 2.0, 0.0)
"""


def test_what_was_stored_is_sent_again(generated_workspace: Workspace) -> None:
    generated_workspace.run("/usr/bin/python3", "-c", PARTS)


def test_every_type_comes_as_it_was_sent(generated_workspace: Workspace) -> None:
    generated_workspace.run("/usr/bin/python3", "-c", EVERY_TYPE)


TIMES = """
import io, rospy
from genpy.dynamic import generate_dynamic
from lantern_controller._runtime.core.values import NOW
from lantern_controller.ros_messages import compose
rospy.rostime.set_rostime_initialized(True)
Times = generate_dynamic("testing/Times", "time[] stamps\\nduration[] pauses")["testing/Times"]
before = rospy.Time.now()
message = compose(Times(), {"stamps": [NOW, {"secs": 3}], "pauses": [{"secs": 1, "nsecs": 5}]})
message.serialize(io.BytesIO())
assert before <= message.stamps[0] <= rospy.Time.now(), message
assert message.stamps[1] == rospy.Time(3) and message.pauses == [rospy.Duration(1, 5)], message
"""


def test_arrays_may_hold_the_time_of_sending(generated_workspace: Workspace) -> None:
    generated_workspace.run("/usr/bin/python3", "-c", TIMES)
