"""Typing of requirements on the data of commands, which ``value`` means in them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from robosc import errors, source
from robosc.expr import traversal, tree, undefined_data
from robosc.expr.types import NoneType, Type
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.entities import Requirement
from robosc.model.names.tables import CommunicationInfo, SymbolTable
from robosc.model.typing.expected import BOOLEAN
from robosc.model.typing.expressions import Typer
from robosc.model.typing.value_word import Incoming
from robosc.syntax import nodes

_VALUE = re.compile(r"(?<!\^)\bvalue\b")


def may_read_value(node: nodes.ExprNode | nodes.ProvideNode | nodes.OtherwiseNode) -> bool:
    """Whether the word ``value`` stands in a part of the model, be it as a name of something
    else."""
    return _VALUE.search(node.span.text) is not None


def requirement_text(
    node: nodes.RequirementNode | nodes.PossibleNode | nodes.AssumeNode,
    part: source.Span | None = None,
) -> str:
    """A requirement or an assumption on one line, its title first; with one ``part`` of its
    condition, as if it were the whole."""
    span, whole, title = node.span, node.condition.span, node.title
    text = span.text
    begin = 0 if title is None else max(0, title.span.end - span.start)
    before = text[begin : whole.start - span.start]
    if part is not None and before.count("(") == before.count(")"):
        text = text[: whole.start - span.start] + part.text + text[whole.end - span.start :]
    if title is None:
        plain = fold_text(text)
    else:
        word = "assume" if isinstance(node, nodes.AssumeNode) else "requirement"
        plain = f"{title.text}: {word} {fold_text(text[begin:])}"
    return plain + (f" ({node.repeated})" if node.repeated else "")


def requirement_id(node: nodes.RequirementNode | nodes.PossibleNode | nodes.AssumeNode) -> str:
    """The first word of the title; empty without one."""
    words = [] if node.title is None else node.title.text.split()
    return words[0] if words else ""


def requirement_of(
    node: nodes.RequirementNode,
    keys: tuple[str, ...],
    condition: tree.Expr,
    text: str,
    *,
    on_data: bool = False,
) -> Requirement:
    """A requirement as it is written; what is about the data of a command restricts its request
    only."""
    return Requirement(
        node.kind,
        keys,
        condition,
        text,
        node.to_start or on_data,
        on_data=on_data,
        id=requirement_id(node),
        repeated=node.repeated,
        span=node.span,
    )


_COMMENT_OR_STRING = re.compile(
    r"""//[^\n]*|/\*.*?\*/|("(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')""", re.DOTALL
)


def fold_text(text: str) -> str:
    """Text of the model on one line, without comments; strings are kept."""
    plain = _COMMENT_OR_STRING.sub(lambda match: match[1] or " ", text)
    return " ".join(plain.split())


class CommandTyper:
    """Types the requirements that read what their commands carry."""

    def __init__(self, symbols: SymbolTable, types: TypeTable, report: Report) -> None:
        self._symbols = symbols
        self._types = types
        self._report = report

    def requirements(
        self, node: nodes.RequirementNode, commands: Sequence[CommunicationInfo]
    ) -> Sequence[Requirement]:
        """The requirements of a statement; none after an error.

        Each part of ``A and B`` (``A or B`` of ``disables``) is one of its own. Those that read
        ``value`` are about each command's own data, and restrict its request only.
        """
        by_type = self._typed(node.condition, commands)
        if by_type is None or not commands:
            return ()
        first = by_type[commands[0].sent]
        if not traversal.reads_value(first):
            keys = tuple(command.key for command in commands)
            condition = undefined_data.condition_on_data(first)
            return (requirement_of(node, keys, condition, requirement_text(node)),)
        return tuple(self._parts(node, commands, by_type))

    def _parts(
        self,
        node: nodes.RequirementNode,
        commands: Sequence[CommunicationInfo],
        by_type: dict[Type | None, tree.Expr],
    ) -> Iterator[Requirement]:
        operator = "or" if node.kind == "disables" else "and"
        keys = tuple(command.key for command in commands)
        parts = {type_: traversal.operands(expr, operator) for type_, expr in by_type.items()}
        found = parts[commands[0].sent]
        for index, part in enumerate(found):
            text = requirement_text(node, part.span if len(found) > 1 else None)
            if not traversal.reads_value(part):
                kept = undefined_data.condition_on_data(part)
                yield requirement_of(node, keys, kept, text)
                continue
            for command in commands:
                own = parts[command.sent][index]
                key = (command.key,)
                yield requirement_of(node, key, own, text, on_data=True)

    def _typed(
        self, node: nodes.ExprNode, commands: Sequence[CommunicationInfo]
    ) -> dict[Type | None, tree.Expr] | None:
        """The condition for each type of data; None after a reported error."""
        members: dict[Type | None, list[CommunicationInfo]] = {}
        for command in commands:
            members.setdefault(command.sent, []).append(command)
        found: dict[Type | None, tree.Expr] = {}
        faults: dict[Type | None, tuple[errors.Diagnostic, ...]] = {}
        for type_ in members:
            report = Report()
            incoming = Incoming(type_, known=type_ is not None)
            typer = Typer(report, self._types.reporting_to(report), self._symbols, incoming)
            condition = typer.check(node, BOOLEAN, "a requirement")
            if condition is not None:
                found[type_] = condition
            faults[type_] = report.diagnostics
        empty = next((type_ for type_ in members if isinstance(type_, NoneType)), None)
        if empty is not None:
            said = _carries_nothing(members[empty])
            faults[empty] = tuple(
                replace(d, message=said) if d.code == "value-not-allowed" else d
                for d in faults[empty]
            )
        for type_, diagnostics in faults.items():
            for diagnostic in diagnostics:
                everywhere = all(diagnostic in others for others in faults.values())
                if not everywhere and type_ != empty:
                    names = errors.listing(f"'{command.name}'" for command in members[type_])
                    message = f"{diagnostic.message} (of {names})"
                    diagnostic = replace(diagnostic, message=message)
                self._report.extend([diagnostic])
        return found if len(found) == len(members) else None


def _carries_nothing(commands: Sequence[CommunicationInfo]) -> str:
    names = errors.listing(f"'{command.name}'" for command in commands)
    return f"{names} {'carries' if len(commands) == 1 else 'carry'} no data: there is no 'value'"
