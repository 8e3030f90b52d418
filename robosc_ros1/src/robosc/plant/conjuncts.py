"""The parts of a requirement, all of which have to hold: what is told of a command that is held
back."""

from __future__ import annotations

from collections.abc import Iterator

from robosc import dotted
from robosc.expr import traversal, tree, types
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Requirement, Robot
from robosc.plant import logic, model_text

_MOST_VALUES = 4
"""More than these would hide the reason in the message."""


@dataclass(frozen=True)
class Conjunct:
    """A part of a requirement: ``failure`` tells that it does not hold, while ``unmet`` does.

    ``failure`` is empty for the whole requirement, which has a text as its author wrote it.
    ``values`` are what it compares, by the names in the model; ``limits`` the numbers that stand in
    it.
    """

    failure: str
    unmet: tree.Expr
    values: dict[str, tree.Expr]
    limits: tuple[float, ...]


def conjuncts(requirement: Requirement, robot: Robot) -> tuple[Conjunct, ...]:
    """The parts of a requirement in order; empty if they tell no more than the requirement."""
    parts = list(_parts(requirement.condition, not requirement.forbids))
    found = tuple(
        Conjunct(
            f"{_text(part, robot)} is {'false' if wanted else 'true'}" if len(parts) > 1 else "",
            logic.negation(part) if wanted else part,
            dict(_values(part)),
            tuple(_limits(part)),
        )
        for part, wanted in parts
    )
    return found if len(found) > 1 or found[0].values else ()


def _text(expr: tree.Expr, robot: Robot) -> str:
    """A part as the model says it: ``dock.idle``, not ``!dock.busy``."""
    phase = _named_phase(expr)
    if phase is None or expr.span is None:
        return model_text.to_dsl(expr, robot)
    communication = dotted.around(model_text.to_dsl(phase, robot))
    return f"{communication}.{dotted.last(expr.span.text)}"


def _named_phase(expr: tree.Expr) -> tree.PhaseRef | None:
    """One of the phases of which a name such as ``dock.idle`` means none; None for other parts."""
    if not isinstance(expr, tree.Unary | tree.Binary):
        return None
    left = expr.operand if isinstance(expr, tree.Unary) else expr.left
    if left.span is None or left.span != expr.span:
        return None
    return left if isinstance(left, tree.PhaseRef) else _named_phase(left)


def _parts(expr: tree.Expr, wanted: bool) -> Iterator[tuple[tree.Expr, bool]]:
    if _named_phase(expr):
        yield expr, wanted
    elif isinstance(expr, tree.Unary) and expr.operator == "!":
        yield from _parts(expr.operand, not wanted)
    elif isinstance(expr, tree.Binary) and expr.operator == ("and" if wanted else "or"):
        yield from _parts(expr.left, wanted)
        yield from _parts(expr.right, wanted)
    else:
        yield expr, wanted


def _limits(expr: tree.Expr) -> Iterator[float]:
    values = (node.value for node in traversal.walk(expr) if isinstance(node, tree.Literal))
    yield from dict.fromkeys(value for value in values if isinstance(value, float))


def _values(expr: tree.Expr) -> Iterator[tuple[str, tree.Expr]]:
    read = dict.fromkeys(
        node
        for node in traversal.walk(expr)
        if isinstance(node, tree.VariableRef | tree.ParameterRef | tree.ValueRef)
    )
    plain = [
        n
        for n in read
        if not isinstance(n.type, types.ArrayType | types.BooleanType | types.ObjectType)
    ]
    for node in plain[:_MOST_VALUES]:
        match node:
            case tree.VariableRef(key=name):
                yield name, node
            case tree.ParameterRef(parameter=parameter):
                yield parameter.key, node
            case tree.ValueRef(path=path):
                yield traversal.path_text(("value", *path)), node
