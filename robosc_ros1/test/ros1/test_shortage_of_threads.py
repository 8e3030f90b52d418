"""A node that finds no more threads for a while serves requests again when there are some."""

from __future__ import annotations

import pytest
from ros1.stage import Puppet, Stage

SCRIPT = """
import os, queue, resource, rospy, time
from gauntlet_interfaces.msg import ReachAction
from gauntlet_interfaces.srv import SetLevel
from probe_controller.ros_actions import Action
from probe_controller.ros_calls import Service
from probe_controller.ros_connections import send_promptly
send_promptly()
rospy.init_node("short_of_threads")
caller, told = %s, queue.Queue()
begin = getattr(caller, "call", None) or caller.start
caller.report = lambda token, kind, payload=None: told.put((token, kind))
caller.look = lambda: None
# A thread of rospy that finds no threads for its own connections never works again.
topics = rospy.topics.get_topic_manager()
ours = [t for of in (topics.pubs, topics.subs) for name, t in of.items() if "/served" in name]
while not all(topic.has_connections() for topic in ours):
    time.sleep(0.01)
before = resource.getrlimit(resource.RLIMIT_NPROC)
resource.setrlimit(resource.RLIMIT_NPROC, (1, before[1]))
if os.getuid() == 0:
    os.setuid(65534)  # there is no limit for root
if hasattr(caller, "_ends"):
    caller._ends._settled.clear()  # a status may have come, and shown that all are connected
ready = [caller.ready() for _ in range(20)]
held = vars(caller).get("_connections") or vars(caller).get("_token")
resource.setrlimit(resource.RLIMIT_NPROC, before)
while not caller.ready():
    time.sleep(0.01)
begin({}, 20)
while told.get(timeout=60) != (20, "response"):
    pass
print("ready:", set(ready), "held:", held)
"""


@pytest.mark.parametrize(
    ("server", "caller"),
    [
        (
            {"what": "service", "type": "gauntlet_interfaces/SetLevel", "mode": "answer"},
            'Service("/served", SetLevel)',
        ),
        (
            {"what": "action", "type": "gauntlet_interfaces/ReachAction", "mode": "succeed"},
            'Action("/served", ReachAction)',
        ),
    ],
    ids=["service", "action"],
)
def test_requests_wait_only_while_threads_are_short(
    stage: Stage, puppet: Puppet, server: dict[str, str], caller: str
) -> None:
    puppet.do(**server, name="/served")
    done = stage.workspace.run("python3", "-c", SCRIPT % caller, master=stage.master)
    assert done.stdout.endswith("ready: {False} held: None\n"), done.stdout
