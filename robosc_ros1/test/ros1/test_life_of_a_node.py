"""Start, end, and everything that happens to a node in between."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
import ros_support
from ros1.stage import Node, Puppet, Stage, event, master_pid
from ros_support import Master, Workspace, await_condition, processor_clock, stopped

RUN = {"name": "/run", "type": "gauntlet_interfaces/ReachAction"}
ASK = {"name": "/ask", "type": "gauntlet_interfaces/SetLevel"}
BOOL = "std_msgs/Bool"

BUDGET = 2.0
"""A node ends within so many seconds, says docs/running.md, on a machine that is not busy."""


@contextmanager
def ends_in_time() -> Iterator[None]:
    """What is done here takes no longer than a node may take to end."""
    with processor_clock() as clock:
        yield
        assert clock() < 2 * BUDGET


def end(stage: Stage, how: str, pid: int) -> None:
    if how == "rosnode kill":
        stage.workspace.run("rosnode", "kill", "/probe_controller", master=stage.master)
    else:
        os.kill(pid, getattr(signal, how))


def address(master: Master, node: str) -> str:
    """Where the master believes a node to be; nothing, if it knows of none."""
    answer: Any = ServerProxy(master.uri)
    return str(answer.lookupNode("/test", node)[2])


@pytest.mark.once
@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP", "rosnode kill"])
def test_shutdown_cancels_goals_and_sends_the_stop_command(
    stage: Stage, puppet: Puppet, ear: Puppet, how: str
) -> None:
    puppet.do("action", **RUN, mode="hold")
    puppet.do("listen", topic="/halt", type="std_msgs/Empty")
    with stage.controller(ear, stop_command="halt") as node:
        puppet.publish("/level", "std_msgs/Int16", 9)
        puppet.publish("/run_wanted", BOOL, True)
        puppet.wait(lambda line: line.get("asked") == "/run", "the goal")
        node.tells(event("request", "blow"))
        mark = puppet.mark
        # The tool of the third way takes its own time.
        with ends_in_time() if how != "rosnode kill" else nullcontext():
            end(stage, how, node.process.pid)
            assert node.process.wait(60) in (0, -signal.SIGTERM, -signal.SIGINT)
        puppet.wait(lambda line: line.get("cancelled") == "/run", "the cancel", since=mark)
        puppet.hears("/halt", since=mark)
        assert "Traceback" not in node.log


def test_the_end_waits_for_nobody_who_stands_still(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    """Neither the master, nor a listener, nor servers with a call and a goal under way."""
    puppet.do("listen", topic="/halt", type="std_msgs/Empty")
    with stage.puppet() as still, stage.controller(ear, stop_command="halt") as node:
        still.do("action", **RUN, mode="hold")
        still.do("service", **ASK, mode="hang")
        still.do("listen", topic="/probe_controller/events", type="std_msgs/String")
        puppet.publish("/run_wanted", BOOL, True)
        puppet.publish("/ask_wanted", BOOL, True)
        for name in ("/run", "/ask"):
            still.wait(lambda line, name=name: line.get("asked") == name, "the request")
        mark = puppet.mark
        with stopped(still.process.pid), stopped(master_pid(stage.master)):
            with ends_in_time():
                node.process.send_signal(signal.SIGINT)
                assert node.process.wait(60) == 0
            puppet.hears("/halt", since=mark)
        still.wait(lambda line: line.get("cancelled") == "/run", "the cancel")
        assert "Traceback" not in node.log


def nowhere() -> Master:
    """Where no master is."""
    return Master(ros_support.free_port())


def test_it_may_end_before_there_is_a_master(generated_workspace: Workspace) -> None:
    name = "probe_controller"
    with generated_workspace.start("rosrun", name, name, master=nowhere()) as process:
        log: Path = process.log  # type: ignore[attr-defined]
        await_condition(lambda: "master may not be running yet" in log.read_text(), "the wait")
        with ends_in_time():
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == 0
        assert "Traceback" not in log.read_text()


SIGNALLED = """
import os, signal, sys
class Signalling:
    def find_spec(name, path=None, target=None):
        if name == "rospy":
            os.kill(os.getpid(), signal.{how})
sys.meta_path.insert(0, Signalling)
from probe_controller.start import main
main()
"""


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_it_may_end_while_modules_are_imported(generated_workspace: Workspace, how: str) -> None:
    """On a busy machine that takes seconds."""
    command = ("python3", "-c", SIGNALLED.format(how=how))
    with generated_workspace.start(*command, master=nowhere()) as process:
        assert process.wait(60) == 0
        assert process.log.read_text() == ""  # type: ignore[attr-defined]


# What holds up the end of a process: rospy's log, and what Python does after all else.
HOLDING = {
    "log": "import logging; logging.getLogger('rospy.core').addFilter(lambda _: sleep(60))",
    "exit": """
import sys, types
class Held:
    def __del__(self, sleep=sleep):
        sleep(60)
sys.modules["held"] = types.ModuleType("held")
sys.modules["held"].held = Held()
""",
}


@pytest.mark.parametrize("what", HOLDING)
def test_nothing_holds_up_its_end(stage: Stage, ear: Puppet, what: str) -> None:
    begin = "from probe_controller.start import main; main()"
    code = f"from time import sleep\n{HOLDING[what]}\n{begin}"
    ear.do("listen", topic="/probe_controller/state", type="std_msgs/String")
    with stage.workspace.start("python3", "-c", code, master=stage.master) as process:
        ear.hears("/probe_controller/state")
        with ends_in_time():
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == 0


def test_it_may_start_before_there_is_a_master(
    generated_workspace: Workspace, ros: None, tmp_path: Path
) -> None:
    late = ros_support.Master(ros_support.free_port())
    name = "probe_controller"
    with generated_workspace.start("rosrun", name, name, master=late) as process:
        log: Path = process.log  # type: ignore[attr-defined]
        await_condition(lambda: "master may not be running yet" in log.read_text(), "the wait")
        stage = Stage(generated_workspace, late)
        with ros_support.master(tmp_path, late.port), stage.puppet() as puppet:
            puppet.do("listen", topic="/blow", type="std_msgs/Int16")
            puppet.publish("/level", "std_msgs/Int16", 9)
            puppet.hears("/blow")


def test_the_stop_command_may_be_a_service(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("service", **ASK, mode="answer", delay=0.2)
    with stage.controller(ear, stop_command="ask") as node:
        node.process.send_signal(signal.SIGINT)
        puppet.wait(lambda line: line.get("asked") == "/ask", "the stop command")
        assert node.process.wait(60) == 0


def test_a_second_node_of_the_same_name_takes_over(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear) as first, stage.controller(ear) as second:
        first.process.wait(60)
        puppet.publish("/level", "std_msgs/Int16", 9)
        second.tells(event("request", "blow"))
        assert second.process.poll() is None


def node_pid(master: Master, node: str) -> int | None:
    """The process of a node; None where none answers."""
    with suppress(OSError):
        uri: Any = ServerProxy(master.uri).lookupNode("/test", node)[2]  # type: ignore[index]
        return int(ServerProxy(uri).getPid("/test")[2])  # type: ignore[index, call-overload]
    return None


def test_what_is_meant_for_the_one_who_had_its_address_does_not_end_it(
    stage: Stage, ear: Puppet
) -> None:
    """As the master tells a node whose name a new one takes, at whatever address it had."""
    reason = "[%s] Reason: new node registered with same name"
    with stage.controller(ear) as node:
        node_itself: Any = ServerProxy(address(stage.master, node.name))
        assert node_itself.shutdown("/master", reason % "/camera")[0] == 1
        assert node_itself.shutdown("/master", reason % f"{node.name}_too")[0] == 1
        shown = node.ear.mark
        node.shows(lambda s: s["stopped"] is None, since=shown)
        with suppress(OSError):  # it may end before it answers
            node_itself.shutdown("/master", reason % node.name)
        assert node.process.wait(60) == 0


def test_no_address_of_a_node_that_has_ended_is_known(stage: Stage, ear: Puppet) -> None:
    """Also where it wrote to the log: of a parameter that there is not."""
    with stage.controller(ear, timout__run=1.0) as node:
        assert "is ignored" in node.log
        end(stage, "SIGTERM", node.process.pid)
        node.process.wait(60)
        assert address(stage.master, node.name) == ""


def test_roslaunch_starts_it_again(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    for topic in ("events", "state"):
        ear.do("listen", topic=f"/probe_controller/{topic}", type="std_msgs/String")
    with stage.workspace.start(
        "roslaunch", "probe_controller", "probe_controller.launch", "respawn:=true",
        "rate:=50.0", "stop_command:=halt", master=stage.master,
    ):  # fmt: skip
        ear.hears("/probe_controller/state")
        done = stage.workspace.run(
            "rosparam", "get", "/probe_controller/rate/default", master=stage.master
        )
        assert done.stdout.strip() == "50.0"
        mark = ear.mark
        pid = node_pid(stage.master, "/probe_controller")
        assert pid is not None
        os.kill(pid, signal.SIGKILL)
        await_condition(
            lambda: node_pid(stage.master, "/probe_controller") not in (None, pid), "the next node"
        )
        puppet.publish("/level", "std_msgs/Int16", 9)
        ear.hears("/probe_controller/events", event("request", "blow"), since=mark)


def test_the_master_is_killed_and_restarted(
    generated_workspace: Workspace, ros: None, tmp_path: Path
) -> None:
    (tmp_path / "first").mkdir()
    (tmp_path / "second").mkdir()
    with ros_support.master(tmp_path / "first") as running:
        stage = Stage(generated_workspace, running)
        with stage.puppet() as ear, stage.controller(ear) as node:
            with stage.puppet() as before:
                before.publish("/level", "std_msgs/Int16", 9)
                node.tells(event("request", "blow"))
                end_master(running)
                # What is connected goes on.
                before.publish("/level", "std_msgs/Int16", 3)
                node.tells(event("request", "halt"))
                await_condition(lambda: "does not answer" in node.log, "the warning")
            with ros_support.master(tmp_path / "second", running.port):
                await_condition(lambda: "registering again" in node.log, "the registration")
                with stage.puppet() as after:
                    mark = ear.mark
                    after.publish("/level", "std_msgs/Int16", 9)
                    node.tells(event("request", "blow"), since=mark)
                    after.do("listen", topic="/blow", type="std_msgs/Int16")
                    after.hears("/blow")
                node.process.send_signal(signal.SIGINT)
                assert node.process.wait(60) == 0


def end_master(running: ros_support.Master) -> None:
    """Kill the rosmaster process, and wait until it is gone."""
    os.kill(master_pid(running), signal.SIGKILL)
    await_condition(lambda: not running.answers(), "the end of the master")


# What rospy does if it handles the answer to a subscription after an update that came later.
FORGETFUL = """
from rospy.impl.registration import RegManager
from probe_controller.start import main
remember, forgotten = RegManager.publisher_update, []
def publisher_update(self, name, uris):
    if name != "/level" or forgotten:
        return remember(self, name, uris)
    forgotten.append(uris)
RegManager.publisher_update = publisher_update
main()
"""


def test_it_connects_where_rospy_forgets_who_publishes(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    for topic in ("events", "state"):
        ear.do("listen", topic=f"/probe_controller/{topic}", type="std_msgs/String")
    level = {"topic": "/level", "type": "std_msgs/Int16", "fields": {"data": 7}}
    puppet.do("publish", **level, connected=False, times=0)
    with stage.workspace.start("python3", "-c", FORGETFUL, master=stage.master) as process:
        ear.hears("/probe_controller/state")
        stage.master.await_links("/probe_controller")
        puppet.do("publish", **level)
        Node(process, "/probe_controller", ear, 0).tells(event("response", "level", value=7))


LOOKS = """
import rospy
from probe_controller.ros_tables import Tables
from probe_controller.ros_watch import Watch
rospy.init_node("looking")
watch, told = Watch(Tables((), (), (), ()), ""), []
watch._strangers = lambda *_: {("/rosout", "", "/other", "", "getPublications")}
watch._announce = lambda *_: told.append("announced")
watch._fault = lambda *_: told.append("asked")
for _ in range(4):
    watch._look_around()
    told.append("looked")
print(*told)
"""


def test_who_may_only_be_connecting_is_not_announced(stage: Stage) -> None:
    """It would connect twice, and lose what is sent over the first connection."""
    done = stage.workspace.run("python3", "-c", LOOKS, master=stage.master)
    assert done.stdout.endswith("looked announced looked asked looked asked looked\n")


def test_it_ends_when_the_master_is_gone(
    generated_workspace: Workspace, ros: None, tmp_path: Path
) -> None:
    with ros_support.master(tmp_path) as running:
        stage = Stage(generated_workspace, running)
        with stage.puppet() as ear, stage.controller(ear) as node:
            end_master(running)
            with ends_in_time():
                node.process.send_signal(signal.SIGINT)
                node.process.wait(60)
