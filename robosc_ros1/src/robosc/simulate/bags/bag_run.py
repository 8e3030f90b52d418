"""A bag through the runtime monitor: what the recorded robot and its controller did, judged.

The monitor judges as a generated supervisor does. Its clock is that of the recording.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any

from robosc.emit.supervisor.command_recognition import CommandMatch, command_matches
from robosc.emit.supervisor.commuting import not_commuting
from robosc.errors import UsageError
from robosc.language.events import EventKind, Kind
from robosc.model.declarations.servers import shared_servers
from robosc.model.entities import Communication, Robot
from robosc.plant.event_values import parts_taken
from robosc.progress import Progress
from robosc.runtime.core import engine_parts, transforms
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.recorder import Entry
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.values import UNREADABLE, Mismatch
from robosc.runtime.judge import gathering, matching, monitoring, observation, sight
from robosc.runtime.judge.ports import MonitorPort
from robosc.simulate import faults, start
from robosc.simulate.bags.bag_files import Bag
from robosc.simulate.bags.recorded_names import RecordedNames, recorded_names
from robosc.simulate.bags.selected_fields import Path as FieldPath
from robosc.simulate.machines.execute import read_settings
from robosc.simulate.machines.state import make_controller
from robosc.supervisor import Supervisor

# What a recording tells of the time at which a message came, beside the time of the recorder.
#
# A recorder, and the machine that it shares with the robot, may be late. A message was made at its
# stamp, so it may have come at any time from then on, with the least age that its topic had before.
# A burst of one topic had waited for the recorder. A silence that such a message ends later than it
# may have come is none that anybody knows of.


Recorded = tuple[str, float, "float | None", Any]
"""Topic, time of the recorder, seconds of the message's stamp (None: it has none), message."""

_LATEST = 2.0
"""Seconds by which a recorder may be late: so far is looked ahead."""
_BURST = 0.1
"""The part of the usual pause of a topic within which messages that had waited follow."""
_REMEMBERED = 50
"""Messages of a topic from which its usual pause and its least age are known."""
_KNOWN = 5
"""Pauses of a topic after which its usual one is known."""


class Lookahead:
    """The messages of a recording, one after the other, with those that follow; for ``timed``
    topics it matters when they came."""

    def __init__(self, messages: Iterable[Recorded], timed: Iterable[str]) -> None:
        self._messages = iter(messages)
        self._timed = frozenset(timed)
        self._ahead: deque[Recorded] = deque()
        latest = partial(deque[float], maxlen=_REMEMBERED)
        self._ages = {topic: latest() for topic in self._timed}
        self._pauses = {topic: latest() for topic in self._timed}
        self._last: dict[str, float] = {}

    def __iter__(self) -> Iterator[Recorded]:
        ahead = self._ahead
        if not self._timed:
            yield from self._messages
        for recorded in self._messages:
            ahead.append(recorded)
            topic, time, stamp, _ = recorded
            if topic in self._timed:
                self._note(topic, time, stamp)
            while ahead[0][1] + _LATEST <= time:
                yield ahead[0]
                ahead.popleft()
        while ahead:
            yield ahead[0]
            ahead.popleft()

    def may_have_come(self, topic: str, time: float) -> float | None:
        """The recorded time of the next message of a topic, if it may have come before a time;
        None: it cannot have, or there is none."""
        coming = ((t, stamp) for name, t, stamp, _ in self._ahead if name == topic)
        recorded, stamp = next(coming, (None, None))
        if recorded is None:
            return None
        if stamp is not None:
            return recorded if stamp + min(self._ages[topic]) <= time else None
        following, _ = next(coming, (None, None))
        pauses = self._pauses[topic]
        if following is None or len(pauses) < _KNOWN:
            return None
        usual = sorted(pauses)[len(pauses) // 2]
        return recorded if following - recorded < _BURST * usual else None

    def _note(self, topic: str, time: float, stamp: float | None) -> None:
        if stamp is not None:
            self._ages[topic].append(time - stamp)
        elif topic in self._last:
            self._pauses[topic].append(time - self._last[topic])
        self._last[topic] = time


# The types that the topics of a model should have in a recording.


_NUMBERS = frozenset(
    {"Float32", "Float64", *(f"{u}Int{bits}" for u in ("", "U") for bits in (8, 16, 32, 64))}
)
"""The messages of std_msgs that are a number: whichever was recorded, it can be read."""


def types_of(communication: Communication, ros_1: bool) -> Mapping[str, str]:
    """By the parts of a communication's name (of a message ``""``), as ``rosbags`` has them."""
    package, name = communication.binding.package, communication.binding.type
    if communication.kind is Kind.SERVICE:
        return {"/_service_event": f"{package}/srv/msg/{name}_Event"}
    if communication.kind is not Kind.ACTION:
        return {"": f"{package}/msg/{name}"}
    if not ros_1:
        feedback = f"{package}/action/msg/{name}_FeedbackMessage"
        return {"/_action/status": "action_msgs/msg/GoalStatusArray", "/_action/feedback": feedback}
    parts = {f"/{part.lower()}": f"{package}/msg/{name}Action{part}"
             for part in ("Goal", "Feedback", "Result")}  # fmt: skip
    return {
        **parts,
        "/cancel": "actionlib_msgs/msg/GoalID",
        "/status": "actionlib_msgs/msg/GoalStatusArray",
    }


def demand_type(path: Path, name: str, part: str, recorded: Collection[str], expected: str) -> None:
    """Raises UsageError if a topic, a part of what has the name, has messages that are not of the
    type that the model expects."""
    if all(_sort(type_) == _sort(expected) for type_ in recorded):
        return
    found = " and ".join(_in_ros(type_) for type_ in recorded)
    remedy = (
        "keep only those (for instance with 'rosbag filter')"
        if expected in recorded
        else "correct the model"
    )
    raise UsageError(
        f"{path}: {name}{part} has messages of {found}, but the model expects"
        f" {_in_ros(expected)}: {remedy}, or give the name that is meant: --remap {name}:=/OTHER"
    )


def _sort(type_: str) -> str:
    package, _, name = type_.partition("/msg/")
    return "a number" if package == "std_msgs" and name in _NUMBERS else type_


def _in_ros(type_: str) -> str:
    return type_.replace("/msg/", "/")


# The transforms of a model in a recording, from its messages on ``/tf`` and ``/tf_static``.


TOPICS = ("/tf", "/tf_static")
TYPE = "tf2_msgs/msg/TFMessage"
FORMER_TYPE = "tf/msg/tfMessage"
"""That of the first tf, with the same contents."""


class RecordedTransforms:
    """``now`` is the clock of the recording, ``post`` makes what takes the messages of some
    communications. ``faults`` are those that were found until now."""

    def __init__(
        self,
        chains: Mapping[tuple[str, str], transforms.Keys],
        settings: Settings,
        now: Callable[[], float],
        post: Callable[[Sequence[str]], Callable[[Any], None]],
    ) -> None:
        rows = [(*frames, keys) for frames, keys in chains.items()]
        self._transforms = transforms.Transforms(rows, transforms.period_by(settings.rates))
        self._posts = {keys: post(keys) for _, _, keys in rows}
        self._now = now
        self.next = self._transforms.next
        self.faults: dict[str, None] = {}

    def handler(self, bag: Bag, topic: str, is_static: bool) -> observation.Handler:
        """What takes the messages of a topic."""
        nodes = {c.node for c in bag.storage.channels.values() if c.topic == topic and c.node}
        publishers = " or ".join(sorted(nodes)) or f"whoever sends {topic}"

        def take(message: Any) -> None:
            now = self._now()
            told = partial(str, publishers)
            self._pass_on(self._transforms.take(message.transforms, is_static, told, now, now))
            self.faults |= dict.fromkeys(self._transforms.faults())

        return take

    def flush(self) -> None:
        """Pass on what has waited until now."""
        self._pass_on(self._transforms.due(self._now()))

    def _pass_on(self, messages: Sequence[tuple[transforms.Keys, Any]]) -> None:
        for keys, message in messages:
            self._posts[keys](message)


# The role of a monitor that follows a recording, with a short way for messages that come
# alone.


_ROUNDING = 1e-6
"""Seconds, above what is lost by rounding times since 1970."""


ShortWay = Callable[[Any], "int | None"]
"""Takes a message that comes alone, and returns how many events it was that are not recorded, since
there is nothing to say of them; None: it has to go through the engine, and nothing has changed."""


class BagMonitoring(monitoring.Monitoring):
    """Judges a recording. Most of its messages come while nothing is due by the clock: they need
    neither inbox nor queue."""

    def _span(self) -> float:
        return self.tolerance  # a recording does not tell how late its node was

    def begin(self) -> None:
        super().begin()
        sorts = {c.sort for c in self._controller.COMMUNICATIONS}
        self._has_clocks = bool(self._parts.clocks.delays)
        self._may_be_due = bool(self._invariants.rows) or "action" in sorts

    def is_idle_until(self, time: float) -> bool:
        """Whether nothing is due until a time of the recording."""
        span = time - self._parts.steady() + _ROUNDING
        left = self._parts.clocks.time_to_next() if self._has_clocks else None
        if left is not None and left <= span:
            return False
        left = self.due() if self._may_be_due or self._pending.oldest is not None else None
        return left is None or left > span

    def short_way(self, entry: engine_parts.BoundInput) -> ShortWay:
        """Return what applies an input as the engine would, but for its entry in the record."""
        engine, clocks, crossings = self._engine, self._parts.clocks, self._crossings
        state, read, apply, writes = vars(self._controller), entry.read, entry.apply, entry.writes
        keys, orders = (entry.key,), crossings.of(entry.key)
        is_watched, pending = clocks.is_watched(entry.key), self._pending

        def take(message: Any) -> int | None:
            before = None if orders is None else orders.moment()
            values = [state[name] for name in writes]
            try:
                apply(None if read is None else read(message))
            except (Mismatch, *UNREADABLE):
                return None
            for name, value in zip(writes, values, strict=True):
                if state[name] is not value:
                    engine.after(writes, None)
                    break
            if orders is not None and before is not None:
                orders.happened(crossings.arrival((entry,), message), before)
            if is_watched:
                clocks.heard(keys, self._parts.steady())
            if pending.oldest is not None:
                pending.judge(self._answer)
            return 1

        return take

    def short_way_of_commands(
        self, topic: str, patterns: Sequence[matching.CommandPattern]
    ) -> ShortWay:
        """Return what takes the commands of a topic as :meth:`offer` does."""

        def take(message: Any) -> int | None:
            return 0 if self._take_message(topic, patterns, message) else None

        return take


_BEHIND = 0.001
"""Seconds, far above what is lost by rounding."""


@dataclass
class Track:
    """A topic in a recording: times in seconds since 1970, ``longest`` is the longest silence that
    was ended, ``age`` the largest by a stamp."""

    count: int = 0
    first: float = 0.0
    last: float = 0.0
    longest: float = 0.0
    age: float | None = None

    def take(self, time: float, stamp: float | None) -> None:
        if not self.count:
            self.first = self.last = time
        if time - self.last > self.longest:
            self.longest = time - self.last
        self.count += 1
        self.last = time
        if stamp is not None and (self.age is None or time - stamp > self.age):
            self.age = max(0.0, time - stamp)


class _BagPort(MonitorPort):
    """The clock of a recording, and its types."""

    def __init__(self, bag: Bag) -> None:
        self.time = bag.start
        self.corrected = bag.corrected  # type: ignore[method-assign]

    def now(self) -> float:
        return self.time

    def log(self, level: str, text: str) -> None:
        """What matters is in the recorder."""


class _OnTime(gathering.Lateness):
    """A recording that is read tells nothing of how late its node was."""

    def note(self, delay: float) -> None:
        """Do nothing."""


def _raise(error: Exception) -> None:
    """End the replay, which would meet an unexpected exception again for ever."""
    raise error


def _of_fields(path: tuple[str | int, ...]) -> FieldPath:
    """The fields of a path until the first element of an array."""
    return tuple(takewhile(lambda part: isinstance(part, str), path))  # type: ignore[arg-type]


@dataclass
class _Heard:
    """The topics that matter, each with those who take its messages."""

    handlers: dict[str, list[observation.Handler]] = field(default_factory=dict)
    absent: list[str] = field(default_factory=list)
    unseen: list[str] = field(default_factory=list)
    unsent: list[str] = field(default_factory=list)


def settings_of(robot: Robot, given: Sequence[str] = ()) -> Settings:
    """The settings of a robot's node; ``given`` are parameters as ``NAME=VALUE``.

    Raises:
        UsageError: one is no parameter, or has a wrong value.
    """
    stop = {} if robot.stop is None else {"stop_command": robot.display_names[robot.stop]}
    try:
        return read_settings(robot, {**stop, **start.parameters(given)})
    except faults.InvalidLine as fault:
        raise UsageError(str(fault)) from None


class BagRun:
    """A recording that is followed once. ``whole`` values are recorded, or short forms; ``names``
    are those that the robot had in it.

    Raises:
        ModelError: commands of one topic cannot be told apart by their data.
        UsageError: a topic of the robot has messages of another type.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        bag: Bag,
        settings: Settings,
        *,
        described: bool = False,
        names: RecordedNames | None = None,
    ) -> None:
        robot = supervisor.plant.robot
        self.supervisor = supervisor
        self.bag = bag
        self._described = described
        # Who only judges shows no values: short forms of scans would take longer than all else.
        settings = settings._replace(
            whole_values=settings.whole_values or not described, shadow=False
        )
        self.settings = settings
        self.tracks: dict[str, Track] = {}
        self._port = _BagPort(bag)
        controller = make_controller(supervisor)
        controller.configure(settings.more)
        now, clock = self._port.now, gathering.ArrivalTime(self._port.now)
        role = partial(BagMonitoring, port=self._port, clock=clock, lateness=_OnTime(now))
        self.engine: Engine[BagMonitoring] = Engine(
            role, controller, self._port, settings, now, clock
        )
        self.engine.unexpected = _raise
        self._judge = self.engine.role
        self.engine.recorder.now = self._port.now
        if described:
            self._judge.describe = lambda message: message
        self._judge.before_clocks = self._hear_what_may_have_come
        self._ahead = Lookahead((), ())
        self._timed: dict[str, str] = {}
        self._short_ways: dict[str, ShortWay] = {}
        self._fields: dict[str, set[FieldPath]] = {}
        """All that is read of the messages of topics."""
        self.unrecorded = 0
        """The events that :meth:`entries` does not yield, since there is nothing to say of them."""
        self.undecided = Counter[str]()
        """Silences that may have been none, by the names of their communications."""
        self._heard = _Heard()
        self._matches = {
            match.key: match for found in command_matches(robot, False).values() for match in found
        }
        self._names = names or recorded_names(robot)
        self.transforms = RecordedTransforms(
            robot.transforms, settings, self._port.now, self.engine.poster
        )
        self._connect()

    @property
    def hears(self) -> bool:
        """Whether the bag has a topic of the robot."""
        return bool(self._heard.handlers)

    @property
    def absent(self) -> Sequence[str]:
        """Topics of the model without messages in the bag."""
        return self._heard.absent

    @property
    def unseen(self) -> Sequence[str]:
        """The names of the communications that a bag cannot show, or this one does not."""
        names = self.supervisor.plant.robot.display_names
        return [names[key] for key in self._heard.unseen]

    @property
    def unjudged(self) -> Sequence[tuple[str, str]]:
        """The commands, by name and kind, that depend on what is not seen."""
        names = self.supervisor.plant.robot.display_names
        return [(names[key], kind) for key, kind in self._judge.unjudged]

    @property
    def unsent(self) -> Sequence[str]:
        """The names of the commands whose topics the bag does not have."""
        names = self.supervisor.plant.robot.display_names
        return [names[key] for key in self._heard.unsent]

    @property
    def judges_states(self) -> bool:
        """Whether all is seen on which the requirements on states depend."""
        return not sight.unknown_in(self.engine.controller, self._heard.unseen)

    def entries(self, progress: Progress) -> Iterator[Entry]:
        """Follow the recording; the events, with the verdicts on them."""
        engine, port, judge = self.engine, self._port, self._judge
        engine.begin()
        recorder, number = engine.recorder, 0
        handlers = self._heard.handlers
        tracks = {topic: self.tracks.setdefault(topic, Track()) for topic in handlers}
        messages = self.bag.messages(handlers, progress, self._fields)
        self._ahead = Lookahead(messages, self._timed.values())
        for topic, time, stamp, message in self._ahead:
            tracks[topic].take(time, stamp)
            take = self._short_ways.get(topic)
            if take is not None and judge.is_idle_until(time) and not self._tells_until(time):
                port.time = max(port.time, time)
                count = take(message)
                if count is not None:
                    self.unrecorded += count
                    if recorder.number != number:
                        number = recorder.number
                        yield from recorder.take()
                    continue
            self._wait(time)
            for handle in handlers[topic]:
                handle(message)
            engine.cycle()
            number = recorder.number
            yield from recorder.take()
        self._wait(port.time + self._judge.tolerance)
        engine.cycle()
        yield from engine.recorder.take()

    def _tells_until(self, time: float) -> bool:
        """Whether transforms are to be passed on until then."""
        told = self.transforms.next()
        return told is not None and told <= time

    def _wait(self, time: float) -> None:
        """Let the clock go on, as a node would wake up."""
        engine, port = self.engine, self._port
        while True:
            delay, told = engine.time_to_deadline(), self.transforms.next()
            due = math.inf if delay is None else port.time + delay
            if told is not None and told <= min(due, time):
                port.time = max(port.time, told)
                self.transforms.flush()
            elif due <= time:
                port.time = max(due, math.nextafter(port.time, math.inf))
            else:
                break
            engine.cycle()
        port.time = max(port.time, time)

    def _hear_what_may_have_come(self) -> None:
        clocks = self.engine.parts.clocks
        if clocks.any_due():
            now = self.engine.parts.now()
            for key, left in clocks.time_left().items():
                until = self._expected(key, now) if not left else None
                if until is not None:
                    # As if it had come so late that its timeout ends just behind the next one.
                    arrival = until + _BEHIND - self.settings.timeout_of(key)
                    clocks.heard((key,), min(now, arrival))

    def _expected(self, key: str, time: float) -> float | None:
        """The time until which the message of a communication may yet have come before a time."""
        topic = self._timed.get(key)
        until = None if topic is None else self._ahead.may_have_come(topic, time)
        if until is not None:
            self.undecided[self.supervisor.plant.robot.display_names[key]] += 1
        return until

    # --- who listens to what ---------------------------------------------------------------------

    def _connect(self) -> None:
        robot = self.supervisor.plant.robot
        shared = {c.key for together in shared_servers(robot) for c in together}
        if robot.transforms:
            self._connect_transforms([k for keys in robot.transforms.values() for k in keys])
        heard: dict[str, list[str]] = {}
        commands: dict[str, list[CommandMatch]] = {}
        for one in robot.communications.values():
            if one.frames is not None:
                continue
            if one.kind is Kind.OUTGOING:
                heard.setdefault(self._topic(one), []).append(one.key)
            elif one.kind is Kind.INCOMING:
                commands.setdefault(self._topic(one), []).append(self._matches[one.key])
            elif one.key in shared or one.kind in (Kind.SERVED_SERVICE, Kind.SERVED_ACTION):
                # Requests do not say whose they are, and whoever is called is not followed.
                self._heard.unseen.append(one.key)
            elif one.kind is Kind.ACTION:
                self._connect_action(one)
            else:
                self._connect_service(one)
        for topic, keys in heard.items():
            if topic in self.bag.topics:
                self._demand_type(topic, robot.communications[keys[0]])
                self._add(topic, self.engine.poster(keys))
                # One that is too old when it comes was not in time, however late that was.
                of_topic = [robot.communications[key] for key in keys]
                timed = (c.key for c in of_topic if c.max_age is None and c.timeout is not None)
                self._timed.update(dict.fromkeys(timed, topic))
                continue
            self._miss(topic, keys)
        for topic, matches in commands.items():
            if topic in self.bag.topics:
                self._demand_type(topic, robot.communications[matches[0].key])
                self._connect_commands(topic, matches)
            else:
                self._heard.absent.append(topic)
                self._heard.unsent += [match.key for match in matches]
        self._judge.leave_out(self._heard.unseen)
        self._judge.order_matters(not_commuting(self.supervisor))
        if not self._described:
            for topic, keys in heard.items():
                self._shorten(topic, [robot.communications[key] for key in keys])

    def _shorten(self, topic: str, communications: Sequence[Communication]) -> None:
        """Take the messages of a topic in a short way, and by what is read of them, if only these
        take them."""
        handlers = self._heard.handlers.get(topic, ())
        if len(handlers) != 1 or any(c.max_age is not None for c in communications):
            return
        keys = [c.key for c in communications]
        if len(keys) == 1:
            entry = self.engine.parts.inputs[keys[0], "response"]
            self._short_ways[topic] = self._judge.short_way(entry)
        robot, events = self.supervisor.plant.robot, self.supervisor.plant.events
        read = (
            parts_taken(robot, e) for e in events if e.key in keys and e.kind is EventKind.RESPONSE
        )
        paths = {_of_fields(path) for parts in read for path in parts}
        if () not in paths:
            self._fields[topic] = paths

    def _miss(self, topic: str, keys: Sequence[str]) -> None:
        self._heard.absent.append(topic)
        # Of one that should come all the time it is not known when it did.
        found = self.supervisor.plant.robot.communications
        self._heard.unseen += [k for k in keys if found[k].timeout is not None]

    def _connect_transforms(self, keys: Sequence[str]) -> None:
        names = {self._names.of(name): name == "/tf_static" for name in TOPICS}
        there = {topic: static for topic, static in names.items() if topic in self.bag.topics}
        for topic, is_static in there.items():
            recorded = [t for t in self.bag.types[topic] if t != FORMER_TYPE]
            demand_type(self.bag.path, topic, "", recorded, TYPE)
            self._add(topic, self.transforms.handler(self.bag, topic, is_static))
        if not there:
            self._miss("/tf", keys)

    def _connect_commands(self, topic: str, matches: Sequence[CommandMatch]) -> None:
        rows = [(m.key, m.exact, m.field) for m in sorted(matches, key=lambda m: not m.exact)]
        patterns = matching.command_patterns(rows, self.bag.make(topic))  # type: ignore[arg-type]
        self._add(topic, lambda message: self._judge.offer(topic, patterns, message))
        if not self._described and len(self._heard.handlers[topic]) == 1:
            self._short_ways[topic] = self._judge.short_way_of_commands(topic, patterns)

    def _connect_action(self, action: Communication) -> None:
        if not self.bag.ros_1 and (self._reads_ends(action) or self._reads_goals(action)):
            self._heard.unseen.append(action.key)
            return
        seen = observation.SeenAction if self.bag.ros_1 else observation.SeenActionOfRos2
        if not self._add_parts(action, seen(self._judge, action.key).handlers):
            self._heard.unsent.append(action.key)

    def _reads_ends(self, action: Communication) -> bool:
        """Whether the model reads the goal's result, which a bag of ROS 2 does not have."""
        rows = self.engine.controller.INPUTS
        return any(
            r.key == action.key and r.kind == "response" and r.read is not None for r in rows
        )

    def _reads_goals(self, action: Communication) -> bool:
        """Whether the model decides on the data of goals, which a bag of ROS 2 does not have."""
        rows = self.engine.controller.COMMANDS
        return any(r.key == action.key and r.read is not None for r in rows)

    def _connect_service(self, service: Communication) -> None:
        handlers = observation.SeenServiceOfRos2(self._judge, service.key).handlers
        if not self._add_parts(service, handlers):
            self._heard.unseen.append(service.key)

    def _add_parts(self, owner: Communication, handlers: Mapping[str, observation.Handler]) -> bool:
        """Whether the bag has one of these topics below a name."""
        name = self._topic(owner)
        there = [part for part in handlers if name + part in self.bag.topics]
        for part in there:
            self._demand_type(name, owner, part)
            self._add(name + part, handlers[part])
        if not there:
            self._heard.absent.append(name)
        return bool(there)

    def _demand_type(self, name: str, owner: Communication, part: str = "") -> None:
        expected = types_of(owner, self.bag.ros_1)[part]
        demand_type(self.bag.path, name, part, self.bag.types[name + part], expected)

    def _add(self, topic: str, handler: observation.Handler) -> None:
        self._heard.handlers.setdefault(topic, []).append(handler)

    def _topic(self, communication: Communication) -> str:
        return self._names.of(communication.identifier)
