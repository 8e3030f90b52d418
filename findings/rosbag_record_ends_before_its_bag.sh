#!/bin/sh
# rosbag 1.15.15 (Debian 12): the command "rosbag record" ends on SIGINT while the bag is being written.
# It starts the recorder as a child of its own, hands the signal on, and takes the KeyboardInterrupt that
# follows for its end, with status 0; the recorder first writes what it still holds, and only then gives
# the bag its name. Who waits for the command (roslaunch, a script, subprocess.run with a time-out) finds
# "run.bag.active", which has no index, or no file at all; with bz2 and 100 messages of 1 MB it comes
# seconds later. (SIGTERM is no way out: it ends both at once, and the bag never gets its name.) Wait for
# the bag, not for the command. This project's own tests failed by it once, with a small bag.
# Seen: "status 0, run.bag.active; the bag came later".
set -eu
folder=$(mktemp -d)
trap 'kill "${master:-}" 2> /dev/null || true; rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq python3-rosbag=1.15.15+ds-2 librosbag4d=1.15.15+ds-2 \
    librosbag-storage4d=1.15.15+ds-2 libroscpp4d=1.15.15+ds-2 libxmlrpcpp3d=1.15.15+ds-2 \
    libtopic-tools2d=1.15.15+ds-2 libroslz4-1d=1.15.15+ds-2 librosconsole3d=1.14.3-10+b3 \
    librostime1d libroscpp-serialization0d libcpp-common0d libroslib0d librospack0d \
    libclass-loader3d libament-index-cpp0d librcpputils1d librcutils1d libconsole-bridge1.0 \
    liblog4cxx15 libapr1 libaprutil1 libb64-0d libtinyxml2-9 libicu72 libpython3.11 liblz4-1 \
    libboost-chrono1.74.0 libboost-filesystem1.74.0 libboost-program-options1.74.0 \
    libboost-regex1.74.0 libboost-thread1.74.0 \
    python3-roslz4=1.15.15+ds-2 python3-rospy=1.15.15+ds-2 python3-rosgraph=1.15.15+ds-2 \
    python3-rosmaster=1.15.15+ds-2 python3-roslib=1.15.8-3 python3-genpy=0.6.16-2 python3-genmsg \
    python3-std-msgs=0.5.13-2 python3-rosgraph-msgs=1.11.3-2 python3-roscpp-msg \
    python3-rospkg=1.4.0-2 python3-catkin-pkg=0.5.2-5 python3-catkin python3-yaml \
    python3-netifaces python3-defusedxml python3-distro python3-dateutil python3-six \
    python3-pyparsing python3-docutils python3-gnupg python3-pycryptodome 2> /dev/null
for package in *.deb; do dpkg -x "$package" .; done
export PYTHONPATH="$folder/usr/lib/python3/dist-packages" ROS_PACKAGE_PATH="$folder/usr/share"
export LD_LIBRARY_PATH="$(echo "$folder"/usr/lib/*-linux-gnu)" CMAKE_PREFIX_PATH="$folder/usr"
port=${PORT:-12981}
export ROS_MASTER_URI="http://127.0.0.1:$port" ROS_IP=127.0.0.1 ROS_LOG_DIR="$folder"
/usr/bin/python3 usr/bin/rosmaster --core -p "$port" > master.txt 2>&1 &
master=$!
cat > run.py <<'END'
import base64
import os
import signal
import subprocess
import time

import rosgraph
import rospy
from std_msgs.msg import String

while not rosgraph.is_master_online():
    time.sleep(0.1)
rospy.init_node("finding", disable_signals=True)
text = base64.b64encode(os.urandom(750_000)).decode()
pub = rospy.Publisher("/text", String, queue_size=100)
command = ["usr/bin/rosbag", "record", "-q", "--bz2", "-O", "run", "/text"]
with open("record.txt", "w") as log:
    record = subprocess.Popen(["/usr/bin/python3", *command], stdout=log, start_new_session=True)
while not pub.get_num_connections():
    time.sleep(0.02)
for _ in range(100):
    pub.publish(String(text))
time.sleep(2)  # until the recorder has them
record.send_signal(signal.SIGINT)
status = record.wait()
print("status %s, %s" % (status, *[f for f in os.listdir(".") if f.startswith("run.bag")]), end="; ")
while not os.path.exists("run.bag"):
    time.sleep(0.1)
print("the bag came later")
END
seen=$(/usr/bin/python3 run.py)
echo "$seen"
[ "$seen" = "status 0, run.bag.active; the bag came later" ]
