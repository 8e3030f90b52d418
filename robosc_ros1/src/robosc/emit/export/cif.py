"""CIF 3 text of the plant, its requirements and its supervisor, for the Eclipse ESCET tools.

Written after the CIF language reference and the manual of data-based controller synthesis
(https://eclipse.dev/escet/cif/). What RoboSC leaves implicit, CIF wants said:

- A CIF event happens only if *every* automaton that has it in its alphabet takes part. A component
  that merely does not react to an uncontrollable event gets a self-loop for it.
- A CIF event of synthesis carries no data: an event with a value becomes one event per value.
- An assignment that leaves a range is a fault in CIF. Where that can happen, the edge's guard rules
  it out, and for an uncontrollable event a requirement forbids the states in which it would.
- Names of controllable events begin with ``c_``, of uncontrollable ones with ``u_``, as CIF asks.

Synthesis in CIF knows booleans, enumerations and ranges of integers from 0 upwards, comparisons of
their sums, and no reals. See :mod:`robosc.emit.export.cif_expr` for what that does to expressions,
and :mod:`robosc.emit.export.cif_names` for numbers without bounds and strings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field

from robosc import dotted, errors, limits, names
from robosc.emit.export.cif_expr import condition, in_range, update
from robosc.emit.export.cif_names import CifScope, CifVariable
from robosc.expr.tree import FALSE, TRUE, Expr, StateRef, VariableRef
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Requirement
from robosc.plant import acceptance, partial_evaluation, step
from robosc.plant.automaton import (
    ASSUMPTIONS,
    Edge,
    Event,
    LocalAutomaton,
    Plant,
    StateVariable,
    VariableKind,
)
from robosc.plant.partial_evaluation import assigned, holds
from robosc.supervisor import Guard, Supervisor
from robosc.synthesis.event_parameters import weight

# The events of CIF: those of the plant, each with each of its values.


@dataclass(frozen=True, slots=True)
class CifEvent:
    """An event with one value: an event of its own in CIF."""

    event: Event
    values: partial_evaluation.PartValues
    name: str


def cif_events(plant: Plant, scope: CifScope) -> Iterator[CifEvent]:
    """Each event with each of its values.

    Raises:
        StateSpaceError: they are too many to be written down.
    """
    for event in plant.events:
        if weight(event) > limits.CIF_VALUES:
            name = f"{event.name}.{event.kind.word}"
            raise errors.StateSpaceError(
                f"CIF needs an event for each value, and {name} has more than"
                f" {limits.CIF_VALUES:,}: convert the received value by an enum,"
                " or export as JSON"
            )
        event_name = _event_name(event)
        parameters = (event.whole or event).parameters
        words = [scope.value_names(event_name, p) for p in parameters]
        for values in step.valuations(event):
            known = list(zip(parameters, values, words, strict=True))
            parts = [event_name, *(own[p.values.index(value)] for p, value, own in known)]
            name = scope.fresh("_".join(parts))
            yield CifEvent(event, {p.path: value for p, value, _ in known}, name)


def _event_name(event: Event) -> str:
    prefix = "c" if event.controllable else "u"
    name = names.without_index(event.name).replace(".", "_")
    number = event.index if event.kind.of_component else ""
    return f"{prefix}_{name}_{event.kind.word}{number}"


def cif_plant(plant: Plant) -> str:
    """Plant and requirements: the input of CIF's data-based synthesis.

    Raises:
        StateSpaceError: an event has too many values to be written down.
        UsageError: a test reads data of several components.
    """
    return _Writer(plant).specification()


def cif_supervised(supervisor: Supervisor) -> str:
    """The same with robosc's supervisor as an automaton of guards, to simulate and to compare."""
    return _Writer(supervisor.plant).specification(supervisor.guards)


@dataclass
class _Writer:
    plant: Plant
    lines: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.scope = CifScope(self.plant)
        self.occurrences = list(cif_events(self.plant, self.scope))

    def specification(self, guards: Sequence[Guard] | None = None) -> str:
        robot = self.plant.robot
        self.lines = [f"// {robot.name}: plant and requirements, written by robosc."]
        self._enums()
        self._events()
        for component in robot.components:
            if component.states:
                self._component(component.name)
            for communication in component.communications:
                if communication.phases is not None:
                    self._phase(communication.key)
        self._assumptions()
        self._parameters()
        self._messages()
        self._requirements()
        if guards is not None:
            self._supervisor(guards)
        return "\n".join(self.lines) + "\n"

    # --- declarations ------------------------------------------------------------------------

    def _enums(self) -> None:
        if self.scope.enums:
            self.lines.append("")
        for enum, literals in self.scope.enums.items():
            if enum in self.scope.notes:
                self.lines.append(f"// {self.scope.notes[enum]}")
            self.lines.append(f"enum {enum} = {', '.join(literals)};")

    def _events(self) -> None:
        notes = {n: note for n, note in self.scope.notes.items() if n not in self.scope.enums}
        if notes:
            self.lines += ["", *(f"// {name}: {note}" for name, note in notes.items())]
        for word, controllable in (("controllable", True), ("uncontrollable", False)):
            names = [o.name for o in self.occurrences if o.event.controllable == controllable]
            if names:
                self.lines.append("")
                self.lines += [f"{word} {name};" for name in names]

    # --- automata ----------------------------------------------------------------------------

    def _automaton(
        self,
        head: str,
        locations: Mapping[str, Iterable[str]],
        variables: Iterable[str] = (),
    ) -> None:
        """An automaton with the lines of its locations, by name; one alone needs none."""
        self.lines += ["", f"{head}:", *(f"  {line}" for line in variables)]
        for name, body in locations.items():
            self.lines.append(f"  location {name}".rstrip() + ":")
            self.lines += [f"    {line}" for line in body]
        self.lines.append("end")

    def _component(self, name: str) -> None:
        index = self.plant.variable_index[VariableKind.LOCATION, name]
        state = self.plant.variables[index]
        locations = {
            self.scope.location(name, location): _flags(state, number)
            for number, location in enumerate(state.values)
        }
        for occurrence in self.occurrences:
            for automaton in occurrence.event.automata:
                if automaton.component == name:
                    self._add_edges(occurrence, automaton, locations)
        head = f"plant automaton {self.scope.automaton(name)}"
        self._automaton(head, locations, self._declarations(name))

    def _declarations(self, component: str) -> Iterator[str]:
        for variable in self.scope.variables.values():
            if variable.component == component:
                state = variable.state
                note = f" // minus {variable.offset}" if variable.offset else ""
                starts = [variable.text(state.values[number]) for number in state.start_indexes]
                start = f"= {starts[0]}" if len(starts) == 1 else f"in {{{', '.join(starts)}}}"
                yield f"disc {variable.type} {self.scope.own_name(variable)} {start};{note}"

    def _add_edges(
        self, occurrence: CifEvent, automaton: LocalAutomaton, locations: Mapping[str, list[str]]
    ) -> None:
        """Add the edges of one event to the lines of the locations of its automaton."""
        found = [list(self._edges(occurrence, automaton, n)) for n in range(len(locations))]
        if not any(found):
            # An event without an edge here would be possible always.
            found[0] = [f"edge {occurrence.name} when false;"]
        for lines, edges in zip(locations.values(), found, strict=True):
            lines += edges

    def _edges(
        self, occurrence: CifEvent, automaton: LocalAutomaton, location: int
    ) -> Iterator[str]:
        """The edges of one event in one location, and the self-loop that keeps it possible."""
        guards: list[Expr] = []
        for edge, guard, before in self._ways(occurrence, automaton, location):
            conditions = self._alone(guard, before)
            updates = []
            for target, expr in self._updates(edge, occurrence):
                conditions += in_range(self.scope, target, expr)
                name = self.scope.own_name(target)
                updates.append(f"{name} := {update(self.scope, target, expr)}")
            yield self._edge(occurrence, automaton, edge, conditions, updates)
            guards.append(guard)
        if not automaton.blocking and TRUE not in guards:
            conditions = self._alone(TRUE, guards)
            when = f" when {' and '.join(conditions)}" if conditions else ""
            yield f"edge {occurrence.name}{when};"

    def _ways(
        self, occurrence: CifEvent, automaton: LocalAutomaton, location: int
    ) -> Iterator[tuple[Edge, Expr, list[Expr]]]:
        """Edges with their guards, and the guards of earlier edges that may hold together with it.

        Of several edges the first is taken, where CIF may take any. With the same levels guards
        never hold together.
        """
        found: list[tuple[Edge, Expr]] = []
        for edge in automaton.edges:
            guard = holds(edge.guard, occurrence.values) if edge.source == location else FALSE
            if guard == FALSE:
                continue
            before = [other for earlier, other in found if earlier.levels != edge.levels]
            if TRUE in before:
                return
            yield edge, guard, before
            found.append((edge, guard))

    def _alone(self, guard: Expr, before: list[Expr]) -> list[str]:
        """A guard, and that none of the guards before it holds, as conditions of CIF."""
        own = [] if guard == TRUE else [condition(self.scope, guard)]
        return own + [f"not {condition(self.scope, other, 9)}" for other in before]

    def _edge(
        self,
        occurrence: CifEvent,
        automaton: LocalAutomaton,
        edge: Edge,
        conditions: list[str],
        updates: list[str],
    ) -> str:
        text = f"edge {occurrence.name}"
        text += f" when {', '.join(conditions)}" if conditions else ""
        text += f" do {', '.join(updates)}" if updates else ""
        if edge.target != edge.source:
            text += f" goto {self._target(automaton, edge.target)}"
        return f"{text};"

    def _target(self, automaton: LocalAutomaton, number: int) -> str:
        variable = self.plant.variables[automaton.variable]
        if variable.kind is VariableKind.PHASE:
            return str(variable.values[number])
        return self.scope.location(automaton.component, variable.values[number])

    def _updates(self, edge: Edge, occurrence: CifEvent) -> Iterator[tuple[CifVariable, Expr]]:
        """Assignments with the value put in; those that read a missing element drop out."""
        for index, expr in edge.updates:
            variable = self.plant.variables[index]
            component, name = dotted.first(variable.name), dotted.inside(variable.name)
            value = assigned(
                expr, occurrence.values, variable.test or VariableRef(component, name, expr.type)
            )
            if value is not None:
                yield self.scope.variables[index], value

    def _phase(self, key: str) -> None:
        """The automaton of a communication itself."""
        index = self.plant.variable_index[VariableKind.PHASE, key]
        variable = self.plant.variables[index]
        locations = {str(phase): _flags(variable, n) for n, phase in enumerate(variable.values)}
        for occurrence in self.occurrences:
            step = occurrence.event.phase
            if step is not None and step.variable == index:
                target = str(variable.values[step.target])
                for source in (str(variable.values[n]) for n in step.sources):
                    goto = "" if source == target else f" goto {target}"
                    locations[source].append(f"edge {occurrence.name}{goto};")
            accepts = acceptance.acceptance_of(occurrence.event)
            if accepts is not None and accepts.variable == index:
                self._add_edges(occurrence, accepts, locations)
        self._automaton(f"plant automaton {self.scope.phase(key)}", locations)

    def _assumptions(self) -> None:
        """An automaton for each event of which something is assumed."""
        found: dict[int, dict[str, list[str]]] = {}
        for occurrence in self.occurrences:
            for automaton in occurrence.event.automata:
                if automaton.component == ASSUMPTIONS:
                    locations = found.setdefault(automaton.variable, {"": [*_ALWAYS]})
                    self._add_edges(occurrence, automaton, locations)
        for locations in found.values():
            name = self.scope.fresh("Assumption")
            self._automaton(f"plant automaton {name}", locations)

    def _parameters(self) -> None:
        """The variables that parameters of the node decide, which nothing changes."""
        name = self.scope.parameters
        if name:
            locations = {"known": _ALWAYS}
            self._automaton(f"plant automaton {name}", locations, self._declarations(name))

    def _messages(self) -> None:
        """Messages that no component reacts to: always possible, changing nothing."""
        free = [o.name for o in self.occurrences if o.event.phase is None and not o.event.automata]
        if free:
            edges = [f"edge {event};" for event in free]
            self._automaton(
                f"plant automaton {self.scope.fresh('Messages')}", {"": [*_ALWAYS, *edges]}
            )

    # --- requirements ------------------------------------------------------------------------

    def _requirements(self) -> None:
        for requirement in self.plant.robot.requirements:
            self.lines += ["", f"// {' '.join(requirement.text.split())}"]
            self.lines += list(self._requirement(requirement))
        for goal in self.plant.robot.goals:
            self.lines += ["", f"// {goal.text}", "// CIF has no such requirement."]
        self._cancels()
        self._ranges()

    def _requirement(self, requirement: Requirement) -> Iterator[str]:
        if requirement.on_data and self.plant.robot.supervises:
            yield from self._on_data(requirement)
            return
        text = condition(self.scope, self.plant.view.expression(requirement.condition))
        if requirement.kind == "always":
            yield f"requirement invariant {text};"
        elif requirement.kind == "never":
            yield f"requirement invariant not ({text});"
        for occurrence in self.occurrences:
            event = occurrence.event
            restricted = event.kind.given and requirement.concerns(event.kind)
            if restricted and event.command in requirement.communications:
                if requirement.kind == "needs":
                    yield f"requirement invariant {occurrence.name} needs {text};"
                else:
                    yield f"requirement invariant {text} disables {occurrence.name};"

    def _on_data(self, requirement: Requirement) -> Iterator[str]:
        """What a requirement on the data of a command says of each case of them."""
        kept = self.plant.view.met(requirement)
        for occurrence in self.occurrences:
            event = occurrence.event
            if event.kind.sent and event.command in requirement.communications:
                text = condition(self.scope, holds(kept, event.data))
                yield f"requirement invariant {occurrence.name} needs {text};"

    def _cancels(self) -> None:
        cancels = [o for o in self.occurrences if o.event.kind is EventKind.CANCEL]
        if cancels:
            self.lines += [
                "",
                "// An action is cancelled only where one of its requirements fails.",
            ]
        for occurrence in cancels:
            requirement = occurrence.event.requirement
            text = condition(self.scope, FALSE if requirement is None else requirement)
            self.lines.append(f"requirement invariant {occurrence.name} needs {text};")

    def _ranges(self) -> None:
        """States in which an uncontrollable event would leave a range."""
        found = [
            text
            for occurrence in self.occurrences
            if not occurrence.event.controllable
            for automaton in acceptance.components_of(occurrence.event)
            for text in self._overflows(occurrence, automaton)
        ]
        if found:
            self.lines += [
                "",
                "// What cannot be prevented must not take a variable out of its range.",
            ]
            self.lines += list(dict.fromkeys(found))

    def _overflows(self, occurrence: CifEvent, automaton: LocalAutomaton) -> Iterator[str]:
        places = self.plant.variables[automaton.variable].values
        here = self._open(occurrence)
        if here is None:
            return
        for location, place in enumerate(places):
            for edge, guard, before in self._ways(occurrence, automaton, location):
                parts = [condition(self.scope, StateRef(automaton.component, str(place))), *here]
                parts += [] if guard == TRUE else [condition(self.scope, guard, 3)]
                parts += self._alone(TRUE, before)
                where = " and ".join(parts)
                for target, expr in self._updates(edge, occurrence):
                    inside = in_range(self.scope, target, expr)
                    if inside:
                        yield f"requirement invariant {where} => {' and '.join(inside)};"

    def _open(self, occurrence: CifEvent) -> list[str] | None:
        """Conditions of the phase of an event and of what is assumed of it; None: it never is."""
        event = occurrence.event
        conditions: list[str] = []
        gates = [(gate.variable, gate.edges) for gate in acceptance.gates_of(event)]
        ways = [(n, [(e.source, holds(e.guard, occurrence.values)) for e in es]) for n, es in gates]
        if event.phase is not None:
            ways.append((event.phase.variable, [(n, TRUE) for n in event.phase.sources]))
        for index, sources in ways:
            values, cases = self.plant.variables[index].values, []
            for guard in dict.fromkeys(guard for _, guard in sources if guard != FALSE):
                places = [str(values[n]) for n, other in sources if other == guard]
                found = []
                if len(places) < len(values):
                    found.append(_any([f"{self.scope.phase(event.key)}.{p}" for p in places]))
                found += [] if guard == TRUE else [condition(self.scope, guard, 3)]
                cases.append(" and ".join(found))
            if not cases:
                return None
            conditions += [_any(cases)] if all(cases) else []
        return conditions

    # --- supervisor --------------------------------------------------------------------------

    def _supervisor(self, found: Sequence[Guard]) -> None:
        guards = {g.event.identity: g.expr for g in found}
        edges = [
            f"edge {o.name} when {condition(self.scope, guards[o.event.identity])};"
            for o in self.occurrences
            if o.event.controllable
        ]
        name = self.scope.fresh("Supervisor")
        self._automaton(f"supervisor automaton {name}", {"": [*_ALWAYS, *edges]})


def _any(conditions: Sequence[str]) -> str:
    return conditions[0] if len(conditions) == 1 else f"({' or '.join(conditions)})"


_ALWAYS = ("initial;", "marked;")
"""Of a location that an automaton never leaves."""


def _flags(variable: StateVariable, index: int) -> list[str]:
    """Whether the location of a value is initial, and whether it is marked."""
    marked = variable.marked is None or index in variable.marked
    return ["initial;"] * (index == variable.initial) + ["marked;"] * marked
