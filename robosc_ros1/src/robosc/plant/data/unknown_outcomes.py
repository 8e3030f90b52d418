"""The reasons, as text for users, why the plant does not know the outcome of a test of data."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.expr import traversal, tree
from robosc.plant.data.terms import reads_parameters

MAY_BE_MISSING = "it is assigned a part of a variable that may be missing"
SEVERAL_CHANGES = "one event changes several things that it reads"
WIDENED = "an integer that may be too large for a double is assigned to one"


def why_free(term: tree.TestRef | tree.ChoiceRef) -> str:
    """Return why the outcome of a test, or of an assignment to what it reads, is unknown."""
    test = term.test if isinstance(term, tree.ChoiceRef) else term
    assert test is not None, "a choice without a test has its own reason"
    parts = [part for side in test.sides for part in traversal.walk(side)]
    if any(map(reads_parameters, test.sides)):
        return "it reads a parameter"
    if any(isinstance(part, tree.Aggregate) for part in parts):
        return "it goes through the elements of an array"
    called = [part.operator for part in parts if isinstance(part, tree.Call)]
    if "section" in called or "sector" in called:
        return "it reads a part of an array"
    if "element" in called:
        return "it reads a computed or negative index"
    read = set(_read(parts))
    if len(read) > 1:
        incoming = [isinstance(each, tree.ValueRef) for each in read]
        if any(incoming) and not all(incoming):
            return "it reads a received value and a variable"
        return "it reads more than one number or string"
    if called:
        return f"it calls {called[0]}(…)"
    if any(isinstance(part, tree.Convert) for part in parts):
        return "the rules of the enum do not only compare with constants"
    if any(isinstance(part, tree.Binary | tree.Unary) and not _asks(part) for part in parts):
        return "it is computed"
    if any(isinstance(part, tree.Part) for part in parts):
        return "it is a part of a variable, and is assigned to another variable"
    if any(isinstance(part, tree.ValueRef) and part.optional for part in parts):
        return "an error may come without a value"
    return "what is assigned is of another type"


def _asks(part: tree.Binary | tree.Unary) -> bool:
    """Whether this is a comparison or a connective; otherwise it computes a number or a string."""
    return part.operator == "!" or (
        isinstance(part, tree.Binary) and (part.operation.is_comparison or part.operation.is_lazy)
    )


def _read(parts: list[tree.Expr]) -> Iterator[tree.Expr]:
    """Yield the distinct data that are read."""
    whole = {part.operand for part in parts if isinstance(part, tree.Part)}
    for part in parts:
        if isinstance(part, tree.Part | tree.ValueRef | tree.ParameterRef) or (
            isinstance(part, tree.VariableRef) and part not in whole
        ):
            yield part
