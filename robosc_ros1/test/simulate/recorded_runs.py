"""Runs of a generated controller against a played robot, recorded as bags by rosbags' writers.

The controller may be told to ignore what forbids some of its commands. Whatever it sends against
its guards is noted as it sends it: the list of the faults that the bag has.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import count
from pathlib import Path
from typing import Any

from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from robosc.model.entities import Communication
from robosc.runtime.core.calls import Failure
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.interfaces import Data, Port
from robosc.runtime.core.model import Controller
from robosc.runtime.core.settings import Settings
from robosc.simulate.bags.recorded_messages import default_message, fill
from robosc.simulate.machines.execute import read_settings
from robosc.simulate.machines.state import make_controller
from robosc.supervisor import Supervisor

START = 1_700_000_000.0
GOAL = "std_msgs/Header header\nactionlib_msgs/GoalID goal_id\n{type}Goal goal\n"
OF_STATUS = "std_msgs/Header header\nactionlib_msgs/GoalStatus status\n{type}{part} {field}\n"
EVENT_2 = "service_msgs/ServiceEventInfo info\n{type}_Request[<=1] request\n{type}_Response[<=1] response\n"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
LATEST_OF_ROS_2 = Stores.ROS2_JAZZY


class BagWriter:
    """A bag that is written; types that are not of ROS are defined by text."""

    def __init__(self, path: Path, definitions: dict[str, str]) -> None:
        self.ros_1 = path.suffix == ".bag"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.ros_1 else LATEST_OF_ROS_2)
        if TRANSFORMS not in self.store.types:  # that of ROS 1 has none
            text = "geometry_msgs/TransformStamped[] transforms\n"
            self.store.register(get_types_from_msg(text, TRANSFORMS))
        for name, text in definitions.items():
            self.store.register(get_types_from_msg(text, name))
        if self.ros_1:
            self.path = path
            self._writer: Any = rosbag1.Writer(path)
        else:
            plugin = rosbag2.StoragePlugin.MCAP if path.suffix == ".mcap" else None
            plugin = plugin or rosbag2.StoragePlugin.SQLITE3
            folder = path.with_suffix("")
            # Either the folder or a file in it is what users give.
            self.path = folder / path.name if path.suffix == ".mcap" else folder
            self._writer = rosbag2.Writer(folder, version=9, storage_plugin=plugin)
        self._connections: dict[str, Any] = {}
        self._pending: list[tuple[int, int, str, str, Any]] = []
        self._last: dict[str, float] = {}
        self._number = count()

    def write(self, topic: str, type_: str, time: float, data: dict[str, Any]) -> None:
        # Those of one topic keep their order.
        time = self._last[topic] = max(time, self._last.get(topic, 0.0))
        message = default_message(self.store, type_)
        fill(self.store, message, data)
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        if stamp is not None and not stamp.sec:
            stamp.sec, stamp.nanosec = int(time), int(time % 1 * 1e9)
        entry = (round(time * 1e9), next(self._number), topic, type_, message)
        heappush(self._pending, entry)

    def write_links(self, topic: str, time: float, *links: tuple[str, str, float]) -> None:
        """Write transforms as (parent, child, distance along x)."""
        transforms = []
        for parent, child, distance in links:
            one = default_message(self.store, "geometry_msgs/msg/TransformStamped")
            one.header.stamp.sec, one.header.stamp.nanosec = int(time), int(time % 1 * 1e9)
            one.header.frame_id, one.child_frame_id = parent, child
            one.transform.translation.x, one.transform.rotation.w = distance, 1.0
            transforms.append(one)
        self.write(topic, TRANSFORMS, time, {"transforms": transforms})

    def close(self) -> None:
        pack = self.store.serialize_ros1 if self.ros_1 else self.store.serialize_cdr
        with self._writer as writer:
            while self._pending:
                time, _, topic, type_, message = heappop(self._pending)
                if topic not in self._connections:
                    self._connections[topic] = self._connection(writer, topic, type_)
                writer.write(self._connections[topic], time, pack(message, type_))

    def _connection(self, writer: Any, topic: str, type_: str) -> Any:
        """A connection with the type's name in ROS, which rosbags changes for services."""
        if self.ros_1:
            return writer.add_connection(topic, type_, typestore=self.store)
        text, _ = self.store.generate_msgdef(type_, ros_version=2)
        name = type_.replace("/srv/msg/", "/srv/")
        return writer.add_connection(topic, name, msgdef=text, rihs01=self.store.hash_rihs01(type_))


@dataclass
class Fault:
    """A command that was sent although its guard did not hold."""

    time: float
    name: str


@dataclass
class Robot:
    """What the played robot does: messages by topic with the seconds between them and their data;
    how long calls take, and how often they fail."""

    sensors: dict[str, tuple[float, Callable[[float, random.Random], dict[str, Any] | None]]]
    call_seconds: tuple[float, float] = (0.05, 0.6)
    failing: float = 0.2


@dataclass
class Recorded:
    """A recorded run: the bag, and the faults in it."""

    path: Path
    faults: list[Fault] = field(default_factory=list)
    sent: int = 0
    messages: int = 0
    allowed: list[tuple[float, str]] = field(default_factory=list)
    """Times at which a lawless command was allowed, with its name."""

    def lasting(self, seconds: float) -> list[Fault]:
        """The faults whose command was forbidden for so long before and afterwards."""
        return [
            fault
            for fault in self.faults
            if not any(
                name == fault.name and abs(time - fault.time) < seconds
                for time, name in self.allowed
            )
        ]


class _RecordingPort(Port):
    def __init__(self, run: Run) -> None:
        self._run = run

    def now(self) -> float:
        return self._run.time

    def send(self, key: str, data: Data) -> None:
        self._run.note_fault(key)
        self._run.record_message(key, data or {})

    def call(self, key: str, data: Data, token: int) -> None:
        self._run.note_fault(key)
        self._run.begin_call(key, data or {}, token)

    start = call

    def cancel(self, key: str, token: int) -> None:
        self._run.record_cancel(key, token)

    def log(self, level: str, text: str) -> None:
        pass


class Run:
    """A controller, a robot and a recorder. ``lawless`` are the names of commands that are sent
    whenever the components have them, while ``lawless_at`` says so. ``jitter`` is in seconds: how
    late a message may reach the recorder."""

    def __init__(
        self,
        supervisor: Supervisor,
        path: Path,
        robot: Robot,
        definitions: dict[str, str] | None = None,
        seed: int = 0,
        jitter: float = 0.0,
        lawless: tuple[str, ...] = (),
        lawless_at: Callable[[float], bool] = lambda time: True,
    ) -> None:
        self.time = self._written = START
        self.random = random.Random(seed)
        self._supervisor = supervisor
        self._robot = robot
        self._jitter = jitter
        self._lawless = lawless
        self._lawless_at = lawless_at
        self._agenda: list[tuple[float, int, Callable[[], None]]] = []
        self._number = count()
        self._open: dict[int, str] = {}
        self._communications = supervisor.plant.robot.communications
        self._names = supervisor.plant.robot.display_names
        self._bag = BagWriter(path, definitions or {})
        self.recorded = Recorded(self._bag.path)
        self._controller = make_controller(supervisor)
        self._rows = {(c.key, c.kind): c for c in self._controller.COMMANDS}
        self._controller.COMMANDS = tuple(
            c._replace(guard=self._without_guard(c.guard), requirements=())
            if self._names[c.key] in lawless and c.kind == "request" else c
            for c in self._controller.COMMANDS
        )  # fmt: skip
        settings: Settings = read_settings(supervisor.plant.robot, {})
        self._controller.configure(settings.more)
        self._engine = controller_engine(
            self._controller, _RecordingPort(self), settings, lambda: self.time
        )
        self._topics: dict[str, list[Communication]] = {}
        for one in self._communications.values():
            if one.kind.value == "outgoing message":
                self._topics.setdefault(self._topic(one), []).append(one)

    def _without_guard(self, guard: Callable[[Controller], bool]) -> Callable[[Controller], bool]:
        return lambda controller: self._lawless_at(self.time - START) or guard(controller)

    def play(self, seconds: float) -> Recorded:
        for topic, (period, make) in self._robot.sensors.items():
            self._at(self.random.uniform(0.0, period), lambda t=topic, p=period, m=make: (
                self._sense(t, p, m)))  # type: ignore[misc]  # fmt: skip
        self._engine.begin()
        self._engine.cycle()
        end = START + seconds
        while True:
            delay = self._engine.time_to_deadline()
            next_ = self._agenda[0][0] if self._agenda else end
            due = end if delay is None else max(self.time + delay, self.time + 1e-6)
            if min(due, next_) >= end:
                break
            if next_ <= due:
                self.time, _, do = heappop(self._agenda)
                do()
            else:
                self.time = due
            self._engine.cycle()
            self._note_allowed()
        self._bag.close()
        return self.recorded

    def _at(self, delay: float, do: Callable[[], None]) -> None:
        heappush(self._agenda, (self.time + delay, next(self._number), do))

    def _topic(self, one: Communication) -> str:
        return "/" + one.identifier.lstrip("/")

    def _type(self, one: Communication, suffix: str = "", folder: str = "msg") -> str:
        inner = "" if folder == "msg" else "/msg"  # as rosbags has it
        return f"{one.binding.package}/{folder}{inner}/{one.binding.type}{suffix}"

    def _sense(self, topic: str, period: float, make: Any) -> None:
        ones = self._topics[topic]
        data = make(self.time - START, self.random)
        if data is not None:
            message = default_message(self._bag.store, self._type(ones[0]))
            fill(self._bag.store, message, data)
            self._engine.poster([one.key for one in ones])(message)
            self._record(topic, self._type(ones[0]), data)
        self._at(period, lambda: self._sense(topic, period, make))

    def _record(self, topic: str, type_: str, data: dict[str, Any]) -> None:
        self.recorded.messages += 1
        # Readers do not keep the order of messages of one time.
        time = self._written = max(self.time, self._written + 2e-6)
        self._bag.write(topic, type_, time + self.random.uniform(0.0, self._jitter), data)

    def _note_allowed(self) -> None:
        for key, kind in self._rows:
            name = self._names[key]
            if kind == "request" and name in self._lawless and self._is_allowed(key):
                self.recorded.allowed.append((self.time - START, name))

    def _is_allowed(self, key: str) -> bool:
        row = self._rows[key, "request"]
        needed = [self._controller.REQUIREMENTS[i] for i in row.requirements]
        return row.guard(self._controller) and all(r.holds(self._controller) for r in needed)

    def note_fault(self, key: str) -> None:
        self.recorded.sent += 1
        if not self._is_allowed(key):
            self.recorded.faults.append(Fault(self.time - START, self._names[key]))

    def record_message(self, key: str, data: dict[str, Any]) -> None:
        one = self._communications[key]
        self._record(self._topic(one), self._type(one), data)

    # --- services and actions --------------------------------------------------------------------

    def begin_call(self, key: str, data: dict[str, Any], token: int) -> None:
        one = self._communications[key]
        action = one.kind.value == "action"
        self._open[token] = key
        if action:
            self._engine.report(key, token, "accepted")
            self._show(one, token, "goal", data)
        elif not self._bag.ros_1:
            self._event(one, token, 1, {})
        fails = self.random.random() < self._robot.failing
        self._at(self.random.uniform(*self._robot.call_seconds), lambda: self._end(token, fails))

    def _end(self, token: int, fails: bool) -> None:
        key = self._open.pop(token, None)
        if key is None:
            return
        one = self._communications[key]
        action = one.kind.value == "action"
        if action:
            self._show(one, token, "aborted" if fails else "succeeded", {})
        elif not self._bag.ros_1:
            self._event(one, token, 2, {})
            fails = False
        if fails:
            self._engine.report(key, token, "error", Failure("it failed"))
        else:
            result = self._result(one)
            self._engine.report(key, token, "response", result)

    def _result(self, one: Communication) -> Any:
        """A result or response with its defaults."""
        names = {"action": ("Result", "_Result"), "service": ("Response", "_Response")}
        of_1, of_2 = names[one.kind.value]
        type_ = self._type(one, of_1) if self._bag.ros_1 else self._type(
            one, of_2, "action" if one.kind.value == "action" else "srv")  # fmt: skip
        known = type_ in self._bag.store.fielddefs
        return default_message(self._bag.store, type_) if known else None

    def record_cancel(self, key: str, token: int) -> None:
        self._show(self._communications[key], token, "cancel", {})
        # Apart from the messages of sensors: those of the robot must not overtake each other.
        self._at(0.02, lambda: self._end_cancelled(token))

    def _end_cancelled(self, token: int) -> None:
        key = self._open.pop(token, None)
        if key is not None:
            self._show(self._communications[key], token, "canceled", {})
            self._engine.report(key, token, "cancelled", Failure("preempted"))

    def _show(self, one: Communication, token: int, what: str, data: dict[str, Any]) -> None:
        """What the topics of an action show."""
        topic = self._topic(one)
        if not self._bag.ros_1:
            status = {"goal": 2, "cancel": 3, "succeeded": 4, "canceled": 5, "aborted": 6}[what]
            self._status(topic, token, status)
            return
        ident = {"goal_id": {"id": f"goal {token}"}}
        if what == "goal":
            self._record(f"{topic}/goal", self._type(one, "ActionGoal"), {**ident, "goal": data})
        elif what == "cancel":
            self._record(f"{topic}/cancel", "actionlib_msgs/msg/GoalID", ident["goal_id"])
        else:
            number = {"canceled": 2, "succeeded": 3, "aborted": 4}[what]
            status = {"status": {**ident, "status": number}}
            self._record(f"{topic}/result", self._type(one, "ActionResult"), status)

    def _status(self, topic: str, token: int, status: int) -> None:
        one = default_message(self._bag.store, "action_msgs/msg/GoalStatus")
        one.goal_info.goal_id.uuid = one.goal_info.goal_id.uuid.copy()
        one.goal_info.goal_id.uuid[:4] = [token >> 24, token >> 16 & 255, token >> 8 & 255,
                                          token & 255]  # fmt: skip
        one.status = status
        type_ = "action_msgs/msg/GoalStatusArray"
        self._record(f"{topic}/_action/status", type_, {"status_list": [one]})

    def _event(self, one: Communication, token: int, type_: int, data: dict[str, Any]) -> None:
        info = {"event_type": type_, "sequence_number": token}
        self._record(
            f"{self._topic(one)}/_service_event", self._type(one, "_Event", "srv"), {"info": info}
        )


def definitions_of(text: str, name: str, ros_1: bool) -> Iterator[tuple[str, str]]:
    """The messages behind an action (three parts) or, in ROS 2, a service (two) as types."""
    package, _, type_ = name.partition("/")
    parts = [part.strip() for part in text.split("---")]
    if ros_1:
        for suffix, part in zip(("Goal", "Result", "Feedback"), parts, strict=True):
            yield f"{package}/msg/{type_}{suffix}", part
        yield f"{package}/msg/{type_}ActionGoal", GOAL.format(type=name)
        for suffix in ("Result", "Feedback"):
            text = OF_STATUS.format(type=name, part=suffix, field=suffix.lower())
            yield f"{package}/msg/{type_}Action{suffix}", text
        return
    whole = f"{package}/srv/{type_}"
    for suffix, part in zip(("_Request", "_Response"), parts, strict=True):
        yield whole + suffix, part or "uint8 structure_needs_at_least_one_member"
    yield f"{whole}_Event", EVENT_2.format(type=whole)
