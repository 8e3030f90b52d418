#!/bin/sh
# rospy 1.15.15: publish() while the node ends raises AttributeError. _PublisherImpl.publish looks whether
# the topic is closed, and then takes its buffer; close() sets the buffer to None. In between, on Ctrl-C,
# "b.tell()" is that of None, outside of what publish() catches (ValueError of a closed buffer). actionlib's
# timer publishes the status of goals all the time, so that its thread ends with a traceback now and then.
# Seen: "AttributeError: 'NoneType' object has no attribute 'tell'", in one line.
set -eu
port=${PORT:-12977}
export ROS_MASTER_URI="http://127.0.0.1:$port" ROS_IP=127.0.0.1
folder=$(mktemp -d)
export ROS_LOG_DIR="$folder"
/usr/bin/python3 /usr/bin/rosmaster --core -p "$port" > "$folder/master.txt" 2>&1 &
master=$!
trap 'kill $master; rm -rf "$folder"' EXIT
cat > "$folder/run.py" <<'END'
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
seen=$(/usr/bin/python3 "$folder/run.py" | tail -n 1)  # before it, that the master is not there yet
echo "$seen"
[ "$seen" = "AttributeError: 'NoneType' object has no attribute 'tell'" ]
