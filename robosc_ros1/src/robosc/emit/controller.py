"""From a supervisor to what the template of ``controller.py`` places.

Everything that needs thought happens here: which component moves where, in which order, under which
condition; the template only writes it down.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import prod
from textwrap import indent, wrap

from robosc.emit.naming import Names, field_attribute, place
from robosc.emit.python import (
    Attributes,
    access,
    converted,
    converter_counts,
    in_controller,
    in_enum_rule,
    literal,
    operand,
    path_text,
    reads_array,
    within,
)
from robosc.ir.automaton import Axis, AxisKind, Edge, Event, Participant, Plant
from robosc.ir.expr import negation
from robosc.model.entities import (
    Communication,
    Data,
    DataObject,
    EventKind,
    Kind,
    Provide,
    Variable,
)
from robosc.model.expr import FALSE, TRUE, Binary, Expr, Literal, ValueRef, walk
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

__all__ = ["CommandView", "ControllerContext", "InputView", "controller_context"]

_SHORT = 60
"""A dict that is no longer than this stays on one line."""

SETTLE_LIMIT = 10_000
"""No settling takes more steps than this, whatever the product of the components' states is."""

SORTS = {
    Kind.INCOMING: "incoming",
    Kind.OUTGOING: "outgoing",
    Kind.SERVICE: "service",
    Kind.ACTION: "action",
}

# What the module imports or defines, and what the base class has.
_RESERVED = """
    Command Communication Controller Input Mismatch Requirement Tau Undefined annotations
    ROBOT SOURCE COMMUNICATIONS INPUTS COMMANDS TAUS REQUIREMENTS SETTLE_BOUND
    assigned components copy count_undefined divide given holds in_range kept message only_field
    optional self undefined value variables
"""


@dataclass(frozen=True)
class EnumView:
    """A conversion function; ``rules`` are (condition, value, place, may be undefined)."""

    function: str
    name: str
    place: str
    counts: bool
    rules: tuple[tuple[str, str, str, bool], ...]
    default: str


@dataclass(frozen=True)
class AttributeView:
    """An attribute of the controller with its initial value and a comment."""

    name: str
    initial: str
    comment: str


@dataclass(frozen=True)
class ComponentView:
    name: str
    place: str
    attributes: tuple[AttributeView, ...]


@dataclass(frozen=True)
class BranchView:
    """One way in which a component takes part: ``condition`` (empty: always) and its effect.

    ``effects`` are (attribute, right-hand side) to be evaluated over the old state.
    """

    condition: str
    place: str
    effects: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class ReactionView:
    """What an event does: the branches of each component, and the attributes that they set."""

    busy: str | None
    busy_before: bool
    busy_after: bool
    participants: tuple[tuple[str, tuple[BranchView, ...]], ...]
    attributes: tuple[str, ...]

    @property
    def does_something(self) -> bool:
        return bool(self.attributes) or self.busy_before != self.busy_after


@dataclass(frozen=True)
class InputView:
    """An uncontrollable event; ``read`` is the expression that takes its value from ``message``."""

    key: str
    kind: str
    name: str
    place: str
    description: str
    read: str | None
    read_lines: tuple[tuple[str, str], ...]
    reader: str | None
    applier: str
    reaction: ReactionView


@dataclass(frozen=True)
class GuardLine:
    """A part of a conjunction under the comments that say where it comes from."""

    comments: tuple[str, ...]
    text: str


@dataclass(frozen=True)
class ProvideView:
    """A provide statement; ``data`` are the lines of a dict, the first without indentation."""

    condition: str | None
    data: tuple[str, ...]
    place: str


@dataclass(frozen=True)
class CommandView:
    """A controllable event of a communication."""

    key: str
    kind: str
    name: str
    place: str
    description: str
    guard: str
    guard_notes: tuple[str, ...]
    guard_lines: tuple[GuardLine, ...]
    joiner: str
    """What stands between the guard's lines: "and" or "or"."""
    consent: str | None
    consent_conditions: tuple[str, ...]
    busy: str | None
    data: str | None
    provides: tuple[ProvideView, ...]
    applier: str | None
    reaction: ReactionView
    requirements: tuple[int, ...]
    reason: str
    """Python source: a string, or None."""


@dataclass(frozen=True)
class TauView:
    component: str
    number: int
    step: str
    place: str
    attribute: str
    moves: tuple[tuple[str, str], ...]
    """(condition, target) per way to take it."""


@dataclass(frozen=True)
class RequirementView:
    text: str
    comments: tuple[str, ...]
    place: str
    method: str
    condition: str

    @property
    def literal(self) -> str:
        return literal(self.text)


@dataclass(frozen=True)
class ControllerContext:
    """All that ``common/controller.py.jinja`` sees."""

    robot: str
    source: str
    class_name: str
    settle_bound: int
    enums: tuple[EnumView, ...]
    components: tuple[ComponentView, ...]
    phases: tuple[AttributeView, ...]
    locations: tuple[tuple[str, str], ...]
    variables: tuple[tuple[str, str], ...]
    communications: tuple[tuple[str, str, str], ...]
    requirements: tuple[RequirementView, ...]
    inputs: tuple[InputView, ...]
    commands: tuple[CommandView, ...]
    taus: tuple[TauView, ...]
    tables: tuple[str, ...] = ()
    """What the module imports of ``_runtime.model``, and in ``helpers`` of ``_runtime.values``."""
    helpers: tuple[str, ...] = ()


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
    used = [n for n in ("divide", "given", "in_range", "only_field", "optional") if f"{n}(" in text]
    raises = any(e.reaction.busy_before for e in (*context.inputs, *context.commands))
    return ("Mismatch", *used) if raises else tuple(used)


class _Builder:
    """Names everything once, then describes it in model order."""

    def __init__(self, supervisor: Supervisor) -> None:
        self.supervisor = supervisor
        self.plant: Plant = supervisor.plant
        self.robot = supervisor.plant.robot
        self.names = Names(_RESERVED.split())
        self.class_name = self.names.take(f"{self.robot.name}Controller")
        self.enums = _enums(self.robot.communications.values())
        functions = {e: self.names.take(snake_case(e.name)) for e in self.enums}
        self.variables: dict[str, Variable] = {
            v.key: v for c in self.robot.components if c.behaviour for v in c.behaviour.variables
        }
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

    def _word(self, key: str) -> str:
        """A communication as a part of an identifier."""
        return snake_case(self.robot.display_names[key].replace(".", "_")) or "n"

    def _text(self, expr: Expr) -> str:
        return in_controller(expr, self.attributes)

    def _operand(self, expr: Expr) -> str:
        """The text of a condition as an operand of ``and``."""
        return operand(expr, self._text(expr))

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
            settle_bound=_settle_bound(self.supervisor),
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
                self._text(holds),
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
            reaction=self._reaction(event),
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
        reaction = self._reaction(event)
        consent = tuple(self._consent(event))
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
            consent=self.names.take(f"accepts_{kind}_of_{word}") if consent else None,
            consent_conditions=consent,
            busy=self.attributes.phases.get(event.key),
            data=self.names.take(f"data_for_{word}") if provides else None,
            provides=provides,
            applier=self.names.take(f"{kind}_{word}") if reaction.does_something else None,
            reaction=reaction,
            requirements=event.requirements,
            reason="None" if reason is None else literal(reason),
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
                lines.setdefault(self._operand(holds), []).append(text)
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
            return _comments(notes), "and", tuple(GuardLine((), self._operand(p)) for p in parts)
        parts = _chain(expr, "or")
        return _comments(notes), "or", tuple(GuardLine((), self._text(p)) for p in parts)

    def _provide(self, provide: Provide) -> ProvideView:
        communication = self.robot.communications[provide.communication]
        text = self._data(provide.data, communication.request)
        if not isinstance(provide.data, DataObject):
            field = communication.binding.request_field
            text = f"{{{literal(field or '')}: {text}}}"
        condition = None if provide.condition is None else self._text(provide.condition)
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
            return f"float({self._text(data)})"
        return self._text(data)

    def _tau(self, event: Event, guard: Guard | None) -> TauView:
        participant = event.participants[0]
        axis = self.plant.axes[participant.axis]
        moves = []
        for edges in _alike(participant.edges):
            edge = edges[0]
            moved = [e for e in edges if e.source != e.target]  # others would change nothing
            if not moved:
                continue
            parts = [self._location_test(axis, [e.source for e in moved])]
            for condition in (edge.guard, None if guard is None else guard.expr):
                if condition is not None and condition != TRUE:
                    parts.append(self._operand(condition))
            text = " and ".join(part for part in parts if part) or "True"
            moves.append((text, str(axis.values[edge.target])))
        return TauView(
            event.name,
            event.index,
            self.names.take(f"step_{event.index}_of_{snake_case(event.key)}"),
            place(event.span),
            self.attributes.locations[event.key],
            tuple(moves),
        )

    # --- reactions -----------------------------------------------------------------------------

    def _reaction(self, event: Event) -> ReactionView:
        participants = []
        changed: dict[str, None] = {}
        for participant in event.participants:
            branches = []
            for edges in _alike(participant.edges):
                branch = self._branch(event, participant, edges)
                changed.update(dict.fromkeys(name for name, _ in branch.effects))
                branches.append(branch)
            if any(branch.effects for branch in branches):
                participants.append((participant.component, tuple(branches)))
        phase = event.phase
        return ReactionView(
            busy=None if phase is None else self.attributes.phases[event.key],
            busy_before=phase is not None and phase.source == 1,
            busy_after=phase is not None and phase.target == 1,
            participants=tuple(participants),
            attributes=tuple(changed),
        )

    def _branch(self, event: Event, participant: Participant, edges: list[Edge]) -> BranchView:
        edge = edges[0]
        effects = []
        for index, expr in edge.updates:
            variable = self.variables[self.plant.axes[index].name]
            effects.append(self._effect(event, variable, expr))
        for assignment in edge.data:
            variable = self.variables[f"{participant.component}.{assignment.variable}"]
            effects.append(self._effect(event, variable, assignment.value))
        axis = self.plant.axes[participant.axis]
        if any(e.source != e.target for e in edges):
            target = literal(axis.values[edge.target])
            effects.append((self.attributes.locations[participant.component], target))
        return BranchView(
            self._edge_condition(axis, edges, participant), place(edge.span), tuple(effects)
        )

    def _edge_condition(self, axis: Axis, edges: list[Edge], participant: Participant) -> str:
        guard = edges[0].guard
        parts = [self._location_test(axis, [e.source for e in edges])]
        if guard is not None:
            text = self._text(guard)
            if reads_array(guard):
                text = f"self.holds(lambda: {text}, {literal(place(edges[0].span))})"
                parts.append(text)
            else:
                parts.append(operand(guard, text))
        return " and ".join(part for part in parts if part)

    def _location_test(self, axis: Axis, sources: Iterable[int]) -> str:
        """Whether the component is in one of the states; empty if it always is."""
        states = [str(axis.values[source]) for source in sources]
        attribute = f"self.{self.attributes.locations[axis.name]}"
        if len(states) == axis.size:
            return ""
        if len(states) == 1:
            return f"{attribute} == {literal(states[0])}"
        return f"{attribute} in ({', '.join(literal(s) for s in states)})"

    def _effect(self, event: Event, variable: Variable, expr: Expr) -> tuple[str, str]:
        attribute = self.attributes.variables[variable.key]
        text = self._text(expr)
        if isinstance(variable.type, DoubleType) and isinstance(expr.type, IntegerType):
            text = f"float({text})"
        where = literal(place(expr.span)) if expr.span is not None else '""'
        if not within(expr, variable.type):
            assert isinstance(variable.type, IntegerType)
            assert variable.type.bounds is not None
            low, high = variable.type.bounds
            if not variable.in_state:
                text = f"self.kept({text}, {low}, {high}, self.{attribute}, {where})"
            elif not event.controllable:
                text = f"in_range({text}, {low}, {high}, {literal(variable.key)})"
        if reads_array(expr):
            text = f"self.assigned(lambda: {text}, self.{attribute}, {where})"
        return attribute, text

    def _consent(self, event: Event) -> Iterator[str]:
        """Conditions under which the plant can do a controllable event, its phase apart."""
        for participant in event.participants:
            axis = self.plant.axes[participant.axis]
            ways = []
            free = True
            for edges in _alike(participant.edges):
                ranges = list(self._ranges(edges[0]))
                where = self._edge_condition(axis, edges, participant)
                free = free and not ranges
                if participant.blocking:
                    ways.append(" and ".join(part for part in (where, *ranges) if part))
                elif ranges:
                    inside = " and ".join(ranges)
                    yield f"(not ({where}) or {inside})" if where else inside
            if not participant.blocking or (free and self._always(participant, axis)):
                continue
            yield ways[0] if len(ways) == 1 else f"({' or '.join(ways)})" if ways else "False"

    def _always(self, participant: Participant, axis: Axis) -> bool:
        open_edges = {e.source for e in participant.edges if e.guard is None}
        return len(open_edges) == axis.size

    def _ranges(self, edge: Edge) -> Iterator[str]:
        for index, expr in edge.updates:
            variable = self.variables[self.plant.axes[index].name]
            if not within(expr, variable.type):
                assert isinstance(variable.type, IntegerType)
                assert variable.type.bounds is not None
                low, high = variable.type.bounds
                yield f"{low} <= {self._text(expr)} <= {high}"


def _alike(edges: Iterable[Edge]) -> list[list[Edge]]:
    """The edges of one transition in one group: on the automaton level there is one per state."""
    groups: dict[tuple[int, int, int], list[Edge]] = {}
    for edge in edges:
        span = edge.span
        groups.setdefault((id(span.source), span.start, span.end), []).append(edge)
    return list(groups.values())


def _comments(texts: Iterable[str]) -> tuple[str, ...]:
    """Comments in lines of bearable length."""
    return tuple(
        line for text in texts for line in wrap(text.strip(), 88, subsequent_indent="    ")
    )


def _value_parts(event: Event) -> list[ValueRef]:
    """The parts of the value that any transition reads, data-only variables included."""
    found: dict[tuple[str | int, ...], ValueRef] = {}
    for participant in event.participants:
        for edge in participant.edges:
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


def _settle_bound(supervisor: Supervisor) -> int:
    """Steps that settling can take without coming back to where it was.

    Synthesis knows the exact number unless the system is large or settling has no end. Else: own
    steps change nothing but their components' states, so there are no more situations than
    combinations of those, nor than reachable states.
    """
    if supervisor.settle_bound is not None:
        return max(1, supervisor.settle_bound)
    plant = supervisor.plant
    axes = {p.axis for e in plant.events if e.kind is EventKind.TAU for p in e.participants}
    combinations = prod(
        axis.size
        for index, axis in enumerate(plant.axes)
        if index in axes and axis.kind is AxisKind.LOCATION
    )
    return max(1, min(combinations, supervisor.controlled_states or combinations, SETTLE_LIMIT))
