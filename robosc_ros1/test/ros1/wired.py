"""The world of ``wire.py`` on a roscore."""

from __future__ import annotations

import contextlib
import signal
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import ros_support
import wire
from ros1.stage import PATIENCE, PUPPET, Puppet, action
from ros_support import Master, await_condition, plain_environment

__all__ = ["packages", "world"]

TYPES = {
    "wanted": "std_msgs/Bool",
    "estop": "std_msgs/Bool",
    "level": "std_msgs/Int16",
    "drive": "std_msgs/Int16",
    "halt": "std_msgs/Empty",
}
SUPERVISED = ("drive", "halt", "light", *action("reach"), *action("fetch"), "wanted", "estop")
SERVICES = {"refusing": "fail"}
GOALS = {"refusing": "reject"}


def packages(folder: Path) -> None:
    """Generate a controller, a supervisor, and a controller for that which wants everything."""
    wire.generate(folder, 1, dict.fromkeys(wire.NODES, ()), {})


class _World:
    def __init__(
        self, stack: contextlib.ExitStack, made: Path, mode: str, master: Master,
        folder: Path,
    ) -> None:  # fmt: skip
        self._stack = stack
        self._made = made
        self._mode = mode
        self._master = master
        self._folder = folder
        self._env = plain_environment(**master.environment, ROS_LOG_DIR=str(folder))
        self._ear = self._puppet()
        self._servers: list[Puppet] = []
        self._node: Any = None

    def _puppet(self) -> Puppet:
        log = self._folder / "puppet.log"
        process = self._stack.enter_context(
            ros_support.forked_process(PUPPET, self._env, log, True)
        )
        self._stack.callback(self._master.forget, f"/puppet_{process.pid}_")
        self._stack.callback(process.kill)
        return Puppet(process)

    def serve(self, server: str) -> None:
        puppet = self._puppet()
        self._servers.append(puppet)
        mode = SERVICES.get(server, "hold")
        puppet.do("service", name="/light", type="std_srvs/SetBool", mode=mode)
        for name in wire.ACTIONS:
            mode = GOALS.get(server, "hold")
            puppet.do("action", name=f"/{name}", type="actionlib/TestAction", mode=mode)
            if server == "foreign":
                puppet.do("shout", name=f"/{name}", count=1)
                puppet.wait(lambda line, n=name: line.get("asked") == f"/{n}", "another's goal")
                del puppet.lines[:]

    def kill_servers(self) -> None:
        process = self._servers[-1].process
        process.kill()
        process.wait()

    def free_servers(self) -> None:
        for name in wire.ACTIONS:
            self._servers[-1].do("finish", name=f"/{name}", mode="succeed")

    def begin(self) -> None:
        for topic in ("drive", "halt"):
            self._ear.do("listen", topic=f"/{topic}", type=TYPES[topic])
        self._node = self._start(self._mode if self._mode == "controller" else "supervisor")
        if self._mode == "supervisor":
            rules = [f"/{name}:=/supervised/{name}" for name in SUPERVISED]
            self._start("lax", *rules)

    def _start(self, name: str, *rules: str) -> Any:
        package = self._made / "src" / f"wire_{name}"
        mark = self._ear.mark
        self._ear.do("listen", topic=f"/wire_{name}/state", type="std_msgs/String")
        parameters = {
            "operate": "true", "on_mismatch": "stop", "state_rate": "20", "timeout/light": "90",
            "timeout/reach": "90", "timeout/fetch": "90", "rate": "10",
        }  # fmt: skip
        words = [f"_{key}:={value}" for key, value in parameters.items()]
        code = f"from wire_{name}.start import main; main()"
        env = self._env | {"PYTHONPATH": f"{package / 'src'}:{self._env.get('PYTHONPATH', '')}"}
        command = ["-c", code, *rules, *words]
        node = self._stack.enter_context(
            ros_support.forked_process(command, env, self._folder / f"{name}.log")
        )
        self._stack.callback(self._master.forget, f"/wire_{name}")
        self._ear.hears(f"/wire_{name}/state", since=mark)
        self._master.await_links(f"/wire_{name}")
        return node

    def say(self, topic: str, value: Any) -> None:
        self._ear.publish(f"/{topic}", TYPES[topic], value)

    def order(self, what: str) -> None:
        if what == "end":
            self._node.send_signal(signal.SIGINT)
            self._node.wait(PATIENCE)
        else:
            self._ear.publish(f"/wire_{self._mode}/operate", "std_msgs/String", what)

    def asks(self, names: tuple[str, ...]) -> None:
        topic = "/wire_lax/state" if self._mode == "supervisor" else "/wire_controller/state"
        self._ear.hears(topic, lambda s: all(s["communications"][n] == "busy" for n in names))

    def shows(self, condition: Callable[[dict[str, Any]], Any]) -> dict[str, Any]:
        return self._ear.hears(f"/wire_{self._mode}/state", condition, since=self._ear.mark)

    def heard(self) -> Counter[str]:
        found: Counter[str] = Counter()
        for puppet in (self._ear, *self._servers):
            with puppet._changed:
                for line in puppet.lines:
                    if line.get("heard") in ("/drive", "/halt"):
                        found[line["heard"][1:]] += 1
                    elif "asked" in line:
                        found[line["asked"][1:]] += 1
                    elif "cancelled" in line:
                        found[f"cancel {line['cancelled'][1:]}"] += 1
        return found

    def until(self, condition: Callable[[], Any], what: str) -> None:
        await_condition(condition, what)


@contextlib.contextmanager
def world(made: Path, mode: str, master: Master, folder: Path) -> Iterator[wire.World]:
    """A node of this mode, one of the ``made`` packages, and its robot, on a master."""
    with contextlib.ExitStack() as stack:
        yield _World(stack, made, mode, master, folder)
