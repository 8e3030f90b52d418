"""What recorded runs show of each requirement: where it stopped a command, and was violated."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from robosc.progress import Progress
from robosc.runtime.model import Command, Controller
from robosc.runtime.reasons import violated
from robosc.simulate.bags.judgement import judge
from robosc.simulate.event_log import LogEntry, read_log
from robosc.simulate.replay import Follower
from robosc.supervisor import Supervisor


@dataclass
class RequirementRecord:
    """A requirement in recorded runs: how often it began to hold a command back that the components
    would have taken, when first and by which values; and where it was violated."""

    stopped: int = 0
    first: dict[str, object] | None = None
    violations: list[dict[str, object]] = field(default_factory=list)


@dataclass(frozen=True)
class RecordedRun:
    """A log or a bag: what it is called, how many events were judged, and what was found that is
    about no single requirement; ``faulty`` if it shows a violation or leaves the model."""

    path: str
    events: int
    found: tuple[str, ...]
    faulty: bool


@dataclass(frozen=True)
class RecordedRuns:
    """All runs, and what they show of the requirements, by the texts of these."""

    runs: tuple[RecordedRun, ...]
    shown: dict[str, RequirementRecord]

    @property
    def faulty(self) -> bool:
        return any(run.faulty for run in self.runs)


def recorded_runs(
    supervisor: Supervisor, logs: Iterable[Path], bags: Iterable[Path], progress: Progress
) -> RecordedRuns:
    """Follow logs, and judge bags.

    Raises:
        UsageError: one cannot be read, or has nothing of this robot.
        ModelError: commands of one topic cannot be told apart by their data.
    """
    shown = {
        requirement.text: RequirementRecord() for requirement in supervisor.plant.robot.requirements
    }
    runs = [_follow(supervisor, str(log), shown) for log in logs]
    runs += [_judge(supervisor, bag, shown, progress) for bag in bags]
    return RecordedRuns(tuple(runs), shown)


def _follow(supervisor: Supervisor, log: str, shown: dict[str, RequirementRecord]) -> RecordedRun:
    follower = Follower(supervisor)
    before: set[tuple[str, str]] = set()
    for entry in read_log(log):
        follower.take(entry)
        controller = follower.controller
        if controller is None:
            before = set()
            continue
        now = dict(_held_back(controller))
        for (text, command), because in now.items():
            if (text, command) not in before:
                _stopped(shown[text], entry, command, because)
        before = set(now)
    found = list(follower.missing)
    for departure in follower.departures:
        place = f"{departure.file}:{departure.line}: {departure.event}"
        about = [text for text in shown if text in departure.reason]
        for text in about:
            shown[text].violations.append({"run": log, "place": place, "told": departure.reason})
        if not about:
            found.append(f"{place}: {departure.reason}")
    return RecordedRun(log, follower.followed, tuple(found), bool(follower.departures))


def _held_back(controller: Controller) -> Iterable[tuple[tuple[str, str], list[str]]]:
    """Requirements by which commands that the components would take are not allowed now."""
    for command in controller.COMMANDS:
        if command.kind == "request" and _could_be(controller, command):
            for reason in violated(controller, command):
                yield (reason["text"], command.key), reason.get("because", [])


def _could_be(controller: Controller, command: Command) -> bool:
    if command.read is not None or not command.possible(vars(controller)):
        return False
    return command.synchronisation is None or bool(command.synchronisation(controller))


def _stopped(shown: RequirementRecord, entry: LogEntry, command: str, because: list[str]) -> None:
    shown.stopped += 1
    if shown.first is None:
        shown.first = {
            "run": entry.file,
            "time": entry.document.get("time"),
            "command": command,
            "values": because,
        }


def _judge(
    supervisor: Supervisor, bag: Path, shown: dict[str, RequirementRecord], progress: Progress
) -> RecordedRun:
    judgement = judge(supervisor, bag, (), progress)
    found = list(judgement.missing)
    for finding in judgement.findings:
        seconds = finding.time - judgement.start
        told = f"{seconds:.3f} s: {finding.event}: {'; '.join(finding.reasons)}"
        about = [text for text in finding.about if text in shown]
        if finding.sort != "violation" or not about:
            found.append(told)
            continue
        for text in about:
            shown[text].violations.append(
                {"run": str(bag), "place": f"{seconds:.3f} s", "told": told, "count": finding.count}
            )
    return RecordedRun(str(bag), judgement.events, tuple(found), bool(judgement.findings))
