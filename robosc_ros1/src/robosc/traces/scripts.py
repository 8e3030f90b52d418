"""The scripts of a package's test: chosen runs, and what no run shows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

from robosc.emit.controller.python_literals import assignment
from robosc.emit.package.config import Config
from robosc.emit.package.package import Mode
from robosc.emit.supervisor.listening import unheard
from robosc.emit.write.line_breaks import break_long_lines
from robosc.expr.tree import FALSE
from robosc.language.events import Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model.ros.definitions import MessageDefinitions
from robosc.simulate.machines.machine import label
from robosc.simulate.start import supervisor_with
from robosc.simulate.values.literals import literal_text
from robosc.simulate.values.message_fields import Fields, KnownFields
from robosc.supervisor import Supervisor
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import Steps
from robosc.traces.guard_recorder import GuardRecorder, MonitorRecorder, permissive
from robosc.traces.recorder import Recorder, ScriptedRun
from robosc.traces.samples import Samples
from robosc.traces.search import Edge, InputGraph, scaled
from robosc.traces.unreachable import Unreachable

LONGEST_RUN = 120
"""The most inputs of a run, unless it is on its way to something."""
RUNS, INPUTS = 60, 2000
"""The most runs, and the most inputs of all of them."""
Shown: TypeAlias = tuple[list[str], str]
"""The scripts that show something, or why none does."""
RequirementRow: TypeAlias = tuple[str, str, Shown, Shown]
"""A requirement's text and place, and what shows it true, and false where it alone forbids."""
PROVED = "proved unreachable"
BEATS = 2
"""The most periods that pass after an input."""
ATTEMPTS = 2
"""How often a case is tried whose way did not lead there."""


@dataclass(frozen=True)
class Traces:
    """The runs of a package's test, and the cases, with those that are shown by none."""

    runs: tuple[ScriptedRun, ...]
    cases: dict[Case, str]
    shown: frozenset[Case]
    coverage: Coverage
    proved: frozenset[Case]
    """Those that no run can show."""
    inputs: int
    """How many were tried to find the others."""

    def why(self, cases: Collection[Case]) -> str:
        """Why none of some cases is shown."""
        if self.proved.issuperset(cases):
            return PROVED
        return f"not found in {self.inputs:,} inputs"


def choose(
    supervisor: Supervisor,
    fields: Fields | None = None,
    mute: Collection[str] = (),
    rates: Mapping[str, float] = MappingProxyType({}),
    follows: bool = False,
    unjudged: Collection[str] = (),
    judges_states: bool = False,
) -> Traces:
    """Choose the runs of a supervised robot; all else is as in Steps."""
    steps = Steps(supervisor, mute, rates, follows, unjudged, fields, judges_states)
    coverage = Coverage(steps)
    samples = Samples(steps.robot, [s.event for s in steps.steps], steps.fields)
    excluded = Unreachable(coverage)
    proved = excluded.whatever_numbers_are()
    search = InputGraph(steps, coverage, samples, coverage.cases.keys() - proved)
    search.explore()
    judged = permissive(supervisor) if follows else supervisor
    wanted = set(search.seen)
    told: set[Any] = set()
    attempts = Counter[Case]()
    runs: list[ScriptedRun] = []
    shown: set[Case] = set()
    left = scaled(INPUTS, coverage)
    kind = MonitorRecorder if follows else GuardRecorder if steps.guards_others else Recorder
    machine = None
    while wanted and len(runs) < RUNS and left > 0:
        recorder = kind(judged, steps, coverage, told, machine)
        machine = recorder.machine
        shown |= recorder.run.cases
        wanted -= shown
        in_vain = attempts.total() + search.failures.total()
        progress = _extend(recorder, search, wanted, shown, attempts)
        left -= len(recorder.run.lines)
        if progress or not runs:
            runs.append(recorder.run)
        elif in_vain == attempts.total() + search.failures.total():
            break  # and the next run would be the same
    _annotate(runs, coverage)
    found = frozenset(shown & coverage.cases.keys())
    proved |= excluded.with_numbers(coverage.cases.keys() - found - proved)
    return Traces(tuple(runs), coverage.cases, found, coverage, proved, search.tried)


def _annotate(runs: Sequence[ScriptedRun], coverage: Coverage) -> None:
    """Note at each line what of requirements it is the first one to show."""
    told: set[Case] = set()
    for run in runs:
        for number, line in enumerate(run.lines):
            new = [c for c in coverage.cases if c in line.cases and c not in told]
            told.update(new)
            notes: dict[str, list[str]] = {}
            for case in new:
                if case[0] == "demand":
                    demand = coverage.rules_by_number[case[1]].demands[case[2]]
                    name = f"{demand.place}, {label(coverage.rules_by_number[case[1]].step.event)}"
                    notes.setdefault(name, []).append(coverage.outcomes[case])
            texts = tuple(f"{name}: {'; '.join(parts)}" for name, parts in notes.items())
            run.lines[number] = replace(line, notes=texts)


def _extend(
    recorder: Recorder,
    search: InputGraph,
    wanted: set[Case],
    shown: set[Case],
    attempts: Counter[Case],
) -> bool:
    """Lead a run to wanted cases until there are none near; whether it showed any."""
    progress = False
    inputs = 0
    while wanted and inputs < LONGEST_RUN:
        if recorder.is_over:
            break
        node = search.node(recorder.state)
        search.expand(node)
        path = search.path(node, wanted)
        if path is None:
            search.convert(node, wanted)
            search.expand_around(node)
            path = search.path(node, wanted)
        if path is None:
            break
        for edge in path:
            new = _play(recorder, search, edge, wanted)
            inputs += 1
            progress = progress or bool(new)
            shown |= new
            wanted -= new
            if search.node(recorder.state) is not edge[1]:
                search.failures[id(edge)] += 1
                break
        for case in edge[2] & wanted:
            attempts[case] += 1
            if attempts[case] >= ATTEMPTS:
                wanted.discard(case)
    return progress


def _play(recorder: Recorder, search: InputGraph, edge: Edge, wanted: set[Case]) -> set[Case]:
    """Do an input; let beats pass in which commands follow that it allows, and in which it shows
    that one is not sent. Return the wanted cases that were shown."""
    if recorder.is_over:
        return set()
    move, target, cases = edge
    lines = recorder.run.lines
    at = len(lines)
    recorder.play(move)
    for _ in range(BEATS):
        every = set().union(*(line.cases for line in lines[at:]))
        new = every & wanted
        arrived = search.node(recorder.state) is target
        forbids = _forbids(search.coverage, new, every)
        if recorder.is_over or (arrived and not (cases & wanted) - new and not forbids):
            break
        recorder.beat()
        if forbids:
            break
    return set().union(*(line.cases for line in lines[at:])) & wanted


def _forbids(coverage: Coverage, cases: set[Case], beside: set[Case]) -> bool:
    """Whether one of the cases, ``beside`` others, is that a command must not come."""
    return any(
        c[0] in ("blocked", "yields")
        or (c[0] == "demand" and coverage.demanded(c) is False)
        or (c[0] == "edge" and ("blocked", *c[1:3]) in beside)
        for c in cases
    )


def chosen(supervisor: Supervisor, model: Path) -> Traces:
    """The runs of the test of a package of ROS 1 without configuration; ``model`` is the file."""
    definitions = MessageDefinitions.for_model(model, ros_version="1")
    return choose(supervisor, KnownFields(supervisor.plant.robot, definitions))


def test_files(
    supervisor: Supervisor, model: Path, target: str, config: Config, mode: Mode
) -> dict[str, str]:
    """The files of a package's test, by path; ``target`` is ``ros1`` or ``ros2``, ``model`` the
    file of the model."""
    configured = supervisor_with(supervisor, config.parameters)
    robot = configured.plant.robot
    definitions = MessageDefinitions.for_model(model, ros_version=target[-1])
    services = (Kind.SERVICE, Kind.SERVED_SERVICE)
    # A service of ROS 2 cannot tell that it has failed.
    mute = [c.key for c in robot.communications.values() if c.kind in services]
    mute = mute if target == "ros2" else []
    rates = {n: float(v) for n, v in config.parameters.items() if n.startswith("rate/")}
    follows = mode == "monitor"
    hidden, sees_all = frozenset[str](), False
    if follows:
        hidden, sees_all = unheard(configured, robot.span.source.file_name, target == "ros1")
    known = KnownFields(robot, definitions)
    traces = choose(configured, known, mute, rates, follows, hidden, sees_all)
    return files(configured, traces, config.untested)


def files(supervisor: Supervisor, traces: Traces, untested: Collection[str]) -> dict[str, str]:
    """The files of a package's test, by path: a script for each run, and what they show.

    ``untested`` are the commands that need not be shown, because the model's owner says so; to a
    monitor none need be, since some need time to pass.
    """
    names = run_names(traces)
    found = {
        f"test/scripts/{name}.sim": script(supervisor, run, name)
        for name, run in zip(names, traces.runs, strict=True)
    }
    source = supervisor.plant.robot.span.source.file_name
    follows = traces.coverage.steps.follows
    rest = [(case, text) for case, text in traces.cases.items() if case not in traces.shown]
    head = (
        f"# This file was generated by robosc from {source}. Do not edit it: change the model.\n"
        '"""What the scripts show: requirements met and violated, and what none of them shows."""\n'
    )
    found["test/shown.py"] = (
        f"{break_long_lines(head)}\n"
        + assignment("RUNS", names)
        + assignment("REQUIREMENTS", requirement_rows(supervisor, traces))
        + assignment("UNTESTED", [] if follows else _untested(traces, untested))
        + f"SHOWN, CASES, INPUTS = {len(traces.shown)}, {len(traces.cases)}, {traces.inputs}\n"
        + assignment("UNKNOWN", sorted(traces.coverage.steps.fields.unknown))
        + assignment("UNREACHABLE", [text for c, text in rest if c in traces.proved])
        + assignment("NOT_FOUND", [text for c, text in rest if c not in traces.proved])
    )
    return found


def run_names(traces: Traces) -> list[str]:
    """The names of the scripts, in order."""
    digits = len(str(len(traces.runs)))
    return [f"run_{number:0{digits}}" for number in range(1, len(traces.runs) + 1)]


def requirement_rows(supervisor: Supervisor, traces: Traces) -> list[RequirementRow]:
    """What the scripts show of each requirement on commands."""
    rows: list[RequirementRow] = []
    names = run_names(traces)
    for index, requirement in enumerate(supervisor.plant.robot.requirements):
        demands = {
            (rule.step.number, n)
            for rule in traces.coverage.rules
            for n, demand in enumerate(rule.demands)
            if demand.requirement == index
        }
        sides = [{("states", index, value)} & traces.cases.keys() for value in (True, False)]
        for case in traces.cases:
            if case[0] == "demand" and case[1:3] in demands:
                holds = traces.coverage.demanded(case)
                if holds is not None:
                    sides[not holds].add(case)
        if not any(sides):
            continue
        met, violated = (_side(traces, names, cases) for cases in sides)
        rows.append((requirement.text, requirement.span.place, met, violated))
    return rows


def _side(traces: Traces, names: Sequence[str], cases: Collection[Case]) -> Shown:
    """What shows one of some cases."""
    pairs = zip(names, traces.runs, strict=True)
    shown = [name for name, run in pairs if not run.cases.isdisjoint(cases)]
    return shown, "" if shown else f"not shown ({traces.why(cases)})"


def _untested(traces: Traces, untested: Collection[str]) -> list[str]:
    """The commands that no run sends, though the supervisor allows them somewhere."""
    found = []
    for rule in traces.coverage.rules:
        event = rule.step.event
        guard = traces.coverage.steps.guards.get(event.identity)
        case = "sent", rule.step.number
        never = case in traces.proved or (guard is not None and guard.expr == FALSE)
        if case not in traces.shown and not never:
            names = (event.name, label(event))
            if not untested or not set(names) & set(untested):
                why = f"not shown ({traces.why([case])}); see untested in robosc.yaml"
                found.append(f"{label(event)} is {why}")
    return found


def script(supervisor: Supervisor, run: ScriptedRun, title: str) -> str:
    """A run as a script of ``robosc simulate --execute``."""
    robot = supervisor.plant.robot
    lines = [
        f"# This file was generated by robosc from {robot.span.source.file_name}. Do not edit it.",
        f"# {title} of {robot.name}",
    ]
    lines += [f"set {name} {literal_text(value, True)}" for name, value in run.parameters.items()]
    lines += _lines(run)
    return "\n".join(lines) + "\n"


def _lines(run: ScriptedRun) -> Iterator[str]:
    for line in run.lines:
        yield from (f"# {note}" for note in line.notes)
        if line.text:
            yield line.text
        for expected in line.expected:
            yield f"expect {expected}"
