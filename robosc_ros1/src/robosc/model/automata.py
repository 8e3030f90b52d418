"""The automaton of a component: its variables, states and transitions, resolved and typed.

The span of an entity with a name is that of the name; of others, that of the whole text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field, replace

from robosc.expr import tree, types
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.runtime.core.places import stands_in
from robosc.source import Span


def span_field() -> Span:
    """A field for the place in the text, which is not compared."""
    return field(compare=False, repr=False, kw_only=True)  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of a component.

    ``in_state`` is False if it is not part of the plant's state (docs/semantics.md, "Data").
    ``initial`` is None for an object or an array, which holds nothing at the start. ``persistent``:
    the value outlasts the node, so that it may start with any.
    """

    name: str
    component: str
    type: types.Type
    initial: types.Value | None
    in_state: bool
    persistent: bool = False
    span: Span = span_field()

    @property
    def key(self) -> str:
        return f"{self.component}.{self.name}"

    @property
    def written(self) -> str:
        """The key as conditions have it: of the errors of a state in a row with a dot more."""
        return self.key.replace(" ", ".")


@dataclass(frozen=True, slots=True)
class Assignment:
    """``variable := value``; the variable belongs to the component of the transition."""

    variable: str
    value: tree.Expr
    span: Span = span_field()


@dataclass(frozen=True, slots=True)
class Transition:
    """A transition on an event of a communication (its key), an internal one, or one that is taken
    ``delay`` seconds after its component entered its state.

    ``goto`` is the state in which it ends; None: it enters none. ``named`` is the path of the state
    with states in it that the model names instead. The internal ones and the delayed ones have the
    name of their component as their communication; ``index`` counts either from 1 in source order.
    """

    event: EventKind
    communication: str
    guard: tree.Expr | None
    assignments: tuple[Assignment, ...]
    goto: str | None
    named: str | None = None
    index: int = 0
    delay: tree.Expr | None = None
    span: Span = span_field()

    @property
    def expressions(self) -> Iterator[tree.Expr]:
        """Its guard, if it has one, and what it assigns."""
        if self.guard is not None:
            yield self.guard
        yield from (assignment.value for assignment in self.assignments)

    def enters(self, place: str, source: State) -> bool:
        """Whether it enters the state of a path, taken in the state ``source``.

        It does if it ends in there, unless it comes from inside and names a state further inside.
        """
        entered = self.named or self.goto
        if entered is None or self.goto is None or not is_in(self.goto, place):
            return False
        return not source.is_in(place) or is_in(place, entered)


class _Place:
    """The kinds of transitions of a state, or of all states."""

    __slots__ = ()
    transitions: tuple[Transition, ...]

    @property
    def on_communications(self) -> tuple[Transition, ...]:
        return tuple(t for t in self.transitions if not t.event.of_component)

    @property
    def taus(self) -> tuple[Transition, ...]:
        """The internal transitions."""
        return tuple(t for t in self.transitions if t.event is EventKind.TAU)

    @property
    def afters(self) -> tuple[Transition, ...]:
        """The delayed transitions."""
        return tuple(t for t in self.transitions if t.event is EventKind.AFTER)


@dataclass(frozen=True, slots=True)
class CompositeState(_Place):
    """A state with states in it, with the transitions that leave any of those.

    ``name`` is its path, ``docking.near`` for the state ``near`` of ``docking``. ``performs`` is
    the key of the command that it performs; the states in it are then its stages. ``meanwhile``: it
    asks although other actions of its component are under way.
    """

    name: str
    transitions: tuple[Transition, ...]
    performs: str | None = None
    meanwhile: bool = False
    span: Span = span_field()


@dataclass(frozen=True, slots=True)
class State(_Place):
    """A location of a component's automaton, with the transitions that leave it.

    ``name`` is its path. ``around`` are the states in which it stands, the innermost first.
    """

    name: str
    initial: bool
    marked: bool
    transitions: tuple[Transition, ...]
    around: tuple[CompositeState, ...] = ()
    span: Span = span_field()

    def is_in(self, place: str | None) -> bool:
        """Whether it is the state of a path or stands in it; None stands for every state."""
        return place is None or is_in(self.name, place)


def is_in(path: str, place: str) -> bool:
    """Whether a path is that of a place, of a stage of it, or of a state in it."""
    return stands_in(path, place)


@dataclass(frozen=True, slots=True)
class Behaviour(_Place):
    """The automaton of a component; its own ``transitions`` exist in every state."""

    variables: tuple[Variable, ...] = ()
    states: tuple[State, ...] = ()
    transitions: tuple[Transition, ...] = ()
    composites: tuple[CompositeState, ...] = ()
    span: Span = span_field()

    def levels(self, state: State) -> tuple[tuple[Transition, ...], ...]:
        """The transitions on communications in a state, level by level: its own first."""
        return tuple(place.on_communications for place in (state, *state.around, self))

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
    def placed(self) -> Iterator[tuple[str | None, Transition]]:
        """The transitions with the state that they leave: those of every state (None), of states
        with states in them, then state by state."""
        yield from ((None, transition) for transition in self.transitions)
        for place in self.places:
            yield from ((place.name, transition) for transition in place.transitions)

    @property
    def all_transitions(self) -> Iterator[Transition]:
        return (transition for _, transition in self.placed)

    def changed(
        self, of: Callable[[str | None, tuple[Transition, ...]], tuple[Transition, ...]]
    ) -> Behaviour:
        """The behaviour with what takes the place of the transitions of each state (None: of every
        state)."""

        def outer(place: CompositeState) -> CompositeState:
            return replace(place, transitions=of(place.name, place.transitions))

        def inner(place: State) -> State:
            own = of(place.name, place.transitions)
            return replace(place, transitions=own, around=tuple(map(outer, place.around)))

        return replace(
            self,
            states=tuple(map(inner, self.states)),
            transitions=of(None, self.transitions),
            composites=tuple(map(outer, self.composites)),
        )

    @property
    def staying(self) -> Iterator[Transition]:
        """The internal transitions that may lead to the state that they leave."""
        for place, taken in self.placed:
            stays = place is None or is_in(taken.goto or place, place)
            if stays and taken.event is EventKind.TAU:
                yield taken


@dataclass(frozen=True, slots=True)
class Lasting:
    """A named condition that holds where ``condition`` has held for ``delay`` without a break.

    ``name`` is that of a component without a text in the model, which is in the state
    :data:`HOLDING` where it holds, else in :data:`RESTING`.
    """

    name: str
    condition: tree.Expr
    delay: tree.Expr
    span: Span = span_field()


RESTING, HOLDING = "waiting", "holding"
