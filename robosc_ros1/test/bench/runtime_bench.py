"""The generated controller of the line follower without ROS: cost per event, and no growth.

``--events 10000000`` is eight hours of a busy robot, compressed.
"""

from __future__ import annotations

import argparse
import random
import resource
import time
from typing import Any

from emit.generated_code import controller_class
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.runtime.engine import Engine
from robosc.runtime.port import Port

__all__ = ["main"]

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

    def call(self, key: str, data: Any, token: int, timeout: float) -> None:
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
    engine = Engine(controller(), port)
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
    return int(
        sorted(parts)[5] > LIMIT or parts_memory > early * 1.05 or engine.stopped is not None
    )


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


def drive(engine: Engine, port: NullPort, inputs: list[tuple[str, Message]], count: int) -> None:
    posters = [(engine.poster(key, "response"), message) for key, message in inputs]
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
