"""The values of the terms of a plant, and what users see of them."""

from __future__ import annotations

from collections.abc import Sequence

from robosc import errors, limits
from robosc.expr import tree, types
from robosc.language.events import EventKind
from robosc.model.entities import Robot
from robosc.plant.data.classes import Classes
from robosc.plant.data.terms import Term
from robosc.plant.data.view import FiniteView, Scope
from robosc.plant.model_text import to_dsl


def _labels(classes: Classes, term: Term, robot: Robot, whole: bool) -> tuple[str, ...]:
    """Return the texts, for users, of the values of a term: ``Battery.charge > 0.2``, ``x <= 1``,
    with ``whole`` also for a part of a message ``value.x <= 1``."""
    if isinstance(term, tree.ChoiceRef) and term.renews is not None:
        return tuple(f"new {label}" for label in _labels(classes, term.renews, robot, whole))

    def spelled(leaf: tree.Leaf) -> str | None:
        incoming = isinstance(leaf, tree.ValueRef) and leaf == term and not whole
        return to_dsl(leaf, robot).removeprefix("value.") if incoming else None

    return tuple(
        classes.label(number, term, lambda expr: to_dsl(expr, robot, spelled))
        for number in range(len(classes))
    )


def values_of_term(
    view: FiniteView, scope: Scope, term: Term, what: str
) -> tuple[Sequence[types.Value], tuple[str, ...] | None]:
    """Return the values or classes of a term, and the texts of classes for users.

    ``what`` is the subject of error messages.
    """
    classes = view.values(scope, term)
    if classes is not None:
        whole = scope is not None and scope[0] is EventKind.REQUEST
        return classes, _labels(classes, term, view.robot, whole)
    values = types.domain(term.type)
    assert values is not None, f"{what} takes part in synthesis and is not finite"
    if isinstance(values, range) and values.stop - values.start > limits.VALUES:
        raise errors.StateSpaceError(
            f"{what}, {term.type}, takes more than {limits.VALUES} values:"
            " narrow its range, or convert it by an enum"
        )
    return values, None
