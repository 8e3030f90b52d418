"""A supervisor as it executes: the generated code, between a robot and a controller that are typed.

A request that is typed is what the controller sends: it passes as it is, corrected, or not at all,
and what becomes of it is the outcome. So it is with answers to what the robot calls. Nothing is
sent by itself but the command of ``stop``.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from robosc.expr import traversal, types
from robosc.language.events import EventKind, Kind
from robosc.model.entities import Robot
from robosc.plant.automaton import Event
from robosc.plant.event_values import value_parts
from robosc.runtime.core import calls, interfaces, reasons, recorder, values
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.settings import Settings
from robosc.runtime.judge import matching
from robosc.runtime.judge.ports import SupervisorPort
from robosc.runtime.judge.supervising import Supervising, supervisor_engine
from robosc.simulate.faults import InvalidLine, Refused
from robosc.simulate.machines import execute, machine
from robosc.simulate.values import event_data, literals, typed_values
from robosc.supervisor import Supervisor


class _Port(execute.Clockwork, SupervisorPort):
    """The clock, the requests that are open, and what was blocked."""

    def __init__(
        self,
        blank: Mapping[str, event_data.Given],
        demand_fitting: execute.Check,
    ) -> None:
        super().__init__()
        self._demand_fitting = demand_fitting
        self._blank = blank
        """The parts that are read of each command, as a message has them that nobody filled in."""
        self.asked: dict[int, str] = {}
        """The keys of the commands that were typed, by the identity of what they carry."""
        self.documents: list[dict[str, Any]] = []
        self.sent: dict[str, list[Any]] = {}
        """What was passed on and is not told yet, by key: also what nothing reads."""

    def send(self, key: str, data: interfaces.Data) -> None:
        self.sent.setdefault(key, []).append(data)

    def call(self, key: str, data: interfaces.Data, token: int) -> None:
        self.sent.setdefault(key, []).append(data)
        super().call(key, data, token)

    def start(self, key: str, data: interfaces.Data, token: int) -> None:
        self.sent.setdefault(key, []).append(data)
        super().start(key, data, token)

    def works(self, key: str) -> bool:
        """The guarded controller is there, and may take its time."""
        return True

    def blocked(self, text: str) -> None:
        self.documents.append(json.loads(text))

    def corrected(self, message: Any, data: dict[str, Any]) -> Any:
        # An array that was not typed has the length of its field, which typed values do not know.
        whole = {name: value for name, value in data.items() if value != []}
        try:
            self._demand_fitting(self.asked[id(message)], "request", whole)
        except InvalidLine as problem:
            raise ValueError(str(problem)) from problem
        return with_fields(message, data)

    def composed(self, key: str, data: dict[str, Any] | None) -> Any:
        return with_fields(self._blank[key], data or {})

    def changes(self, sent: Any, made: Any, data: dict[str, Any]) -> dict[str, dict[str, Any]]:
        """Typed values have no fields but those that the model reads, by path."""
        before = dict(_leaves(sent))
        return {
            traversal.path_text(path): {"sent": values.jsonable(before.get(path, type(value)())),
                              "made": values.jsonable(value)}
            for path, value in dict(_leaves(made)).items()
            if value != before.get(path, type(value)())
        }  # fmt: skip

    def content(self, message: Any) -> Any:
        return {traversal.path_text(path): value for path, value in message.items()}


class SupervisedExecution(execute.Execution):
    """A :class:`~robosc.simulate.machines.machine.Machine` that executes the supervisor."""

    def __init__(
        self,
        supervisor: Supervisor,
        settings: Settings,
        check: execute.Check = lambda *command: None,
    ) -> None:
        names = supervisor.plant.robot.display_names
        self._keys = {names[key]: key for key in supervisor.plant.robot.communications}
        super().__init__(supervisor, settings, check)
        asked = {
            (e.key, e.kind): e.whole or e
            for e in self.plant.events
            if e.controllable and not e.kind.of_component
        }
        self._inputs = (*self._inputs, *asked.values())

    def _make(self) -> Engine[Any]:
        commands = (e for e in self.plant.events if e.controllable and e.kind is EventKind.REQUEST)
        blank = {e.key: _blank(self.plant.robot, e) for e in commands}
        self._port = _Port(blank, self._check)
        self._clock = self._port
        self._controller = self._kind()
        execute.read_given(self._controller, self.plant)
        engine = supervisor_engine(self._controller, self._port, self._settings, self._port.now)
        engine.recorder.now = self._port.now
        return engine

    def can(self, event: Event, given: event_data.Given | None) -> bool:
        if event.kind is EventKind.REQUEST and event.controllable:
            return True
        if event.controllable and (event.kind is EventKind.CANCEL or event.kind.served):
            return event.key in self._port.open
        return super().can(event, given)

    def commands(self) -> list[machine.CommandState]:
        return [replace(command, data=None) for command in super().commands()]

    def fire(self, event: Event, given: event_data.Given) -> list[machine.Happening]:
        if not event.controllable:
            return super().fire(event, given)
        if not self.can(event, given):
            phase = self._phase(event)
            why = f"is {phase}" if phase == "idle" or not event.kind.served else "is answered"
            raise Refused(f"{machine.label(event)} cannot happen now: {event.name} {why}")
        engine, key = self._engine, event.key
        role = engine.role
        assert isinstance(role, Supervising)
        self._port.asked[id(given)] = key
        if event.kind.served:
            self._answer(event, given)
        elif event.kind is EventKind.CANCEL:
            role.withdraw(key)
        elif (communication := self.plant.robot.communications[key]).kind is Kind.INCOMING:
            role.offer(communication.ros_name, [matching.CommandPattern(key)], given, given)
        else:
            role.request(key, given, given, lambda *_: None)
        engine.cycle()
        self._past.append((event, given))  # so that the identity remains its own
        return self._happened()

    def _answer(self, event: Event, given: event_data.Given) -> None:
        """Let the controller answer a call of the robot."""
        token = self._port.open[event.key]
        payload: Any = given
        if event.kind is EventKind.REFUSAL:
            payload = calls.Failure("simulated")
        if event.kind is not EventKind.PROGRESS:
            del self._port.open[event.key]
        self._engine.report(event.key, token, event.kind.word, payload)

    def _happened(self) -> list[machine.Happening]:
        blocked = [self._blocked(document) for document in self._port.documents]
        self._port.documents.clear()
        return [*super()._happened(), *blocked]

    def _happening(self, entry: recorder.Entry) -> machine.Happening:
        sent = self._port.sent.get(self._keys.get(entry.name, ""), [])
        if entry.kind == EventKind.REQUEST.word and entry.outcome == "applied" and sent:
            data = sent.pop(0)
            by_path = isinstance(data, dict) and all(isinstance(path, tuple) for path in data)
            if by_path and data.keys() - {()}:
                entry = entry._replace(value=event_data.given_json(data))
        if entry.correction is None:
            return super()._happening(entry)
        told = super()._happening(entry._replace(detail=_told(entry.correction)))
        return replace(told, judged={"corrected": entry.correction})

    def _blocked(self, document: Mapping[str, Any]) -> machine.Happening:
        event = document["event"]
        texts = [reasons.reason_text(reason) for reason in document["blocked_by"]]
        if "corrected" in document:
            texts.insert(0, _told(document["corrected"]))
        detail = "; ".join(texts)
        told = (event["kind"], event["name"], event["value"], 0, "blocked", detail)
        return machine.Happening(*told, self._port.time, True, document)

    def draw(self, rng: random.Random) -> tuple[Event, event_data.Given] | float | None:
        drawn = super().draw(rng)
        if isinstance(drawn, float) and rng.random() < 0.5:
            asked = [e for e in self._inputs if e.controllable and self.can(e, None)]
            if asked:
                event, robot = rng.choice(asked), self.plant.robot
                raw = (
                    event_data.random_raw(robot, event, rng) if value_parts(robot, event) else None
                )
                return event, event_data.complete(robot, event, raw, machine.label(event))
        return drawn


def _told(correction: Mapping[str, Any]) -> str:
    fields = correction["fields"].items()
    changes = ", ".join(f"{path} {f['sent']} becomes {f['made']}" for path, f in fields)
    return f"corrected: {changes} ({correction['place']})"


def _blank(robot: Robot, event: Event) -> event_data.Given:
    """The parts of a command that are read, or its whole value, as they are by default."""
    communication = robot.communications[event.key]
    whole = communication.value_type(event.kind)
    named = isinstance(whole, types.NoneType | types.ObjectType)
    parts = value_parts(robot, event) if named else {(): whole}
    return {path: typed_values.default_part(type_) for path, type_ in parts.items()}


def with_fields(message: event_data.Given, fields: Mapping[str, Any]) -> dict[literals.Path, Any]:
    """What was typed, with fields set: in the parts that it has, around them and within them."""
    made = copy.deepcopy(dict(message))
    for path, value in _leaves({(name,): part for name, part in fields.items()}):
        around = [whole for whole in made if whole == path[: len(whole)] != path]
        for whole in around:
            made[whole] = _with_part(made[whole], path[len(whole) :], value)
        for part in [part for part in made if part[: len(path)] == path]:
            made[part] = _part(value, part[len(path) :])
        if not around:
            made[path] = value
    return made


def _with_part(whole: Any, path: literals.Path, value: Any) -> Any:
    """A whole in which a part is set; what has no parts is the value of its message's one field."""
    if not path or not isinstance(whole, SimpleNamespace):
        return value
    parts, name = dict(vars(whole)), str(path[0])
    parts[name] = _with_part(parts[name], path[1:], value)
    return SimpleNamespace(**parts)


def _part(whole: Any, path: literals.Path) -> Any:
    """A part of a value; None for an element of an array that it does not have."""
    for step in path:
        if isinstance(step, str):
            whole = None if whole is None else vars(whole)[step]
        else:
            whole = whole[step] if step < len(whole) else None
    return whole


def _leaves(parts: Mapping[literals.Path, Any]) -> Iterator[tuple[literals.Path, Any]]:
    """The values by path, with the members of objects in the place of the objects."""
    for path, value in parts.items():
        members = vars(value) if isinstance(value, SimpleNamespace) else value
        if isinstance(members, dict):
            yield from _leaves({(*path, name): member for name, member in members.items()})
        else:
            yield path, value
