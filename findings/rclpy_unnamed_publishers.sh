#!/bin/sh
# rclpy 7.1.6 (Jazzy, Fast DDS) lists a publisher of a topic before it knows whose it is: for some
# milliseconds Node.get_publishers_info_by_topic() gives the name _NODE_NAME_UNKNOWN_ (and a
# namespace like it) for a publisher of a node that is long known and has a name. The publisher and
# the name come by two ways of discovery. Who judges publishers by their nodes' names has to ask
# again; the name is no node's.
# Seen: "_NODE_NAME_UNKNOWN_ speaker", the names of 100 publishers of the node "speaker", which were
# made one after the other.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check empy==3.3.4
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    "ros-jazzy-rclpy[fastrtps]==7.1.6" ros-jazzy-std-msgs==5.3.6
cat > "$folder/run.py" <<'END'
import subprocess
import sys
import time

import rclpy
from std_msgs.msg import Bool

PUBLISHERS = 100
rclpy.init()
if len(sys.argv) > 1:
    node = rclpy.create_node("speaker")
    for _ in range(PUBLISHERS):
        node.create_publisher(Bool, "topic", 1)
        time.sleep(0.02)
    time.sleep(60)
node = rclpy.create_node("watcher")
speaker = subprocess.Popen([sys.executable, __file__, "speak"])
names, known = set(), []
end = time.monotonic() + 60
while known.count("speaker") < PUBLISHERS and time.monotonic() < end:
    known = [publisher.node_name for publisher in node.get_publishers_info_by_topic("topic")]
    names.update(known)
print(" ".join(sorted(names)))
speaker.kill()
END
cd "$folder"
seen=$(ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$folder/venv/bin/python" run.py)
echo "$seen"
[ "$seen" = "_NODE_NAME_UNKNOWN_ speaker" ]
