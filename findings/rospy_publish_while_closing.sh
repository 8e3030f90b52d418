#!/bin/sh
# rospy 1.15.15 (Debian 12): publish() while the node ends can raise AttributeError, which is none of
# the exceptions that its documentation has. _PublisherImpl.publish looks whether the topic is closed,
# and then takes its buffer; close() sets the buffer to None. In between, on Ctrl-C, "b.tell()" is
# that of None, outside of what publish() catches (ValueError of a closed buffer). actionlib's timer
# publishes the status of goals all the time, so that its thread ends with a traceback now and then.
# Here the end comes just between the two, since what publish() asks there makes it.
# Seen: "AttributeError: 'NoneType' object has no attribute 'tell'", in one line.
set -eu
folder=$(mktemp -d)
trap 'kill "${master:-}" 2> /dev/null || true; rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq python3-rospy=1.15.15+ds-2 python3-rosgraph=1.15.15+ds-2 \
    python3-rosmaster=1.15.15+ds-2 python3-roslib=1.15.8-3 python3-genpy=0.6.16-2 python3-genmsg \
    python3-std-msgs=0.5.13-2 python3-rosgraph-msgs=1.11.3-2 python3-roscpp-msg python3-rospkg=1.4.0-2 \
    python3-catkin-pkg=0.5.2-5 python3-yaml \
    python3-netifaces python3-defusedxml python3-distro python3-dateutil python3-six \
    python3-pyparsing python3-docutils 2> /dev/null
for package in *.deb; do dpkg -x "$package" .; done
export PYTHONPATH="$folder/usr/lib/python3/dist-packages"
port=${PORT:-12977}
export ROS_MASTER_URI="http://127.0.0.1:$port" ROS_IP=127.0.0.1 ROS_LOG_DIR="$folder"
/usr/bin/python3 usr/bin/rosmaster --core -p "$port" > master.txt 2>&1 &
master=$!
cat > run.py <<'END'
import rospy
from std_msgs.msg import Bool

rospy.init_node("finding", disable_signals=True)
publisher = rospy.Publisher("topic", Bool, queue_size=1)


def ends():  # called between the two, in publish()
    rospy.signal_shutdown("Ctrl-C")
    return True


publisher.impl.has_connections = ends
try:
    publisher.publish(Bool())
except Exception as error:
    print(f"{type(error).__name__}: {error}")
END
seen=$(/usr/bin/python3 run.py | tail -n 1)  # before it, that the master is not there yet
echo "$seen"
[ "$seen" = "AttributeError: 'NoneType' object has no attribute 'tell'" ]
