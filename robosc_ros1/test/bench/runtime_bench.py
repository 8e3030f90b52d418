"""The engine without ROS: cost per event of the line follower, no growth, cost of large robots, and
how late timeouts are.

``--events 10000000`` is eight hours of a busy robot, compressed.
"""

from __future__ import annotations

import argparse
import random
import resource
import threading
import time
from typing import Any

from emit.generated_code import controller_class
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.interfaces import Port
from robosc.runtime.core.model import Command, Communication, Controller, Input
from robosc.runtime.core.settings import read
from robosc.runtime.core.timers import After

__all__ = ["main"]

SIZES = (10, 100, 1000)
"""Numbers of commands, each with a guard over a flag of its own."""
TOUCH_LIMIT = 8.0
"""Microseconds of processor time for an input that concerns one of 1,000 commands."""
GROWTH_LIMIT = 1.5
"""So much more than in the smallest robot may a command cost that is due."""
WATCHED = 50
"""Messages whose silence is noticed."""
SILENCE = 0.1
"""Their timeout, in seconds."""
LATENESS = 5.0
"""Milliseconds after which a timeout must have been acted upon, 99 of 100 times."""
BESIDE = 1.1
"""So much more may an input cost while clocks run that do not concern it."""
LIMIT = 20.0
"""Microseconds of processor time that an event may cost the engine."""


class NullPort(Port):
    """Takes everything and gives services and actions their end, some events later."""

    def __init__(self) -> None:
        self.running: list[tuple[str, int]] = []
        self.sent = 0

    def now(self) -> float:
        return time.monotonic()

    def send(self, key: str, data: Any) -> None:
        self.sent += 1

    def call(self, key: str, data: Any, token: int) -> None:
        self.running.append((key, token))

    start = call

    def cancel(self, key: str, token: int) -> None:
        pass

    def log(self, level: str, text: str) -> None:
        pass


class Message:
    __slots__ = ("data",)

    def __init__(self, data: float | None = None) -> None:
        self.data = data


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--events", type=int, default=1_000_000)
    args = parser.parse_args(arguments)
    model = EXAMPLES / "line_follower" / "line_follower.rscd"
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    controller, _ = controller_class(supervisor)
    port = NullPort()
    engine = controller_engine(controller(), port)
    engine.begin()
    inputs = recorded(random.Random(1))
    parts = []
    for _ in range(10):
        start = time.process_time()
        drive(engine, port, inputs, args.events // 10)
        parts.append((time.process_time() - start) / (args.events // 10) * 1e6)
        parts_memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        if len(parts) == 3:
            early = parts_memory
    counters = engine.recorder.counters
    print(f"engine, line follower, {counters['inputs']} inputs, {counters['commands']} commands")
    print(
        f"  per input {min(parts):.1f} to {max(parts):.1f} us of processor time  (at most {LIMIT:g})"
    )
    print(f"  memory {early} kB after 3/10, {parts_memory} kB at the end")
    missed = sorted(parts)[5] > LIMIT or parts_memory > early * 1.05 or engine.stopped is not None
    return int(wide_robots() | lateness_of_timeouts() | missed)


def wide_robots() -> bool:
    """Measure robots with many commands; whether a target is missed."""
    touched, due = {}, {}
    for size in SIZES:
        touched[size] = min(cost_of_an_input(size) for _ in range(5))
        due[size] = min(cost_of_a_due_command(size) for _ in range(5))
        print(
            f"  {size} commands: {touched[size]:.1f} us per input that concerns one,"
            f" {due[size]:.1f} us per command that is due"
        )
    print(f"  (at most {TOUCH_LIMIT:g} us, and {GROWTH_LIMIT:g} times the smallest robot's)")
    least, largest = due[SIZES[0]], due[SIZES[-1]]
    return touched[SIZES[-1]] > TOUCH_LIMIT or largest > GROWTH_LIMIT * least


def lateness_of_timeouts(rounds: int = 10) -> bool:
    """Measure how late the silence of 50 messages is noticed; whether a target is missed."""
    controller, late = watching_controller()
    settings, _ = read(controller.COMMUNICATIONS, {})
    engine = controller_engine(controller, NullPort(), settings)
    thread = threading.Thread(target=engine.run, daemon=True)
    thread.start()
    posters = [engine.poster([f"In.m{number}"]) for number in range(WATCHED)]
    for turn in range(1, rounds + 1):
        for post in posters:
            post(None)
            time.sleep(0.001)
        while len(late) < turn * WATCHED:
            time.sleep(0.01)
    engine.close()
    thread.join()
    late.sort()
    worst = late[int(len(late) * 0.99)] * 1e3
    print(
        f"  timeouts of {WATCHED} messages: {late[len(late) // 2] * 1e3:.2f} ms late at the median,"
        f" {worst:.2f} ms at 99 %  (at most {LATENESS:g} ms on an idle machine)"
    )
    costs = [[cost_of_an_input(100, 5000, clocks=n) for n in (0, 250)] for _ in range(20)]
    without, beside = map(min, zip(*costs, strict=True))
    print(
        f"  beside 250 clocks that run, an input costs {beside / without:.2f} times as much"
        f"  (at most {BESIDE:g})"
    )
    return worst > LATENESS or beside > BESIDE * without


def watching_controller() -> tuple[Controller, list[float]]:
    """A controller of messages with a timeout; and how late each silence was noticed, in seconds."""
    controller = Controller()
    heard: dict[str, float] = {}
    late: list[float] = []

    def entries(number: int) -> tuple[Input, Input]:
        key = f"In.m{number}"

        def response(_: Any, value: Any) -> None:
            heard[key] = time.monotonic()

        def timeout(_: Any, value: Any) -> None:
            late.append(time.monotonic() - heard[key] - SILENCE)

        return (
            Input(key, "response", None, response, ()),
            Input(key, "timeout", None, timeout, ()),
        )

    controller.INPUTS = tuple(entry for n in range(WATCHED) for entry in entries(n))
    controller.COMMANDS = ()
    controller.COMMUNICATIONS = tuple(
        Communication(f"In.m{n}", f"m{n}", "outgoing", (), (), SILENCE) for n in range(WATCHED)
    )
    controller.TAUS = ()
    controller.undefined = {}
    return controller, late


class StillPort(NullPort):
    """Its clock stands until it is moved."""

    time = 0.0

    def now(self) -> float:
        return self.time


def wide_controller(size: int) -> Controller:
    """A controller with ``size`` inputs, flags and commands, each about its own flag."""

    def reader(_: Any, message: Any) -> Any:
        return message

    def entry(number: int) -> tuple[Input, Command]:
        name = f"flag_{number}"

        def apply(controller: Any, value: Any) -> None:
            setattr(controller, name, value)

        def guard(controller: Any) -> bool:
            return bool(getattr(controller, name))

        read = Input(f"In.m{number}", "response", reader, apply, (name,))
        sent = f"Out.m{number}"
        command = Command(sent, "request", guard, None, None, None, (name,), (), ())
        return read, command

    controller = Controller()
    entries = [entry(number) for number in range(size)]
    controller.INPUTS = tuple(read for read, _ in entries)
    controller.COMMANDS = tuple(command for _, command in entries)
    controller.COMMUNICATIONS = tuple(
        Communication(e.key, e.key, "outgoing" if isinstance(e, Input) else "incoming")
        for pair in entries
        for e in pair
    )
    controller.TAUS = ()
    controller.undefined = {}
    for number in range(size):
        setattr(controller, f"flag_{number}", False)
    return controller


def cost_of_an_input(size: int, count: int = 20_000, clocks: int = 0) -> float:
    """Microseconds per input that changes nothing but the one flag, to the same, while clocks run."""
    controller = wide_controller(size)
    controller.state, controller.entries = "waiting", 0
    controller.AFTERS = tuple(
        After("Wait", n, "waiting", 60.0 + n, "state", "entries", lambda _: None, ("state",), ())
        for n in range(clocks)
    )
    engine = controller_engine(controller, StillPort())
    engine.begin()
    posters = [engine.poster([f"In.m{number}"]) for number in range(size)]
    start = time.process_time()
    for number in range(count):
        posters[number % size](False)
        engine.cycle()
    return (time.process_time() - start) / count * 1e6


def cost_of_a_due_command(size: int) -> float:
    """Microseconds per command, all being due at once, period after period."""
    port = StillPort()
    engine = controller_engine(wide_controller(size), port)
    for number in range(size):
        setattr(engine.controller, f"flag_{number}", True)
    engine.begin()
    engine.cycle()
    rounds = max(3, 3000 // size)
    start = time.process_time()
    for _ in range(rounds):
        port.time += 0.1
        engine.cycle()
    taken = time.process_time() - start
    if port.sent != size * (rounds + 1):
        raise AssertionError(f"{port.sent} commands were sent, not {size * (rounds + 1)}")
    return taken / rounds / size * 1e6


def recorded(chance: random.Random) -> list[tuple[str, Message]]:
    """Measurements as a robot sends them: mostly a line, sometimes an obstacle or no line."""
    inputs = []
    for _ in range(1000):
        kind = chance.random()
        if kind < 0.45:
            distance = 0.2 if chance.random() < 0.3 else 1.0
            inputs.append(("DistanceSensor.distance", Message(distance)))
        elif kind < 0.95:
            inputs.append(("LineDetector.correction", Message(chance.uniform(-50, 50))))
        else:
            inputs.append(("LineDetector.no_line", Message()))
    return inputs


def drive(
    engine: Engine[Any], port: NullPort, inputs: list[tuple[str, Message]], count: int
) -> None:
    posters = [(engine.poster([key]), message) for key, message in inputs]
    for number in range(count):
        post, message = posters[number % len(posters)]
        post(message)
        if port.running and number % 10 == 0:
            key, token = port.running.pop(0)
            engine.report(key, token, "response" if number % 30 else "error", None)
        engine.cycle()
        if number % 1000 == 0:
            engine.recorder.take()  # as a reporter does, some times per second


if __name__ == "__main__":
    raise SystemExit(main())
