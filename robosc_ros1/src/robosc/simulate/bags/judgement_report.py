"""A judgement as text, as JSON and as JUnit XML."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from robosc.errors import counted
from robosc.language.events import EventKind
from robosc.model.entities import Requirement
from robosc.runtime.judge.findings import Sort
from robosc.simulate.bags.judgement import Finding, Goals, Judgement
from robosc.simulate.script.junit import Outcome, suite_text

_TITLES: dict[Sort, str] = {
    "violation": "violated",
    "blocked": "a supervisor would have blocked",
    "corrected": "a supervisor would have corrected",
    "departure": "leaves the model",
}
_DONE = {"request": "was sent", "cancel": "was cancelled"}


def judgement_text(judgement: Judgement) -> str:
    """What ``robosc replay`` prints for a bag."""
    seconds = judgement.end - judgement.start
    lines = [
        f"{judgement.bag}: ROS {judgement.ros}, {seconds:.1f} s,"
        f" {counted(judgement.messages, 'message')},"
        f" {sum(t.count for t in judgement.tracks.values()):,} of them of {judgement.robot.name}"
    ]
    lines += [_line(judgement, finding) for finding in judgement.findings]
    lines += _tables(judgement)
    lines += judgement_notes(judgement)
    lines.append(f"{judgement.robot.name}: {_verdict(judgement)}")
    return "\n".join(lines) + "\n"


def _line(judgement: Judgement, finding: Finding) -> str:
    seconds = finding.time - judgement.start
    return f"{seconds:10.3f} s  {_TITLES[finding.sort]}: {_said(judgement, finding)}"


def _said(judgement: Judgement, finding: Finding) -> str:
    times = ""
    if finding.count > 1:
        times = f" {finding.count} times until {finding.until - judgement.start:.3f} s"
    reasons = "; ".join(finding.reasons)
    if finding.kind == "state":
        return f"{reasons}{times}"
    name = finding.name or "a message"
    what = f"{name} {_DONE[finding.kind]}" if finding.kind in _DONE else finding.event
    return f"{what}{times}: {reasons}"


def _tables(judgement: Judgement) -> Iterator[str]:
    for topic, track in judgement.tracks.items():
        if not track.count:
            continue
        span = track.last - track.first
        rate = f", {(track.count - 1) / span:.3g} Hz" if span > 0 else ""
        silence = f", longest silence {track.longest:.3f} s" if track.count > 1 else ""
        age = "" if track.age is None else f", oldest by its stamp {track.age:.3f} s"
        yield f"  {topic}: {counted(track.count, 'message')}{rate}{silence}{age}"
    for name, count in judgement.silences.items():
        yield f"  {name}: fell silent {counted(count, 'time')}"
    for name, goals in judgement.goals.items():
        yield f"  {name}: {_goals(goals)}"


def _goals(goals: Goals) -> str:
    ends = [
        f"{number} {word}"
        for number, word in (
            (goals.succeeded, "succeeded"),
            (goals.failed, "failed"),
            (goals.cancelled, "cancelled"),
            (int(goals.since is not None), "still going on"),
        )
        if number
    ]
    return f"{counted(goals.count, 'goal')}: {', '.join(ends)}; the longest {goals.longest:.3f} s"


def judgement_notes(judgement: Judgement) -> Iterator[str]:
    """Yield what of a recording was not judged, and other remarks."""
    yield from judgement.missing
    yield from judgement.notes
    if judgement.absent:
        yield f"not in the bag: {', '.join(judgement.absent)}"
    if judgement.unseen:
        yield f"not followed, since the bag does not show it: {', '.join(judgement.unseen)}"
    if judgement.unjudged:
        names = ", ".join(_event(name, kind) for name, kind in judgement.unjudged)
        yield f"not judged, since it depends on that: {names}"
    if judgement.unjudged_states:
        told = "; ".join(judgement.unjudged_states)
        yield f"not judged, since the whole state is not known: {told}"


def _event(name: str, kind: str) -> str:
    return name if kind == "request" else f"{name}.{kind}"


def _verdict(judgement: Judgement) -> str:
    events = counted(judgement.events, "event")
    kinds: tuple[tuple[Sort, str, str], ...] = (
        ("violation", "violation", ""),
        ("blocked", "command", " blocked beyond the requirements"),
        ("corrected", "command", " to correct"),
        ("departure", "place", " outside the model"),
    )
    said = [
        f"{counted(number, noun)}{what}"
        for sort, noun, what in kinds
        if (number := len(judgement.of(sort)))
    ]
    follows = "follows the model" + (
        " as far as the recording could be read" if judgement.missing else ""
    )
    return f"{events}: {', '.join(said) if said else follows}"


def judgement_document(judgement: Judgement) -> dict[str, Any]:
    """``replay --json`` for a bag, version 1."""
    return {
        "version": 1,
        "robot": judgement.robot.name,
        "bag": judgement.bag,
        "ros": judgement.ros,
        "start": round(judgement.start, 6),
        "seconds": round(judgement.end - judgement.start, 6),
        "messages": judgement.messages,
        "events": judgement.events,
        "commands": judgement.commands,
        "crossed": judgement.crossed,
        "reordered": judgement.reordered,
        "findings": [
            {
                "sort": f.sort,
                "time": round(f.time - judgement.start, 6),
                "until": round(f.until - judgement.start, 6),
                "count": f.count,
                "event": {"kind": f.kind, "name": f.name},
                "reasons": f.reasons,
            }
            for f in judgement.findings
        ],
        "topics": [
            {
                "topic": topic,
                "messages": t.count,
                "longest_silence": round(t.longest, 6),
                "oldest": None if t.age is None else round(t.age, 6),
            }
            for topic, t in judgement.tracks.items()
        ],
        "silences": judgement.silences,
        "actions": [
            {
                "name": name,
                "goals": g.count,
                "succeeded": g.succeeded,
                "failed": g.failed,
                "cancelled": g.cancelled,
                "longest": round(g.longest, 6),
            }
            for name, g in judgement.goals.items()
        ],
        "notes": list(judgement.notes),
        "missing": list(judgement.missing),
        "absent": list(judgement.absent),
        "not_followed": list(judgement.unseen),
        "not_judged": [
            *({"kind": kind, "name": name} for name, kind in judgement.unjudged),
            *({"kind": "state", "name": text} for text in judgement.unjudged_states),
        ],
    }


def judgement_junit(judgement: Judgement) -> str:
    """A test case for each requirement, for synthesis, for corrections, and for the model. What was
    not judged as a whole, and is not contradicted, is skipped, with the reason."""
    robot = judgement.robot
    not_judged = "; ".join(_not_judged(judgement))
    outcomes = [
        Outcome(
            requirement.text,
            [
                said_at(judgement, f)
                for f in judgement.of("violation")
                if requirement.text in f.about
            ],
            str(requirement.span.source.path),
            requirement.span.line,
            _unjudged(judgement, requirement),
        )
        for requirement in robot.requirements
    ]
    outcomes.append(
        Outcome(
            "what synthesis forbids",
            [said_at(judgement, f) for f in judgement.of("blocked")],
            unjudged=not_judged,
        )
    )
    if robot.corrected:
        corrected = [said_at(judgement, f) for f in judgement.of("corrected")]
        outcomes.append(Outcome("what a supervisor corrects", corrected, unjudged=not_judged))
    outcomes.append(
        Outcome(
            "the run follows the model",
            [said_at(judgement, f) for f in judgement.of("departure")],
            unjudged=_not_followed(judgement),
        )
    )
    outcomes.append(Outcome("the recording could be read as a whole", judgement.missing))
    return suite_text(judgement.bag, robot.name, outcomes)


def _unjudged(judgement: Judgement, requirement: Requirement) -> str:
    """Why it is not known of a requirement whether it was kept; empty: it is known."""
    if requirement.communications:
        return "; ".join(_not_judged(judgement, requirement))
    return "" if judgement.judges_states else _not_followed(judgement)


def _not_judged(judgement: Judgement, requirement: Requirement | None = None) -> Iterator[str]:
    """Yield why commands were not judged, all or those of a requirement."""
    unjudged, unsent = list(judgement.unjudged), list(judgement.unsent)
    if requirement is not None:
        names = {judgement.robot.display_names[key] for key in requirement.communications}
        unsent = [name for name in unsent if name in names]
        unjudged = [
            (n, k) for n, k in unjudged if n in names and requirement.concerns(EventKind(k))
        ]
    if unjudged:
        told = ", ".join(_event(name, kind) for name, kind in unjudged)
        yield f"not judged: {told}, since {_not_followed(judgement)}"
    if unsent:
        yield f"not in the recording: {', '.join(unsent)}"


def _not_followed(judgement: Judgement) -> str:
    """What is not followed, since the bag does not show it; empty: all is."""
    if not judgement.unseen:
        return ""
    return f"the bag does not show {', '.join(judgement.unseen)}"


def said_at(judgement: Judgement, finding: Finding) -> str:
    """Return a finding on one line, with its time in the recording."""
    return f"{finding.time - judgement.start:.3f} s: {_said(judgement, finding)}"
