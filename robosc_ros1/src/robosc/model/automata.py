"""The automaton of a component: its variables, states and transitions, resolved and typed.

The span of an entity with a name is that of the name; of others, that of the whole text.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from robosc.expr.tree import Expr
from robosc.expr.types import Type, Value
from robosc.language.events import EventKind
from robosc.runtime.places import stands_in
from robosc.source import Span


def span_field() -> Span:
    """A field for the place in the text, which is not compared."""
    return field(compare=False, repr=False, kw_only=True)  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of a component.

    ``in_state`` is False if it is not part of the plant's state (docs/semantics.md, "Data").
    ``initial`` is None for an object or an array, which holds nothing at the start.
    """

    name: str
    component: str
    type: Type
    initial: Value | None
    in_state: bool
    span: Span = span_field()

    @property
    def key(self) -> str:
        return f"{self.component}.{self.name}"


@dataclass(frozen=True, slots=True)
class Assignment:
    """``variable := value``; the variable belongs to the component of the transition."""

    variable: str
    value: Expr
    span: Span = span_field()


@dataclass(frozen=True, slots=True)
class ResultTransition:
    """A transition on an event of a communication (its key).

    ``goto`` is the state in which it ends; None: it enters none. ``named`` is the path of the state
    with states in it that the model names instead.
    """

    event: EventKind
    communication: str
    guard: Expr | None
    assignments: tuple[Assignment, ...]
    goto: str | None
    named: str | None = None
    span: Span = span_field()

    def enters(self, place: str, source: State) -> bool:
        """Whether it enters the state of a path, taken in the state ``source``.

        It does if it ends in there, unless it comes from inside and names a state further inside.
        """
        entered = self.named or self.goto
        if entered is None or self.goto is None or not is_in(self.goto, place):
            return False
        return not source.is_in(place) or is_in(place, entered)


@dataclass(frozen=True, slots=True)
class Tau:
    """An internal transition (controllable); ``index`` counts those of the component from 1.

    The event of ``transition`` is ``tau``, and its communication the component's name.
    """

    index: int
    transition: ResultTransition


@dataclass(frozen=True, slots=True)
class After:
    """A transition that is taken ``delay`` seconds after its component entered its state.

    ``index`` counts those of the component from 1 in source order. The event of ``transition`` is
    ``after``, and its communication the component's name.
    """

    index: int
    delay: Expr
    transition: ResultTransition


@dataclass(frozen=True, slots=True)
class CompositeState:
    """A state with states in it, with the transitions that leave any of those.

    ``name`` is its path, ``docking.near`` for the state ``near`` of ``docking``. ``performs`` is
    the key of the command that it performs; the states in it are then its stages.
    """

    name: str
    transitions: tuple[ResultTransition, ...]
    taus: tuple[Tau, ...]
    afters: tuple[After, ...] = ()
    performs: str | None = None
    span: Span = span_field()


@dataclass(frozen=True, slots=True)
class State:
    """A location of a component's automaton, with the transitions that leave it.

    ``name`` is its path. ``around`` are the states in which it stands, the innermost first.
    """

    name: str
    initial: bool
    marked: bool
    transitions: tuple[ResultTransition, ...]
    taus: tuple[Tau, ...]
    afters: tuple[After, ...] = ()
    around: tuple[CompositeState, ...] = ()
    span: Span = span_field()

    def is_in(self, place: str | None) -> bool:
        """Whether it is the state of a path or stands in it; None stands for every state."""
        return place is None or is_in(self.name, place)


def is_in(path: str, place: str) -> bool:
    """Whether a path is that of a place, of a stage of it, or of a state in it."""
    return stands_in(path, place)


@dataclass(frozen=True, slots=True)
class Behaviour:
    """The automaton of a component; its own ``transitions`` and ``taus`` exist in every state."""

    variables: tuple[Variable, ...]
    states: tuple[State, ...]
    transitions: tuple[ResultTransition, ...]
    taus: tuple[Tau, ...]
    composites: tuple[CompositeState, ...] = ()
    span: Span = span_field()

    def levels(self, state: State) -> tuple[tuple[ResultTransition, ...], ...]:
        """The transitions that apply in a state, level by level: its own first."""
        around = (outer.transitions for outer in state.around)
        return state.transitions, *around, self.transitions

    @property
    def places(self) -> tuple[CompositeState | State, ...]:
        """The states with states in them, and the others."""
        return *self.composites, *self.states

    @property
    def inside(self) -> dict[str, tuple[str, ...]]:
        """The states in those that have several or perform an action, by name, the most first."""
        found = {
            outer.name: tuple(state.name for state in self.states if state.is_in(outer.name))
            for outer in self.composites
        }
        named = (o.name for o in self.composites if o.performs or len(found[o.name]) > 1)
        return {name: found[name] for name in sorted(named, key=lambda name: -len(found[name]))}

    @property
    def all_transitions(self) -> Iterator[ResultTransition]:
        """Those of every state, of states with states in them, then state by state."""
        yield from self.transitions
        yield from (tau.transition for tau in self.taus)
        for place in self.places:
            yield from place.transitions
            yield from (tau.transition for tau in place.taus)
            yield from (after.transition for after in place.afters)

    @property
    def staying(self) -> Iterator[ResultTransition]:
        """The internal transitions that may lead to the state that they leave."""
        yield from (tau.transition for tau in self.taus)
        for place in self.places:
            for taken in (tau.transition for tau in place.taus):
                if is_in(taken.goto or place.name, place.name):
                    yield taken


@dataclass(frozen=True, slots=True)
class Lasting:
    """A named condition that holds where ``condition`` has held for ``delay`` without a break.

    ``name`` is that of a component without a text in the model, which is in the state
    :data:`HOLDING` where it holds, else in :data:`RESTING`.
    """

    name: str
    condition: Expr
    delay: Expr
    span: Span = span_field()


RESTING, HOLDING = "waiting", "holding"
