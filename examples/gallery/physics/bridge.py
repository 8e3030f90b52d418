"""The node between a world and ROS: steps MuJoCo, publishes sensors and /clock, takes commands.

Simulated time goes on when the controller has taken what the sensors and action servers said, has
answered the tick of the clock, and all that it sent has arrived; after a server was started anew,
when the two know of each other. So neither the machine's speed nor what else it does decides how a
robot fares. For that the bridge listens to the controller's ``~events``; for the film, to its
``~state``.

    python3 -m physics.bridge WORLD --ros 1 --seed 3 --faults --record run.json
"""

from __future__ import annotations

import argparse
import functools
import json
import math
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from physics.actions import ActionServer
from physics.faults import Faults
from physics.progress import Progress
from physics.rover import Laser
from physics.world import STEP, World
from physics.worlds import WORLDS

PATIENCE = 60.0
"""Seconds of real time after which something that is waited for counts as lost; so many are in the
record."""
HEART = "/alive"
"""What a controller sends at every tick, whatever else it may or may not send then: with any other
topic in its place, a command that comes late would pass for the answer to the next tick."""
START = 60.0
"""Seconds of real time in which all that is started is connected."""
ALIVE = 0.5
"""Seconds of real time after which a clock that stands goes on by a millionth of a second."""
REPEAT = 1.0
"""Seconds of real time after which a sensor that is not heard yet speaks once more."""
AGAIN = 0.05
"""Seconds of real time after which a tick that the supervisor does not know is sent once more."""
SETTLED = 1.2
"""Seconds of real time without a message or an event after which nothing is under way: longer than
any timeout, since until the first tick a silence is noticed by the clock of the machine."""


class Bridge:
    """One run of a world."""

    def __init__(
        self,
        world: World,
        faults: Faults,
        middleware: Any,
        version: int,
        controller: str,
        guarded: bool,
        awaited: str | None,
    ) -> None:
        self._world, self._faults, self._ros = world, faults, middleware
        self._guarded = guarded
        self._has_company = awaited is None
        self._ticked = 0.0
        self._heard_at: dict[str, float] = {}
        """When the last message of a sensor was sent, by the clock that others knew then."""
        self._timeouts: dict[str, float] = {}
        self._pulse = HEART if HEART in world.commands else next(iter(world.commands))
        """The topic on which every tick of the clock is answered."""
        self._arrived: Counter[str] = Counter()
        self.moved = 0.0
        self.lost: list[str] = []
        """What did not come within ``PATIENCE``, and when."""
        for topic, type_ in {**world.sensors, **world.buttons}.items():
            middleware.advertise(topic, type_)
        for topic, type_ in world.commands.items():
            middleware.subscribe(topic, type_, self._taker(topic))
        self._state: dict[str, Any] = {}
        self._progress = Progress()
        reports = {
            "state": self._on_state,
            "model": self._progress.on_model,
            "events": self._progress.on_event,
        }
        if guarded:
            reports["blocked"] = self._progress.on_blocked
        for topic, callback in reports.items():
            middleware.subscribe(f"/{controller}/{topic}", "std_msgs/String", callback)
        if awaited is not None:
            middleware.subscribe(awaited, "std_msgs/Empty", self._on_company)
        self._servers = {
            name: ActionServer(version, middleware.post, world, name, self._noter(name))
            for name in world.actions
        }
        self.recording: dict[str, list[Any]] = {"poses": [], "path": [], "states": []}

    def _noter(self, name: str) -> Callable[[], None]:
        def note() -> None:
            self._progress.under_way[name] -= 1

        return note

    def _taker(self, topic: str) -> Callable[[Any], None]:
        note = self._noter(topic)

        def take(message: Any) -> None:
            self._arrived[topic] += 1
            note()
            self._world.command(topic, message)

        return take

    def _on_state(self, message: Any) -> None:
        self._state = json.loads(message.data)

    def _on_company(self, message: Any) -> None:
        self._has_company = True

    def run(self, metres: float) -> bool:
        """Run until success, or the end of the time; False if nobody connected.

        The robot need not go on when it has moved so far and all faults are over.
        """
        if not self._is_met():
            return False
        world = self._world
        while world.time < world.seconds and not world.succeeded():
            if self.moved >= metres and world.time >= self._faults.over:
                break
            before = world.place()
            self._step()
            self.moved += math.dist(before, world.place())
        return True

    def close(self) -> None:
        for server in self._servers.values():
            server.close()

    def _is_met(self) -> bool:
        """Wait for the controller; whether it came."""

        def is_met() -> bool:
            return self._ros.connected() and self._progress.is_known and self._has_company

        self._ros.exchange(is_met, START)
        for name, server in self._servers.items():
            server.late = self._faults.late
            self._start(name)
        return is_met() and self._is_heard()

    def _is_heard(self) -> bool:
        """Let the sensors speak until the controller says that it has heard each; whether it did.

        The end of a connection that accepts it may know of it a little later than the other one.
        """
        taken, deadline = self._progress.taken, time.monotonic() + START
        samples = [sample for sample in self._world.sense() if sample[0] in self._world.sensors]
        while not all(taken[topic] for topic, _, _ in samples):
            if time.monotonic() > deadline:
                return False
            for topic, type_, fields in samples:
                if not taken[topic]:
                    self._ros.publish(topic, type_, fields, self._world.time)
                    self._heard_at[topic] = self._ticked
                    self._world.observer.hear(topic)
            self._ros.exchange(lambda: all(taken[topic] for topic, _, _ in samples), REPEAT)
        while self._guarded and not all(self._progress.judged[t] for t in self._world.commands):
            if time.monotonic() > deadline:
                return False
            self._ros.clock(self._world.time)
            self._ros.exchange(lambda: False, REPEAT)
        # What was sent before all were connected may have come, and its event may not.
        self._let_settle()
        self._progress.under_way.clear()
        return True

    def _let_settle(self) -> None:
        """Wait until nothing has come from the controller for ``SETTLED`` seconds."""
        seen, latest = -1, self._activity()
        while seen != latest:
            seen = latest
            self._ros.exchange(functools.partial(self._is_more, seen), SETTLED)
            latest = self._activity()

    def _is_more(self, seen: int) -> bool:
        return self._activity() > seen

    def _activity(self) -> int:
        """Return how many messages and events have come from the controller so far."""
        counts = self._arrived, self._progress.judged, self._progress.taken
        return sum(count.total() for count in counts)

    def _start(self, name: str) -> None:
        """Start an action server, and wait until the controller knows the new one.

        Its goal is then over for it, or is sent to the new one: how long it waits for the old one,
        which is known for some time in ROS 2, it decides by the time of the machine.
        """
        server = self._servers[name]
        server.begin()
        self._await(lambda: server.is_ready, f"a client of {name}", START)

        def is_over() -> bool:
            return name not in self._progress.going or server.is_busy

        self._await(is_over, f"the end of {name}", START)

    def _await(self, condition: Callable[[], bool], what: str, seconds: float = PATIENCE) -> None:
        """Let simulated time stand until the condition holds, but for very little: what does not
        hear of it for some seconds takes it for broken, and its sensors for silent."""
        end, ticks = time.monotonic() + seconds, 0
        self._ros.exchange(condition, ALIVE)
        while not condition() and time.monotonic() < end:
            ticks += 1
            if self._ticked:
                self._ros.clock(self._ticked + 1e-6 * ticks)
            self._ros.exchange(condition, ALIVE)
        if not condition():
            self.lost.append(f"{what} at {self._world.time:.2f} s")
            self._progress.under_way.clear()

    def _step(self) -> None:
        world, progress = self._world, self._progress
        expected = dict(progress.taken)
        for name, server in self._servers.items():
            if self._faults.is_killed(name, world.time) != server.is_killed:
                self._start(name) if server.is_killed else server.kill()
            waited_for = name in progress.active and not server.is_cancelled
            if server.step() and waited_for:
                expected[name] = expected.get(name, 0) + 1
        world.busy = frozenset(name for name, server in self._servers.items() if server.is_busy)
        world.step()
        for topic, type_, fields in world.sense():
            if not self._faults.is_silent(topic, world.time):
                ranges = self._faults.ranges(topic, world.time)
                if ranges is not None:
                    fields = {**fields, "ranges": ranges * len(fields["ranges"])}
                self._ros.publish(topic, type_, fields, world.time)
                self._heard_at[topic] = self._ticked
                world.observer.hear(topic, usable=ranges is None)
                expected[topic] = expected.get(topic, 0) + 1
        self._await(
            lambda: all(progress.taken[name] >= count for name, count in expected.items()),
            "what was told",
        )
        self._tick()
        self._record()

    def _tick(self) -> None:
        """Have the clock tick, and wait until it is answered and all that was sent has arrived."""
        answers = self._arrived[self._pulse]
        self._ros.clock(self._world.time)
        if self._ticked == 0.0:  # it is the first: all clocks begin with it
            self._heard_at = dict.fromkeys(self._heard_at, self._world.time)
        self._ticked = self._world.time
        if self._guarded:
            self._let_supervisor_tick()
        self._await(lambda: self._arrived[self._pulse] > answers and self._has_all(), "an answer")

    def _let_supervisor_tick(self) -> None:
        """Wait until the supervisor knows the time: it is another node than that which answers.

        It says so in the ~state that it makes after each command, and what is guarded sends all of
        them at every tick. While all topics are silent it does not say it, and gets real time.
        """
        judged = dict(self._progress.judged)

        def is_done() -> bool:
            topics = self._world.commands
            return self._knows_time() and all(
                self._progress.judged[t] > judged.get(t, 0) for t in topics
            )

        end = time.monotonic() + PATIENCE
        self._ros.exchange(is_done, AGAIN)
        while not is_done() and time.monotonic() < end:
            self._ros.clock(self._world.time)
            self._ros.exchange(is_done, AGAIN)
        if not self._state.get("clocks"):
            self._ros.exchange(lambda: False, STEP)

    def _knows_time(self) -> bool:
        """Whether the clocks in ~state have gone on to the last tick."""
        clocks = self._state.get("clocks", {})
        for name, left in clocks.items():
            self._timeouts[name] = max(left, self._timeouts.get(name, left))
            age = self._ticked - self._heard_at[self._progress.topic(name)]
            if left > self._timeouts[name] - age + STEP / 2:
                return False
        return True

    def _has_all(self) -> bool:
        """Whether all that the controller has sent has arrived."""
        progress = self._progress
        return all(progress.under_way[topic] <= 0 for topic in self._world.commands) and all(
            not server.is_ready
            or (
                progress.under_way[name] <= 0
                and (server.is_cancelled or not server.is_busy or name not in progress.cancelled)
            )
            for name, server in self._servers.items()
        )

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
    faults = Faults()
    if args.faults:
        scanners = [topic for topic, type_ in world.sensors.items() if type_ == Laser.TYPE]
        faults = Faults.planted(args.seed, world.sensors, world.actions, scanners)
    bridge = Bridge(
        world, faults, middleware, args.ros, args.controller, args.guarded, args.awaited
    )
    started = time.monotonic()
    try:
        met = bridge.run(args.metres)
    finally:
        bridge.close()
        middleware.close()
        world.close()
    if not met:
        print("bridge: the controller did not connect", file=sys.stderr)
        return 1
    summary = summary_of(world, faults, time.monotonic() - started)
    record = {"world": args.world, "seed": args.seed, "moved": bridge.moved}
    record["lost"] = bridge.lost
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
    parser.add_argument("--guarded", action="store_true", help="that node is a supervisor")
    parser.add_argument(
        "--awaited", help="begin when an Empty came on this topic, as of a recorder"
    )
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
        "times": world.observer.times,
        "faults": faults.texts,
    }


if __name__ == "__main__":
    raise SystemExit(main())
