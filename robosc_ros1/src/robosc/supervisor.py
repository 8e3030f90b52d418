"""The result of synthesis: one guard per controllable event, sizes, and reasons."""

from __future__ import annotations

from functools import cached_property
from typing import Literal, TypeAlias

from robosc import errors, source
from robosc.expr import tree, types
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event, Plant
from robosc.plant.part_names import PartNames

Status: TypeAlias = Literal["as required", "restricted", "never"]


@dataclass(frozen=True, slots=True)
class Step:
    """One event of a trace with its parameter values, in the order of ``event.parameters``.

    For a tau ``values`` is one string, ``"from->to"``.
    """

    event: Event
    values: tuple[types.Value | None, ...] = ()


@dataclass(frozen=True, slots=True)
class Guard:
    """When a controllable event is allowed.

    In every state of the controlled system in which the plant can do the event, it is enabled
    exactly where ``expr`` holds; elsewhere ``expr`` means nothing (that freedom keeps it short).
    ``required`` is what the requirements alone say (TRUE without any).
    """

    event: Event
    expr: tree.Expr
    required: tree.Expr
    status: Status


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why synthesis forbids more than the requirements do; ``event`` None: the supervisor is empty.

    ``trace`` leads from the initial state to the one that must be avoided; ``reason`` and
    ``remedy`` are sentences; ``diagnostic`` is the same as a warning at its place in the model.
    ``traced`` False: looking for a trace would take too long, so it is empty, and the reason says
    so. ``told`` False: the diagnostic of another copy's command says the same. ``conflict`` are the
    texts and places of requirements that suffice for it, and of what the robot may do, of which
    none can be left out; None: they were not looked for.
    """

    event: Event | None
    reason: str
    trace: tuple[Step, ...]
    remedy: str | None
    diagnostic: errors.Diagnostic
    traced: bool = True
    told: bool = True
    conflict: tuple[tuple[str, source.Span], ...] | None = None


@dataclass(frozen=True)
class Supervisor:
    """The maximally permissive, safe, controllable and nonblocking restriction of a plant.

    Counts are of reachable states: ``plant_states`` without requirements, ``controlled_states`` and
    ``controlled_transitions`` (state-event-value triples, self-loops included) under control.
    ``properties`` are the controller properties by name; ``seconds`` is the synthesis alone.
    ``empty``: not even the initial state can be kept; then all guards are FALSE and counts 0.
    ``step_bound`` is how many internal transitions can follow one event at the most;
    None if that is unknown or without end. ``opposite_order`` is whether the symbolic engine had to
    turn the order of its variables round, so that another symbolic search need not try the first.
    """

    plant: Plant
    engine: str
    seconds: float
    plant_states: int
    controlled_states: int
    controlled_transitions: int
    guards: tuple[Guard, ...]
    explanations: tuple[Explanation, ...]
    properties: tuple[tuple[str, bool], ...]
    diagnostics: tuple[errors.Diagnostic, ...] = ()
    empty: bool = False
    step_bound: int | None = None
    opposite_order: bool = False

    @cached_property
    def part_names(self) -> PartNames:
        """Names for what its long guards have in common."""
        return PartNames(self.plant.robot, [guard.expr for guard in self.guards])
