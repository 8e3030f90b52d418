"""Records a run: the controller plays on a virtual clock, and the plant's step says what is right.

The engine decides when a command goes out; whether it may, what it carries, and what state every
event leads to are those of the plant. Where the two differ the script says what the plant says, and
ends.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import field
from itertools import islice
from typing import Any

from robosc.expr.traversal import path_text
from robosc.expr.tree import ParameterRef
from robosc.expr.types import ArrayType, EnumType, ObjectType, StringType, Type
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event
from robosc.runtime.core.places import place_of, stage_of, stands_in
from robosc.runtime.core.settings import parameter_name
from robosc.runtime.core.values import NOW, Undefined, jsonable
from robosc.simulate.machines.execute import Execution, read_settings
from robosc.simulate.machines.machine import Happening, label
from robosc.simulate.machines.supervised import SupervisedExecution
from robosc.simulate.values.literals import literal_text
from robosc.simulate.values.message_fields import parts_of
from robosc.supervisor import Supervisor
from robosc.traces.coverage import Case, Coverage, through
from robosc.traces.exact_steps import (
    LATE,
    NOTHING,
    Carried,
    ExactStep,
    State,
    Steps,
    refused,
)
from robosc.traces.samples import Sample, fields_text
from robosc.traces.search import Move, value_of

PATIENCE = 100000
"""Seconds of deadlines that no run is to meet: calls are answered by scripts."""
SILENCE = 1.5
"""Seconds: the timeout of messages, unless that is a parameter of the model, or shorter than a
delay that is not longer than this."""
OVERDUE = 2.5
"""Seconds: the timeout of services that can fail by time alone, unless it is such a parameter."""
RATE = 1.0
"""Hertz: how often commands are repeated, unless the model says so."""
MARGIN = 0.01
"""Seconds before a message would be silent in which it is sent again."""
LONGEST = 60.0
"""Seconds: while more time passes, messages are not sent again."""
NEVER = 1000.0
"""Seconds: longer times of the model are not waited for."""
LONGEST_BEAT = 1.1
"""Seconds: what is sent more seldom is not waited for."""
SHORTEST = 1e-6
"""Seconds: no wait is shorter."""
TOGETHER = 0.002
"""Seconds: what the clock brings within this time comes with one wait."""
PARTS = 4
"""The most parts of a period that pass one by one, since messages are to be sent in between."""
TOLD = 10000
"""Characters of all variables, if they are as long as an object; in ``~state`` longer ones are cut.
"""
BEATS = 400
"""The most moments of a clock that one wait may have."""


@dataclass(frozen=True, eq=False)
class RunLine:
    """A line of a script: what is done, what is expected after it, and which cases it shows.

    ``notes`` tell what of requirements no line before it has shown.
    """

    text: str
    expected: tuple[str, ...]
    cases: frozenset[Case]
    notes: tuple[str, ...] = ()


@dataclass(eq=False)
class ScriptedRun:
    """The lines of a run, and the parameters with which its node starts."""

    parameters: Mapping[str, Any]
    lines: list[RunLine] = field(default_factory=list)

    @property
    def cases(self) -> set[Case]:
        return set().union(*(line.cases for line in self.lines))


class Disagreement(Exception):
    """The controller did what the plant forbids, or left out what it demands."""


class Recorder:
    """One run from the start of the controller; ``machine`` is one that a run has ended with."""

    def __init__(
        self,
        supervisor: Supervisor,
        steps: Steps,
        coverage: Coverage,
        told: set[Any],
        machine: Execution | None = None,
    ) -> None:
        self._begin(steps, coverage, told)
        self._by_name = {
            (s.event.kind.word, s.event.name, s.event.index if s.event.kind.of_component else 0): s
            for s in steps.steps
        }
        parameters = self._parameters()
        self.run = ScriptedRun(parameters)
        settings = read_settings(self._robot, parameters)
        if machine is not None:
            machine.restart()
        elif steps.guards_others:
            machine = SupervisedExecution(supervisor, settings)
        else:
            machine = Execution(supervisor, settings, steps.demand_fitting)
        self.machine = machine
        self._also: Mapping[Any, Carried] = {}
        """What the other events carry that the latest message is, by identity."""
        self._heard: dict[str, tuple[ExactStep, Sample, float]] = {}
        self._record("", None, SILENT_PARTS, self.machine.beginning)

    def _begin(self, steps: Steps, coverage: Coverage, told: set[Any]) -> None:
        self._told = told
        self._is_accepted: set[str] = set()
        """The actions, by key, of which a goal runs that the server has surely taken."""
        self._steps = steps
        self._coverage = coverage
        self._robot = steps.robot
        self.state: State = steps.initial
        self.is_over = False
        self._violated: set[int] = set()
        self._new_violations: list[int] = []
        """The requirements on states that do not hold now, and of these what no line tells yet."""
        self._stages: dict[str, list[str]] = {}
        for name in self._robot.stages:
            self._stages.setdefault(place_of(name), []).append(stage_of(name))
        self._fields = {
            label(s.event): self._robot.commands[s.event.command].field or ""
            for s in steps.commands
            if s.event.kind.sent
        }

    def _parameters(self) -> dict[str, Any]:
        """The parameters with which the node starts; also, what times they give."""
        steps = self._steps
        names = {k: parameter_name(n) for k, n in self._robot.display_names.items()}
        self._timeouts: dict[str, float] = {}
        self._overdue: dict[str, float] = {}
        self._due: dict[str, float] = {}
        """When calls of services end that are not answered, by key."""
        parameters: dict[str, Any] = {"rate": RATE, **steps.rates}
        waits = [t.delay for component in self._robot.components for t in component.transitions]
        waits += [one.delay for one in self._robot.lasting]
        delays = [_seconds(delay) for delay in waits if delay is not None]
        for key, communication in self._robot.communications.items():
            given = communication.timeout
            if communication.kind is Kind.OUTGOING and given is not None:
                seconds = _parameter(given)
                if seconds is None:
                    seconds = _silence(_seconds(given), delays)
                    parameters[f"timeout/{names[key]}"] = seconds
                self._timeouts[f"~{key}"] = seconds
            elif communication.kind in (Kind.SERVICE, Kind.ACTION):
                overdue = _parameter(given)
                if overdue is None:
                    overdue = OVERDUE if key in steps.mute else PATIENCE
                    parameters[f"timeout/{names[key]}"] = overdue
                if communication.kind is Kind.SERVICE:
                    self._overdue[key] = overdue
                if communication.kind is Kind.ACTION and _parameter(communication.within) is None:
                    parameters[f"goal_timeout/{names[key]}"] = PATIENCE
        return parameters

    # --- what is done ------------------------------------------------------------------------

    def play(self, move: Move) -> None:
        """Do an input."""
        step, sample = move
        if self._steps.comes_by_time(step):
            self._await(step)
        else:
            self._fire(step, sample)

    def _fire(self, step: ExactStep, sample: Sample) -> None:
        event = self._own(step.event)
        if not self.machine.can(event, sample.given) or (sample.rejects and self._runs(event.key)):
            self.is_over = True
            return
        if event.kind is EventKind.FEEDBACK:
            self._is_accepted.add(event.key)
        happened = self.machine.fire(event, sample.given)
        text = f"{label(event)} {sample.text}".strip()
        for key in (event.key, *(other.key for other, _ in sample.also)):
            if f"~{key}" in self._timeouts:
                self._heard[f"~{key}"] = step, sample, self.machine.time
        self._also = {other.identity: parts for other, parts in sample.also}
        self._record(text, step, sample.parts, happened, value_of(step, sample))

    def _own(self, event: Event) -> Event:
        """An event as the machine knows it."""
        return event

    def _runs(self, key: str) -> bool:
        """Whether a goal is known to have been accepted, so that it cannot be rejected."""
        return key in self._is_accepted or self.state[f"~{key}"] == "cancelling"

    def _note_request(self, key: str, before: State) -> None:
        """A goal that takes the place of another one is not rejected: something was begun."""
        if before.get(f"~{key}") == "idle":
            self._is_accepted.discard(key)
        else:
            self._is_accepted.add(key)

    def beat(self) -> None:
        """Let time pass until a command is repeated, or a clock brings something else, but no
        silence."""
        is_whole = False
        for _ in range(PARTS):
            delay = self._next(set(self._fresh()))
            if self.is_over or is_whole or delay is None or delay > LONGEST_BEAT:
                return
            part = self._kept_fresh(delay, "")
            is_whole = part == delay
            if not self.is_over:
                self._wait(_up(part))

    def _fresh(self, but: str = "") -> Iterator[str]:
        """The messages that fall silent some time."""
        return (p for p in self._heard if self.state[p] == "fresh" and p != but)

    def _left(self, phase: str) -> float:
        """The seconds until a message falls silent."""
        return self._heard[phase][2] + self._timeouts[phase] - self.machine.time

    def _next(self, without: Collection[str]) -> float | None:
        """The seconds until time brings something, but the silence of some messages."""
        times = [self._left(phase) for phase in self._fresh() if phase not in without]
        silences = {self._robot.display_names[p[1:]] for p in self._timeouts}
        times += [t for n, t in self.machine.clocks.items() if n not in silences]
        times += [due - self.machine.time for due in self._due.values()]
        # What is due, and has not happened, waits for something else.
        times = [time for time in times if time > 0.0]
        command = self.machine.next_command
        times += [] if command is None else [max(command, SHORTEST)]
        return min(times, default=None)

    def _kept_fresh(self, time: float, target: str) -> float:
        """Send again what would fall silent within a time. Return how much of it may pass before
        there is more to be sent again, since it was heard just now."""
        for phase in list(self._fresh(target)):
            step, sample, heard = self._heard[phase]
            is_near = self._left(phase) <= time + MARGIN and heard < self.machine.time
            if is_near and not self.is_over:
                self._fire(step, sample)
        left = min(map(self._left, self._fresh(target)), default=math.inf)
        return time if left > time + MARGIN else left / 2

    def _await(self, step: ExactStep) -> None:
        """Let time pass until an event that it causes, while messages stay fresh."""
        target = step.phase or ""
        left = max(self._times_to(step), default=0.0)
        if left > NEVER:
            return
        is_short = left <= LONGEST
        for beat in range(BEATS):
            if self.is_over or not step.in_phase(self.state):
                return
            # One wait brings one moment: to a node, all that a longer one brings comes at once.
            delay = self._next(set(self._fresh(target)) if is_short else ())
            if delay is None or delay > NEVER:  # nothing but deadlines that no run is to meet
                return
            if beat > PARTS and min(self._times_to(step), default=0.0) > BEATS * delay:
                return  # commands come too often
            part = self._kept_fresh(delay, target) if is_short else delay
            if not self.is_over and self._wait(_up(part), step):
                return

    def _times_to(self, step: ExactStep) -> list[float]:
        """The seconds of the clocks that may bring an event; none: that depends on more."""
        if step.phase in self._heard:
            return [self._left(step.phase)]
        heres = [f"{p.component}.{self.state[p.place]}" for p in step.partners]
        clocks = self.machine.clocks.items()
        return [t for n, t in clocks if any(stands_in(h, n) for h in heres)]

    def _wait(self, time: float, until: ExactStep | None = None) -> bool:
        """Let time pass; whether an event happened then."""
        happened = self.machine.wait(time)
        end = self.machine.time + TOGETHER
        while (more := self._next(())) is not None and self.machine.time + more < end:
            time += _up(more)
            happened += self.machine.wait(_up(more))
        self._record(f"wait {time:.6f}".rstrip("0").rstrip("."), None, NOTHING, happened)
        event = None if until is None else until.event
        return event is not None and any(
            (h.kind, h.name) == (event.kind.word, event.name) for h in happened
        )

    # --- what the plant says -------------------------------------------------------------------

    def _record(
        self,
        text: str,
        step: ExactStep | None,
        parts: Carried,
        happened: Iterable[Happening],
        *shown: Case,
    ) -> None:
        if self.machine.stopped is not None:  # by internal transitions that never end
            self.is_over = True
            return
        before, cases = self.state, set(shown)
        assigned = set() if step is None else set(_assigned(step, before, parts))
        sent: list[tuple[ExactStep, Any]] = []
        try:
            for happening in happened:
                if happening.kind != EventKind.TAU.word:
                    self._look_at_states()
                cases |= self._follow(happening, step, parts, sent)
            self._demand_all(before, happened, sent)
        except Disagreement:
            self.is_over = True
        cases |= self._coverage.of_state(self.state)
        cases |= set() if step is None else through(step, before, self.state)
        expected = (
            *self._applied(step, before, parts),
            *self._expected(before, sent, assigned, self._stays(step, before, cases)),
            *self._reasons(),
            *self._violations(),
        )
        self.run.lines.append(RunLine(text, expected, frozenset(cases)))

    def _look_at_states(self) -> None:
        """Notice which requirements on states hold, as a monitor does after each input."""
        violated = self._steps.violated(self.state)
        self._new_violations = [n for n in self._new_violations if n in violated]
        self._new_violations += [n for n in violated if n not in self._violated]
        self._violated = set(violated)

    def _violations(self) -> Iterator[str]:
        """What a monitor finds about the state, if it stays."""
        self._look_at_states()
        yield from (f"violated {self._robot.requirements[n].text}" for n in self._new_violations)
        self._new_violations = []

    def _follow(
        self,
        happening: Happening,
        step: ExactStep | None,
        parts: Carried,
        sent: list[tuple[ExactStep, Any]],
    ) -> set[Case]:
        """Let the plant take an event that the controller reports."""
        found = self._by_name[happening.kind, happening.name, happening.index]
        refusal = None if step is None else self._steps.refusal_of(step)
        if happening.outcome == "refused" and found is step:
            if step.after(self.state, parts) is not None:
                raise Disagreement
            return self._coverage.of_refused_call(step, self.state, parts)
        if happening.outcome != "applied":
            if found.event.controllable and not found.allowed(self.state):
                return set()  # there are no data for it
            if found is step and refusal is not None:
                return self._coverage.of_refusal(step, self.state, parts)
            raise Disagreement
        cases: set[Case] = set()
        if step is not None and found is refusal:
            cases |= self._coverage.of_refusal(step, self.state, parts)
        carried = parts if found is step else refused(parts) if found is refusal else LATE
        carried = self._also.get(found.event.identity, carried)
        if found.event.controllable:
            if not found.event.kind.of_component and not self._steps.enabled(found, self.state):
                raise Disagreement
            try:
                carried = found.carried(self.state)
                data = found.provided(self.state)[1]
            except Undefined:
                raise Disagreement from None
            if found.event.kind is not EventKind.TAU:
                sent.append((found, data))
        key = found.event.key
        self._due.pop(key, None)
        if found.event.kind is EventKind.REQUEST:
            self._note_request(key, self.state)
        if found.event.kind is EventKind.REQUEST and key in self._overdue:
            self._due[key] = (happening.time or 0.0) + self._overdue[key]
        after = found.after(self.state, carried)
        if after is None:
            sent[:] = [one for one in sent if one[0] is not found]
            raise Disagreement
        cases |= self._coverage.of_step(found, self.state, carried, after)
        self.state = after
        return cases

    def _demand_all(
        self, before: State, happened: Iterable[Happening], sent: list[tuple[ExactStep, Any]]
    ) -> None:
        """Demand what became allowed and was not sent."""
        ended = {h.name for h in happened if h.kind in ("response", "error", "cancelled")}
        for command in self._steps.commands:
            known = {id(one) for one, _ in sent}
            if id(command) in known or command.event.name in ended:
                continue
            is_new = self._steps.enabled(command, self.state) and not command.allowed(before)
            # Without data it was allowed all the same, and waits for its next period.
            phase_was = command.in_phase(before) and command.has_data(before)
            if is_new and phase_was and not _is_busy(command, self.state):
                sent.append((command, command.provided(self.state)[1]))
                raise Disagreement

    def _applied(self, step: ExactStep | None, before: State, parts: Carried) -> Iterator[str]:
        """That an answer was one."""
        calls = (Kind.SERVICE, Kind.ACTION)
        if step is None or self._robot.communications[step.event.key].kind not in calls:
            return
        if self._steps.refusal_of(step) is None or step.after(before, parts) is not None:
            yield "applied"

    def _reasons(self) -> Iterator[str]:
        """Why commands are disabled, where no run has told that yet, or not what alone decides it:
        a command need not be due before that changes again."""
        for command in self._steps.commands:
            if self._steps.guards_others and self._steps.reads_data(command):
                continue
            if command.event.kind is EventKind.CANCEL and self._steps.guards_others:
                yield from self._cancel(command)
                continue
            reasons = self._coverage.reasons(command, self.state)
            alone = frozenset(self._coverage.of_command(command, self.state))
            elsewhere = self._coverage.open_elsewhere(command, self.state)
            why = command.number, reasons, elsewhere, alone
            if reasons is not None and why not in self._told:
                self._told.add(why)
                yield f"disabled {label(command.event)} because {'; '.join(reasons)}"

    def _cancel(self, command: ExactStep) -> Iterator[str]:
        """Whether a goal may be cancelled, where no run has told that yet."""
        why = frozenset(self._coverage.of_command(command, self.state, NOTHING))
        if command.in_phase(self.state) and (command.number, why) not in self._told:
            self._told.add((command.number, why))
            word = "enabled" if command.allowed(self.state) else "disabled"
            yield f"{word} {label(command.event)}"

    def _stays(self, step: ExactStep | None, before: State, cases: set[Case]) -> set[str]:
        """The components that take part in an event, where no run has told yet that they stay."""
        found = set()
        for partner in () if step is None else step.partners:
            name = partner.component
            why = frozenset(c for c in cases if c[0] in ("edge", "stays") and c[2] == name)
            stay = step and step.number, name, before[partner.place], self.state[partner.place], why
            if stay not in self._told:
                self._told.add(stay)
                found.add(name)
        return found

    def _expected(
        self,
        before: State,
        sent: list[tuple[ExactStep, Any]],
        assigned: set[str],
        staying: set[str],
    ) -> Iterator[str]:
        names = [label(step.event) for step, _ in sent]
        yield f"sent {', '.join(_folded(names)) or 'nothing'}"
        latest = {label(s.event): d for s, d in sent if d is not None and s.event.kind.sent}
        for name, data in latest.items():
            field = self._fields.get(name)
            fields = {
                path_text((field, *path) if field else path): value
                for path, value in parts_of(jsonable(data))
                if "header" not in path and value != NOW and not isinstance(value, dict | list)
            }
            if fields:
                yield f"data {name} {fields_text(fields)}"
        yield from self._changes(before, assigned, staying)

    def _changes(self, before: State, assigned: set[str], staying: set[str]) -> Iterator[str]:
        lasting = {one.name for one in self._robot.lasting}
        for component in self._robot.components:
            name, place = component.name, self.state.get(component.name)
            if place is None or name in lasting:
                continue
            if place_of(place) != place_of(before[name]) or name in staying or not self.run.lines:
                yield f"{name}.{place_of(place)}"
            if place != before[name]:
                yield from self._stage(f"{name}.{place_of(place)}", stage_of(place))
        for key, communication in self._robot.communications.items():
            phases, phase = communication.phases, self.state.get(f"~{key}")
            if phases is not None and phase != before[f"~{key}"] and phase != "unheard":
                yield f"{self._robot.display_names[key]}.{phase}"
        for key, variable in self._robot.variables.items():
            value = self.state[key]
            if value is None or not (value != before[key] or key in assigned):
                continue
            written = variable.written
            if isinstance(variable.type, ObjectType):
                if len(repr(value)) * len(self._robot.variables) > TOLD:
                    continue
                yield from islice(self._part(written, variable.type, jsonable(value)), 1)
            elif not isinstance(variable.type, ArrayType):
                yield from _equal(written, value, variable.type)

    def _stage(self, state: str, stage: str) -> Iterator[str]:
        """The stage of a state that performs a command, or that it is in none that is told."""
        if stage:
            yield f"{state}.{stage}"
        else:
            yield from (f"!{state}.{other}" for other in self._stages.get(state, ()))

    def _part(self, path: str, type_: ObjectType, value: Any) -> Iterator[str]:
        """The plain parts of an object that are not what a message begins with."""
        for name, inner in type_.properties:
            part = value.get(name)
            if name == "header" or not part:
                continue
            if isinstance(inner, ObjectType):
                yield from self._part(f"{path}.{name}", inner, part)
            elif not isinstance(inner, ArrayType | EnumType):
                yield from _equal(f"{path}.{name}", part, inner)


SILENT_PARTS: Carried = NOTHING


def _assigned(step: ExactStep, state: State, parts: Carried) -> Iterator[str]:
    """The variables that an event assigns."""
    for partner in step.partners:
        edge = partner.edge(state, parts)
        if edge is not None:
            yield from (key for key, *_ in edge.assigned)


def _equal(name: str, value: Any, type_: Type) -> Iterator[str]:
    """That something has a value, if that can be written."""
    if not (isinstance(value, float) and not math.isfinite(value)):
        enum, quoted = isinstance(type_, EnumType), isinstance(type_, StringType)
        yield f"{name} = {value if enum else literal_text(value, quoted)}"


def _parameter(expr: Any) -> float | None:
    """The value of a duration that is a parameter of the model; None: it is none."""
    return _seconds(expr) if isinstance(expr, ParameterRef) else None


def _seconds(expr: Any) -> float:
    """A duration of the model."""
    return float(expr.parameter.default if isinstance(expr, ParameterRef) else expr.value)


def _silence(timeout: float, delays: Iterable[float]) -> float:
    """The timeout of a message in a run: its own if it would not end before a delay otherwise."""
    return timeout if any(timeout < delay <= SILENCE for delay in delays) else SILENCE


def _up(delay: float) -> float:
    """A time in microseconds that is not shorter."""
    return max(math.ceil(round(delay * 1e6, 3)) / 1e6, SHORTEST)


def _is_busy(command: ExactStep, state: State) -> bool:
    return command.phase is not None and state[command.phase] != "idle"


def _folded(names: list[str]) -> list[str]:
    """``move.request * 3`` for what comes three times in a row."""
    found: list[list[Any]] = []
    for name in names:
        if found and found[-1][0] == name:
            found[-1][1] += 1
        else:
            found.append([name, 1])
    return [name if count == 1 else f"{name} * {count}" for name, count in found]
