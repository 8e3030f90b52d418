"""What is to be said of a bag: violations, commands that a supervisor would have blocked or
corrected, places where the run leaves the model, and how often everything came."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from robosc.errors import UsageError, counted
from robosc.language.events import EventKind, Kind
from robosc.model.entities import Robot
from robosc.progress import Progress
from robosc.runtime.core.reasons import reason_text
from robosc.runtime.core.recorder import Entry
from robosc.runtime.judge.findings import DEPARTURE, Sort, verdicts
from robosc.simulate.bags import bag_files, bag_run
from robosc.simulate.bags.recorded_names import recorded_names
from robosc.supervisor import Supervisor

_PAUSE = 1.0
"""Seconds without a finding after which one of the same kind counts as another."""

_GOING_ON = (EventKind.FEEDBACK.value, EventKind.CANCEL.value)
"""The events of a goal that do not end it."""


@dataclass
class Finding:
    """Something that happened ``count`` times in a row, from ``time`` until ``until``, in seconds
    since 1970. ``reasons`` are those of the first time."""

    sort: Sort
    time: float
    until: float
    kind: str
    name: str
    reasons: list[str]
    about: tuple[str, ...]
    """What tells it from others: the texts of requirements, or the event alone."""
    count: int = 1

    @property
    def event(self) -> str:
        return f"{self.name}.{self.kind}" if self.name else self.kind


@dataclass
class Goals:
    """The goals of an action: how they ended, and the longest, in seconds."""

    count: int = 0
    succeeded: int = 0
    failed: int = 0
    cancelled: int = 0
    longest: float = 0.0
    since: float | None = None


@dataclass
class Judgement:
    """The result for a bag; times are in seconds since 1970."""

    robot: Robot
    bag: str
    ros: int
    start: float
    end: float
    messages: int
    events: int = 0
    commands: int = 0
    crossed: int = 0
    reordered: int = 0
    findings: list[Finding] = field(default_factory=list)
    silences: dict[str, int] = field(default_factory=dict)
    goals: dict[str, Goals] = field(default_factory=dict)
    tracks: dict[str, bag_run.Track] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    """What should be in the recording, and could not be read."""
    absent: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ()
    unjudged: tuple[tuple[str, str], ...] = ()
    unsent: tuple[str, ...] = ()
    """The commands whose topics are not in the recording."""
    judges_states: bool = True
    """Whether the requirements on states were judged."""

    @property
    def unjudged_states(self) -> list[str]:
        """The texts of the requirements on all states, if these were not judged."""
        found = self.robot.requirements
        return [] if self.judges_states else [r.text for r in found if not r.communications]

    @property
    def exit_code(self) -> int:
        """1: a requirement was violated, or the run leaves the model; 2: not all that the recording
        should have could be judged."""
        return 1 if self.findings else 2 if self.missing else 0

    def of(self, sort: Sort) -> list[Finding]:
        return [finding for finding in self.findings if finding.sort == sort]


def judge(
    supervisor: Supervisor,
    path: Path,
    given: Sequence[str],
    progress: Progress,
    remapped: Sequence[str] = (),
) -> Judgement:
    """Judge a bag. ``given`` are parameters of the robot's node, as ``NAME=VALUE``, ``remapped``
    are names that were others in the run, as ``FROM:=TO``.

    Raises:
        ModelError: commands of one topic cannot be told apart by their data.
        UsageError: the bag cannot be read, or has nothing of the robot; or one is no parameter.
    """
    robot = supervisor.plant.robot
    settings = bag_run.settings_of(robot, given)
    with bag_files.opened_bag(path) as bag:
        run = bag_run.BagRun(supervisor, bag, settings, names=recorded_names(robot, remapped))
        if not run.hears:
            raise UsageError(_no_topic(path, run, bag))
        judgement = Judgement(
            robot, str(path), 1 if bag.ros_1 else 2, bag.start, bag.end, sum(bag.counts.values())
        )
        collector = _Collector(judgement)
        for entry in run.entries(progress):
            collector.take(entry)
        judgement.events += run.unrecorded
        judgement.tracks = run.tracks
        judgement.absent, judgement.unseen = tuple(run.absent), tuple(run.unseen)
        judgement.unjudged = tuple(run.unjudged)
        judgement.unsent, judgement.judges_states = tuple(run.unsent), run.judges_states
        if run.undecided:
            bag.storage.notes.append(_late(run.undecided))
        judgement.notes, judgement.missing = (
            (*bag.storage.notes, *run.transforms.faults),
            tuple(bag.storage.missing),
        )
        if not judgement.events:
            raise UsageError(f"{path}: nothing could be judged: {_no_evidence(judgement)}")
        counters = run.engine.recorder.counters
        judgement.crossed, judgement.reordered = counters["crossed"], counters["reordered"]
    return judgement


def _no_evidence(judgement: Judgement) -> str:
    """Why a recording has no event of the robot."""
    topics = ", ".join(judgement.tracks)
    read = sum(track.count for track in judgement.tracks.values())
    reason = f"there is no message of {topics}"
    if read:
        reason = f"the {counted(read, 'message')} of {topics} tell of no event of the model"
    return "; ".join((reason, *judgement.missing, *judgement.notes))


def _late(undecided: Mapping[str, int]) -> str:
    silences = ", ".join(f"{name} ({counted(n, 'time')})" for name, n in undecided.items())
    return (
        f"not counted as silent, since a message that was recorded late may have been in time:"
        f" {silences}"
    )


def _first(topics: Sequence[str] | dict[str, str]) -> str:
    names = sorted(topics)
    more = f" and {len(names) - 5} more" if len(names) > 5 else ""
    return f"it has {', '.join(names[:5])}{more}" if names else "it is empty"


def _no_topic(path: Path, run: bag_run.BagRun, bag: bag_files.Bag) -> str:
    """Why nothing can be judged; names that look remapped, into a namespace for one, are told."""
    robot = run.supervisor.plant.robot.name
    if not run.absent:
        return f"{path}: nothing could be judged: {robot} has no topic that a bag could have"
    said = [f"{path} has no topic of {robot}: {_first(bag.topics)}", *bag.storage.notes]
    topics = sorted(bag.topics, reverse=True)
    found = {name: topic for name in run.absent for topic in topics if topic.endswith(name)}
    if found:
        rules = " ".join(f"--remap {name}:={topic}" for name, topic in found.items())
        said.append(f"if names were remapped, give {rules}")
    return "; ".join(said)


class _Collector:
    """Puts events together to findings and counts."""

    def __init__(self, judgement: Judgement) -> None:
        self._found = judgement
        robot = judgement.robot
        names = robot.display_names
        self._actions = {
            names[c.key] for c in robot.communications.values() if c.kind is Kind.ACTION
        }
        self._open: dict[tuple[object, ...], Finding] = {}

    def take(self, entry: Entry) -> None:
        found = self._found
        found.events += 1
        if entry.seen:
            found.commands += 1
        if entry.kind == EventKind.TIMEOUT.value:
            found.silences[entry.name] = found.silences.get(entry.name, 0) + 1
        if entry.name in self._actions and entry.outcome in ("applied", "forbidden", "undecided"):
            self._goal(entry)
        for sort, reasons, about in _verdicts(entry):
            self._add(entry, sort, reasons, about)

    def _add(self, entry: Entry, sort: Sort, reasons: list[str], about: tuple[str, ...]) -> None:
        key = (sort, entry.kind, entry.name, about)
        known = self._open.get(key)
        if known is not None and entry.time - known.until < _PAUSE:
            known.until = entry.time
            known.count += 1
            return
        finding = Finding(sort, entry.time, entry.time, entry.kind, entry.name, reasons, about)
        self._open[key] = finding
        self._found.findings.append(finding)

    def _goal(self, entry: Entry) -> None:
        goals = self._found.goals.setdefault(entry.name, Goals())
        if entry.kind == EventKind.REQUEST.value:
            goals.count += 1
            goals.since = entry.time
            return
        if entry.kind in _GOING_ON or goals.since is None:
            return
        goals.succeeded += entry.kind == EventKind.RESPONSE.value
        goals.failed += entry.kind == EventKind.ERROR.value
        goals.cancelled += entry.kind == EventKind.CANCELLED.value
        goals.longest = max(goals.longest, entry.time - goals.since)
        goals.since = None


def _verdicts(entry: Entry) -> Iterator[tuple[Sort, list[str], tuple[str, ...]]]:
    for sort, reasons in verdicts(entry.outcome, entry.detail, entry.blocked_by):
        about = () if sort == DEPARTURE else tuple(reason["text"] for reason in reasons)
        yield sort, list(map(reason_text, reasons)), about
