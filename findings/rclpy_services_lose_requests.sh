#!/bin/sh
# rclpy 7.1.6 (Jazzy, Fast DDS): a service loses calls without a word. Services have the quality of
# service "reliable", which makes one expect that none is lost, but keep ten: of requests that come
# while the server handles another, the newest ten take the places of all before. Those are never
# answered, their futures never end, and neither side is told; a client with no deadline of its own
# waits for ever.
# Fifty calls are made at once, to a server that is busy for two seconds with a call before them.
# Seen: "answered 11 of 51: 0 41 42 43 44 45 46 47 48 49 50", in one line.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check empy==3.3.4
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    "ros-jazzy-rclpy[fastrtps]==7.1.6" ros-jazzy-lifecycle-msgs==2.0.3
cat > "$folder/run.py" <<'END'
import subprocess
import sys
import time

import rclpy
from lifecycle_msgs.srv import GetState

AT_ONCE = 50
rclpy.init()
if len(sys.argv) > 1:
    node = rclpy.create_node("server")

    pauses = iter([2.0])

    def answer(request, response):
        time.sleep(next(pauses, 0.2))  # so that the client takes each answer before the next
        return response

    node.create_service(GetState, "ask", answer)
    rclpy.spin(node)
node = rclpy.create_node("client")
server = subprocess.Popen([sys.executable, __file__, "serve"])
client = node.create_client(GetState, "ask")
client.wait_for_service()
calls = [client.call_async(GetState.Request())]
time.sleep(1)  # the server has it, and is busy
calls += [client.call_async(GetState.Request()) for _ in range(AT_ONCE)]
end = time.monotonic() + 30
while time.monotonic() < end and not calls[-1].done():
    rclpy.spin_once(node, timeout_sec=0.1)
for _ in range(20):  # the server has answered the last: nothing else comes
    rclpy.spin_once(node, timeout_sec=0.1)
answered = [str(number) for number, call in enumerate(calls) if call.done()]
print(f"answered {len(answered)} of {len(calls)}: {' '.join(answered)}")
server.kill()
END
cd "$folder"
seen=$(ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$folder/venv/bin/python" run.py)
echo "$seen"
[ "$seen" = "answered 11 of 51: 0 41 42 43 44 45 46 47 48 49 50" ]
