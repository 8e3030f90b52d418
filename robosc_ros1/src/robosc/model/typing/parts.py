"""Typing of parts of objects and arrays: of received values, variables, constants, elements."""

from __future__ import annotations

from dataclasses import dataclass, replace

from robosc.expr.evaluation import part_of_value
from robosc.expr.traversal import part_of, path_text
from robosc.expr.tree import ElementRef, Expr, Literal
from robosc.expr.types import ArrayType, IntegerType, ObjectType, Type
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.typing.compatibility import describe
from robosc.remedies import Hint
from robosc.runtime.core.values import Undefined
from robosc.syntax.nodes import Access, MemberNode, Name


def path_of(access: Access | MemberNode) -> tuple[str | int, ...]:
    """The path of an access with names as str."""
    return tuple(p.text if isinstance(p, Name) else p for p in access.path)


def _unbounded(type_: Type) -> Type:
    """The type of a part of a variable: the range of a part is not checked on assignment."""
    return IntegerType() if isinstance(type_, IntegerType) else type_


@dataclass(frozen=True)
class Parts:
    """Types the parts that accesses name; errors are reported at the member in question."""

    report: Report
    types: TypeTable

    def type_of(self, access: Access | MemberNode, whole: Type) -> Type | None:
        """The type of a part; None after a reported error."""
        type_: Type | None = whole
        for part in access.path:
            assert type_ is not None
            type_ = self._member(access, type_, part)
            if type_ is None:
                return None
        return type_

    def _member(self, access: Access | MemberNode, type_: Type, part: Name | int) -> Type | None:
        if isinstance(part, int):
            if isinstance(type_, ArrayType):
                return type_.element
            self.report.add(
                "unknown-member", access.span, f"{describe(type_)} has no element [{part}]"
            )
            return None
        if isinstance(type_, ObjectType):
            found = type_.property(part.text)
            self.types.record_property(part, type_)
            if found is not None:
                return found
            declarations = self.types.type_declarations
            if not declarations.may_have(type_, part.text):
                diagnostic = self.report.add(
                    "unknown-member",
                    part.span,
                    f"{type_.name} has no property '{part.text}'",
                    self.report.suggest(part.text, [n for n, _ in type_.properties]),
                )
                declarations.miss(type_, part.text, diagnostic)
            return None
        hint: Hint | None = "take an element first: [0]" if isinstance(type_, ArrayType) else None
        if isinstance(type_, ArrayType) and part.text in ("length", "len", "size", "count"):
            whole = access.span.text.removesuffix(f".{part.text}")
            hint = f"write length({whole})"
        self.report.add(
            "unknown-member",
            part.span,
            f"{describe(type_)} has no property '{part.text}'",
            hint,
        )
        return None

    def of_computed(self, node: MemberNode, whole: Expr) -> Expr | None:
        """A part of a computed object; None after a reported error."""
        type_ = self.type_of(node, whole.type)
        return (
            None if type_ is None else part_of(whole, path_of(node), _unbounded(type_), node.span)
        )

    def of_argument(self, access: Access, whole: Expr) -> Expr | None:
        """An argument of a function, or a part of it; None after a reported error."""
        if isinstance(whole, ElementRef):
            type_ = self.type_of(access, whole.type)
            path = (*whole.path, *path_of(access))
            return None if type_ is None else replace(whole, path=path, type=type_)
        return self.of_named(access, whole, 0)

    def of_named(self, access: Access, whole: Expr, members: int) -> Expr | None:
        """A part of a variable or a constant; None after a reported error.

        The first ``members`` names of the access's path belong to the name of the whole.
        """
        rest = replace(access, path=access.path[members:])
        if not rest.path:
            return whole
        type_ = self.type_of(rest, whole.type)
        if type_ is None:
            return None
        if isinstance(whole, Literal):
            return self._of_constant(whole, rest, type_)
        return part_of(whole, path_of(rest), _unbounded(type_), access.span)

    def _of_constant(self, whole: Literal, rest: Access, type_: Type) -> Literal | None:
        path = path_of(rest)
        try:
            return Literal(part_of_value(whole.value, path), type_, rest.span)
        except (Undefined, KeyError):
            message = f"the constant has no value for '{path_text(path)}'"
            self.report.add("unknown-member", rest.span, message)
            return None
