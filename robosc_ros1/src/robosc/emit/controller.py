"""From a supervisor to what the template of ``controller.py`` places.

Everything that needs thought happens here: which component moves where, in which order, under which
condition; the template only writes it down.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import prod
from textwrap import indent, wrap

from robosc.emit.naming import PythonNames, field_attribute, place
from robosc.emit.python import (
    Attributes,
    access,
    converted,
    converter_counts,
    in_enum_rule,
    literal,
    reads_array,
)
from robosc.emit.reactions import Reactions, Spelling, alike
from robosc.emit.views import (
    AttributeView,
    CommandView,
    ComponentView,
    ControllerContext,
    EnumView,
    GuardLine,
    InputView,
    ProvideView,
    RequirementView,
    TauView,
)
from robosc.ir.automaton import Event, Plant, VariableKind
from robosc.ir.expr import may_be_huge, negation
from robosc.model.entities import (
    Communication,
    Data,
    DataObject,
    EventKind,
    Kind,
    Provide,
)
from robosc.model.expr import FALSE, TRUE, Binary, Expr, Literal, ValueRef, path_text, walk
from robosc.model.types import (
    ArrayType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    Type,
)
from robosc.names import snake_case
from robosc.supervisor import Guard, Supervisor

__all__ = ["SORTS", "ControllerContext", "controller_context"]

_SHORT = 60
"""A dict that is no longer than this stays on one line."""

STEP_LIMIT = 10_000
"""No run to completion takes more steps, whatever the product of the components' states is."""

SORTS = {
    Kind.INCOMING: "incoming",
    Kind.OUTGOING: "outgoing",
    Kind.SERVICE: "service",
    Kind.ACTION: "action",
}

# What the module imports or defines, and what the base class has.
_RESERVED = """
    Command Communication Controller Input Mismatch Requirement Tau Undefined annotations
    ROBOT SOURCE COMMUNICATIONS INPUTS COMMANDS TAUS REQUIREMENTS STEP_BOUND
    assigned components copy count_undefined divide given holds in_range kept message only_field
    optional self undefined value variables widen
"""


def controller_context(supervisor: Supervisor, robot_file: str) -> ControllerContext:
    context = _Builder(supervisor).build(robot_file)
    return replace(context, tables=_tables(context), helpers=_helpers(context))


def _tables(context: ControllerContext) -> tuple[str, ...]:
    used = {
        "Command": context.commands,
        "Communication": context.communications,
        "Input": context.inputs,
        "Requirement": context.requirements,
        "Tau": context.taus,
    }
    return tuple(sorted(["Controller", *(name for name, entries in used.items() if entries)]))


def _helpers(context: ControllerContext) -> tuple[str, ...]:
    """Those that some expression calls: all expressions are text in the context."""
    text = repr(context)
    names = ("divide", "given", "in_range", "only_field", "optional", "widen")
    used = [name for name in names if f"{name}(" in text]
    reactions = [i.reaction for i in context.inputs] + [c.reaction for c in context.commands]
    raises = any(reaction.busy_before for reaction in reactions)
    return ("Mismatch", *used) if raises else tuple(used)


class _Builder:
    """Names everything once, then describes it in model order."""

    def __init__(self, supervisor: Supervisor) -> None:
        self.supervisor = supervisor
        self.plant: Plant = supervisor.plant
        self.robot = supervisor.plant.robot
        self.names = PythonNames(_RESERVED.split())
        self.class_name = self.names.take(f"{self.robot.name}Controller")
        self.enums = _enums(self.robot.communications.values())
        functions = {e: self.names.take(snake_case(e.name)) for e in self.enums}
        locations: dict[str, str] = {}
        variables: dict[str, str] = {}
        for component in self.robot.components:
            if component.behaviour is None:
                continue
            locations[component.name] = self.names.take(snake_case(component.name))
            for variable in component.behaviour.variables:
                wish = f"{snake_case(component.name)}_{snake_case(variable.name)}"
                variables[variable.key] = self.names.take(wish)
        phases = {
            c.key: self.names.take(f"{self._word(c.key)}_busy")
            for c in self.robot.communications.values()
            if c.has_phase
        }
        self.attributes = Attributes(locations, variables, phases, functions)
        self.spelling = Spelling(self.attributes)
        self.reactions = Reactions(self.plant, self.spelling)

    def _word(self, key: str) -> str:
        """A communication as a part of an identifier."""
        return snake_case(self.robot.display_names[key].replace(".", "_")) or "n"

    def build(self, robot_file: str) -> ControllerContext:
        guards = {id(g.event): g for g in self.supervisor.guards}
        by_event = {g.event: g for g in self.supervisor.guards}
        inputs = []
        commands = []
        taus = []
        requirements = tuple(self._requirements())
        for event in self.plant.events:
            guard = guards.get(id(event)) or by_event.get(event)
            if event.kind is EventKind.TAU:
                taus.append(self._tau(event, guard))
            elif event.controllable:
                commands.append(self._command(event, guard))
            else:
                inputs.append(self._input(event))
        context = ControllerContext(
            robot=self.robot.name,
            source=robot_file,
            class_name=self.class_name,
            step_bound=_step_bound(self.supervisor),
            enums=tuple(self._enum_view(e) for e in self.enums),
            components=tuple(self._components()),
            phases=tuple(self._phase_views()),
            locations=tuple(self.attributes.locations.items()),
            variables=tuple(self.attributes.variables.items()),
            communications=tuple(
                (c.key, self.robot.display_names[c.key], SORTS[c.kind])
                for c in self.robot.communications.values()
            ),
            requirements=requirements,
            inputs=tuple(inputs),
            commands=tuple(commands),
            taus=tuple(t for t in taus if t.moves),
        )
        return context

    # --- what there is -----------------------------------------------------------------------

    def _enum_view(self, enum: EnumType) -> EnumView:
        rules = tuple(
            (
                in_enum_rule(rule.condition, self.attributes.enums),
                literal(rule.value),
                "" if rule.condition.span is None else place(rule.condition.span),
                reads_array(rule.condition),
            )
            for rule in enum.rules
        )
        return EnumView(
            self.attributes.enums[enum],
            enum.name,
            enum.origin,
            converter_counts(enum),
            rules,
            literal(enum.default),
        )

    def _components(self) -> Iterator[ComponentView]:
        for component in self.robot.components:
            if component.behaviour is None:
                continue
            states = component.behaviour.states
            initial = next(s.name for s in states if s.initial)
            attributes = [
                AttributeView(
                    self.attributes.locations[component.name],
                    literal(initial),
                    "state: " + ", ".join(s.name for s in states),
                )
            ]
            for variable in component.behaviour.variables:
                what = "" if variable.in_state else ", only for data that is sent"
                attributes.append(
                    AttributeView(
                        self.attributes.variables[variable.key],
                        literal(variable.initial),
                        f"variable {variable.name}: {variable.type}{what}",
                    )
                )
            yield ComponentView(component.name, place(component.span), tuple(attributes))

    def _phase_views(self) -> Iterator[AttributeView]:
        for key, attribute in self.attributes.phases.items():
            yield AttributeView(attribute, "False", f"{self.robot.display_names[key]} is under way")

    def _requirements(self) -> Iterator[RequirementView]:
        for number, requirement in enumerate(self.robot.requirements, 1):
            holds = requirement.condition
            if requirement.kind in ("disables", "never"):
                holds = negation(holds)
            where = place(requirement.span)
            yield RequirementView(
                requirement.text,
                _comments([f"{requirement.text}  ({where})"]),
                where,
                self.names.take(f"requirement_{number}"),
                self.spelling.text(holds),
            )

    # --- events --------------------------------------------------------------------------------

    def _description(self, event: Event) -> str:
        communication = self.robot.communications[event.key]
        return f"{event.kind.value} of the {communication.kind.value} {communication.name}"

    def _input(self, event: Event) -> InputView:
        communication = self.robot.communications[event.key]
        word = self._word(event.key)
        read, lines = self._reading(event, communication)
        reader = None
        if read is not None:
            reader = self.names.take(f"read_{event.kind.value}_of_{word}")
        return InputView(
            key=event.key,
            kind=event.kind.value,
            name=event.name,
            place=place(event.span),
            description=self._description(event),
            read=read,
            read_lines=lines,
            reader=reader,
            applier=self.names.take(f"on_{event.kind.value}_of_{word}"),
            reaction=self.reactions.reaction(event),
        )

    def _reading(
        self, event: Event, communication: Communication
    ) -> tuple[str | None, tuple[tuple[str, str], ...]]:
        """How the event's value is taken from ``message``: one expression, or entries by path."""
        type_ = communication.value_type(event.kind)
        enums = self.attributes.enums
        counter = "self.count_undefined"
        if isinstance(type_, NoneType):
            return None, ()
        carried = type_.source if isinstance(type_, EnumType) else type_
        if isinstance(carried, ObjectType) and isinstance(type_, ObjectType):
            lines = []
            for reference in _value_parts(event):
                text = converted(reference.type, access("message", reference.path), enums, counter)
                if any(isinstance(part, int) for part in reference.path):
                    text = f"optional(lambda: {text})"
                lines.append((literal(path_text(reference.path)), text))
            return ("dict" if lines else None), tuple(lines)
        root = "message"
        if not isinstance(carried, ObjectType):
            name = (
                communication.binding.feedback_field
                if event.kind is EventKind.FEEDBACK
                else communication.binding.response_field
            )
            root = (
                f"message.{field_attribute(name)}"
                if name is not None
                else "getattr(message, only_field(message))"
            )
        return converted(type_, root, enums, counter), ()

    def _command(self, event: Event, guard: Guard | None) -> CommandView:
        word = self._word(event.key)
        kind = event.kind.value
        reaction = self.reactions.reaction(event)
        synchronisation = tuple(self.reactions.synchronisation(event))
        provides = tuple(
            self._provide(p)
            for p in self.robot.provides
            if p.communication == event.key and event.kind is EventKind.REQUEST
        )
        notes, joiner, lines = self._guard(event, guard)
        reason = None
        if guard is not None and guard.status != "as required":
            reason = self._reason(event)
        return CommandView(
            key=event.key,
            kind=kind,
            name=event.name,
            place=place(event.span),
            description=self._description(event),
            guard=self.names.take(f"can_{kind}_{word}"),
            guard_notes=notes,
            guard_lines=lines,
            joiner=joiner,
            synchronisation=self.names.take(f"synchronises_{kind}_of_{word}")
            if synchronisation
            else None,
            synchronisation_conditions=synchronisation,
            busy=self.attributes.phases.get(event.key),
            data=self.names.take(f"data_for_{word}") if provides else None,
            provides=provides,
            applier=self.names.take(f"{kind}_{word}") if reaction.does_something else None,
            reaction=reaction,
            requirements=event.requirements,
            reason="None" if reason is None else literal(reason),
            partners=tuple(p.component for p in event.automata) if synchronisation else (),
        )

    def _reason(self, event: Event) -> str | None:
        for explanation in self.supervisor.explanations:
            if explanation.event == event:
                return explanation.reason
        return None

    def _guard(
        self, event: Event, guard: Guard | None
    ) -> tuple[tuple[str, ...], str, tuple[GuardLine, ...]]:
        """Comments above the guard, and its parts with the requirement that each comes from."""
        expr = TRUE if guard is None else guard.expr
        status = "as required" if guard is None else guard.status
        requirements = [self.robot.requirements[i] for i in event.requirements]
        texts = [f"{r.text}  ({place(r.span)})" for r in requirements]
        if event.kind is EventKind.REQUEST and status == "as required" and requirements:
            lines: dict[str, list[str]] = {}
            for requirement, text in zip(requirements, texts, strict=True):
                holds = requirement.condition
                if requirement.kind == "disables":
                    holds = negation(holds)
                lines.setdefault(self.spelling.operand(holds), []).append(text)
            return (), "and", tuple(GuardLine(_comments(c), t) for t, c in lines.items())
        notes = list(texts)
        if event.kind is EventKind.CANCEL:
            if not requirements:
                notes.append("No requirement speaks of this action: it is never cancelled.")
            else:
                notes.insert(0, "Allowed where one of these is violated:")
        if status == "restricted":
            notes.append("Restricted further by synthesis: " + (self._reason(event) or ""))
        elif status == "never" and expr == FALSE and event.kind is EventKind.REQUEST:
            notes.append("Never allowed: " + (self._reason(event) or "found by synthesis"))
        parts = _chain(expr, "and")
        if len(parts) > 1:
            return (
                _comments(notes),
                "and",
                tuple(GuardLine((), self.spelling.operand(p)) for p in parts),
            )
        parts = _chain(expr, "or")
        return _comments(notes), "or", tuple(GuardLine((), self.spelling.text(p)) for p in parts)

    def _provide(self, provide: Provide) -> ProvideView:
        communication = self.robot.communications[provide.communication]
        text = self._data(provide.data, communication.request)
        if not isinstance(provide.data, DataObject):
            field = communication.binding.request_field
            text = f"{{{literal(field or '')}: {text}}}"
        condition = None if provide.condition is None else self.spelling.text(provide.condition)
        return ProvideView(condition, tuple(text.split("\n")), place(provide.span))

    def _data(self, data: Data, type_: Type) -> str:
        if isinstance(data, DataObject):
            parts = [
                f"{literal(name)}: {self._data(value, _property(type_, name))}"
                for name, value in data.fields
            ]
            short = "{" + ", ".join(parts) + "}"
            if len(short) <= _SHORT and "\n" not in short:
                return short
            lines = "".join(f"{part},\n" for part in parts)
            return "{\n" + indent(lines, "    ") + "}"
        if isinstance(type_, DoubleType) and isinstance(data.type, IntegerType):
            # A message's floating point field takes a float, not an integer.
            if isinstance(data, Literal) and isinstance(data.value, int):
                return repr(float(data.value))
            widen = "widen" if may_be_huge(data) else "float"
            return f"{widen}({self.spelling.text(data)})"
        return self.spelling.text(data)

    def _tau(self, event: Event, guard: Guard | None) -> TauView:
        automaton = event.automata[0]
        variable = self.plant.variables[automaton.variable]
        moves = []
        for edges in alike(automaton.edges):
            edge = edges[0]
            moved = [e for e in edges if e.source != e.target]  # others would change nothing
            if not moved:
                continue
            parts = [self.reactions.location_test(variable, [e.source for e in moved])]
            for condition in (edge.guard, None if guard is None else guard.expr):
                if condition is not None and condition != TRUE:
                    parts.append(self.spelling.operand(condition))
            text = " and ".join(part for part in parts if part) or "True"
            moves.append((text, str(variable.values[edge.target])))
        return TauView(
            event.name,
            event.index,
            self.names.take(f"step_{event.index}_of_{snake_case(event.key)}"),
            place(event.span),
            self.attributes.locations[event.key],
            tuple(moves),
        )


def _comments(texts: Iterable[str]) -> tuple[str, ...]:
    """Comments in lines of bearable length."""
    return tuple(
        line for text in texts for line in wrap(text.strip(), 88, subsequent_indent="    ")
    )


def _value_parts(event: Event) -> list[ValueRef]:
    """The parts of the value that any transition reads, data-only variables included."""
    found: dict[tuple[str | int, ...], ValueRef] = {}
    for automaton in event.automata:
        for edge in automaton.edges:
            readers = [expr for _, expr in edge.updates] + [a.value for a in edge.data]
            if edge.guard is not None:
                readers.append(edge.guard)
            for expr in readers:
                for part in walk(expr):
                    if isinstance(part, ValueRef):
                        found.setdefault(part.path, part)
    return list(found.values())


def _chain(expr: Expr, operator: str) -> list[Expr]:
    """The operands of a chain of ``and`` or ``or``; the expression alone if it is none."""
    if isinstance(expr, Binary) and expr.operator == operator:
        return [*_chain(expr.left, operator), *_chain(expr.right, operator)]
    return [expr]


def _property(type_: Type, name: str) -> Type:
    found = type_.property(name) if isinstance(type_, ObjectType) else None
    return NoneType() if found is None else found


def _enums(communications: Iterable[Communication]) -> list[EnumType]:
    """All enums that convert something, those that others use first."""
    found: dict[EnumType, None] = {}

    def visit(type_: Type) -> None:
        match type_:
            case EnumType():
                visit(type_.source)
                found.setdefault(type_, None)
            case ObjectType():
                for _, inner in type_.properties:
                    visit(inner)
            case ArrayType():
                visit(type_.element)

    for communication in communications:
        visit(communication.response)
        visit(communication.feedback)
    return list(found)


def _step_bound(supervisor: Supervisor) -> int:
    """Internal transitions that can follow one another without coming back to a state.

    Synthesis knows the exact number unless the system is large or they have no end. Else: own
    steps change nothing but their components' states, so there are no more situations than
    combinations of those, nor than reachable states.
    """
    if supervisor.step_bound is not None:
        return max(1, supervisor.step_bound)
    plant = supervisor.plant
    variables = {p.variable for e in plant.events if e.kind is EventKind.TAU for p in e.automata}
    combinations = prod(
        variable.size
        for index, variable in enumerate(plant.variables)
        if index in variables and variable.kind is VariableKind.LOCATION
    )
    return max(1, min(combinations, supervisor.controlled_states or combinations, STEP_LIMIT))
