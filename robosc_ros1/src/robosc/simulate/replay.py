"""A run of a generated node against the model: does its event log stay within it?

The log is read into a controller that is generated from the model: what the robot sent is applied,
and each command must have been allowed then, with just the data that the model provides.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from copy import copy
from typing import Any

from robosc.errors import UsageError, counted
from robosc.expr import traversal, tree, types
from robosc.expr.traversal import all_names, path_text
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Robot
from robosc.model.typing.compatibility import describe
from robosc.plant import automaton, event_values
from robosc.plant.automaton import Event, EventParameter, Plant, StateVariable, VariableKind
from robosc.runtime.core import persistence, places, recorder, shortening
from robosc.runtime.core.internal_transitions import Tau
from robosc.runtime.core.model import Command, Controller, Input
from robosc.runtime.core.reasons import blocked_by, reason_text
from robosc.runtime.core.timers import After
from robosc.runtime.core.values import Mismatch, Undefined, jsonable
from robosc.simulate.event_log import LogEntry, read_log
from robosc.simulate.faults import InvalidLine
from robosc.simulate.machines.state import make_controller
from robosc.simulate.values import shortened_values, typed_values
from robosc.supervisor import Supervisor

# The values of events in a log: from JSON to those that the controller takes.


@dataclass(frozen=True)
class LoggedPart:
    """A part of an input's value, which may be missing if it is ``optional``."""

    type: types.Type
    optional: bool

    def restored(self, told: Any) -> Any:
        """The value from JSON.

        Raises:
            ValueError: it is not of the type.
        """
        if told is None and self.optional:
            return None
        try:
            value = typed_values.typed_value(self.type, _of_type(self.type, told), "it")
        except InvalidLine:
            value = None
        values = types.domain(self.type)
        if value is None or (values is not None and told not in values):
            raise ValueError(f"it carries {describe(self.type)}")
        return value


def _of_type(type_: types.Type, told: Any) -> Any:
    """The members that the model declares: a whole message is logged with all of them.

    Raises:
        InvalidLine: one is not there.
    """
    match typed_values.within_whole(type_), told:
        case types.ArrayType(element=element), list():
            return [_of_type(element, item) for item in told]
        case types.ObjectType(properties=properties), dict():
            if missing := [name for name, _ in properties if name not in told]:
                raise InvalidLine(f"{missing[0]} is missing")
            return {name: _of_type(inner, told[name]) for name, inner in properties}
    return told


def carried_parts(supervisor: Supervisor) -> dict[tuple[str, str], dict[str, LoggedPart]]:
    """By communication and kind, the parts of an input's value; that of a whole one is ``""``."""
    robot = supervisor.plant.robot
    return {
        (event.key, event.kind.word): _parts(robot, event)
        for event in supervisor.plant.events
        if not isinstance(event_values.value_type(robot, event), types.NoneType)
    }


def _parts(robot: Robot, event: automaton.Event) -> dict[str, LoggedPart]:
    optional = event_values.is_optional(robot, event)
    parts = event_values.value_parts(robot, event).items()
    return {path_text(p): LoggedPart(t, optional or not all_names(p)) for p, t in parts}


def restored_value(told: Any, parts: dict[str, LoggedPart]) -> Any:
    """The value of an input from JSON, if it is one of these types.

    Raises:
        ValueError: it is not.
    """
    if not parts:
        return None
    if "" in parts and not isinstance(parts[""].type, types.ObjectType):
        return parts[""].restored(told)
    if not isinstance(told, dict) or set(told) != set(parts):
        raise ValueError(f"it has the parts {', '.join(parts)}")
    return {path: part.restored(told[path]) for path, part in parts.items()}


# Exact values and the classes that they are in: ``battery.response(0.15: value <= 0.2)``.


def value_with_classes(event: Event, value: Any) -> str:
    """The value of an input, or its parts by path, each with its class."""
    labels = {traversal.path_text(p.path): p for p in event.parameters if p.labels is not None}

    def with_class(path: str, part: Any) -> str:
        text = _text(part)
        parameter = labels.get(path)
        return text if parameter is None else f"{text}: {_label(parameter, part)}"

    if isinstance(value, dict):
        return ", ".join(f"{path} = {with_class(path, part)}" for path, part in value.items())
    return with_class("", value)


def data_behind(plant: Plant, event: Event, variables: Mapping[str, Any]) -> Iterator[str]:
    """The data that a command's requirements compare: each with its value and its class."""
    robot = plant.robot
    read = dict.fromkeys(
        f"{part.component}.{part.variable}"
        for index in event.requirements
        for part in traversal.walk(robot.requirements[index].condition)
        if isinstance(part, tree.VariableRef)
    )
    for variable in plant.variables:
        if variable.name in read and variable.labels is not None and variable.test is None:
            value = variables[variable.name]
            yield f"{variable.name} = {_text(value)}: {_label(variable, value)}"


def _text(value: Any) -> str:
    return json.dumps(jsonable(value))


def _label(of: EventParameter | StateVariable, value: Any) -> str:
    """What users see of the class that a value is in."""
    assert of.labels is not None
    return of.labels[of.values.index(value)]


@dataclass(frozen=True)
class Departure:
    """Where a run leaves the model; ``number`` is the event's in the log, ``requirements`` are the
    texts of those that it is against."""

    file: str
    line: int
    number: int
    event: str
    reason: str
    requirements: tuple[str, ...] = ()


@dataclass(frozen=True)
class Replayed:
    """What a log holds. ``missing`` counts events that the log lost, so that the rest of that run
    could not be followed."""

    robot: str
    runs: int
    events: int
    mismatches: int
    departures: tuple[Departure, ...]
    missing: tuple[str, ...]
    unchecked: int
    """Events whose effects are taken from the log, which has the values only in short forms."""

    @property
    def exit_code(self) -> int:
        """1: a run leaves the model; 2: it could not be followed to its end."""
        return 1 if self.departures else 2 if self.missing else 0


def replay(
    supervisor: Supervisor, log: str, look: Callable[[Follower, LogEntry], None] | None = None
) -> Replayed:
    """Follow all runs of a log. Older files of a rotated log (``LOG.1`` …) are read before it.
    ``look`` is called after each event.

    Raises:
        UsageError: a file cannot be read, or is no event log.
    """
    follower = Follower(supervisor)
    for entry in read_log(log):
        follower.take(entry)
        if look is not None:
            look(follower, entry)
    if not follower.runs:
        raise UsageError(f"{log} holds no events")
    if not (follower.followed or follower.departures or follower.missing):
        events = counted(follower.events, "event")
        raise UsageError(f"{log}: nothing could be judged: it has {events}, but none that happened")
    return Replayed(
        supervisor.plant.robot.name,
        follower.runs,
        follower.events,
        follower.mismatches,
        tuple(follower.departures),
        tuple(follower.missing),
        follower.unchecked,
    )


class Follower:
    """Follows one run after the other; each begins with event 1."""

    def __init__(self, supervisor: Supervisor) -> None:
        self._fresh = make_controller(supervisor)
        names = {c.key: c.name for c in self._fresh.COMMUNICATIONS}
        self._inputs = {(names[i.key], i.kind): i for i in self._fresh.INPUTS}
        self._commands = {(names[c.key], c.kind): c for c in self._fresh.COMMANDS}
        self._taus = {(t.component, t.number): t for t in self._fresh.TAUS}
        self._afters = {(a.component, a.number): a for a in self._fresh.AFTERS}
        self._carried = carried_parts(supervisor)
        self._variables = {
            key: LoggedPart(variable.type, optional=True)
            for key, variable in supervisor.plant.robot.variables.items()
        }
        self._plant = supervisor.plant
        self._locations = {
            variable.name: {*map(str, variable.values)}
            for variable in self._plant.variables
            if variable.kind is VariableKind.LOCATION
        }
        self._paths = {
            (e.key, e.index): e.path for e in self._plant.events if e.kind is EventKind.TAU
        }
        self._events = {(e.name, e.kind.word): e for e in self._plant.events}
        self._controller: Controller | None = None
        self._stopped = False
        self._next = 1
        self.lost: str | None = None
        """Why the state is not known any more, in the present run."""
        self._against: tuple[str, ...] = ()
        self.runs = self.events = self.mismatches = self.unchecked = self.followed = 0
        self.departures: list[Departure] = []
        self.missing: list[str] = []

    @property
    def initial(self) -> Controller:
        """In the initial state; not to be changed."""
        return self._fresh

    @property
    def controller(self) -> Controller | None:
        """In the state after the last event; None where that is not known (any more)."""
        return self._controller

    @property
    def robot(self) -> Robot:
        return self._plant.robot

    def fork(self) -> Follower:
        """Another one that goes on from here by itself."""
        other = copy(self)
        other._controller = None if self._controller is None else self._controller.copy()
        other.departures = list(self.departures)
        other.missing = list(self.missing)
        return other

    def take(self, entry: LogEntry) -> None:
        self.events += 1
        self.mismatches += entry.outcome == "mismatch"
        if entry.number == 1 or entry.number < self._next or not self.runs:
            self.runs += 1
            self._controller = self._started(entry)
            self._stopped = False
            self._next = 1
            self.lost = None
        if self._controller is None:
            return
        if entry.number != self._next:
            place = f"{entry.file}:{entry.line}"
            self.lost = f"{place}: events {self._next} to {entry.number - 1} are missing"
            self.missing.append(self.lost)
            self._controller = None
            return
        self._next += 1
        self._stopped |= entry.outcome == "stopped"
        if entry.outcome not in ("applied", "forbidden", "undecided"):
            return
        self.followed += 1
        self._against = ()
        self.lost = self._follows(self._controller, entry)
        if self.lost is not None:
            event = self._told(entry)
            self.departures.append(
                Departure(entry.file, entry.line, entry.number, event, self.lost, self._against)
            )
            self._controller = None  # what follows is not known any more

    def _started(self, entry: LogEntry) -> Controller:
        """A controller at the beginning of a run.

        Raises:
            UsageError: a parameter, or a variable at its start, cannot have the logged value.
        """
        controller = self._fresh.copy()
        given = entry.document.get("parameters", {})
        values = self._fresh.parameters()
        for parameter in self.robot.parameters:
            if parameter.name in given:
                told = given[parameter.name]
                try:
                    values[parameter.name] = LoggedPart(parameter.type, False).restored(told)
                except ValueError as error:
                    raise _unfit(entry, f"parameter {parameter.name}", told, str(error)) from None
        controller.configure(values)
        starts = entry.document.get("start", {})
        for name in persistence.start(controller, starts):
            if name in starts:
                raise _unfit(entry, f"start of {name}", starts[name], "it is not of its type")
        return controller

    def _told(self, entry: LogEntry) -> str:
        """An event with the value that it brings, and the classes that this is in."""
        event = self._events.get((entry.name, entry.kind))
        parts = {} if event is None else self._carried.get((event.key, event.kind.word), {})
        if event is None or not parts:
            return entry.text
        try:
            return f"{entry.text}({value_with_classes(event, restored_value(entry.value, parts))})"
        except ValueError:
            return entry.text  # the reason says it

    def _follows(self, controller: Controller, entry: LogEntry) -> str | None:
        """Apply an event as the model says, or as the log says where that does not have the values;
        why it cannot be, if so."""
        effect = entry.document.get("effect")
        if effect is None:
            return self._leaves(controller, entry)
        is_followed = not (entry.shortened and (entry.name, entry.kind) in self._inputs)
        if is_followed and not entry.document.get("reordered"):
            try:
                twin = controller.copy()
                reason = self._leaves(twin, entry)
                controller.__dict__.update(twin.__dict__)
                return reason
            except shortened_values.UnknownValue:
                pass
        self.unchecked += 1

        def restored(group: str, name: str, told: Any) -> Any:
            if group == "components" and told not in self._locations[name]:
                raise ValueError(f"{name} has no state {told}")
            return self._variables[name].restored(told) if group == "variables" else told

        try:
            shortened_values.apply_effect(controller, effect, restored)
        except (KeyError, ValueError) as error:
            return f"its effect cannot be {json.dumps(effect)}: {error}"
        return None

    def _leaves(self, controller: Controller, entry: LogEntry) -> str | None:
        """Apply an event; why it cannot be, if so.

        Raises:
            UnknownValue: that depends on values that the log has only in a short form.
        """
        if entry.kind == EventKind.TAU.word:
            tau = self._taus.get((entry.name, entry.index))
            return _step(controller, tau, entry.value)
        owed = next((t for t in controller.TAUS if _can_step(controller, t)), None)
        # Steps that never end are broken off by a stop: some are still owed then.
        if owed is not None and not self._stopped:
            path = self._paths[owed.component, owed.number]
            return f"{owed.component} had to take its transition {path} before"
        if entry.kind == EventKind.AFTER.word:
            after = self._afters.get((entry.name, entry.index))
            return _step(controller, after, entry.value)
        input_ = self._inputs.get((entry.name, entry.kind))
        if input_ is not None:
            controller.reason = str(entry.document.get("reason", ""))
            parts = self._carried.get((input_.key, input_.kind), {})
            return _apply(controller, input_, entry.value, parts)
        command = self._commands.get((entry.name, entry.kind))
        if entry.seen:  # what others sent was judged by the monitor that saw it
            if command is not None:
                self._apply_seen(controller, command, entry)
            return None
        if command is not None:
            stopping = entry.document.get("detail") == recorder.STOP_COMMAND
            if self._stopped and not stopping:
                return "the controller had made a safe stop"
            if (found := _perform(controller, command, entry, stopping, self._carried)) is None:
                return None
            reason, self._against = found
            event = self._events[entry.name, entry.kind]
            return "; ".join([reason, *data_behind(self._plant, event, controller.variables())])
        return f"the model has no {entry.text}"

    def _apply_seen(self, controller: Controller, command: Command, entry: LogEntry) -> None:
        parts = self._carried.get((command.key, command.kind), {})
        try:
            given = () if command.read is None else (restored_value(entry.value, parts),)
        except ValueError:
            return  # a message that could not be read did nothing
        if command.apply is not None and fits(controller, command, *given):
            command.apply(controller, *given)


def _unfit(entry: LogEntry, what: str, told: Any, reason: str) -> UsageError:
    return UsageError(
        f"{entry.file}:{entry.line}: the {what} cannot be {json.dumps(told)}: {reason}"
    )


def _can_step(controller: Controller, tau: Tau) -> bool:
    try:
        return tau.step(controller.copy()) is not None
    except shortened_values.UnknownValue:
        return False


def _step(controller: Controller, row: After | Tau | None, path: Any) -> str | None:
    if row is None:
        return "the model has no such step"
    try:
        taken = row.step(controller)
    except Mismatch as mismatch:
        return str(mismatch)
    taken = taken and places.path_of(taken)
    return None if taken == path else f"the model goes {taken or 'nowhere'} here, not {path}"


def _apply(
    controller: Controller, input_: Input, told: Any, parts: dict[str, LoggedPart]
) -> str | None:
    try:
        value = None if input_.read is None else restored_value(told, parts)
        input_.apply(controller, value)
    except Mismatch as mismatch:
        return str(mismatch)
    except (ValueError, ArithmeticError) as error:
        return f"its value cannot be {json.dumps(told)}: {error}"
    return None


def _perform(
    controller: Controller,
    command: Command,
    entry: LogEntry,
    stopping: bool,
    carried: dict[tuple[str, str], dict[str, LoggedPart]],
) -> tuple[str, tuple[str, ...]] | None:
    """Apply a command; why it cannot be, and the requirements that forbid it by text, if so."""
    value = entry.value
    parts = carried.get((command.key, command.kind), {})
    try:
        given = () if command.read is None else (restored_value(value, parts),)
    except ValueError as error:
        return f"its data cannot be {json.dumps(value)}: {error}", ()
    reasons = blocked_by(controller, command, *given)
    if reasons and not stopping:
        against = tuple(r["text"] for r in reasons if r["kind"] == "requirement")
        return "; ".join(map(reason_text, reasons)), against
    if command.data is not None:
        try:
            data = command.data(controller)
        except Undefined:
            return "some of its data has not arrived yet", ()
        shown = shortening.Shortener()(data) if entry.shortened else jsonable(data)
        provided = json.loads(json.dumps(shown))
        if value is not None and provided != value:
            sends = json.dumps(provided)
            return f"the model sends {sends}, the log has {json.dumps(value)}", ()
    if command.apply is not None and (not reasons or _synchronises(controller, command, *given)):
        command.apply(controller, *given)
    return None


def fits(controller: Controller, command: Command, *given: Any) -> bool:
    """Return whether the components have a command now, whatever the requirements say."""
    return command.possible(vars(controller)) and _synchronises(controller, command, *given)


def _synchronises(controller: Controller, command: Command, *given: Any) -> bool:
    return command.synchronisation is None or bool(command.synchronisation(controller, *given))


# --- results -------------------------------------------------------------------------------------


def replay_text(replayed: Replayed) -> str:
    lines = [
        f"{d.file}:{d.line}: event {d.number}, {d.event}, leaves the model: {d.reason}"
        for d in replayed.departures
    ]
    lines += replayed.missing
    verdict = "leaves the model" if replayed.departures else "follows the model"
    if replayed.missing and not replayed.departures:
        verdict += " as far as the log is complete"
    mismatches = counted(replayed.mismatches, "mismatch", "es")
    reported = f", {mismatches} reported" if replayed.mismatches else ""
    size = f"{counted(replayed.runs, 'run')}, {counted(replayed.events, 'event')}"
    if replayed.unchecked:
        reported += (
            f", {replayed.unchecked} with effects as logged (large values, see whole_values)"
        )
    lines.append(f"{replayed.robot}: {size}{reported}: {verdict}")
    return "\n".join(lines) + "\n"


def replay_document(replayed: Replayed) -> dict[str, Any]:
    """``replay --json``, version 1."""
    return {
        "version": 1,
        "robot": replayed.robot,
        "runs": replayed.runs,
        "events": replayed.events,
        "mismatches": replayed.mismatches,
        "departures": [
            {
                "file": d.file,
                "line": d.line,
                "number": d.number,
                "event": d.event,
                "reason": d.reason,
            }
            for d in replayed.departures
        ],
        "missing": list(replayed.missing),
        "unchecked": replayed.unchecked,
    }
