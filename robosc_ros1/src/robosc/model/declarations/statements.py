"""Resolution of requirements, preferences and provided data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from graphlib import CycleError, TopologicalSorter
from itertools import product
from typing import TypeAlias, TypeVar

from robosc import errors, source
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.quantified import chain
from robosc.expr.tree import Expr
from robosc.expr.types import NoneType
from robosc.expr.undefined_data import condition_on_data, none_of
from robosc.language import events, keywords
from robosc.model import entities
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.names.communications import (
    GroupResolver,
    report_misdirected,
    resolve_communication,
)
from robosc.model.names.tables import CommunicationInfo, SymbolTable
from robosc.model.ros.links import Binder
from robosc.model.typing import expected, expressions, value_word
from robosc.model.typing.command_values import (
    CommandTyper,
    may_read_value,
    requirement_id,
    requirement_of,
    requirement_text,
)
from robosc.model.typing.data import DataTyper
from robosc.syntax import nodes

_TITLED = (nodes.RequirementNode, nodes.PossibleNode, nodes.AssumeNode, nodes.PreferNode)
_Node: TypeAlias = nodes.DeclarationNode | nodes.CommunicationNode | nodes.BehaviourNode
_Entity = TypeVar(
    "_Entity", entities.Provide, entities.Preference, entities.Goal, entities.Assumption
)


@dataclass
class Statements:
    """The statements of a robot and of its components, without those that have errors."""

    requirements: list[entities.Requirement] = field(default_factory=list)
    provides: list[entities.Provide] = field(default_factory=list)
    preferences: list[entities.Preference] = field(default_factory=list)
    goals: list[entities.Goal] = field(default_factory=list)
    performed: list[entities.Provide] = field(default_factory=list)
    """The data of commands that states perform, which go before all others."""
    assumptions: list[entities.Assumption] = field(default_factory=list)
    titles: dict[str, nodes.StringNode] = field(default_factory=dict)
    """By id, the title that has it."""

    def add(self, items: Iterable[_Node], resolver: StatementResolver, owner: str = "") -> None:
        """Resolve those of the nodes that are statements, and add them.

        ``owner`` is the name under which their component was imported; it stands before their ids.
        """
        for item in items:
            if isinstance(item, _TITLED) and item.title is not None:
                title = item.title
                if owner:
                    title = replace(title, text=f"{owner}.{title.text}")
                    item = replace(item, title=title)
                resolver.claim(title, self.titles)
            match item:
                case nodes.RequirementNode():
                    self.requirements += resolver.requirements(item)
                case nodes.PossibleNode():
                    self.goals += _sound(resolver.goal(item))
                case nodes.AssumeNode():
                    self.assumptions += _sound(resolver.assumption(item))
                case nodes.ProvideNode():
                    self.provides += resolver.provides(item)
                case nodes.PreferNode():
                    self.preferences += _sound(resolver.preference(item))

    def on_commands(self) -> tuple[entities.Requirement, ...]:
        """The requirements without those on a group that, in this robot, is empty."""
        return tuple(r for r in self.requirements if r.communications or r.kind in _ON_STATES)


_ON_STATES = ("never", "always")


def _with(keys: Iterable[str], reports: Mapping[str, str]) -> tuple[str, ...]:
    found = (each for key in keys for each in (key, reports.get(key, key)))
    return tuple(dict.fromkeys(found))


def _sound(found: _Entity | None) -> tuple[_Entity, ...]:
    return () if found is None else (found,)


class StatementResolver:
    """Resolves statements, with the names of a robot or those of one of its components."""

    def __init__(
        self, symbols: SymbolTable, types: TypeTable, binder: Binder, report: Report
    ) -> None:
        self._symbols = symbols
        self._types = types
        self._binder = binder
        self._report = report
        self._typer = expressions.Typer(
            report,
            types,
            symbols,
            value_word.no_value("requirements on states have no 'value'"),
        )
        self._groups = GroupResolver(symbols, types.scope, report)
        self._read: IdentityCache[bool] = IdentityCache()

    def claim(self, title: nodes.StringNode, taken: dict[str, nodes.StringNode]) -> None:
        """Report a title without an id, or with one that another title has."""
        words = title.text.split()
        if not words:
            self._report.add(
                "duplicate-id", title.span, "this title is empty", 'begin it with an id: "SR-1 …"'
            )
            return
        first = taken.setdefault(words[0], title)
        if (first.span.source, first.span.start) != (title.span.source, title.span.start):
            self._report.add(
                "duplicate-id",
                title.span,
                f"another statement has the id {words[0]}",
                "give one of them another id, or write both in one group: requirement"
                f' "{words[0]}" {{ … }}',
                [errors.Note("the first one is here", first.span)],
            )

    def requirements(self, node: nodes.RequirementNode) -> Sequence[entities.Requirement]:
        """The requirements that a statement makes; none after an error.

        One on a call that is served restricts its feedback, too, unless it reads the data.
        """
        reports = self._groups.reports(node.communications)
        return [
            requirement
            if requirement.on_data or not reports
            else replace(requirement, communications=_with(requirement.communications, reports))
            for requirement in self._requirements(node)
        ]

    def _requirements(self, node: nodes.RequirementNode) -> Sequence[entities.Requirement]:
        keys: tuple[str, ...] | None = ()
        if node.communications:
            keys = self._groups.commands(
                node.communications, "requirement-on-outgoing", _CANNOT_FORBID
            )
        if keys is not None and node.communications and may_read_value(node.condition):
            commands = self._symbols.component_table.by_keys(keys)
            typer = CommandTyper(self._symbols, self._types, self._report)
            return typer.requirements(node, commands)
        condition = self._typer.check(node.condition, expected.BOOLEAN, "a requirement")
        if condition is None or keys is None:
            return ()
        condition = condition_on_data(condition, self._read)
        return (requirement_of(node, keys, condition, requirement_text(node)),)

    def goal(self, node: nodes.PossibleNode) -> entities.Goal | None:
        """What must remain possible; None after an error."""
        parts = (
            (node.condition, "a requirement"),
            (node.origin, "the condition after 'from'"),
            (node.along, "the condition after 'while'"),
        )
        found: list[Expr | None] = []
        for part, what in parts:
            expr = None if part is None else self._typer.check(part, expected.BOOLEAN, what)
            found.append(None if expr is None else condition_on_data(expr, self._read))
        condition, origin, along = found
        given = sum(part is not None for part, _ in parts)
        if condition is None or sum(expr is not None for expr in found) < given:
            return None
        text, own = requirement_text(node), requirement_id(node)
        return entities.Goal(condition, origin, along, text, own, span=node.span)

    def assumption(self, node: nodes.AssumeNode) -> entities.Assumption | None:
        """What the robot is assumed not to do; None after an error."""
        typer, key = self._typer, None
        if node.communication is not None:
            scope = self._types.scope
            info = resolve_communication(node.communication, self._symbols, scope, self._report)
            if info is None:
                return None
            if info.kind not in _ASSUMED:
                message = f"'{info.name}' sends no response: there is nothing to assume of it"
                self._report.add("assumption-on-command", node.communication.span, message, _ASSUME)
                return None
            key = info.key
            incoming = value_word.response_of(info.name, info.response)
            typer = expressions.Typer(self._report, self._types, self._symbols, incoming)
        condition = typer.check(node.condition, expected.BOOLEAN, "an assumption")
        if condition is None:
            return None
        condition = condition_on_data(condition, self._read)
        if node.kind == "never":
            condition = none_of([condition], node.condition.span)
        text, own = requirement_text(node), requirement_id(node)
        return entities.Assumption(node.kind, key, condition, text, own, span=node.span)

    def preference(self, node: nodes.PreferNode) -> entities.Preference | None:
        """The preference; None after an error."""
        code = "preference-on-outgoing"
        preferred = self._groups.commands(node.preferred, code, _CANNOT_PREFER)
        over = self._groups.commands(node.over, code, _CANNOT_PREFER, left_out=preferred or ())
        if preferred is None or over is None:
            return None
        return entities.Preference(preferred, over, span=node.span)

    def stop(self, stops: Sequence[nodes.StopNode]) -> str | None:
        """The key of the message that stops the robot; None without one, or after an error."""
        for node in stops[1:]:
            note = errors.Note("the first one is here", stops[0].span)
            message = "a robot has one stop command"
            self._report.add("several-stops", node.span, message, "remove one of them", [note])
        if not stops or self.stops_with_nothing(stops):
            return None
        access = stops[0].communication
        info = resolve_communication(access, self._symbols, self._types.scope, self._report)
        if info is not None and info.kind is not events.Kind.INCOMING:
            message = f"'{info.name}' is no incoming message: it cannot be sent as the last command"
            if info.kind is events.Kind.OUTGOING:
                report_misdirected(info, "stop-not-a-message", access.span, message, self._report)
            else:
                self._report.add("stop-not-a-message", access.span, message, _STOPS)
            return None
        return None if info is None else info.key

    def stops_with_nothing(self, stops: Sequence[nodes.StopNode]) -> bool:
        """Whether the robot may go on with its last commands: ``nothing``, and no message of it."""
        if not stops:
            return False
        access = stops[0].communication
        bare = access.root.text == keywords.NOTHING and access.index is None and access.path == ()
        return bare and not self._symbols.communications(keywords.NOTHING)

    def provides(self, node: nodes.ProvideNode) -> list[entities.Provide]:
        """The provide statement, and one for each ``else`` of it; none after an error."""
        access = node.communication
        info = self._groups.command(access, "provide-for-outgoing", _CANNOT_PROVIDE, given=True)
        found: list[entities.Provide] = []
        before: list[Expr] = []
        parts: list[nodes.ProvideNode | nodes.OtherwiseNode] = [node, *node.otherwise]
        for part in parts:
            provide = self._provide(part, info, part.span if before else node.span)
            if provide is None:
                return []
            condition = provide.condition
            if before:
                rest = none_of(before, part.span)
                condition = rest if condition is None else chain("and", [rest, condition])
            found.append(replace(provide, condition=condition))
            before += () if provide.condition is None else (provide.condition,)
        return found

    def _provide(
        self,
        node: nodes.ProvideNode | nodes.OtherwiseNode,
        info: CommunicationInfo | None,
        span: source.Span,
    ) -> entities.Provide | None:
        typer = self._typer
        if info is not None and may_read_value(node):
            incoming = value_word.Incoming(info.sent, known=info.sent is not None)
            typer = expressions.Typer(self._report, self._types, self._symbols, incoming)
        data = self._data_for(node, info, typer)
        condition = None
        if node.condition is not None:
            condition = typer.check(node.condition, expected.BOOLEAN, "the condition")
            if condition is None:
                return None
            condition = condition_on_data(condition, self._read)
        if info is None or data is None:
            return None
        if info.entity is not None and info.instance.imported is None:
            self._binder.sent.check(data, entities.Command(info.entity, info.command))
        return entities.Provide(info.key, data, condition, span=span)

    # --- data ------------------------------------------------------------------------------------

    def _data_for(
        self,
        node: nodes.ProvideNode | nodes.OtherwiseNode,
        info: CommunicationInfo | None,
        typer: expressions.Typer,
    ) -> entities.Data | None:
        if info is None or info.sent is None:
            return None
        if isinstance(info.sent, NoneType):
            if node.data == nodes.DataObjectNode((), span=node.data.span):
                return entities.DataObject(())
            self._report.add(
                "nothing-to-provide",
                node.data.span,
                f"'{info.name}' carries no data",
                "remove the statement, or give the communication a type",
            )
            return None
        data = DataTyper(typer, self._types, self._report)
        return data.typed(node.data, info.sent, f"'{info.name}'")


_ASSUMED = (events.Kind.OUTGOING, events.Kind.SERVICE, events.Kind.ACTION)
_ASSUME = "name an outgoing message, a service or an action"
_CANNOT_FORBID = "the controller cannot forbid what the robot sends"
_CANNOT_PREFER = "the controller does not decide when the robot sends it"
_STOPS = "name an incoming message, such as the velocity of a base"
_CANNOT_PROVIDE = "the robot sends its data, not the controller"


def check_preferences(robot: entities.Robot, report: Report) -> None:
    """Report a cycle of commands of which each is preferred to the next."""
    below: dict[str, dict[str, source.Span]] = {}
    for preference in robot.preferences:
        for first, second in product(preference.preferred, preference.over):
            below.setdefault(first, {}).setdefault(second, preference.span)
    try:
        TopologicalSorter(below).prepare()
    except CycleError as error:
        *_, before, last = cycle = error.args[1][::-1]
        names = " over ".join(robot.display_names[key] for key in cycle)
        report.add(
            "preference-cycle",
            below[before][last],
            f"each of these is preferred to the next: {names}",
            "remove one of the preferences",
        )
