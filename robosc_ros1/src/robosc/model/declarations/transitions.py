"""Resolution of the transitions of a component's behaviour, typed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from robosc import dotted, errors, remedies, source
from robosc.expr import tree, types, undefined_data
from robosc.language.events import EventKind
from robosc.model import automata
from robosc.model.checks import behaviour_rules
from robosc.model.diagnostics import Report, first_of
from robosc.model.names.communications import GroupResolver
from robosc.model.names.tables import CommunicationInfo, Instance, SymbolTable
from robosc.model.typing import compatibility, durations, expected, expressions
from robosc.model.typing.value_word import Incoming, is_value, no_value, reasons_type
from robosc.syntax import nodes
from robosc.syntax.nodes import Access, Name

# Name resolution of the targets of assignments: variables of the same component.


class Targets:
    """Resolves the targets of assignments in one component."""

    def __init__(self, instance: Instance, symbols: SymbolTable, report: Report) -> None:
        self._instance = instance
        self._symbols = symbols
        self._report = report

    def resolve(self, access: Access) -> str | None:
        """The name of the variable that is assigned; None after a reported error."""
        own, root = self._instance, access.root.text
        self._record(access)
        if is_value(access):
            self._not_assignable(access, "'value' is the received value")
        elif not access.path:
            if root in own.variables:
                return root
            self._unknown_target(access)
        elif len(access.path) == 1 and isinstance(member := access.path[0], Name):
            component = self._symbols.component(root)
            if component is own and member.text in own.variables:
                return member.text
            self._foreign_target(access, component, member)
        else:
            self._not_assignable(access, "variables have no parts")
        return None

    def _record(self, access: Access) -> None:
        names = self._instance.types.scope.names
        owner, last = self._instance, access.root
        if access.path and isinstance(access.path[0], Name):
            component = self._symbols.component(access.root.text)
            if component is None:
                return
            owner, last = component, access.path[0]
            names.use(access.root, owner.declaration)
        names.use(last, owner.member(last.text), owner.name, write=True)

    def _not_assignable(self, access: Access, why: str) -> None:
        variables = first_of(self._instance.variables)
        self._report.add(
            "not-assignable",
            access.span,
            f"only variables can be assigned: {why}",
            f"{self._instance.name} has the variables: {variables}" if variables else None,
        )

    def _unknown_target(self, access: Access) -> None:
        own, name = self._instance, access.root.text
        if own.types.scope.is_unresolved(name, "variable"):
            return
        if name in own.states:
            self._not_assignable(access, f"'{name}' is a state; use goto")
        elif self._symbols.component(name) is not None:
            self._not_assignable(access, f"'{name}' is a component")
        elif name in own.communications:
            self._not_assignable(access, f"'{name}' is a communication")
        else:
            self._report.add(
                "unknown-name",
                access.span,
                f"{own.name} has no variable '{name}'",
                self._report.suggest(name, own.variables, "its variables"),
            )

    def _foreign_target(self, access: Access, component: Instance | None, member: Name) -> None:
        root = access.root.text
        scope = self._instance.types.scope
        if component is None:
            if self._symbols.is_broken(root) or scope.is_unresolved(root, "component"):
                return
            known = list(self._symbols.components)
            self._report.add(
                "unknown-name",
                access.root.span,
                f"there is no component '{root}'",
                self._report.suggest(root, known),
            )
        elif member.text in component.variables:
            self._report.add(
                "foreign-assignment",
                access.span,
                f"{self._instance.name} cannot assign a variable of {component.name}",
                f"let {component.name} react to the same event",
            )
        elif member.text in component.states:
            self._not_assignable(access, f"'{access.span.text}' is a state")
        elif not scope.is_unresolved(member.text, "variable"):
            self._report.add(
                "unknown-member",
                member.span,
                f"{root} has no variable '{member.text}'",
                self._report.suggest(member.text, component.variables, "its variables"),
            )


class TransitionResolver:
    """Resolves the transitions of one component, those that stand in the state ``inside``.

    ``is_sound`` is False after an error. ``event_spans`` maps the offset of a transition and its
    event to the span of the event's name, and ``rest`` has those with ``else``.
    """

    def __init__(self, instance: Instance, symbols: SymbolTable, report: Report) -> None:
        self._instance = instance
        self._symbols = symbols
        self._report = report
        self._taus = 0
        self._afters = 0
        self.inside = ""
        """The path of the state in which a transition stands; "": in none."""
        self.event_spans: dict[tuple[int, EventKind], source.Span] = {}
        self.rest: set[tuple[int, EventKind]] = set()
        self.is_sound = True

    def tau(self, node: nodes.TauNode) -> automata.Transition:
        """The internal transition of a node."""
        self._taus += 1
        taken = self._own(EventKind.TAU, node, "an internal transition carries no value")
        return replace(taken, index=self._taus)

    def after(self, node: nodes.AfterNode) -> automata.Transition | None:
        """The transition after a delay; None after an error."""
        happening = self._own(EventKind.AFTER, node, "'after' carries no value")
        return self.waits(node.duration, "'after'", happening)

    def _own(
        self, event: EventKind, node: nodes.TauNode | nodes.AfterNode, why: str
    ) -> automata.Transition:
        """A transition of the component alone; ``why`` there is no value."""
        guard, assignments = self._clauses(node, no_value(why))
        goto, named = self._goto(node.goto)
        name = self._instance.name
        return automata.Transition(event, name, guard, assignments, goto, named, span=node.span)

    def waits(
        self, duration: nodes.ExprNode, what: str, happening: automata.Transition
    ) -> automata.Transition | None:
        """What happens after a duration, which stands behind the word ``what``; None after an
        error."""
        self._afters += 1
        typer = self._typer(no_value(f"{what} carries no value"))
        delay = typer.check(duration, durations.DURATION, what)
        if delay is None or not durations.is_long_enough(delay, what, duration.span, self._report):
            self.is_sound = False
            return None
        return replace(happening, index=self._afters, delay=delay)

    def effect(
        self, event: EventKind, info: CommunicationInfo, node: nodes.PerformsNode | nodes.EffectNode
    ) -> automata.Transition:
        """What a clause says about an event of a communication."""
        taken = self.goes(event, info.whole_key, node)
        return replace(
            taken, assignments=self._assignments(node.assignments, _incoming(event, info))
        )

    def goes(
        self,
        event: EventKind,
        key: str,
        node: nodes.PerformsNode | nodes.EffectNode | nodes.RetryNode,
    ) -> automata.Transition:
        """Where the ``goto`` of a clause leads."""
        goto, named = self._goto(node.goto)
        return automata.Transition(event, key, None, (), goto, named, span=node.span)

    def results(self, node: nodes.ResultTransitionNode) -> list[behaviour_rules.NamedTransition]:
        """One transition for each event of each communication that has it."""
        scope = self._instance.types.scope
        groups = GroupResolver(self._symbols, scope, self._report)
        listed, whole = groups.listed(node.communications)
        self.is_sound &= whole
        goto, named = self._goto(node.goto)
        found: list[behaviour_rules.NamedTransition] = []
        for name in behaviour_rules.check_repeated_events(node.events, self._report):
            having = [
                (access, info, event)
                for access, info in listed
                if (event := info.sort.named(name.text)) in info.events and event is not None
            ]
            for access, info, event in having:
                self.event_spans[node.span.start, event] = name.span
                guard, assignments = self._clauses(node, _incoming(event, info))
                transition = automata.Transition(
                    event, info.key, guard, assignments, goto, named, span=node.span
                )
                found.append(behaviour_rules.NamedTransition(transition, name, access, node.guard))
                if isinstance(node.guard, nodes.ElseNode):
                    self.rest.add((node.span.start, event))
            if not having:
                self._clauses(node, Incoming(None, known=False))  # for their own errors
                self.is_sound = False
                if listed:
                    behaviour_rules.report_unavailable(
                        name, [info for _, info in listed], self._report
                    )
        return found

    def _clauses(
        self,
        node: nodes.ResultTransitionNode | nodes.TauNode | nodes.AfterNode,
        incoming: Incoming,
    ) -> tuple[tree.Expr | None, tuple[automata.Assignment, ...]]:
        return self._guard(node.guard, incoming), self._assignments(node.assignments, incoming)

    def _typer(self, incoming: Incoming) -> expressions.Typer:
        return expressions.Typer(self._report, self._instance.types, self._symbols, incoming)

    def _guard(
        self, node: nodes.ExprNode | nodes.ElseNode | None, incoming: Incoming
    ) -> tree.Expr | None:
        if node is None or isinstance(node, nodes.ElseNode):
            return None
        guard = self._typer(incoming).check(node, expected.BOOLEAN, "a guard")
        if guard is None:
            self.is_sound = False
            return None
        return undefined_data.condition_on_data(guard)

    def _goto(self, goto: nodes.Name | nodes.Access | None) -> tuple[str | None, str | None]:
        """The state in which a ``goto`` ends, and the one that it names, if that has states in it:
        it is entered through the initial one."""
        if goto is None:
            return None, None
        own, scope = self._instance, self._instance.types.scope
        steps = [goto] if isinstance(goto, nodes.Name) else [goto.root, *_names(goto)]
        path = _nearest_state(own, ".".join(step.text for step in steps), self.inside)
        if path is not None:
            parts = dotted.parts(path)
            for length, step in enumerate(steps, 1 + len(parts) - len(steps)):
                scope.names.use(step, own.states[".".join(parts[:length])], own.name)
            leaf = own.first_leaf(path)
            return leaf, None if leaf == path else path
        self.is_sound = False
        if not scope.is_unresolved(steps[-1].text, "state"):
            inside = ".".join(step.text for step in steps[1:])
            known = steps[0].text == own.name and inside in own.states
            suggested = self._report.suggest(goto.span.text, own.states, "its states")
            self._report.add(
                "unknown-state",
                goto.span,
                f"{own.name} has no state '{goto.span.text}'",
                remedies.write(inside) if known else suggested,
            )
        return None, None

    # --- assignments -----------------------------------------------------------------------------

    def _assignments(
        self, given: Sequence[nodes.AssignmentNode], incoming: Incoming
    ) -> tuple[automata.Assignment, ...]:
        targets = Targets(self._instance, self._symbols, self._report)
        found: list[automata.Assignment] = []
        seen: dict[str, source.Span] = {}
        for node in given:
            target = targets.resolve(node.target)
            if target is not None and target in seen:
                self._report.add(
                    "duplicate-assignment",
                    node.target.span,
                    f"'{target}' is assigned twice at the same time",
                    "assignments of one transition happen at once",
                    [errors.Note("the first one is here", seen[target])],
                )
                self.is_sound = False
            elif target is not None:
                seen[target] = node.target.span
            assignment = self._assignment(node, target, incoming)
            if assignment is None:
                self.is_sound = False
            else:
                found.append(assignment)
        return tuple(found)

    def _assignment(
        self, node: nodes.AssignmentNode, target: str | None, incoming: Incoming
    ) -> automata.Assignment | None:
        type_ = self._instance.variables.get(target) if target is not None else None
        typer = self._typer(incoming)
        if target is None or type_ is None:
            # The value is typed for its own errors, although the variable's type is unknown.
            if not (isinstance(node.value, nodes.Access) and not is_value(node.value)):
                typer.check(node.value, expected.ANY, "an assignment")
            return None
        value = typer.check(node.value, expected.expected_type(type_), f"variable '{target}'")
        if value is None:
            return None
        within = () if isinstance(type_, types.EnumType) else types.innermost(type_)
        enums = any(isinstance(part, types.EnumType) for _, part in within)
        if enums and tree.is_constant_data(value):
            message = f"a constant with a value of an enum cannot be assigned to '{target}'"
            hint = "a variable holds what the enum converts; read the constant where it is needed"
            self._report.add("not-assignable", node.value.span, message, hint)
            return None
        compatibility.check_range(value, type_, f"'{target}'", self._report)
        return automata.Assignment(target, compatibility.coerce(value, type_), span=node.span)


def _names(access: nodes.Access) -> Iterator[nodes.Name]:
    return (step for step in access.path if isinstance(step, nodes.Name))


def _incoming(event: EventKind, info: CommunicationInfo) -> Incoming:
    found = info.sort.event(event)
    if found is None or found.brings is None:
        return no_value(f"'on {event.word}' carries no value")
    reasons = reasons_type(info.kind) if event is EventKind.ERROR else None
    if reasons and isinstance(info.node, nodes.ServiceNode) and not info.node.expect:
        why = "'on error' of a service carries a value only where it has 'expect:'"
        return Incoming(None, why, reasons=reasons)
    type_ = info.brought(event)
    return Incoming(type_, known=type_ is not None, optional=found.optional, reasons=reasons)


def _nearest_state(instance: Instance, path: str, inside: str) -> str | None:
    """The whole path of the state that a ``goto`` in a state names; None if it names none.

    A name is looked for in the state ``inside`` and in those around it, from the innermost.
    """
    while inside and "." not in path:
        if f"{inside}.{path}" in instance.states:
            return f"{inside}.{path}"
        inside = dotted.around(inside)
    return path if path in instance.states else None
