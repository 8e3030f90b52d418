#!/bin/sh
# rosbag 1.15.15 (Debian 12): "rosbag filter" and "rosbag compress" lose who published what. A recording
# has a connection for each publisher of a topic, with its name and whether it latches; Bag.write has
# one for each topic, that of its first message, also where it is given the header of another. So what
# a watchdog said in a compressed bag was said by the button, and latched. rosbags 0.11.9 keeps them
# apart (rosbags-convert, of one bag or of several).
# Seen: "recorded: /button /watchdog /button /watchdog", the same for rosbags-convert, and "/button" four
# times for rosbag filter and rosbag compress.
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
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS1_NOETIC)
Bool = store.types["std_msgs/msg/Bool"]
with Writer("run.bag") as writer:
    button, watchdog = (
        writer.add_connection(
            "/stop", Bool.__msgtype__, typestore=store, callerid=node, latching=latches
        )
        for node, latches in (("/button", 1), ("/watchdog", 0))
    )
    for second in range(1, 5):
        data = store.serialize_ros1(Bool(data=True), Bool.__msgtype__)
        writer.write(button if second % 2 else watchdog, second * 10**9, data)
END
cat > read.py <<'END'
import sys

from rosbags.rosbag1 import Reader

with Reader(sys.argv[1]) as reader:
    print(*(connection.ext.callerid for connection, _, _ in reader.messages()))
END
publishers() { venv/bin/python read.py "$1"; }
venv/bin/python write.py
venv/bin/rosbags-convert --src run.bag --dst converted.bag
cp run.bag compressed.bag
(
    export PYTHONPATH="$folder/usr/lib/python3/dist-packages"
    LD_LIBRARY_PATH="$(echo "$folder"/usr/lib/*-linux-gnu)"
    export LD_LIBRARY_PATH
    /usr/bin/python3 usr/bin/rosbag filter run.bag filtered.bag True
    /usr/bin/python3 usr/bin/rosbag compress compressed.bag
) > /dev/null 2>&1
seen="recorded: $(publishers run.bag)
rosbags-convert: $(publishers converted.bag)
rosbag filter: $(publishers filtered.bag)
rosbag compress: $(publishers compressed.bag)"
echo "$seen"
[ "$seen" = "recorded: /button /watchdog /button /watchdog
rosbags-convert: /button /watchdog /button /watchdog
rosbag filter: /button /button /button /button
rosbag compress: /button /button /button /button" ]
