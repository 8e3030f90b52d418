#!/bin/sh
# actionlib 1.14.0 on rospy 1.15.15 (Debian 12): a Python action server stops telling its status for
# good when simulated time steps back once, as when a simulation is reset or a bag is played again. It
# publishes the status by a rospy.Timer without reset=True, whose thread ends then with
# ROSTimeMovedBackwardsException; no callback learns of it. The server goes on taking goals and
# publishes the status with each change of one, so that only who waits for the steady status notices,
# and takes the server for dead. This project found it with its own generated nodes.
# Seen: "status: 4 or more, after the step back: 0", for one second of simulated time each.
set -eu
folder=$(mktemp -d)
trap 'kill "${master:-}" 2> /dev/null || true; rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq python3-actionlib=1.14.0-6 python3-actionlib-msgs=1.13.1-1 \
    python3-rospy=1.15.15+ds-2 python3-rosgraph=1.15.15+ds-2 \
    python3-rosmaster=1.15.15+ds-2 python3-roslib=1.15.8-3 python3-genpy=0.6.16-2 python3-genmsg \
    python3-std-msgs=0.5.13-2 python3-rosgraph-msgs=1.11.3-2 python3-roscpp-msg python3-rospkg=1.4.0-2 \
    python3-catkin-pkg=0.5.2-5 python3-yaml \
    python3-netifaces python3-defusedxml python3-distro python3-dateutil python3-six \
    python3-pyparsing python3-docutils 2> /dev/null
for package in *.deb; do dpkg -x "$package" .; done
export PYTHONPATH="$folder/usr/lib/python3/dist-packages"
port=${PORT:-12979}
export ROS_MASTER_URI="http://127.0.0.1:$port" ROS_IP=127.0.0.1 ROS_LOG_DIR="$folder"
/usr/bin/python3 usr/bin/rosmaster --core -p "$port" > master.txt 2>&1 &
master=$!
cat > run.py <<'END'
import time

import rosgraph
import rospy
from actionlib import ActionServer
from actionlib.msg import TestAction
from rosgraph_msgs.msg import Clock

while not rosgraph.is_master_online():
    time.sleep(0.1)
rospy.set_param("/use_sim_time", True)
rospy.init_node("finding", disable_signals=True)
clock = rospy.Publisher("/clock", Clock, queue_size=100)


def told_in_a_second(start):
    """How many statuses a second of simulated time from ``start`` on brings."""
    before = len(statuses)
    for step in range(101):
        clock.publish(rospy.Time.from_sec(start + step / 100))
        while abs(rospy.get_time() - start - step / 100) > 0.001:
            time.sleep(0.001)  # until this node has the time
        time.sleep(0.01)
    return len(statuses) - before


statuses = []
while rospy.get_time() != 100.0:
    clock.publish(rospy.Time(100))
    time.sleep(0.01)
server = ActionServer("work", TestAction, lambda goal: None, auto_start=False)
server.start()
publish, server.status_pub.publish = server.status_pub.publish, lambda array: (
    statuses.append(array), publish(array)
)
first, second = told_in_a_second(100.01), told_in_a_second(50.0)
print("status: %s, after the step back: %d" % ("4 or more" if first >= 4 else first, second))
END
seen=$(/usr/bin/python3 run.py 2> errors.txt)
echo "$seen; $(grep -c '^rospy.exceptions.ROSTimeMovedBackwardsException' errors.txt) exception"
[ "$seen" = "status: 4 or more, after the step back: 0" ]
grep -q '^rospy.exceptions.ROSTimeMovedBackwardsException' errors.txt
