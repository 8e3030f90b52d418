#!/bin/sh
# rclpy 7.1.6 (Jazzy) does not tell which publisher a message came from. A callback with two
# parameters gets the middleware's information about the message, as in C++, but without the
# publisher's identifier that rmw_message_info_t has; and the number of its reception is None. So a
# node in Python cannot tell two publishers of one topic apart, as one of ROS 1 can by the header of
# the connection.
# Seen: "publication_sequence_number received_timestamp reception_sequence_number source_timestamp,
# reception None", in one line.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check empy==3.3.4
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    "ros-jazzy-rclpy[fastrtps]==7.1.6" ros-jazzy-std-msgs==5.3.6
cat > "$folder/run.py" <<'END'
import rclpy
from std_msgs.msg import Bool

rclpy.init()
node = rclpy.create_node("finding")
heard = []
node.create_subscription(Bool, "topic", lambda message, info: heard.append(info), 1)
publisher = node.create_publisher(Bool, "topic", 1)
while not heard:
    publisher.publish(Bool())
    rclpy.spin_once(node, timeout_sec=0.1)
print(" ".join(sorted(heard[0])) + f", reception {heard[0]['reception_sequence_number']}")
rclpy.shutdown()
END
cd "$folder"
seen=$(ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$folder/venv/bin/python" run.py)
echo "$seen"
[ "$seen" = "publication_sequence_number received_timestamp reception_sequence_number source_timestamp, reception None" ]
