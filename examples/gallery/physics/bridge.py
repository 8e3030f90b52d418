"""The node between a world and ROS: steps MuJoCo, publishes sensors and /clock, takes commands.

Simulated time goes on when the controller has taken what the sensors said, and then answered the
tick of the clock (or has not for ``PATIENCE``). So neither the machine's speed nor what else it
does decides how a robot fares. For that the bridge listens to the controller's ``~events``; for the
film, to its ``~state``.

    python3 -m physics.bridge WORLD --ros 1 --seed 3 --faults --record run.json
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from pathlib import Path
from typing import Any

from physics.faults import Faults
from physics.world import STEP, Task, World
from physics.worlds import WORLDS

PATIENCE = 0.25
"""Seconds of real time that a step waits for the controller at most, twice."""
HANDOVER = 0.01
"""Seconds of real time in which goals and cancels arrive, which come by threads of their own."""
START = 30.0


class ActionServer:
    """Serves one action of a world, one goal at a time."""

    def __init__(self, middleware: Any, world: World, name: str, late: float) -> None:
        self._middleware, self._world, self._name, self._late = middleware, world, name, late
        self._server: Any = None
        self._goal: Any = None
        self._task: Task | None = None
        self._ended: tuple[float, bool] | None = None

    def begin(self) -> None:
        self._server = self._middleware.serve(
            self._name, self._world.actions[self._name], self._accept
        )

    def kill(self) -> None:
        self._server.kill()
        self._server = None
        self._drop()

    @property
    def is_killed(self) -> bool:
        return self._server is None

    @property
    def is_busy(self) -> bool:
        return self._goal is not None

    def _accept(self, goal: Any) -> None:
        if self.is_killed:
            return
        if self._goal is not None:
            self._goal.end("aborted")
            self._drop()
        self._goal, self._task = goal, self._world.begin(self._name, goal.request)

    def _drop(self) -> None:
        if self._task is not None:
            self._task.stop()
        self._goal = self._task = self._ended = None

    def step(self) -> None:
        """Go on with the goal; a result is told ``late`` seconds after it is there."""
        if self._goal is None or self._task is None:
            return
        if self._goal.is_cancelled:
            self._goal.end("canceled")
            self._drop()
            return
        if self._ended is None:
            done = self._task.step()
            self._goal.feed_back(self._task.feedback())
            if done is not None:
                self._ended = (self._world.time + self._late, done)
        if self._ended is not None and self._world.time >= self._ended[0]:
            self._goal.end("succeeded" if self._ended[1] else "aborted", self._task.result())
            self._drop()


class Bridge:
    """One run of a world."""

    def __init__(self, world: World, faults: Faults, middleware: Any, controller: str) -> None:
        self._world, self._faults, self._ros = world, faults, middleware
        self._answers = self._taken = 0
        self.moved = 0.0
        for topic, type_ in {**world.sensors, **world.buttons}.items():
            middleware.advertise(topic, type_)
        for topic, type_ in world.commands.items():
            middleware.subscribe(topic, type_, self._taker(topic))
        self._state: dict[str, Any] = {}
        middleware.subscribe(f"/{controller}/state", "std_msgs/String", self._on_state)
        middleware.subscribe(f"/{controller}/events", "std_msgs/String", self._on_event)
        self._servers = {
            name: ActionServer(middleware, world, name, faults.late) for name in world.actions
        }
        for server in self._servers.values():
            server.begin()
        self.recording: dict[str, list[Any]] = {"poses": [], "path": [], "states": []}

    def _taker(self, topic: str) -> Any:
        def take(message: Any) -> None:
            self._answers += 1
            self._world.command(topic, message)

        return take

    def _on_state(self, message: Any) -> None:
        self._state = json.loads(message.data)

    def _on_event(self, message: Any) -> None:
        self._taken += json.loads(message.data)["event"]["kind"] == "response"

    def run(self, metres: float) -> bool:
        """Run until success, or the end of the time; False if nobody connected.

        The robot need not go on when it has moved so far and all faults are over.
        """
        self._ros.exchange(self._ros.connected, START)
        if not self._ros.connected():
            return False
        world = self._world
        while world.time < world.seconds and not world.succeeded():
            if self.moved >= metres and world.time >= self._faults.over:
                break
            before = world.place()
            self._step()
            self.moved += math.dist(before, world.place())
        return True

    def _step(self) -> None:
        world = self._world
        for name, server in self._servers.items():
            if self._faults.is_killed(name, world.time) != server.is_killed:
                (server.begin if server.is_killed else server.kill)()
            server.step()
        world.busy = frozenset(name for name, server in self._servers.items() if server.is_busy)
        world.step()
        expected = self._taken
        for topic, type_, fields in world.sense():
            if not self._faults.is_silent(topic, world.time):
                self._ros.publish(topic, type_, fields, world.time)
                world.observer.hear(topic)
                expected += 1
        self._ros.exchange(lambda: self._taken >= expected, PATIENCE)
        answers = self._answers
        self._ros.clock(world.time)
        self._ros.exchange(lambda: self._answers > answers, PATIENCE)
        if world.busy:
            self._ros.exchange(lambda: False, HANDOVER)
        self._record()

    def _record(self) -> None:
        world = self._world
        self.recording["path"].append([round(v, 3) for v in world.place()])
        if round(world.time / STEP) % 4 == 0:
            self.recording["poses"].append([round(float(v), 4) for v in world.data.qpos])
            self.recording["states"].append([world.time, self._state])


def main() -> int:
    args = parse_arguments()
    middleware = connect(args.ros, "gallery")
    world = WORLDS[args.world](args.seed)
    faults = Faults.planted(args.seed, world.sensors, world.actions) if args.faults else Faults()
    bridge = Bridge(world, faults, middleware, args.controller)
    started = time.monotonic()
    try:
        met = bridge.run(args.metres)
    finally:
        middleware.close()
        world.close()
    if not met:
        print("bridge: the controller did not connect", file=sys.stderr)
        return 1
    summary = summary_of(world, faults, time.monotonic() - started)
    record = {"world": args.world, "seed": args.seed, "moved": bridge.moved}
    record |= {**summary, **bridge.recording}
    args.record.write_text(json.dumps(record), encoding="utf-8")
    return 0


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("world", choices=sorted(WORLDS))
    parser.add_argument("--ros", type=int, choices=(1, 2), default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--metres", type=float, default=math.inf, help="end after so long a way")
    parser.add_argument("--faults", action="store_true", help="plant faults")
    parser.add_argument("--controller", required=True, help="the controller's node")
    parser.add_argument("--record", type=Path, required=True, help="the file to write")
    return parser.parse_args()


def connect(version: int, name: str) -> Any:
    """Return the middleware of a version of ROS."""
    if version == 1:
        from physics.ros1 import Middleware
    else:
        from physics.ros2 import Middleware  # type: ignore[assignment]
    return Middleware(name)


def summary_of(world: World, faults: Faults, seconds: float) -> dict[str, Any]:
    """Return the numbers of a run."""
    return {
        "succeeded": world.succeeded(),
        "simulated": world.time,
        "real": round(seconds, 2),
        "judgements": world.observer.judgements,
        "violations": dict(world.observer.violations),
        "first": world.observer.first,
        "faults": faults.texts,
    }


if __name__ == "__main__":
    raise SystemExit(main())
