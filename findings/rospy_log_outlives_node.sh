#!/bin/sh
# rospy 1.15.15 with rosmaster 1.15.15 (Debian 12): a node that wrote to the log once is known to the
# master after it has ended, and what has its address then is told to shut down. rospy subscribes to
# the parameter /rosout_disable_topics_generation with the first entry in the log and never
# unsubscribes, so that the master keeps the node, which has unregistered all topics and services, with
# its address. When a node of that name starts again, the master calls "shutdown" at the old address. A
# port is soon given to another process; if that is a node, it shuts down, since rospy does not look
# whose name the request has. The test suite of this project, which starts many nodes, lost some so.
# Seen: of two nodes that ended, one of which had logged, the master knows that one; and another node,
# which got its port, ends with "[/camera] Reason: new node registered with same name".
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
port=${PORT:-12978}
export ROS_MASTER_URI="http://127.0.0.1:$port" ROS_IP=127.0.0.1 ROS_LOG_DIR="$folder"
/usr/bin/python3 usr/bin/rosmaster --core -p "$port" > master.txt 2>&1 &
master=$!
cat > node.py <<'END'
import sys

import rospy

name, what, port = sys.argv[1:]
rospy.init_node(name, disable_signals=True, xmlrpc_port=int(port))
if what == "logs":
    rospy.logwarn("something")
if what == "waits":
    print("up", flush=True)
    rospy.spin()
else:
    print(rospy.get_node_uri().rsplit(":", 1)[1].strip("/"), flush=True)
END
cat > known.py <<'END'
import sys
from xmlrpc.client import ServerProxy

print(ServerProxy(sys.argv[1]).lookupNode("/finding", "/" + sys.argv[2])[0] == 1)
END
node() { /usr/bin/python3 node.py "$@" 2>> errors.txt; }
until /usr/bin/python3 known.py "$ROS_MASTER_URI" camera > known.txt 2>&1; do sleep 0.1; done
node silent is_silent 0 > silent.txt
used=$(node camera logs 0 | tail -n 1)
seen="silent known: $(/usr/bin/python3 known.py "$ROS_MASTER_URI" silent)"
seen="$seen, camera known: $(/usr/bin/python3 known.py "$ROS_MASTER_URI" camera)"
node other waits "$used" > other.txt &
other=$!
until grep -q up other.txt; do sleep 0.1; done
node camera is_silent 0 > camera.txt
wait "$other"
seen="$seen; $(grep -v up other.txt)"
echo "$seen"
[ "$seen" = "silent known: False, camera known: True; shutdown request:\
 [/camera] Reason: new node registered with same name" ]
