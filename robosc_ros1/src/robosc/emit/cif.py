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
their sums, and no reals. See :mod:`robosc.emit.cif_expr` for what that does to expressions, and
:mod:`robosc.emit.cif_data` for numbers without bounds and strings.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from robosc.emit.cif_data import discrete_plant
from robosc.emit.cif_expr import condition, in_range, update
from robosc.emit.cif_names import CifNames, CifScope, initial, offset
from robosc.errors import StateSpaceError
from robosc.ir.automaton import Edge, Event, LocalAutomaton, Plant, VariableKind
from robosc.ir.partial_evaluation import PartValues, assigned, holds
from robosc.ir.step import valuations
from robosc.model.entities import EventKind, Requirement
from robosc.model.expr import FALSE, TRUE, Expr, StateRef, VariableRef
from robosc.model.types import Type, Value
from robosc.names import without_index
from robosc.supervisor import Guard, Supervisor
from robosc.synthesis.event_parameters import weight

__all__ = ["cif_plant", "cif_supervised"]

_MOST_VALUES = 2**14
"""Of one event; they make a text of 40 MB and take some 15 s."""


def cif_plant(plant: Plant) -> str:
    """Plant and requirements: the input of CIF's data-based synthesis."""
    discrete = discrete_plant(plant)
    return _Writer(discrete.plant, discrete.notes).specification()


def cif_supervised(supervisor: Supervisor) -> str:
    """The same with robosc's supervisor as an automaton of guards, to simulate and to compare."""
    discrete = discrete_plant(supervisor.plant)
    guards = tuple(replace(g, expr=discrete.expression(g.expr)) for g in supervisor.guards)
    return _Writer(discrete.plant, discrete.notes).specification(guards)


@dataclass(frozen=True, slots=True)
class _Occurrence:
    """An event with one value: an event of its own in CIF."""

    event: Event
    values: PartValues
    name: str


@dataclass
class _Writer:
    plant: Plant
    notes: Mapping[str, str]
    lines: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.names = CifNames()
        self.context = CifScope(self.plant, self.names)
        self.occurrences = list(self._occurrences())

    def specification(self, guards: Sequence[Guard] | None = None) -> str:
        robot = self.plant.robot
        self.lines = [f"// {robot.name}: plant and requirements, written by robosc."]
        self._enums()
        self._events()
        for component in robot.components:
            if (VariableKind.LOCATION, component.name) in self.plant.variable_index:
                self._component(component.name)
            for communication in component.communications:
                if communication.phases is not None:
                    self._phase(communication.key)
        self._messages()
        self._requirements()
        if guards is not None:
            self._supervisor(guards)
        return "\n".join(self.lines) + "\n"

    # --- declarations ------------------------------------------------------------------------

    def _enums(self) -> None:
        """One declaration per enum; literals carry its name, since enums may share values."""
        enums = self.context.enums()
        if enums:
            self.lines.append("")
        for enum, literals in enums:
            if enum in self.notes:
                self.lines.append(f"// {self.notes[enum]}")
            self.lines.append(f"enum {enum} = {', '.join(literals)};")

    def _events(self) -> None:
        declared = {name for name, _ in self.context.enums()}
        told = [f"// {name}: {note}" for name, note in self.notes.items() if name not in declared]
        self.lines += ["", *told] if told else []
        for word, controllable in (("controllable", True), ("uncontrollable", False)):
            names = [o.name for o in self.occurrences if o.event.controllable == controllable]
            if names:
                self.lines.append("")
                self.lines += [f"{word} {name};" for name in names]

    def _occurrences(self) -> Iterator[_Occurrence]:
        """Each event with each of its values.

        Raises:
            StateSpaceError: they are too many to be written down.
        """
        for event in self.plant.events:
            if weight(event) > _MOST_VALUES:
                name = f"{event.name}.{event.kind.value}"
                raise StateSpaceError(
                    f"CIF needs an event for each value, and {name} has more than"
                    f" {_MOST_VALUES:,}: convert the received value by an enum, or export as JSON"
                )
            for values in valuations(event):
                words = [_event_name(event), *(_value_name(value) for value in values)]
                name = self.names.fresh("_".join(words))
                paths = [p.path for p in event.parameters]
                yield _Occurrence(event, dict(zip(paths, values, strict=True)), name)

    # --- automata ----------------------------------------------------------------------------

    def _component(self, name: str) -> None:
        state = self.plant.variables[self.plant.variable_index[VariableKind.LOCATION, name]]
        self.lines += ["", f"plant automaton {self.context.automaton(name)}:"]
        self.lines += [f"  {line}" for line in self._variables(name)]
        for index, location in enumerate(state.values):
            marked = state.marked is None or index in state.marked
            self.lines.append(f"  location {self.context.location(name, str(location))}:")
            flags = ["initial;"] * (index == state.initial) + ["marked;"] * marked
            body = flags + [
                line
                for occurrence in self.occurrences
                for automaton in occurrence.event.automata
                if automaton.component == name
                for line in self._edges(occurrence, automaton, index)
            ]
            self.lines += [f"    {line}" for line in body]
        self.lines.append("end")

    def _variables(self, component: str) -> Iterator[str]:
        for state in self.plant.variables:
            if state.kind is VariableKind.DATA and state.name.split(".")[0] == component:
                variable = self.context.variables[state.name]
                shift = offset(variable.type)
                note = f" // minus {shift}" if shift else ""
                starts = [
                    initial(self.context, variable.type, state.values[number])
                    for number in state.start_indexes
                ]
                start = f"= {starts[0]}" if len(starts) == 1 else f"in {{{', '.join(starts)}}}"
                type_ = self.context.type(variable.type)
                name = self.context.own_variable(state.name)
                yield f"disc {type_} {name} {start};{note}"

    def _edges(
        self, occurrence: _Occurrence, automaton: LocalAutomaton, location: int
    ) -> Iterator[str]:
        """The edges of one event in one location, and the self-loop that keeps it possible."""
        guards: list[Expr] = []
        for edge, guard, before in self._ways(occurrence, automaton, location):
            conditions = self._alone(guard, before)
            updates = []
            for index, expr in self._updates(edge, occurrence):
                conditions += in_range(self.context, self._type(index), expr)
                updates.append(self._update(index, expr))
            yield self._edge(occurrence, automaton, location, edge, conditions, updates)
            guards.append(guard)
        if not automaton.blocking and TRUE not in guards:
            conditions = self._alone(TRUE, guards)
            when = f" when {' and '.join(conditions)}" if conditions else ""
            yield f"edge {occurrence.name}{when};"

    def _ways(
        self, occurrence: _Occurrence, automaton: LocalAutomaton, location: int
    ) -> Iterator[tuple[Edge, Expr, list[Expr]]]:
        """Edges with their guards, and the guards of earlier edges that may hold together with it.

        Of several edges the first is taken, where CIF may take any. Within one level guards never
        hold together; those of a state and of the whole automaton may.
        """
        found: list[tuple[Edge, Expr]] = []
        for edge in automaton.edges:
            guard = holds(edge.guard, occurrence.values) if edge.source == location else FALSE
            if guard == FALSE:
                continue
            before = [other for earlier, other in found if earlier.level != edge.level]
            if TRUE in before:
                return
            yield edge, guard, before
            found.append((edge, guard))

    def _alone(self, guard: Expr, before: list[Expr]) -> list[str]:
        """A guard, and that none of the guards before it holds, as conditions of CIF."""
        own = [] if guard == TRUE else [condition(self.context, guard)]
        return own + [f"not {condition(self.context, other, 9)}" for other in before]

    def _edge(
        self,
        occurrence: _Occurrence,
        automaton: LocalAutomaton,
        location: int,
        edge: Edge,
        conditions: list[str],
        updates: list[str],
    ) -> str:
        text = f"edge {occurrence.name}"
        if conditions:
            text += f" when {', '.join(conditions)}"
        if updates:
            text += f" do {', '.join(updates)}"
        if edge.target != location:
            names = self.plant.variables[automaton.variable].values
            target = self.context.location(automaton.component, str(names[edge.target]))
            text += f" goto {target}"
        return f"{text};"

    def _type(self, index: int) -> Type:
        return self.context.variables[self.plant.variables[index].name].type

    def _update(self, index: int, expr: Expr) -> str:
        name = self.plant.variables[index].name
        return (
            f"{self.context.own_variable(name)} := {update(self.context, self._type(index), expr)}"
        )

    def _updates(self, edge: Edge, occurrence: _Occurrence) -> Iterator[tuple[int, Expr]]:
        """Assignments with the value put in; those that read a missing element drop out."""
        for index, expr in edge.updates:
            component, _, variable = self.plant.variables[index].name.partition(".")
            kept = VariableRef(component, variable, self._type(index))
            value = assigned(expr, occurrence.values, kept)
            if value is not None:
                yield index, value

    def _phase(self, key: str) -> None:
        """The automaton of a communication itself."""
        index = self.plant.variable_index[VariableKind.PHASE, key]
        variable = self.plant.variables[index]
        steps = [o for o in self.occurrences if o.event.phase and o.event.phase.variable == index]
        self.lines += ["", f"plant automaton {self.context.phase(key)}:"]
        for number, location in enumerate(variable.values):
            self.lines.append(f"  location {location}:")
            marked = variable.marked is None or number in variable.marked
            self.lines += ["    initial;"] * (number == variable.initial)
            self.lines += ["    marked;"] * marked
            for occurrence in steps:
                phase = occurrence.event.phase
                assert phase is not None
                if number in phase.sources:
                    goto = f" goto {variable.values[phase.target]}"
                    there = "" if phase.target == number else goto
                    self.lines.append(f"    edge {occurrence.name}{there};")
        self.lines.append("end")

    def _messages(self) -> None:
        """Messages that no component reacts to: always possible, changing nothing."""
        free = [o.name for o in self.occurrences if o.event.phase is None and not o.event.automata]
        if free:
            name = self.names.fresh("Messages")
            self.lines += ["", f"plant automaton {name}:", "  location:"]
            self.lines += ["    initial;", "    marked;"]
            self.lines += [f"    edge {event};" for event in free]
            self.lines.append("end")

    # --- requirements ------------------------------------------------------------------------

    def _requirements(self) -> None:
        for requirement in self.plant.robot.requirements:
            self.lines += ["", f"// {' '.join(requirement.text.split())}"]
            self.lines += list(self._requirement(requirement))
        self._cancels()
        self._ranges()

    def _requirement(self, requirement: Requirement) -> Iterator[str]:
        text = condition(self.context, requirement.condition)
        if requirement.kind == "always":
            yield f"requirement invariant {text};"
        elif requirement.kind == "never":
            yield f"requirement invariant not ({text});"
        for occurrence in self.occurrences:
            event = occurrence.event
            if event.kind is EventKind.REQUEST and event.key in requirement.communications:
                if requirement.kind == "needs":
                    yield f"requirement invariant {occurrence.name} needs {text};"
                else:
                    yield f"requirement invariant {text} disables {occurrence.name};"

    def _cancels(self) -> None:
        cancels = [o for o in self.occurrences if o.event.kind is EventKind.CANCEL]
        if cancels:
            self.lines += [
                "",
                "// An action is cancelled only where one of its requirements fails.",
            ]
        for occurrence in cancels:
            requirement = occurrence.event.requirement
            text = condition(self.context, FALSE if requirement is None else requirement)
            self.lines.append(f"requirement invariant {occurrence.name} needs {text};")

    def _ranges(self) -> None:
        """States in which an uncontrollable event would leave a range."""
        found = [
            text
            for occurrence in self.occurrences
            if not occurrence.event.controllable
            for automaton in occurrence.event.automata
            for text in self._overflows(occurrence, automaton)
        ]
        if found:
            self.lines += [
                "",
                "// What cannot be prevented must not take a variable out of its range.",
            ]
            self.lines += list(dict.fromkeys(found))

    def _overflows(self, occurrence: _Occurrence, automaton: LocalAutomaton) -> Iterator[str]:
        places = self.plant.variables[automaton.variable].values
        here = []
        phase = occurrence.event.phase
        if phase is not None and len(phase.sources) == 1:
            name = self.plant.variables[phase.variable].values[phase.sources[0]]
            here = [f"{self.context.phase(occurrence.event.key)}.{name}"]
        for location, place in enumerate(places):
            for edge, guard, before in self._ways(occurrence, automaton, location):
                parts = [condition(self.context, StateRef(automaton.component, str(place))), *here]
                parts += [] if guard == TRUE else [condition(self.context, guard, 3)]
                parts += self._alone(TRUE, before)
                where = " and ".join(parts)
                for index, expr in self._updates(edge, occurrence):
                    inside = in_range(self.context, self._type(index), expr)
                    if inside:
                        yield f"requirement invariant {where} => {' and '.join(inside)};"

    # --- supervisor --------------------------------------------------------------------------

    def _supervisor(self, found: Sequence[Guard]) -> None:
        guards = {g.event.identity: g.expr for g in found}
        name = self.names.fresh("Supervisor")
        self.lines += ["", f"supervisor automaton {name}:", "  location:"]
        self.lines += ["    initial;", "    marked;"]
        for occurrence in self.occurrences:
            event = occurrence.event
            if event.controllable:
                guard = condition(self.context, guards[event.identity])
                self.lines.append(f"    edge {occurrence.name} when {guard};")
        self.lines.append("end")


def _event_name(event: Event) -> str:
    prefix = "c" if event.controllable else "u"
    name = without_index(event.name).replace(".", "_")
    if event.kind.of_component:
        return f"{prefix}_{name}_{event.kind.value}{event.index}"
    return f"{prefix}_{name}_{event.kind.value}"


def _value_name(value: Value | None) -> str:
    match value:
        case None:
            return "missing"
        case bool():
            return str(value).lower()
        case int():
            return f"m{-value}" if value < 0 else str(value)
    return str(value)
