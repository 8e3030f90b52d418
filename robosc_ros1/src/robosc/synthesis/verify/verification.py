"""Independent verification of a supervisor: its guards checked against the plant.

The engines compute with arrays or decision diagrams over the whole product; here the states are
searched one by one, in plain Python (:mod:`robosc.synthesis.verify.explicit`), or by sets where
they are too many (:mod:`robosc.synthesis.verify.symbolic`). What an event does in a state is taken
from its definition, :func:`robosc.plant.step.outcome`, which the engines do not call: they compile
events into faster forms.

What verification and the engines share, so that a fault there may be found by neither: the plant
(:mod:`robosc.plant.automaton`) and how it is made from the model; of that definition, which values
of an event occur together (:func:`robosc.plant.step.missing_together`); the values of operators and
enum conversions (:mod:`robosc.expr.evaluation`); which state variables an expression reads
(:func:`robosc.plant.support.support`); and, of the symbolic engine, the BDD library with its
manager (:mod:`robosc.synthesis.bdd.manager`), and the order of its variables
(:mod:`robosc.synthesis.bdd.order`), which no result depends on. They share no search, no fixpoint,
no representation of states and no transition relation.

Verification proves that under the guards of a :class:`~robosc.supervisor.Supervisor` the system is

- *safe*: no requirement is violated, no state requirement fails, no range is left;
- *controllable*: no uncontrollable event is forbidden, or leads to an unsafe state;
- *nonblocking*: from each reachable state a marked one is reachable;
- *maximally permissive*: each step that a guard forbids and the requirements allow leads to a state
  outside the supremal safe, controllable and nonblocking set;

and that the *counts* of the supervisor are those of the search.

The supremal controllable and nonblocking behaviour is that of Ramadge & Wonham, "Supervisory
control of a class of discrete event processes", SIAM J. Control Optim. 25(1), 1987.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Final

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.progress import Progress
from robosc.supervisor import Supervisor
from robosc.synthesis.bdd.manager import usable
from robosc.synthesis.time_limit import processor_time
from robosc.synthesis.verify.explicit import ExplicitVerifier
from robosc.synthesis.verify.verify_report import Check, Findings, VerifyReport, event_phrase

_MANY_STEPS: Final = 1 << 22  # above, symbolic search is faster, as measured
_FEW_STATES: Final = 1 << 13
"""States of a plant up to which they are searched one by one, a tenth of a second, although
synthesis took sets of them. Above, that takes up to 200 times as long: subsystems 8."""
_FEW_STEPS: Final = 1 << 18
"""Up to which a system is searched one by one, however many states its plant has. Twice as many
states are looked at, since those that violate a requirement are, too: nine of ten in zones 12 15.
"""
_FEW_NODES: Final = 1 << 17
"""Nodes, about a fifth of a second, with which sets are tried first where synthesis took them."""


def verify(
    supervisor: Supervisor,
    limit: int = limits.VERIFIED_STATES,
    progress: Progress | None = None,
    seconds: float = limits.VERIFIED_SECONDS,
) -> VerifyReport:
    """Return the results of checking a supervisor's properties by exhaustive search.

    With more than ``limit`` states or many transitions the search is symbolic if possible; failures
    then have no traces.

    Raises:
        StateSpaceError: the system is too large for that, too, or it takes more than ``seconds``
            of processor time.
    """
    with processor_time(seconds, progress, "verification stops after {:g} s") as limited:
        findings = _findings(supervisor, limit, limited)
    name, controllable = supervisor.plant.robot.name, _check_controllable(supervisor)
    if supervisor.empty:
        counts = _check_counts(supervisor, 0, 0, findings.plant_states)
        checks = (controllable, _check_empty(findings.keeps_initial), *counts)
        return VerifyReport(name, checks, 0, 0, method=findings.method)
    figures = findings.states, findings.transitions
    if not findings.safe.holds:
        return VerifyReport(name, (findings.safe, controllable), *figures, method=findings.method)
    counts = _check_counts(supervisor, *figures, findings.plant_states)
    reaching = findings.nonblocking, *findings.possible
    checks = (findings.safe, controllable, *reaching, findings.permissive, *counts)
    return VerifyReport(name, checks, *figures, supervisor.properties, findings.method)


def _findings(supervisor: Supervisor, limit: int, progress: Progress) -> Findings:
    one_by_one = supervisor.engine == "explicit"
    few = limit if one_by_one else min(limit, _FEW_STATES)
    large = supervisor.plant_states > few or supervisor.controlled_transitions > _MANY_STEPS
    if not large or not usable():
        return ExplicitVerifier(supervisor, limit).found()
    from robosc.synthesis.verify import symbolic  # imported on demand

    # What requirements hold together is sparse in its plant, which sets may not hold.
    sparse = one_by_one or supervisor.plant.invariants
    if sparse and supervisor.controlled_transitions <= _FEW_STEPS:
        if not one_by_one:
            with suppress(symbolic.ManyNodes):
                return symbolic.search_by_sets(supervisor, progress, _FEW_NODES)
        with suppress(StateSpaceError):
            found = ExplicitVerifier(supervisor, min(limit, 2 * _FEW_STEPS)).found()
            with suppress(StateSpaceError):
                found = replace(found, plant_states=symbolic.plant_states(supervisor, progress))
            return found
    return symbolic.search_by_sets(supervisor, progress)


def _check_controllable(supervisor: Supervisor) -> Check:
    """Check that each controllable event has a guard, and that no other event has one.

    That suffices: the searches follow every uncontrollable event.
    """
    guards = {guard.event.identity for guard in supervisor.guards}
    for event in supervisor.plant.events:
        if event.controllable and event.identity not in guards:
            return Check("controllable", False, f"the {event_phrase(event)} has no guard")
        if not event.controllable and event.identity in guards:
            return Check("controllable", False, f"the {event_phrase(event)} cannot be forbidden")
    return Check("controllable", True)


def _check_empty(keepable: bool) -> Check:
    detail = "the supervisor is empty although the initial states can be kept" if keepable else None
    return Check("maximally permissive", not keepable, detail)


def _check_counts(
    supervisor: Supervisor, states: int, transitions: int, plant_states: int | None
) -> Iterator[Check]:
    figures = [
        ("controlled states", supervisor.controlled_states, states),
        ("controlled transitions", supervisor.controlled_transitions, transitions),
    ]
    if plant_states is not None:
        figures.append(("plant states", supervisor.plant_states, plant_states))
    for name, claimed, counted in figures:
        agree = claimed == counted
        detail = None if agree else f"the supervisor has {claimed}, the search {counted}"
        yield Check(name, agree, detail)
