"""What recorded runs show of each requirement: where it stopped a command, and was violated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from pathlib import Path

from robosc.lazy_dataclasses import dataclass
from robosc.progress import Progress
from robosc.runtime.core import model, reasons
from robosc.simulate.bags.judgement import judge
from robosc.simulate.bags.judgement_report import judgement_notes, said_at
from robosc.simulate.event_log import LogEntry
from robosc.simulate.replay import Follower, fits, replay
from robosc.simulate.values.shortened_values import UnknownValue
from robosc.supervisor import Supervisor


@dataclass
class RequirementRecord:
    """A requirement in recorded runs: how often it began to hold a command back that the components
    would have taken (None: the runs do not show that), when first and by which values; and where it
    was violated."""

    stopped: int | None = None
    first: dict[str, object] | None = None
    violations: list[dict[str, object]] = field(default_factory=list)


@dataclass(frozen=True)
class RecordedRun:
    """A log or a bag: what it is called, how many events were judged, and what was found that is
    about no single requirement; ``exit_code`` is that of ``robosc replay``."""

    path: str
    events: int
    found: tuple[str, ...]
    exit_code: int


@dataclass(frozen=True)
class RecordedRuns:
    """All runs, and what they show of the requirements, by the texts of these."""

    runs: tuple[RecordedRun, ...]
    shown: dict[str, RequirementRecord]

    @property
    def exit_code(self) -> int:
        """1: one shows a fault; 2: one could not be judged as a whole."""
        codes = {run.exit_code for run in self.runs}
        return 1 if 1 in codes else max(codes, default=0)


def recorded_runs(
    supervisor: Supervisor,
    logs: Iterable[Path],
    bags: Iterable[tuple[Path, Supervisor]],
    progress: Progress,
) -> RecordedRuns:
    """Follow logs, and judge bags, each by its supervisor: one for commands of any controller.

    Raises:
        UsageError: one cannot be read, or has nothing of this robot.
        ModelError: commands of one topic cannot be told apart by their data.
    """
    requirements = supervisor.plant.robot.requirements
    shown = {r.text: RequirementRecord() for r in requirements if not r.implied}
    runs = [_follow(supervisor, str(log), shown) for log in logs]
    runs += [_judge(judging, bag, shown, progress) for bag, judging in bags]
    return RecordedRuns(tuple(runs), shown)


def _follow(supervisor: Supervisor, log: str, shown: dict[str, RequirementRecord]) -> RecordedRun:
    before: set[tuple[str, str]] = set()
    unknown = 0

    def look(follower: Follower, entry: LogEntry) -> None:
        nonlocal before, unknown
        controller = follower.controller
        for text in () if controller is None else _shown_by_state(controller):
            if text in shown:
                shown[text].stopped = shown[text].stopped or 0
        try:
            now = {} if controller is None else dict(_held_back(controller))
        except UnknownValue:
            unknown += 1
            return
        for (text, command), because in now.items():
            if text in shown and (text, command) not in before:
                _stopped(shown[text], entry, command, because)
        before = set(now)

    replayed = replay(supervisor, log, look)
    found = list(replayed.missing)
    if unknown:
        found.append(f"after {unknown} events it is not known what was held back: values are cut")
    for departure in replayed.departures:
        place = f"{departure.file}:{departure.line}: {departure.event}"
        about = [text for text in departure.requirements if text in shown]
        for text in about:
            shown[text].violations.append({"run": log, "place": place, "told": departure.reason})
        if not about:
            found.append(f"{place}: {departure.reason}")
    return RecordedRun(log, replayed.events, tuple(found), replayed.exit_code)


def _shown_by_state(controller: model.Controller) -> Iterator[str]:
    """The requirements of which a state alone tells whether they hold commands back."""
    for command in controller.COMMANDS:
        if command.kind == "request" and command.read is None:
            yield from (controller.REQUIREMENTS[i].text for i in command.requirements)


def _held_back(controller: model.Controller) -> Iterator[tuple[tuple[str, str], list[str]]]:
    """Requirements by which commands that the components would take are not allowed now."""
    for command in controller.COMMANDS:
        if command.kind == "request" and command.read is None and fits(controller, command):
            for reason in reasons.violated(controller, command):
                yield (reason["text"], command.key), reason.get("because", [])


def _stopped(record: RequirementRecord, entry: LogEntry, command: str, because: list[str]) -> None:
    record.stopped = (record.stopped or 0) + 1
    if record.first is None:
        record.first = {
            "run": entry.file,
            "time": entry.document.get("time"),
            "command": command,
            "values": because,
        }


def _judge(
    supervisor: Supervisor, bag: Path, shown: dict[str, RequirementRecord], progress: Progress
) -> RecordedRun:
    judgement = judge(supervisor, bag, (), progress)
    found = list(judgement_notes(judgement))
    for finding in judgement.findings:
        told = said_at(judgement, finding)
        about = [text for text in finding.about if text in shown]
        if finding.sort != "violation" or not about:
            found.append(told)
            continue
        place = f"{finding.time - judgement.start:.3f} s"
        for text in about:
            shown[text].violations.append(
                {"run": str(bag), "place": place, "told": told, "count": finding.count}
            )
    return RecordedRun(str(bag), judgement.events, tuple(found), judgement.exit_code)
