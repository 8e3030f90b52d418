"""From a supervisor to what the template of ``controller.py`` places.

Everything that needs thought happens here: which component moves where, in which order, under which
condition; the template only writes it down.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace
from math import prod

from robosc import dotted, limits
from robosc.emit.controller import (
    guard_methods,
    messages,
    python,
    python_literals,
    reactions,
    template_data,
)
from robosc.emit.controller.attribute_names import attributes_of, counting_entries, word_of
from robosc.emit.controller.naming import PythonNames
from robosc.emit.controller.python_literals import literal
from robosc.emit.controller.template_data import LastingView
from robosc.emit.package import config, rendering
from robosc.expr import traversal, tree, types
from robosc.language import events
from robosc.language.events import EventKind
from robosc.language.functions import HELPERS
from robosc.model import entities
from robosc.names import snake_case
from robosc.plant.automaton import Event, Plant
from robosc.plant.conjuncts import conjuncts
from robosc.plant.part_names import NamedExpr
from robosc.runtime.core import model
from robosc.supervisor import Guard, Supervisor

# Conditions that must have held for some time, as a controller follows them.


def lasting_views(robot: entities.Robot, attributes: python.Attributes) -> tuple[LastingView, ...]:
    """The lasting conditions of a robot, in model order."""
    return tuple(
        LastingView(
            one.name,
            one.span.place,
            attributes.lasting[one.name],
            attributes.text(one.condition),
            attributes.locations[one.name],
            attributes.entries[one.name],
        )
        for one in robot.lasting
    )


# Tables and bounds of a generated controller, and what it imports.


def _helpers(module: str) -> set[str]:
    return {n for n, function in HELPERS.items() if function.__module__.endswith(f".{module}")}


_OF_RUNTIME = {
    "core.functions": _helpers("functions"),
    "core.internal_transitions": {"Tau"},
    "core.model": {
        "Command", "Communication", "Controller", "Input", "Parameter", "Requirement",
    },
    "core.operations": {
        "copied", "given", "in_range", "now", "optional", *_helpers("operations"),
    },
    "core.timers": {"After"},
    "core.values": {"BrokenAssumption", "Mismatch", "only_field", "record", *_helpers("values")},
}  # fmt: skip
"""What a controller may import, by module of the runtime."""


def imports_of(source: str) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The names that the source of a controller uses of the runtime, by module."""
    used = {node.id for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Name)}
    found = {module: used & names for module, names in _OF_RUNTIME.items()}
    return tuple((module, tuple(sorted(names))) for module, names in found.items() if names)


def bound_of_steps(supervisor: Supervisor) -> int:
    """Internal transitions that can follow one another without coming back to a state.

    Synthesis knows the exact number unless the system is large or they have no end. Else there are
    no more situations than combinations of what they change, nor than reachable states.
    """
    if supervisor.step_bound is not None:
        return max(1, supervisor.step_bound)
    plant = supervisor.plant
    written = {v for e in plant.events if e.kind is EventKind.TAU for v in e.writes}
    combinations = prod(plant.sizes(written))
    return max(1, min(combinations, supervisor.controlled_states or combinations, limits.STEPS))


def parameter_row(parameter: model.Parameter) -> str:
    """The entry of a parameter in the table, as arguments."""
    parts = [literal(parameter.name), literal(parameter.type), literal(parameter.default)]
    parts.append(literal(parameter.meaning))
    if parameter.choices:
        parts.append(f"choices={literal(tuple(parameter.choices))}")
    if parameter.shape is not None:
        parts.append(f"shape={literal(parameter.shape)}")
    for name in ("minimum", "maximum"):
        bound = getattr(parameter, name)
        parts += [] if bound is None else [f"{name}={bound!r}"]
    parts += ["required=True"] if parameter.required else []
    return ", ".join([*parts, f"attribute={literal(parameter.attribute)}"])


# What comments and docstrings of a generated controller say about events and phases.


PERMITTED = {
    EventKind.REQUEST: "requested",
    EventKind.CANCEL: "cancelled",
    EventKind.ANSWER: "answered",
    EventKind.REFUSAL: "answered with an error",
    EventKind.PROGRESS: "reported on",
}
"""What a command may be done with."""

PHASES = {
    "busy": "is under way",
    "cancelling": "was cancelled, and has not ended",
    "ending": "was cancelled, and is not answered yet",
    "fresh": "came within its timeout",
    "silent": "came, but not within its timeout",
    "heard": "has come",
}
"""What it means that a communication is in a phase."""


def described(kind: EventKind, communication: entities.Communication) -> str:
    """Return what an event is: ``response of the service call``."""
    if kind is EventKind.CANCELLED:
        return f"end of the cancelled action {communication.name}"
    return f"{kind.word} of the {communication.kind.value} {communication.name}"


_RESERVED = frozenset(dir(model.Controller)).union(
    model.Controller.__annotations__, HELPERS, *_OF_RUNTIME.values(),
    ("annotations", "message", "self", "value"),
)  # fmt: skip
"""What the base class has, the module imports, and methods call their arguments."""


def controller_context(supervisor: Supervisor, robot_file: str) -> template_data.ControllerContext:
    context = _Builder(supervisor).build(robot_file)
    source = rendering.instantiated("common/node/controller.py.jinja", context)
    return replace(context, imports=imports_of(source))


class _Builder:
    """Names everything once, then describes it in model order."""

    def __init__(self, supervisor: Supervisor) -> None:
        self.supervisor = supervisor
        self.plant: Plant = supervisor.plant
        self.robot = supervisor.plant.robot
        self.names = PythonNames(_RESERVED)
        self.class_name = self.names.take(f"{self.robot.name}Controller")
        self.enums = messages.converting_enums(self.robot)
        self.part_names = supervisor.part_names
        self.attributes = attributes_of(self.robot, self.enums, self.part_names, self.names)
        self.reactions = reactions.Reactions(self.plant, self.attributes)
        self.requirements = tuple(map(self._requirement, range(len(self.robot.requirements))))
        self.guards = guard_methods.GuardTexts(supervisor, self.attributes, self.requirements)
        self.shown: list[tree.Expr] = []
        """The conditions in guards, with the names of their parts."""

    def _word(self, key: str) -> str:
        return word_of(key, self.robot)

    def build(self, robot_file: str) -> template_data.ControllerContext:
        guards = {g.event.identity: g for g in guard_methods.whole_guards(self.supervisor)}
        inputs = []
        commands = []
        taus = []
        afters = []
        for event in dict.fromkeys(e.whole or e for e in self.plant.events):
            if event.kind is events.EventKind.TAU:
                taus.append(self._tau(guards[event.identity]))
            elif event.kind is events.EventKind.AFTER:
                afters.append(self._after(event))
            elif event.controllable:
                commands.append(self._command(guards[event.identity]))
            else:
                inputs.append(self._input(event))
        return template_data.ControllerContext(
            robot=self.robot.name,
            source=robot_file,
            class_name=self.class_name,
            step_bound=bound_of_steps(self.supervisor),
            stages=self.robot.stages,
            enums=tuple(messages.enum_view(e, self.attributes) for e in self.enums),
            components=tuple(self._components()),
            phases=tuple(self._phase_views()),
            locations=tuple(self.attributes.locations.items()),
            variables=tuple(self.attributes.variables.items()),
            communications=tuple(map(self._row, config.declared_communications(self.robot))),
            requirements=self.requirements,
            inputs=tuple(inputs),
            commands=self._with_preferences(commands),
            refusals=tuple(messages.refusals(self.robot, self.attributes, self.names)),
            taus=tuple(t for t in taus if t.body),
            afters=tuple(afters),
            lasting=lasting_views(self.robot, self.attributes),
            guard_parts=tuple(map(self._part, self.part_names.used(self.shown))),
            persistent=tuple(
                (key, self.attributes.variables[key], repr(types.domain(variable.type)))
                for key, variable in self.robot.persistent.items()
            ),
            parameters=tuple(
                template_data.AttributeView(
                    self.attributes.parameters[p.key],
                    python.readable(p.default),
                    f"{p.key}: {p.type}",
                )
                for p in self.robot.parameters
            ),
            parameter_rows=tuple(
                map(
                    parameter_row,
                    config.declared_parameters(self.robot, self.attributes.parameters),
                )
            ),
        )

    # --- what there is -----------------------------------------------------------------------

    def _row(self, declared: model.Communication) -> str:
        """The entry of a communication in the table, as arguments."""
        parts = [python.literal(part) for part in (declared.key, declared.name, declared.sort)]
        phases = self.robot.communications[declared.key].phases
        if phases is not None:
            flags = tuple(self.attributes.phases[declared.key, phase] for phase in phases.active)
            for field, names in (("flags", flags), ("phases", phases.names)):
                parts.append(f"{field}={python_literals.literal(names)}")
        more = [(field, getattr(declared, field)) for field in config.ATTRIBUTES]
        parts += [f"{field}={python.literal(value)}" for field, value in more if value is not None]
        return ", ".join(parts)

    def _components(self) -> Iterator[template_data.ComponentView]:
        for component in self.robot.components:
            states = component.states
            if not states:
                continue
            initial = next(s.name for s in states if s.initial)
            attributes = [
                template_data.AttributeView(
                    self.attributes.locations[component.name],
                    python.literal(initial),
                    "state: " + ", ".join(s.name for s in states),
                )
            ]
            for name in counting_entries(component):
                outer = dotted.inside(name)
                what = f"entered or left {outer}" if outer else "entered a state"
                entries = self.attributes.entries[name]
                attributes.append(template_data.AttributeView(entries, "0", f"how often it {what}"))
            for variable in component.behaviour.variables:
                what = "" if variable.in_state else ", only for data that is sent"
                attributes.append(
                    template_data.AttributeView(
                        self.attributes.variables[variable.key],
                        "None" if variable.initial is None else python.literal(variable.initial),
                        f"variable {variable.name}: {variable.type}{what}",
                    )
                )
            yield template_data.ComponentView(
                component.name, component.span.place, tuple(attributes)
            )

    def _phase_views(self) -> Iterator[template_data.AttributeView]:
        for (key, phase), attribute in self.attributes.phases.items():
            yield template_data.AttributeView(
                attribute, "False", f"{self.robot.display_names[key]} {PHASES[phase]}"
            )

    def _requirement(self, number: int) -> template_data.RequirementView:
        requirement = self.robot.requirements[number]
        parts = tuple(
            template_data.ConjunctView(
                part.failure,
                self.attributes.text(part.unmet),
                tuple((name, self.attributes.text(ref)) for name, ref in part.values.items()),
                python.literal(part.limits),
            )
            for part in conjuncts(requirement, self.robot)
        )
        return template_data.RequirementView(
            requirement.text,
            requirement.span.place,
            self.names.take(f"requirement_{number + 1}"),
            self.robot.supervises and requirement.on_data,
            self.attributes.text(guard_methods.holds_where(requirement)),
            self.names.take(f"failures_of_requirement_{number + 1}") if parts else None,
            parts,
        )

    def _part(self, part: NamedExpr) -> template_data.GuardPartView:
        return template_data.GuardPartView(
            self.attributes.parts[part.name],
            part.text(self.robot),
            self.attributes.text(part.expr),
        )

    # --- events --------------------------------------------------------------------------------

    def _input(self, event: Event) -> template_data.InputView:
        word = self._word(event.key)
        read, lines = messages.reading(event, self.robot, self.attributes)
        reader = None
        if read is not None:
            reader = self.names.take(f"read_{event.kind.word}_of_{word}")
        expect = self.robot.communications[event.key].expect
        if event.kind is not events.EventKind.RESPONSE:
            expect = None
        return template_data.InputView(
            key=event.key,
            kind=event.kind.word,
            place=event.span.place,
            description=described(event.kind, self.robot.communications[event.key]),
            read=read,
            read_lines=lines,
            reader=reader,
            applier=self.names.take(f"on_{event.kind.word}_of_{word}"),
            reaction=self.reactions.reaction(event),
            expects=None if expect is None else self.names.take(f"expects_response_of_{word}"),
            expected="" if expect is None else self._held(expect),
        )

    def _held(self, condition: tree.Expr) -> str:
        """A condition that is counted where it is undefined."""
        text = self.attributes.text(condition)
        if traversal.may_be_undefined(condition) and condition.span is not None:
            return f"self.holds(lambda: {text}, {python.literal(condition.span.place)})"
        return text

    def _command(self, guard: Guard) -> template_data.CommandView:
        event = guard.event
        word = self._word(event.key)
        kind = event.kind.word
        reaction = self.reactions.reaction(event)
        synchronisation = self.reactions.synchronisation(event)
        data: tuple[str, ...] = ()
        if event.kind.sent:
            data = messages.provided_data(event.command, self.robot, self.attributes)
        text = self.guards.guard(guard)
        self.shown += text.shown
        changes = reaction.body or reaction.writes
        read, lines = messages.reading(event, self.robot, self.attributes)
        corrections = messages.corrected_data(event.key, self.robot, self.attributes)
        during, unless = self.reactions.phases(event)
        sent = f"feedback_of_{word}" if event.kind is events.EventKind.PROGRESS else word
        return template_data.CommandView(
            key=event.key,
            kind=kind,
            place=event.span.place,
            description=described(event.kind, self.robot.communications[event.key]),
            permission=f"{event.name} may be {PERMITTED[event.kind]}",
            read=read,
            read_lines=lines,
            reader=self.names.take(f"read_{kind}_of_{word}") if read is not None else None,
            corrector=self.names.take(f"corrected_{word}") if corrections else None,
            corrector_body=corrections,
            guard=self.names.take(f"can_{kind}_{word}"),
            guard_notes=text.notes,
            guard_text=text.text,
            synchronisation=(
                self.names.take(f"synchronises_{kind}_of_{word}") if synchronisation else None
            ),
            synchronisation_text=synchronisation.text,
            during=during,
            unless=unless,
            data=self.names.take(f"data_for_{sent}") if data else None,
            data_body=data,
            applier=self.names.take(f"{kind}_{word}") if changes else None,
            reaction=reaction,
            reads=python.read_by([synchronisation], text.read),
            requirements=event.requirements,
            reason=text.reason,
            partners=self.reactions.partners(event, f"{kind}_of_{word}", self.names),
        )

    def _with_preferences(
        self, commands: list[template_data.CommandView]
    ) -> tuple[template_data.CommandView, ...]:
        row_of = {(c.communication.key, c.kind.word): c.key for c in self.robot.commands.values()}
        keys = [row_of.get((c.key, c.kind)) for c in commands]
        at = {key: n for n, key in enumerate(keys) if key is not None}
        preferred = {key: others for key, others in self.robot.yields_to.items() if key in at}
        return tuple(
            replace(c, yields_to=tuple(sorted(at[other] for other in preferred[key])))
            if key is not None and key in preferred
            else c
            for key, c in zip(keys, commands, strict=True)
        )

    def _after(self, event: Event) -> template_data.AfterView:
        component = self.robot.component(event.key)
        state, after = next(
            (place, after)
            for place in component.behaviour.places
            for after in place.afters
            if after.index == event.index
        )
        automaton, *_ = event.automata
        condition = self.reactions.condition(automaton)
        reaction = self.reactions.reaction(event, tested=len(reactions.alike(automaton.edges)) == 1)
        location = self.attributes.locations[event.key]
        assert after.delay is not None
        delay = python.duration(after.delay)
        body = [
            f"before = self.{location}",
            *reaction.body,
            f'return before + "->" + self.{location}',
        ]
        if condition:
            body = [f"if {condition.text}:", *(f"    {line}" for line in body), "return None"]
        return template_data.AfterView(
            event.name,
            event.index,
            self.names.take(f"after_{event.index}_of_{snake_case(event.key)}"),
            event.span.place,
            state.name,
            python.literal(delay),
            f"~{delay}" if isinstance(delay, str) else f"{delay} s",
            location,
            self.attributes.entries.get(
                f"{event.key}.{state.name}", self.attributes.entries.get(event.key, "")
            ),
            tuple(body),
            python.read_by([condition]),
            reaction.writes,
        )

    def _tau(self, guard: Guard) -> template_data.TauView:
        event = guard.event
        automaton, *_ = event.automata
        variable = self.plant.variables[automaton.variable]
        location = self.attributes.locations[event.key]
        conditions: list[python.PythonCode] = []
        body = []
        writes: dict[str, None] = {}
        for edges in reactions.alike(automaton.edges):
            edge = edges[0]
            # Others would change nothing.
            moved = [e for e in edges if e.source != e.target or e.updates]
            if not moved:
                continue
            parts = [self.reactions.location_test(variable, [e.source for e in moved])]
            for condition in (edge.guard, guard.expr):
                if condition is not None and condition != tree.TRUE:
                    shown = self.part_names.of_guard(condition)
                    self.shown.append(shown)
                    code = self.attributes.code(condition)
                    parts.append(replace(code, text=self.attributes.operand(shown)))
            parts += self.reactions.ranges(edge)
            conditions.append(python.joined("and", parts))
            effects, written = self.reactions.effects(event, moved)
            writes.update(dict.fromkeys(written))
            body += [
                f"if {conditions[-1].text or 'True'}:",
                f"    before = self.{location}",
                *(f"    {line}" for line in effects),
                f'    return before + "->{variable.values[edge.target]}"',
            ]
        return template_data.TauView(
            event.name,
            event.index,
            self.names.take(f"step_{event.index}_of_{snake_case(event.key)}"),
            event.span.place,
            (*body, "return None") if body else (),
            python.read_by(conditions),
            tuple(writes),
        )
