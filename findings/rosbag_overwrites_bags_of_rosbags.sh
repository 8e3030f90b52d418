#!/bin/sh
# rosbag 1.15.15 (Debian 12) destroys bags that rosbags 0.11.9 (rosbags-convert, too) wrote, when it
# appends to them or renews their index. The record at the begin of a bag is filled up with blanks:
# rosbags makes the whole record 4,096 bytes long, rosbag 4,104. Opened with mode "a", also by
# "rosbag reindex", rosbag writes that record anew, and so over the first 8 bytes of the first chunk.
# It reads nothing behind that, calls it the end, and cuts the file off. "rosbag reindex" ends with
# status 0; the bag as it was is in run.orig.bag. Who appends has no copy.
# Seen: "rosbag reindex: 4 messages before, 0 after, status 0" and "append: ROSBagUnindexedException".
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check rosbags==0.11.9
apt-get download -qq python3-rosbag=1.15.15+ds-2 python3-roslz4=1.15.15+ds-2 libroslz4-1d=1.15.15+ds-2 \
    python3-rospy=1.15.15+ds-2 python3-rosgraph=1.15.15+ds-2 python3-roslib=1.15.8-3 \
    python3-genpy=0.6.16-2 python3-genmsg python3-std-msgs=0.5.13-2 python3-rosgraph-msgs=1.11.3-2 \
    python3-roscpp-msg python3-rospkg=1.4.0-2 python3-catkin-pkg=0.5.2-5 python3-catkin python3-yaml \
    python3-netifaces python3-defusedxml python3-distro python3-dateutil python3-six \
    python3-pyparsing python3-docutils python3-gnupg python3-pycryptodome 2> /dev/null
for package in *.deb; do dpkg -x "$package" .; done
cat > write.py <<'END'
import sys

from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS1_NOETIC)
Bool = store.types["std_msgs/msg/Bool"]
for path in sys.argv[1:]:
    with Writer(path) as writer:
        stop = writer.add_connection("/stop", Bool.__msgtype__, typestore=store)
        for second in range(1, 5):
            data = store.serialize_ros1(Bool(data=second == 3), Bool.__msgtype__)
            writer.write(stop, second * 10**9, data)
END
venv/bin/python write.py run.bag other.bag
export PYTHONPATH="$folder/usr/lib/python3/dist-packages" LD_LIBRARY_PATH="$(echo "$folder"/usr/lib/*-linux-gnu)"
cat > count.py <<'END'
import sys

import rosbag

with rosbag.Bag(sys.argv[1]) as bag:
    print(bag.get_message_count())
END
before=$(/usr/bin/python3 count.py run.bag)
status=0
/usr/bin/python3 usr/bin/rosbag reindex run.bag > /dev/null 2>&1 || status=$?
after=$(/usr/bin/python3 count.py run.bag)
cat > append.py <<'END'
import rosbag
import rospy
from std_msgs.msg import Bool

try:
    with rosbag.Bag("other.bag", "a") as bag:
        bag.write("/stop", Bool(True), rospy.Time(5))
    with rosbag.Bag("other.bag") as bag:
        print("%d messages" % sum(1 for _ in bag.read_messages()))
except Exception as error:
    print(type(error).__name__)
END
seen="rosbag reindex: $before messages before, $after after, status $status
append: $(/usr/bin/python3 append.py)"
echo "$seen"
[ "$seen" = "rosbag reindex: 4 messages before, 0 after, status 0
append: ROSBagUnindexedException" ]
