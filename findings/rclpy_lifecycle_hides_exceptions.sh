#!/bin/sh
# rclpy 7.1.6 (Jazzy) says nothing of an exception in a callback of a lifecycle node: no traceback,
# no line of the log, at no level. The transition ends with ERROR, the default on_error() answers
# SUCCESS, and so the node is unconfigured again, as if nothing had been asked; a manager that
# configures it sees "error" and no reason. A node has to catch and log what its callbacks raise.
# Seen: "result ERROR, state unconfigured, words of the exception in the output 0".
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check empy==3.3.4
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    "ros-jazzy-rclpy[fastrtps]==7.1.6" ros-jazzy-lifecycle-msgs==2.0.3
cat > "$folder/run.py" <<'END'
import sys

import rclpy
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.lifecycle import LifecycleNode


class Driver(LifecycleNode):
    def on_configure(self, state):
        raise OSError("the device is missing")


rclpy.init(args=["--ros-args", "--log-level", "debug"])
node = Driver("driver")
other = rclpy.create_node("manager")
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(node)
executor.add_node(other)


def ask(type_, service, request):
    client = other.create_client(type_, f"driver/{service}")
    client.wait_for_service()
    future = client.call_async(request)
    executor.spin_until_future_complete(future, 60)
    return future.result()


request = ChangeState.Request()
request.transition.id = 1  # configure
done = ask(ChangeState, "change_state", request)
state = ask(GetState, "get_state", GetState.Request())
print(f"result {'SUCCESS' if done.success else 'ERROR'}, state {state.current_state.label}")
END
cd "$folder"
seen=$(ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$folder/venv/bin/python" run.py 2> log)
seen="$seen, words of the exception in the output $(grep -c "device is missing\|OSError" log || true)"
echo "$seen"
[ "$seen" = "result ERROR, state unconfigured, words of the exception in the output 0" ]
