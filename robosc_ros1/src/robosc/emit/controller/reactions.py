"""What an event does to the controller, and when the plant can do it, as Python text.

Assignments are simultaneous: conditions and right-hand sides see the state before the event, and
nothing is changed if one of them raises Mismatch. So an attribute is assigned at once only if
nothing that is evaluated afterwards reads it or raises; else its new value waits in a local
variable of its name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from robosc.emit.controller.naming import PythonNames
from robosc.emit.controller.python import Attributes, PythonCode, joined, literal
from robosc.emit.controller.template_data import PartnerView, ReactionView
from robosc.emit.write.line_breaks import unparenthesised
from robosc.expr import traversal, tree, types
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata
from robosc.plant import acceptance, logic, python_text
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant, StateVariable
from robosc.plant.model_text import to_dsl

_IMPOSSIBLE = {EventKind.TIMEOUT: "silent", EventKind.CANCELLED: "not being cancelled"}
"""What a communication is where an event of it is not possible, if it is not just idle."""


@dataclass(frozen=True)
class _Effect:
    """An attribute and its new value over the old state.

    ``change`` is how far the new value is from the old one, such as ``+= 1``, if it is written so.
    """

    attribute: str
    value: PythonCode
    change: str = ""


@dataclass(frozen=True)
class _Branch:
    """One way in which a component takes part: ``condition`` (empty: always) and its effects."""

    condition: PythonCode
    place: str
    effects: tuple[_Effect, ...]


@dataclass(frozen=True)
class _LocalReaction:
    """What an event does to one component."""

    component: str
    branches: tuple[_Branch, ...]

    @property
    def evaluated(self) -> list[PythonCode]:
        """All that is evaluated."""
        values = [effect.value for branch in self.branches for effect in branch.effects]
        return [branch.condition for branch in self.branches] + values


class Reactions:
    """Describes the events of one plant."""

    def __init__(self, plant: Plant, attributes: Attributes) -> None:
        self.plant = plant
        self.attributes = attributes
        self.variables = plant.robot.variables

    def reaction(self, event: Event, tested: bool = False) -> ReactionView:
        """What an event does; ``tested``: its one edge is known to be enabled."""
        parts = []
        for automaton in acceptance.components_of(event):
            groups = alike(automaton.edges)
            branches = tuple(self._branch(event, automaton, edges) for edges in groups)
            if tested:
                branches = tuple(replace(branch, condition=PythonCode("")) for branch in branches)
            if any(branch.effects for branch in branches):
                parts.append(_LocalReaction(automaton.component, branches))
        changed = {e.attribute: None for part in parts for b in part.branches for e in b.effects}
        body = [*self._assumed(event), *_body(parts)]
        if event.kind is EventKind.CALL:
            body = [*self._accepted(event), *body]
        phase = acceptance.phase_of(event)
        if phase is not None:
            during, _ = self.phases(event)
            if during:
                wrong = _IMPOSSIBLE.get(event.kind, "not under way")
                mismatch = f'    raise Mismatch("{event.name} is {wrong}")'
                body = [f"if {_none_of(during)}:", mismatch, *body]
            for number, flag in self._flags(event).items():
                was, becomes = phase.sources == (number,), number == phase.target
                if not was if becomes else number in phase.sources:
                    body.append(f"self.{flag} = {becomes}")
                    changed[flag] = None
        return ReactionView(*self._with_resets(event, body, tuple(changed)))

    def _with_resets(
        self, event: Event, body: Sequence[str], changed: tuple[str, ...]
    ) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """What an event does and writes, with what follows for lasting conditions."""
        before: list[str] = []
        after: list[str] = []
        written = dict.fromkeys(changed)
        for number, automaton in enumerate(acceptance.resets_of(event), 1):
            name = literal(automaton.component)
            before.append(f"before_{number} = self.lasting({name})")
            after.append(f"self.follow({name}, before_{number})")
            written[self.attributes.locations[automaton.component]] = None
            written[self.attributes.entries[automaton.component]] = None
        return (*before, *body, *after), tuple(written)

    def _assumed(self, event: Event) -> Iterator[str]:
        """The statements that refuse an event of the robot, with the reason, where it is assumed
        not to happen."""
        for restriction in self.plant.restrictions.get((event.kind, event.key), ()):
            assumption = restriction.assumption
            where = f"{assumption.text} ({assumption.span.place})"
            yield f"if not ({self.attributes.text(restriction.condition)}):"
            yield f"    raise BrokenAssumption({literal(where)})"

    def _accepted(self, event: Event) -> Iterator[str]:
        """The statements that refuse a call, with the reason, where no component takes it."""
        taken = " or ".join(f"self.{flag}" for flag in self._flags(event).values())
        yield f"if {taken}:"
        yield f'    raise Mismatch("{event.name} is busy: it serves one call at a time")'
        accepts = acceptance.acceptance_of(event)
        assert accepts is not None
        if not accepts.edges:
            yield f'raise Mismatch("no component takes {event.name}")'
            return
        guard = accepts.edges[0].guard
        if guard is None:
            return
        condition = self.attributes.text(guard)
        listeners = [automaton.component for automaton in acceptance.components_of(event)]
        states = " + ".join(
            f'"{" and " if n else ""}{name} is in " + {self._told(name)}'
            for n, name in enumerate(listeners)
        )
        where = literal(f", and {event.name} is taken where {to_dsl(guard, self.plant.robot)}")
        yield f"if not ({condition}):"
        yield f"    raise Mismatch({states} + {where})"

    def _told(self, component: str) -> str:
        """The code for the state of a component under the name that the model gives it."""
        location = f"self.{self.attributes.locations[component]}"
        has_stages = any(s.startswith(f"{component}.") for s in self.plant.robot.stages)
        return f'{location}.partition(" ")[0]' if has_stages else location

    def phases(self, event: Event) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The attributes of the phases in which an event is possible; where it is possible in the
        first one, too, which has none, those of the phases in which it is not."""
        phase = acceptance.phase_of(event)
        if phase is None:
            return (), ()
        sources, flags = phase.sources, self._flags(event)
        if 0 in sources:
            return (), tuple(flag for number, flag in flags.items() if number not in sources)
        return tuple(flag for number, flag in flags.items() if number in sources), ()

    def _flags(self, event: Event) -> dict[int, str]:
        """The attributes of the phases of an event's communication, by their numbers."""
        phases = self.plant.robot.communications[event.key].phases
        assert phases is not None
        return {
            number: self.attributes.phases[event.key, phase]
            for number, phase in enumerate(phases.active, 1)
        }

    def effects(self, event: Event, edges: list[Edge]) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The statements of an event's one transition, where it is taken, and what they write."""
        (automaton,) = acceptance.components_of(event)
        branch = replace(self._branch(event, automaton, edges), condition=PythonCode(""))
        _, *lines = _body([_LocalReaction(automaton.component, (branch,))])
        return self._with_resets(event, lines, tuple(e.attribute for e in branch.effects))

    def _branch(self, event: Event, automaton: LocalAutomaton, edges: list[Edge]) -> _Branch:
        edge = edges[0]
        effects = []
        for assignment in edge.assignments:
            variable = self.variables[f"{automaton.component}.{assignment.variable}"]
            effects.append(self._effect(event, variable, assignment.value))
        location = self.plant.variables[automaton.variable]
        if any(e.source != e.target for e in edges):
            target = PythonCode(literal(location.values[edge.target]))
            effects.append(_Effect(self.attributes.locations[automaton.component], target))
        component = automaton.component
        counters = [component] if edge.enters and component in self.attributes.entries else []
        for name in (*counters, *(f"{component}.{outer}" for outer in edge.outer)):
            entries = self.attributes.entries[name]
            more = PythonCode(f"self.{entries} + 1", frozenset([entries]))
            effects.append(_Effect(entries, more, "+= 1"))
        condition = self._edge_condition(location, edges)
        return _Branch(condition, edge.span.place, tuple(effects))

    def _edge_condition(self, location: StateVariable, edges: list[Edge]) -> PythonCode:
        guard = edges[0].guard
        parts = [self.location_test(location, [e.source for e in edges])]
        if guard is not None:
            code = self.attributes.code(guard)
            text = self.attributes.operand(guard)
            if traversal.may_be_undefined(logic.exact(guard)):
                text = f"self.holds(lambda: {code.text}, {literal(edges[0].span.place)})"
            parts.append(replace(code, text=text))
        return joined("and", parts)

    def condition(self, automaton: LocalAutomaton) -> PythonCode:
        """Where an automaton takes part whose edges have one guard; empty: always."""
        location = self.plant.variables[automaton.variable]
        return self._edge_condition(location, list(automaton.edges))

    def location_test(self, location: StateVariable, sources: Iterable[int]) -> PythonCode:
        """Whether the component is in one of the states; empty if it always is."""
        states = [str(location.values[source]) for source in sources]
        attribute = self.attributes.locations[location.name]
        if len(states) == location.size:
            return PythonCode("")
        if len(states) == 1:
            test = f"== {literal(states[0])}"
        else:
            test = f"in ({', '.join(literal(s) for s in states)})"
        return PythonCode(f"self.{attribute} {test}", frozenset([attribute]))

    def _effect(self, event: Event, variable: automata.Variable, expr: tree.Expr) -> _Effect:
        attribute = self.attributes.variables[variable.key]
        code = self.attributes.code(expr)
        text, reads, mismatches = code.text, code.reads, code.mismatches
        if isinstance(variable.type, types.DoubleType) and isinstance(expr.type, types.IntegerType):
            text = f"{'widen' if python_text.may_be_huge(expr) else 'float'}({text})"
        where = literal(expr.span.place) if expr.span is not None else '""'
        if not traversal.within(expr, variable.type):
            assert isinstance(variable.type, types.IntegerType)
            assert variable.type.bounds is not None
            low, high = variable.type.bounds
            if not variable.in_state:
                text = f"self.kept({text}, {low}, {high}, self.{attribute}, {where})"
                reads |= {attribute}
            elif not event.controllable:
                text = f"in_range({text}, {low}, {high}, {literal(variable.key)})"
                mismatches = True
        if traversal.may_be_undefined(logic.exact(expr)):
            text = f"self.assigned(lambda: {text}, self.{attribute}, {where})"
            reads |= {attribute}
        value = PythonCode(text, reads, mismatches)
        return _Effect(attribute, value, self._change(attribute, expr, text))

    def _change(self, attribute: str, expr: tree.Expr, text: str) -> str:
        """What is added to an attribute, or subtracted, by an expression with this text."""
        if isinstance(expr, tree.Binary) and isinstance(expr.right, tree.Literal | tree.Leaf):
            change = f"{expr.operator} {self.attributes.text(expr.right)}"
            if expr.operator in ("+", "-") and text == f"self.{attribute} {change}":
                return change.replace(" ", "= ", 1)
        return ""

    def synchronisation(self, event: Event) -> PythonCode:
        """The condition under which the plant can do a controllable event, its phase apart; empty
        if it always can."""
        conditions = [condition for _, condition in self._synchronisation(event)]
        if len(conditions) == 1:
            return replace(conditions[0], text=unparenthesised(conditions[0].text))
        return joined("and", conditions)

    def partners(self, event: Event, name: str, names: PythonNames) -> tuple[PartnerView, ...]:
        """The components of that condition, each with whether it can take part, the ranges of its
        variables apart; several have a method each, one alone has that of the whole."""
        parts = list(self._synchronisation(event, ranges=False))
        if len(parts) == 1 and parts == list(self._synchronisation(event)):
            return (PartnerView(parts[0][0], parts[0][1].text, ""),)
        return tuple(
            PartnerView(
                component, unparenthesised(code.text), names.take(f"partner_{number}_in_{name}")
            )
            for number, (component, code) in enumerate(parts, 1)
        )

    def _synchronisation(
        self, event: Event, ranges: bool = True
    ) -> Iterator[tuple[str, PythonCode]]:
        for automaton in event.automata:
            if automaton.resets:
                continue
            location = self.plant.variables[automaton.variable]
            ways = []
            free = True
            for edges in alike(automaton.edges):
                inside = joined("and", self.ranges(edges[0]) if ranges else ())
                where = self._edge_condition(location, edges)
                free = free and not inside
                both = joined("and", [where, inside])
                if automaton.blocking:
                    ways.append(both)
                elif inside:
                    text = f"(not ({where.text}) or {inside.text})" if where else inside.text
                    yield automaton.component, replace(both, text=text)
            if not automaton.blocking or (free and self._always(automaton, location)):
                continue
            if len(ways) == 1:
                yield automaton.component, ways[0]
            else:
                one = joined("or", ways)
                text = f"({one.text})" if ways else "False"
                yield automaton.component, replace(one, text=text)

    def _always(self, automaton: LocalAutomaton, location: StateVariable) -> bool:
        open_edges = {e.source for e in automaton.edges if e.guard is None}
        return len(open_edges) == location.size

    def ranges(self, edge: Edge) -> Iterator[PythonCode]:
        """The conditions under which what an edge assigns stays in its ranges."""
        for index, expr in edge.updates:
            variable = self.variables.get(self.plant.variables[index].name)
            if variable is not None and not traversal.within(expr, variable.type):
                assert isinstance(variable.type, types.IntegerType)
                assert variable.type.bounds is not None
                low, high = variable.type.bounds
                code = self.attributes.code(expr)
                yield replace(code, text=f"{low} <= {code.text} <= {high}")


def _none_of(flags: Iterable[str]) -> str:
    one, *more = [f"self.{flag}" for flag in flags]
    return f"not ({' or '.join([one, *more])})" if more else f"not {one}"


def alike(edges: Iterable[Edge]) -> list[list[Edge]]:
    """The edges of one transition in one group: on the automaton level there is one per state.

    In each state the first edge counts, so that a group comes after all that stand before one of
    its edges.
    """
    groups: dict[tuple[object, ...], list[Edge]] = {}
    ranks: dict[tuple[object, ...], int] = {}
    seen: dict[int, int] = {}
    for edge in edges:
        span = edge.span
        where = id(span.source), span.start, span.end
        key = *where, edge.guard, edge.updates, edge.assignments, edge.outer
        groups.setdefault(key, []).append(edge)
        seen[edge.source] = rank = seen.get(edge.source, 0) + 1
        ranks[key] = max(ranks.get(key, 0), rank)
    return [groups[key] for key in sorted(groups, key=ranks.__getitem__)]


def _body(parts: list[_LocalReaction]) -> Iterator[str]:
    """The statements that change the state."""
    waiting = _waiting(parts)
    assigned = {name for part in parts for name in _always_assigned(part)}
    for name in waiting:
        if name not in assigned:
            yield f"{name} = self.{name}"
    for part in parts:
        first = part.branches[0]
        if not first.condition:
            yield f"# {part.component} ({first.place})"
            yield from _effects(first, waiting, "")
            continue
        yield f"# {part.component}"
        for number, branch in enumerate(part.branches):
            word = "if" if number == 0 else "elif"
            head = f"{word} {branch.condition.text}:" if branch.condition else "else:"
            yield f"{head}  # {branch.place}"
            yield from _effects(branch, waiting, "    ") if branch.effects else ["    pass"]
    for name in waiting:
        yield f"self.{name} = {name}"


def _effects(branch: _Branch, waiting: Iterable[str], indent: str) -> Iterator[str]:
    for effect in branch.effects:
        name = effect.attribute
        if name in waiting:
            yield f"{indent}{name} = {effect.value.text}"
        else:
            yield f"{indent}self.{name} {effect.change or f'= {effect.value.text}'}"


def _always_assigned(part: _LocalReaction) -> Iterator[str]:
    if not part.branches[0].condition:
        yield from (effect.attribute for effect in part.branches[0].effects)


def _waiting(parts: list[_LocalReaction]) -> list[str]:
    """The attributes whose new values must wait until all of the event is evaluated."""
    found: dict[str, None] = {}
    for number, part in enumerate(parts):
        later = [code for other in parts[number + 1 :] for code in other.evaluated]
        for branch in part.branches:
            for at, effect in enumerate(branch.effects, 1):
                after = [other.value for other in branch.effects[at:]] + later
                if any(code.mismatches or effect.attribute in code.reads for code in after):
                    found[effect.attribute] = None
    return list(found)
