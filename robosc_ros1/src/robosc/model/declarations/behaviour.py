"""Resolution of a component's behaviour: its variables, states and transitions, typed."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.expr.evaluation import constant
from robosc.expr.types import ArrayType, DoubleType, EnumType, ObjectType, Type, Value, domain
from robosc.model import automata
from robosc.model.checks import behaviour_rules
from robosc.model.declarations.performing import (
    Performing,
    PerformingResolver,
    own_transitions,
    with_counts,
)
from robosc.model.declarations.transitions import TransitionResolver
from robosc.model.diagnostics import Report
from robosc.model.names.tables import Instance, SymbolTable, path_of
from robosc.model.typing import compatibility, expected, expressions, value_word
from robosc.syntax import nodes


class BehaviourResolver:
    """Resolves the behaviour of one component; ``_is_sound`` is False after an error."""

    def __init__(self, instance: Instance, symbols: SymbolTable, report: Report) -> None:
        self._instance = instance
        self._symbols = symbols
        self._report = report
        self._transitions = TransitionResolver(instance, symbols, report)
        self._performing = PerformingResolver(instance, self._transitions, report)
        self._performed: dict[int, Performing] = {}
        self._levels: dict[int, tuple[automata.Transition, ...]] = {}
        self._composites: dict[str, automata.CompositeState] = {}
        self._is_sound = True

    def resolve(self, node: nodes.BehaviourNode) -> automata.Behaviour:
        """The behaviour without the parts that have errors."""
        declared = self._instance.variable_nodes.values()
        variables = [v for v in map(self._variable, declared) if v is not None]
        transitions = self._level(node, "")
        behaviour = automata.Behaviour(
            tuple(variables),
            tuple(self._states(node, "", ())),
            transitions,
            tuple(self._composites.values()),
            span=node.span,
        )
        behaviour = with_counts(behaviour, self._performing.counts)
        self._check_states(node, behaviour)
        return behaviour

    # --- variables -------------------------------------------------------------------------------

    def _variable(self, node: nodes.VariableNode) -> automata.Variable | None:
        name, type_ = node.name, self._instance.variables[node.name.text]
        starts_empty = node.initial is None and isinstance(type_, ArrayType | ObjectType)
        initial = None if type_ is None or starts_empty else self._initial(node, type_)
        if type_ is None or (initial is None and not starts_empty):
            self._is_sound = False
            return None
        if node.persistent and domain(type_) is None:
            self._report.add(
                "variable-type",
                node.type.span,
                f"'{name.text}' cannot be persistent: it is {compatibility.describe(type_)}",
                "what stays is a boolean, an enum, or an integer with a range: integer(0..9)",
            )
        owner = self._instance.name
        return automata.Variable(
            name.text, owner, type_, initial, False, node.persistent, span=name.span
        )

    def _initial(self, node: nodes.VariableNode, type_: Type) -> Value | None:
        if node.initial is None:
            return compatibility.default_value(type_)
        if isinstance(type_, ArrayType | ObjectType):
            self._report.add(
                "variable-type",
                node.initial.span,
                f"'{node.name.text}' cannot have an initial value: it is"
                f" {compatibility.describe(type_)}",
                "it holds nothing until something is assigned to it",
            )
            return None
        typer = expressions.Typer(
            self._report,
            self._instance.types,
            None,
            value_word.no_value("an initial value cannot depend on a received value"),
        )
        place = f"variable '{node.name.text}'"
        if isinstance(node.initial, nodes.Access) and self._reads_something(node.initial, type_):
            return None
        expr = typer.check(node.initial, expected.expected_type(type_), place)
        if expr is None:
            return None
        value = constant(expr)
        if value is None:
            self._report.add(
                "initial-not-constant",
                node.initial.span,
                f"the initial value of '{node.name.text}' must be a finite constant",
            )
            return None
        compatibility.check_range(expr, type_, f"'{node.name.text}'", self._report)
        return float(value) if isinstance(type_, DoubleType) else value

    def _reads_something(self, access: nodes.Access, type_: Type) -> bool:
        """Report an initial value that names a variable or state; whether it does."""
        own = self._instance
        name = access.root.text
        if isinstance(type_, EnumType) and name in type_.values and not access.path:
            return False
        component = self._symbols.component(name) if access.path else own
        if component is None:
            return False
        last = access.path[-1] if access.path else access.root
        text = last.text if isinstance(last, nodes.Name) else ""
        if text not in component.variables and text not in component.states:
            return False
        self._report.add(
            "initial-not-constant",
            access.span,
            "an initial value must be a constant, it cannot read a variable or state",
        )
        return True

    # --- states and transitions ------------------------------------------------------------------

    def _level(
        self, node: nodes.BehaviourNode | nodes.StateNode, path: str
    ) -> tuple[automata.Transition, ...]:
        """Resolve what stands in a state, or outside the states, and in the states in it."""
        named: list[behaviour_rules.NamedTransition] = []
        taus: list[tuple[automata.Transition, nodes.TauNode]] = []
        afters: list[automata.Transition | None] = []
        inner: dict[int, tuple[automata.Transition, ...]] = {}
        retries: list[nodes.RetryNode] = []
        for item in node.items:
            self._transitions.inside = path
            match item:
                case nodes.StateNode():
                    inner[id(item)] = self._level(item, path_of(item, path))
                case nodes.ResultTransitionNode():
                    named += self._transitions.results(item)
                case nodes.TauNode():
                    taus.append((self._transitions.tau(item), item))
                case nodes.AfterNode():
                    afters.append(self._transitions.after(item))
                case nodes.RetryNode():
                    retries.append(item)
        self._levels |= inner
        state = node if isinstance(node, nodes.StateNode) else None
        behaviour_rules.check_events(self._instance, self._report, named, state)
        self._performing.check_requests(named, path)
        found = behaviour_rules.with_else(named)
        if state is None or state.performs is None:
            self._performing.check_retries(retries)
        elif path in self._instance.performed:
            self._transitions.inside = path
            mine, found = own_transitions(found, self._instance.performed[path])
            performing = self._performing.resolve(state, path, mine, retries)
            if performing is not None:
                self._performed[id(node)] = performing
        else:
            self._is_sound = False
        own = behaviour_rules.internal_with_else(taus, state, self._report)
        return *found, *own, *(after for after in afters if after is not None)

    def _states(
        self,
        node: nodes.BehaviourNode | nodes.StateNode,
        path: str,
        around: tuple[automata.CompositeState, ...],
    ) -> Iterator[automata.State]:
        """The states without states in them that stand in a node, in source order."""
        for item in node.items:
            if not isinstance(item, nodes.StateNode):
                continue
            name = path_of(item, path)
            if self._instance.states.get(name) is not item:
                continue
            transitions = self._levels[id(item)]
            span = item.name.span
            performing = self._performed.get(id(item))
            if item.states or performing is not None:
                outer = automata.CompositeState(name, transitions, span=span)
                if performing is not None:
                    outer = performing.within(outer)
                self._composites[name] = outer
                around_inner = (outer, *around)
            if item.states and performing is None:
                yield from self._states(item, name, around_inner)
                continue
            levels = [self._instance.states[state.name] for state in around]
            marked = item.marked
            begins = item.initial
            for level in levels:
                marked = marked or (begins and level.marked)
                begins = begins and level.initial
            if performing is not None:
                whole = automata.State(name, begins, marked, (), span=span)
                yield from performing.states(whole, around_inner)
            else:
                yield automata.State(name, begins, marked, transitions, around, span=span)

    def _check_states(self, node: nodes.BehaviourNode, behaviour: automata.Behaviour) -> None:
        if self._instance.types.scope.is_damaged(node.span):
            self._is_sound = False
            return
        states = [s for s in node.items if isinstance(s, nodes.StateNode)]
        sound = behaviour_rules.check_initial(self._instance, self._report, states, None)
        for composite in self._composites:
            around = self._instance.states[composite]
            if around.performs is not None:
                continue
            sound &= behaviour_rules.check_initial(
                self._instance, self._report, around.states, around
            )
        behaviour_rules.check_staying(self._instance, behaviour, self._report)
        behaviour_rules.check_hiding(
            behaviour, self._transitions.event_spans, self._transitions.rest, self._report
        )
        if sound and self._is_sound and self._transitions.is_sound:
            start = [s.name for s in behaviour.states if s.initial]
            behaviour_rules.check_reach(self._instance, behaviour, start, self._report)
