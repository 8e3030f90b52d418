"""The document of ``robosc report``: what is known of each requirement, and on what it rests."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import date, datetime, timezone
from hashlib import sha256
from pathlib import Path
from typing import Any

from robosc.emit.package.rendering import instantiated
from robosc.errors import Diagnostic, UsageError, counted
from robosc.evidence.runs import RecordedRun, RecordedRuns, RequirementRecord
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Assumption, Goal, Requirement, Robot
from robosc.plant.model_text import to_dsl
from robosc.supervisor import Supervisor
from robosc.synthesis.documents import step_document
from robosc.synthesis.formatting import event_text
from robosc.synthesis.verify.verify_report import VerifyReport, possible_check, verify_document
from robosc.traces.scripts import RequirementRow, Shown

# ``robosc report``: the evidence as HTML, Markdown or JSON.


FORMATS = (".html", ".md", ".json")
_TEMPLATES = {".html": "evidence/report.html.jinja", ".md": "evidence/report.md.jinja"}


@dataclass(frozen=True)
class _View:
    """What the templates see."""

    e: Mapping[str, Any]
    first_held: Callable[[Mapping[str, Any]], str]


def _first_held(requirement: Mapping[str, Any]) -> str:
    """How often a requirement held a command back, and where first."""
    first = requirement["first"]
    at = "" if first["time"] is None else f" at {_moment(first['time'])}"
    values = f": {', '.join(first['values'])}" if first["values"] else ""
    times = counted(requirement["stopped"], "time")
    return f"{times} in the logs, first {first['command']}{at} in {first['run']}{values}"


def _moment(seconds: float) -> str:
    """A time of a log: a date of 1973 to 9999, or seconds of a clock that is simulated."""
    if not 1e8 < seconds <= 253_402_300_799:
        return f"{seconds:.3f} s"
    return f"{datetime.fromtimestamp(seconds, timezone.utc):%Y-%m-%d %H:%M:%S} UTC"


def format_of(suffix: str) -> str:
    """One of :data:`FORMATS`; Markdown without a suffix.

    Raises:
        UsageError: it is another one.
    """
    if suffix and suffix not in FORMATS:
        raise UsageError(f"a report is .html, .md or .json, not {suffix}")
    return suffix or ".md"


def rendered(document: Mapping[str, Any], suffix: str) -> str:
    """The document in a format."""
    if suffix == ".json":
        return json.dumps(document, indent=2, ensure_ascii=False) + "\n"
    return instantiated(_TEMPLATES[suffix], _View(document, _first_held))


Document = dict[str, Any]

STATEMENT = (
    "This is evidence that tools computed. It is no certification, and no claim of conformity with"
    " any standard: whether the model is that of the robot, and whether the requirements are those"
    " that it needs, people have to judge."
)
PROVIDED = (
    "The robot's components do what their behaviours in the model say: what they send comes where"
    " the behaviour has a transition for it, with values of the stated types.",
    "The node is the one that robosc generated from this model, unchanged, and it runs.",
    "What ROS delivers late, twice or not at all is covered as far as the model has timeouts and"
    " ages for it.",
)
"""What everything here rests on, beside the assumptions of the model."""


def evidence(
    supervisor: Supervisor,
    verified: VerifyReport,
    runs: RecordedRuns,
    tests: Iterable[RequirementRow],
    warnings: Iterable[Diagnostic],
    version: str,
) -> Document:
    """The document, version 1; equal inputs give equal documents but for the date.

    ``tests`` is what the scripts of the package's own test show.
    """
    tested: dict[str, list[tuple[Shown, Shown]]] = {}
    for text, _, met, violated in tests:
        tested.setdefault(text, []).append((met, violated))
    robot = supervisor.plant.robot
    safe = any(check.name == "safe" and check.holds for check in verified.checks)
    files = [{"file": Path(s.path).name, "sha256": s.sha256} for s in robot.sources]
    whole = sha256("".join(f["sha256"] for f in files).encode()).hexdigest()
    return {
        "version": 1,
        "statement": STATEMENT,
        "robot": robot.name,
        "date": date.today().isoformat(),
        "model": {"sha256": whole, "files": files},
        "tools": {
            "robosc": version,
            "python": platform.python_version(),
            "engine": supervisor.engine,
        },
        "states": {
            "plant": supervisor.plant_states,
            "under_control": supervisor.controlled_states,
            "transitions": supervisor.controlled_transitions,
        },
        "provided": [*PROVIDED],
        "assumptions": [_cited(assumption) for assumption in robot.assumptions],
        "warnings": [
            {"code": d.code, "message": d.message, "place": d.span.place} for d in warnings
        ],
        "requirements": [
            *(
                {
                    **_requirement(supervisor, safe, several, runs.shown[text]),
                    "tested": _tested(tested.get(text, [])),
                }
                for text, several in _by_text(robot).items()
            ),
            *(_goal(goal, verified) for goal in robot.goals),
        ],
        "verification": verify_document(verified, step_document),
        "runs": [_run(run) for run in runs.runs],
    }


def _cited(one: Requirement | Goal | Assumption) -> Document:
    return {"id": one.id, "text": one.text, "place": one.span.place}


def _by_text(robot: Robot) -> dict[str, list[int]]:
    """The numbers of the requirements that are cited as one: a statement about several commands, or
    in a component that is imported several times."""
    found: dict[str, list[int]] = {}
    for number, requirement in enumerate(robot.requirements):
        if not requirement.implied:
            found.setdefault(requirement.text, []).append(number)
    return found


def _requirement(
    supervisor: Supervisor, safe: bool, numbers: Sequence[int], shown: RequirementRecord
) -> Document:
    robot = supervisor.plant.robot
    some = set(numbers)
    guards = [guard for guard in supervisor.guards if some & set(guard.event.requirements)]
    events = {id(guard.event) for guard in guards}
    return {
        **_cited(robot.requirements[numbers[0]]),
        "commands": [
            {
                "command": event_text(guard.event),
                "allowed_where": to_dsl(guard.expr, robot),
                "status": guard.status,
            }
            for guard in guards
        ],
        "added": [
            {"command": event_text(found.event), "reason": found.reason, "remedy": found.remedy}
            for found in supervisor.explanations
            if found.event is not None and id(found.event) in events
        ],
        "proved": "safe" if safe else None,
        "stopped": shown.stopped,
        "first": shown.first,
        "violations": shown.violations,
    }


def _tested(rows: Sequence[tuple[Shown, Shown]]) -> Document | None:
    """The scripts of the package's test in which it is met and violated, or why there are none."""
    if not rows:
        return None
    sides = zip(("met", "violated"), zip(*rows, strict=True), strict=True)
    return {side: _shown(several) for side, several in sides}


def _shown(several: Sequence[Shown]) -> Document:
    runs = sorted({run for found, _ in several for run in found})
    return {"runs": runs, "why_not": None if runs else several[0][1]}


def _goal(goal: Goal, verified: VerifyReport) -> Document:
    name = possible_check(goal.text)
    proved = any(check.name == name and check.holds for check in verified.checks)
    return {
        **_cited(goal),
        "commands": [],
        "added": [],
        "proved": name if proved else None,
        "tested": None,
        "stopped": None,
        "first": None,
        "violations": [],
    }


def _run(run: RecordedRun) -> Document:
    return {
        "path": run.path,
        "events": run.events,
        "found": [*run.found],
        "faulty": run.exit_code == 1,
        "complete": run.exit_code != 2,
    }
