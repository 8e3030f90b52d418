"""An observer on the wire of a running node: what leaves it is allowed when it leaves.

A robot with a message, a service, an action and an action that is only forbidden *to start*; each of
them is wanted all the time. Its servers are absent, late, slow, refuse, die, or serve somebody
else; meanwhile the e-stop is pressed, or the node is made to stand still. What then arrives at the
robot is judged by the robot's side alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from ros_support import run_robosc

__all__ = [
    "ACTIONS", "CALLS", "EVENTS", "MODES", "NODES", "SERVERS", "World", "faults", "generate",
]  # fmt: skip

MODES = ("controller", "supervisor")
NODES = (*MODES, "lax")
"""The lax one does not know the button: it is what the supervisor guards."""

SERVERS = ("absent", "late", "slow", "refusing", "dying", "foreign")
EVENTS = ("e-stop", "hold", "safe stop", "deactivate", "signal")
CALLS = ("light", "reach", "fetch")
ACTIONS = ("reach", "fetch")
UNREADY = ("absent", "late", "foreign")
SETTLED = 0.3
"""Seconds, by the node's clock, in which what was on its way before the event has arrived."""
LONG = 1.2
"""Seconds, by the node's clock, in which whoever would send something has sent it."""

_MODEL = """
robot Wire {
    interface switch use SetBool from std_srvs
    interface move use ACTION
    datatype object Request { data: boolean }
    datatype object Answer { success: boolean }
    datatype object Goal { GOAL }

    component Wish {
        outgoing message wanted with identifier: "/wanted", type: boolean
        behaviour {
            variable on: boolean
            on response from wanted do on := value
            initial marked state looking {}
        }
    }
    component Button {
        outgoing message estop with identifier: "/estop", type: boolean
        behaviour {
            variable pressed: boolean
            on response from estop do pressed := value
            initial marked state looking {}
        }
    }
    component Gauge {
        outgoing message level with identifier: "/level", type: integer(0..9)
    }
    component Base {
        incoming message drive with identifier: "/drive", type: integer
        incoming message halt with identifier: "/halt", type: none
    }
    component Lamp {
        service light with identifier: "/light", request: Request, response: Answer links switch
        behaviour {
            initial marked state resting { on request to light goto asking }
            state asking { on response, error from light goto resting }
        }
    }
    component Arm {
        action reach with identifier: "/reach", request: Goal, response: none, feedback: none
            links move
        behaviour {
            initial marked state resting { on request to reach goto moving }
            state moving { on response, error, cancelled from reach goto resting }
        }
    }
    component Gripper {
        action fetch with identifier: "/fetch", request: Goal, response: none, feedback: none
            links move
        behaviour {
            initial marked state resting { on request to fetch goto moving }
            state moving { on response, error, cancelled from fetch goto resting }
        }
    }

    requirement drive needs ALLOWED
    requirement light needs ALLOWED
    requirement reach needs ALLOWED
    requirement fetch needs ALLOWED to start
    requirement halt needs !Wish.on
    provide drive with 3
    provide light with { data: true }
    provide reach with { VALUE }
    provide fetch with { VALUE }
    stop with halt
}
"""

_TYPES = {
    1: ("Test from actionlib", "goal: integer", "goal: 5"),
    2: ("Move from robosc_testing", "target: double", "target: 5.0"),
}


def model(ros: int, lax: bool = False) -> str:
    """The robot; ``lax``: for a controller that does not know the button."""
    use, goal, value = _TYPES[ros]
    allowed = "Wish.on" if lax else "Wish.on and !Button.pressed"
    text = _MODEL.replace("ACTION", use).replace("GOAL", goal).replace("VALUE", value)
    return text.replace("ALLOWED", allowed)


def generate(
    folder: Path, ros: int, packages: Mapping[str, tuple[str, ...]], environment: dict[str, str]
) -> None:
    """Generate packages ``wire_NAME`` into ``src`` of a folder, each with more arguments."""
    for name, arguments in packages.items():
        file = folder / f"{name}.rscd"
        file.write_text(model(ros, lax=name == "lax"), encoding="utf-8")
        mode = "supervisor" if name.endswith("supervisor") else "controller"
        words = ("--target", f"ros{ros}", "--mode", mode, "--package", f"wire_{name}")
        words = ("generate", str(file), *words, "--output", "src", *arguments)
        done = run_robosc(words, folder, environment, tested=False)
        assert done.returncode == 0, done.stderr


class World(Protocol):
    """A running node, alone or as the supervisor of one that wants everything, and its robot."""

    def serve(self, server: str) -> None:
        """Offer the service and both actions."""

    def kill_servers(self) -> None: ...

    def free_servers(self) -> None:
        """End the goals of somebody else."""

    def begin(self) -> None:
        """Start the node, and wait until it is connected."""

    def say(self, topic: str, value: Any) -> None: ...

    def order(self, what: str) -> None:
        """Hold, release, deactivate or activate the node, or end it and wait for that."""

    def shows(self, condition: Callable[[dict[str, Any]], Any]) -> dict[str, Any]:
        """The next state that the node shows and that meets the condition."""

    def asks(self, names: tuple[str, ...]) -> None:
        """Wait until who wants everything has asked for these, whether they are sent or not."""

    def heard(self) -> Counter[str]:
        """How often the robot was told what: names of commands, and "cancel NAME"."""

    def until(self, condition: Callable[[], Any], what: str) -> None: ...


def faults(world: World, server: str, event: str) -> list[str]:
    """What arrived at the robot, or did not, that is wrong."""
    if server not in ("absent", "late"):
        world.serve(server)
    world.begin()
    world.say("wanted", True)
    world.until(lambda: world.heard()["drive"], "the first drive")
    if server in UNREADY:
        actions = ACTIONS if server == "foreign" else CALLS
        world.asks(actions)
        wrong = [f"{name} was sent to a server that is {server}" for name in _sent(world, actions)]
    else:
        world.until(lambda: len(_sent(world, CALLS)) == 3, "all requests")
        wrong = []
    if server == "dying":
        world.kill_servers()
    halts = world.heard()["halt"]
    time = _happens(world, event)
    before = world.heard()
    if server in ("late", "dying"):
        world.serve("slow")
    elif server == "foreign":
        world.free_servers()
    if time is not None:
        world.shows(lambda s: s["time"] > time + LONG)
    after = world.heard() - before
    wrong += [
        f"{name} arrived {count} times after the {event}"
        for name, count in after.items()
        if name != "halt" and not name.startswith("cancel")
    ]
    if server == "slow":
        wrong += _uncancelled(world, ("reach",) if event == "e-stop" else ACTIONS)
    if event != "e-stop" and world.heard()["halt"] == halts:
        wrong.append(f"no stop command at the {event}")
    if not wrong and event in ("e-stop", "hold", "deactivate"):
        wrong += _stuck(world, event, server)
    return wrong


def _sent(world: World, names: tuple[str, ...]) -> list[str]:
    heard = world.heard()
    return [name for name in names if heard[name]]


def _uncancelled(world: World, names: tuple[str, ...]) -> list[str]:
    heard = world.heard()
    return [
        f"the goal of {name} was not cancelled" for name in names if not heard[f"cancel {name}"]
    ]


def _happens(world: World, event: str) -> float | None:
    """Have it happen; when the node showed that for so long that nothing is on its way any more."""
    if event == "signal":
        world.order("end")
        return None
    if event == "e-stop":
        world.say("estop", True)
    elif event == "safe stop":
        world.say("level", 77)
    else:
        world.order(event)
    done: Callable[[dict[str, Any]], Any] = lambda s: s["stopped"]  # noqa: E731
    if event == "e-stop":
        done = lambda s: s["variables"]["Button.pressed"]  # noqa: E731
    first = world.shows(done)["time"]
    return float(world.shows(lambda s: s["time"] > first + SETTLED)["time"])


def _stuck(world: World, event: str, server: str) -> list[str]:
    """Let it go on; what is wanted and not sent, though it may be."""
    before = world.heard()
    if event == "e-stop":
        world.say("estop", False)
    else:
        world.order({"hold": "release", "deactivate": "activate"}[event])
    wanted = {"drive"}
    if server in ("late", "dying", "foreign"):
        wanted |= {"reach", "fetch"}
    world.until(lambda: wanted <= (world.heard() - before).keys(), f"{sorted(wanted)} once more")
    return []
