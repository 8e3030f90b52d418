"""The results of verification, and their JSON document."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Literal

from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event
from robosc.supervisor import Step
from robosc.synthesis.formatting import event_text

SHARED: Final = (
    "the plant",
    "the values of operators",
    "which values of an event occur together",
    "which variables an expression reads",
)
SHARED_BY_SETS: Final = ("the library for decision diagrams", "the order of the variables")


MISSING = "it cannot be reached any more"
"""Of what must remain possible."""


def possible_check(text: str) -> str:
    """Return the name of the check of what must remain possible, by the text of that."""
    return f"always possible ({text})"


@dataclass(frozen=True, slots=True)
class Check:
    """The result for one property: ``detail`` says what fails, ``trace`` leads to it."""

    name: str
    holds: bool
    detail: str | None = None
    trace: tuple[Step, ...] = ()


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """The results of a verification; ``states`` and ``transitions`` are those under the guards.

    ``properties`` are the controller properties as synthesis found them, by name; one that fails is
    a warning and does not make the supervisor wrong. If the guards are not safe, there are no
    further checks.
    """

    robot: str
    checks: tuple[Check, ...]
    states: int
    transitions: int
    properties: tuple[tuple[str, bool], ...] = ()
    method: Literal["explicit", "symbolic"] = "explicit"

    @property
    def shared(self) -> tuple[str, ...]:
        """What verification shares with synthesis: a fault in it may be found by neither."""
        return SHARED if self.method == "explicit" else SHARED + SHARED_BY_SETS

    @property
    def verified(self) -> bool:
        return all(check.holds for check in self.checks)


@dataclass(frozen=True, slots=True)
class Findings:
    """What a search found under the guards of a supervisor.

    ``keeps_initial`` says whether the initial states are in the supremal safe, controllable and
    nonblocking set. ``nonblocking``, ``possible`` (what must
    remain so), ``permissive``, ``states`` and ``transitions`` count only if
    ``safe`` holds: no step is followed from an unsafe state. ``plant_states`` is how many states
    the plant reaches; None if that is unknown.
    """

    method: Literal["explicit", "symbolic"]
    keeps_initial: bool
    safe: Check
    nonblocking: Check
    possible: tuple[Check, ...]
    permissive: Check
    states: int
    transitions: int
    plant_states: int | None


def verify_document(report: VerifyReport, event: Callable[[Step], object]) -> dict[str, object]:
    """Return the document of ``verify --json``, version 1; ``event`` returns that of a step."""
    return {
        "version": 1,
        "robot": report.robot,
        "verified": report.verified,
        "method": report.method,
        "shared": [*report.shared],
        "states": report.states,
        "transitions": report.transitions,
        "properties": dict(report.properties),
        "checks": [
            {
                "name": check.name,
                "holds": check.holds,
                "detail": check.detail,
                "trace": [event(step) for step in check.trace],
            }
            for check in report.checks
        ],
    }


def event_phrase(event: Event) -> str:
    """Return ``request of grab``; for a tau ``Motor: idle->busy``."""
    return event_text(event) if event.kind.of_component else f"{event.kind.word} of {event.name}"
