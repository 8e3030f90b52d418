"""Checks of the transitions and states of one behaviour."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import replace

from robosc import dotted, errors, remedies, source
from robosc.expr import traversal, tree, types
from robosc.expr.undefined_data import known_condition, none_of
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata
from robosc.model.checks.exclusive import hold_together
from robosc.model.diagnostics import Report, first_of
from robosc.model.names.communications import HEARD, report_misdirected
from robosc.model.names.tables import CommunicationInfo, Instance
from robosc.model.typing.compatibility import describe
from robosc.runtime.core.places import place_of
from robosc.syntax.nodes import Access, ElseNode, ExprNode, Name, StateNode, TauNode


@dataclass(frozen=True, slots=True)
class NamedTransition:
    """A transition, and the names of its event and communication, and its guard, as written."""

    transition: automata.Transition
    event: Name
    communication: Access
    guard: ExprNode | ElseNode | None

    @property
    def key(self) -> tuple[EventKind, str]:
        """The event and the key of the communication."""
        return self.transition.event, self.transition.communication


def check_events(
    instance: Instance,
    report: Report,
    transitions: Iterable[NamedTransition],
    state: StateNode | None,
) -> None:
    """Report transitions for one event of which one has no guard, and each ``else`` out of place.

    ``state`` is that of the transitions, None for those that apply in every state.
    """
    seen: dict[tuple[EventKind, str], list[NamedTransition]] = {}
    for new in transitions:
        result = new.transition
        earlier = seen.setdefault(new.key, [])
        clash = next((e for e in earlier if e.guard is None or new.guard is None), None)
        cut_short = instance.types.scope.is_cut_short
        where = f"in state '{state.name.text}'" if state else "for every state"
        if isinstance((earlier[-1] if earlier else new).guard, ElseNode):
            _report_else(report, new, earlier, where)
        elif clash is not None and not (cut_short(result.span) or cut_short(clash.transition.span)):
            report.add(
                "duplicate-transition",
                new.event.span,
                f"there is already a transition for '{new.event.text}' of"
                f" '{new.communication.span.text}' {where}",
                "join them, or give each an 'if' that excludes the other",
                [errors.Note("the first one is here", clash.event.span)],
            )
        earlier.append(new)


def check_repeated_events(names: Iterable[Name], report: Report) -> list[Name]:
    """Report events that are listed twice in one transition; each event once."""
    first: dict[str, Name] = {}
    for name in names:
        if first.setdefault(name.text, name) is not name:
            report.add(
                "duplicate-transition",
                name.span,
                f"'{name.text}' appears twice in this list",
                "remove one of them",
                [errors.Note("the first one is here", first[name.text].span)],
            )
    return list(first.values())


def report_unavailable(name: Name, infos: Sequence[CommunicationInfo], report: Report) -> None:
    """Report an event that none of the communications of a transition has."""
    kinds = list(dict.fromkeys(info.kind for info in infos))
    only = infos[0] if len(infos) == 1 else None
    if name.text == EventKind.REQUEST.word and only is not None and only.kind is Kind.OUTGOING:
        message = f"{only.kind.value} '{only.name}' has no {name.text}"
        report_misdirected(only, "event-not-available", name.span, message, report)
        return
    if name.text == EventKind.RESPONSE.word and only is not None and only.kind is Kind.INCOMING:
        hint = HEARD.format(only.name)
    else:
        has = (
            f"{'a' if kind is Kind.SERVICE else 'an'} {kind.value} has: "
            + first_of(e.word for e in next(i for i in infos if i.kind is kind).events)
            for kind in kinds
        )
        hint = "; ".join(has)
    who = f"{only.kind.value} '{only.name}' has no" if only else "none of these communications has"
    report.add("event-not-available", name.span, f"{who} {name.text}", hint)


def _report_else(
    report: Report, new: NamedTransition, earlier: Sequence[NamedTransition], where: str
) -> None:
    what = f"for '{new.event.text}' of '{new.communication.span.text}' {where}"
    if earlier:
        message = f"'else' is for the last transition {what}, and this one comes behind it"
        hint = "put the transition with 'else' behind all others for this event"
        notes = [errors.Note("the 'else' is here", earlier[-1].transition.span)]
    else:
        message = f"'else' needs a transition before it {what}"
        hint = "leave out 'else', or write the transitions with 'if' before this one"
        notes = []
    report.add("misplaced-else", new.event.span, message, hint, notes)


def with_else(transitions: Iterable[NamedTransition]) -> tuple[automata.Transition, ...]:
    """The transitions of one place; the guard of each ``else`` is that none of those before holds.

    Their guards are taken as defined: what cannot be evaluated does not hold in either. What stands
    behind an ``else`` for the same event, which is an error, is left out.
    """
    named = list(transitions)
    covered = {new.key for new in named if isinstance(new.guard, ElseNode)}
    complete: set[tuple[EventKind, str]] = set()
    before: dict[tuple[EventKind, str], list[tree.Expr]] = {}
    found: list[automata.Transition] = []
    for new in named:
        result = new.transition
        if new.key in complete:
            continue
        if isinstance(new.guard, ElseNode):
            complete.add(new.key)
            guards = before.get(new.key)
            result = replace(result, guard=none_of(guards, new.guard.span) if guards else None)
        elif new.key in covered and result.guard is not None:
            guard = known_condition(result.guard)
            before.setdefault(new.key, []).append(guard)
            result = replace(result, guard=guard)
        found.append(result)
    return tuple(found)


def internal_with_else(
    named: Sequence[tuple[automata.Transition, TauNode]], state: StateNode | None, report: Report
) -> tuple[automata.Transition, ...]:
    """The internal transitions of one place, with the guard of an ``else`` as in :func:`with_else`.

    Reports an ``else`` out of place. ``state`` is None for those of every state.
    """
    where = f"in state '{state.name.text}'" if state else "for every state"
    last = next((n for n, (_, node) in enumerate(named) if isinstance(node.guard, ElseNode)), None)
    if last is None:
        return tuple(tau for tau, _ in named)
    rest, node = named[last]
    before = [tau for tau, _ in named[:last]]
    guards = [known_condition(tau.guard) for tau in before if tau.guard]
    if not before or len(guards) < len(before):
        report.add(
            "misplaced-else",
            node.span,
            f"'else' needs internal transitions with 'if' before it {where}, and no others",
            "leave out 'else', or give each internal transition before this one its 'if'",
        )
        return tuple(tau for tau, _ in named)
    for _, other in named[last + 1 :]:
        report.add(
            "misplaced-else",
            other.span,
            f"'else' is for the last internal transition {where}, and this one comes behind it",
            "put the transition with 'else' behind all others",
            [errors.Note("the 'else' is here", node.span)],
        )
    assert node.guard is not None
    guarded = zip([*before, rest], [*guards, none_of(guards, node.guard.span)], strict=True)
    return tuple(replace(tau, guard=guard) for tau, guard in guarded)


def check_staying(instance: Instance, behaviour: automata.Behaviour, report: Report) -> None:
    """Report what internal transitions assign that may stay in their state, if it is not finite.

    One that changes nothing is never taken, and only a change of the plant's state is one.
    """
    for assignment in (a for taken in behaviour.staying for a in taken.assignments):
        type_ = instance.variables.get(assignment.variable)
        if type_ is not None and types.domain(type_) is None:
            report.add(
                "not-finite",
                assignment.span,
                f"'{assignment.variable}' is {describe(type_)}; an internal transition that may"
                " stay in its state is taken whenever it changes something finite",
                "let it go to another state, or assign a boolean, an enum or an integer(0..9)",
            )


def check_initial(
    instance: Instance, report: Report, states: Sequence[StateNode], around: StateNode | None
) -> bool:
    """Report several initial states, or none, in a behaviour or a state; whether there is one."""
    name = instance.name if around is None else f"state '{around.name.text}'"
    initial = [state for state in states if state.initial]
    for state in initial[1:]:
        report.add(
            "several-initial-states",
            state.name.span,
            f"{name} already has an initial state",
            remedies.Remedy(
                f"remove 'initial' from '{state.name.text}' or from '{initial[0].name.text}'",
                remedies.Change.REMOVE_INITIAL,
            ),
            [errors.Note("the first one is here", initial[0].name.span)],
        )
    if not initial:
        report.add(
            "no-initial-state",
            instance.node.name.span if around is None else around.name.span,
            f"{name} has {'behaviour' if around is None else 'states'} but no initial state",
            _initial_state(states),
        )
    return bool(initial)


def _initial_state(states: Sequence[StateNode]) -> remedies.Remedy:
    if not states:
        state = "initial marked state idle {}"
        return remedies.Remedy(f"add: {state}", remedies.Change.ADD_INITIAL, (state,))
    first = states[0]
    head = f"initial {'marked ' if first.marked else ''}state {first.name.text}"
    return remedies.Remedy(f"write: {head}", remedies.Change.MAKE_INITIAL, (first.name.text,))


def check_hiding(
    behaviour: automata.Behaviour,
    event_spans: Mapping[tuple[int, EventKind], source.Span],
    rest: Container[tuple[int, EventKind]],
    report: Report,
) -> None:
    """Report transitions of a state that hide one of an outer level for the same event.

    ``event_spans`` maps the offset of a transition and its event to the span of the event's name;
    ``rest`` has those with ``else``.
    """
    performed = {(EventKind.REQUEST, outer.performs) for outer in behaviour.composites}
    seen: set[tuple[str, EventKind, str]] = set()
    for state in behaviour.states:
        places: tuple[automata.State | automata.CompositeState, ...] = (state, *state.around)
        for depth, place in enumerate(places):
            for transition in place.on_communications:
                key = transition.event, transition.communication
                if key in performed:
                    continue  # it is no other state's: that is reported
                is_rest = (transition.span.start, transition.event) in rest
                outer = ((o.name, t) for o in places[depth + 1 :] for t in o.transitions)
                every = (("", t) for t in behaviour.transitions)
                hidden = [
                    (where, t)
                    for where, t in (*outer, *every)
                    if (t.event, t.communication) == key and _hides(transition, is_rest, t)
                ]
                name = place_of(place.name)
                if hidden and (name, *key) not in seen:
                    seen.add((name, *key))
                    _report_hidden(transition, hidden[0], name, event_spans, report)


def _report_hidden(
    transition: automata.Transition,
    found: tuple[str, automata.Transition],
    place: str,
    event_spans: Mapping[tuple[int, EventKind], source.Span],
    report: Report,
) -> None:
    outer, hidden = found
    where = f"all of '{outer}'" if outer else "every state"
    name = dotted.last(transition.communication)
    report.add(
        "hidden-transition",
        event_spans[transition.span.start, transition.event],
        f"in state '{place}' this hides the transition for '{transition.event.word}'"
        f" of '{name}' that applies in {where}",
        None,
        [errors.Note("the hidden one is here", event_spans[hidden.span.start, hidden.event])],
    )


def _hides(own: automata.Transition, is_rest: bool, common: automata.Transition) -> bool:
    """Whether a transition of a state makes one of the behaviour ineffective there.

    It does not if its guard reads an optional value, or the reason of an error: the other one is
    for events without a value. The one with ``else`` (``is_rest``) is for those, too.
    """
    reads = () if own.guard is None or is_rest else traversal.walk(own.guard)
    if any(
        isinstance(part, tree.ValueRef) and (part.optional or isinstance(part, tree.ReasonRef))
        for part in reads
    ):
        return False
    if not own.event.synchronised and _exclude_each_other(own.guard, common.guard):
        return False
    assigned = {a.variable for a in own.assignments}
    return (
        own.event.synchronised
        or common.goto is not None
        or any(a.variable in assigned for a in common.assignments)
    )


def _exclude_each_other(one: tree.Expr | None, other: tree.Expr | None) -> bool:
    """Whether two guards never hold together, which may be unknown."""
    if one is None or other is None:
        return False
    parts = (*traversal.walk(one), *traversal.walk(other))
    # The states of other components are not known yet, and what is missing is no value to try.
    if any(isinstance(p, tree.StateRef | tree.PhaseRef | tree.Holds) for p in parts):
        return False
    if traversal.may_be_undefined(one) or traversal.may_be_undefined(other):
        return False
    return hold_together([one, other], {}) is False


# Reachability and coreachability of the states of one component.
#
# Guards are ignored, and every event is possible in every state, so this over-approximates the
# component alone. Synthesis decides for the whole robot.


def check_reach(
    instance: Instance, behaviour: automata.Behaviour, initial: list[str], report: Report
) -> None:
    """Report unreachable states, and reachable ones from which no marked state is reachable."""
    steps = {state.name: _successors(state, behaviour) for state in behaviour.states}
    reached = _closure(initial, steps)
    for name, state in instance.states.items():
        if dotted.around(name) in instance.performed:
            continue  # it stands where no state can
        if reached.isdisjoint(instance.leaves(name)):
            report.add(
                "unreachable-state",
                state.name.span,
                f"no transition leads {instance.name} to state '{name}'",
            )
    back: dict[str, set[str]] = {name: set() for name in steps}
    for name, targets in steps.items():
        for target in targets:
            back[target].add(name)
    marked = [s.name for s in behaviour.states if s.marked]
    coreachable = _closure(marked, back)
    cut_off = list(
        dict.fromkeys(
            place_of(name) for name in steps if name in reached and name not in coreachable
        )
    )
    if not cut_off:
        return
    message = (
        f"from state '{cut_off[0]}' of {instance.name} no marked state can be reached"
        if marked
        else f"{instance.name} has no marked state"
    )
    hint = (
        f"blocking states: {first_of(cut_off)}; if the controller is to keep out of them, mark"
        f" them and add 'requirement never {instance.name}.{cut_off[0]}'"
        if marked
        else "mark the states in which its work is done: marked state"
    )
    report.add("no-marked-reachable", instance.states[cut_off[0]].name.span, message, hint)


def _successors(state: automata.State, behaviour: automata.Behaviour) -> set[str]:
    hiding: set[tuple[EventKind, str]] = set()
    targets: list[str | None] = []
    for level in behaviour.levels(state):
        targets += [t.goto for t in level if (t.event, t.communication) not in hiding]
        hiding |= {
            (t.event, t.communication) for t in level if t.guard is None or t.event.synchronised
        }
    for place in (state, *state.around, behaviour):
        targets += [t.goto for t in place.transitions if t.event.of_component]
    return {t for t in targets if t is not None}


def _closure(start: Iterable[str], steps: dict[str, set[str]]) -> set[str]:
    found = set(start)
    work = list(found)
    while work:
        for target in steps[work.pop()] - found:
            found.add(target)
            work.append(target)
    return found
