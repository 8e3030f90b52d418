"""What a call takes: the function in whose parentheses a place is, and which argument it is in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from robosc.language import functions, operators
from robosc.language.tokens import Tokens, is_word, tokenize
from robosc.lsp.analysis import Analysis
from robosc.syntax.nodes import FunctionNode


@dataclass(frozen=True, slots=True)
class Signature:
    """A call as it is written: its arguments as texts, of which one is ``active``."""

    name: str
    arguments: tuple[str, ...]
    result: str
    active: int

    @property
    def label(self) -> str:
        return f"{self.name}({', '.join(self.arguments)}){self.result}"

    @property
    def places(self) -> Iterator[tuple[int, int]]:
        """Where each argument begins and ends in the label."""
        start = len(self.name) + 1
        for argument in self.arguments:
            yield start, start + len(argument)
            start += len(argument) + len(", ")


def signature_at(analysis: Analysis, offset: int) -> Signature | None:
    """The call around an offset; None where there is none, or it has more arguments than it may."""
    tokens = tokenize(analysis.source)
    if any(comment.start < offset < comment.end for comment in tokens.comments):
        return None
    call = _call(tokens, offset)
    if call is None:
        return None
    name, active = call
    found = _declared(analysis, name) or _built_in(name)
    if found is None:
        return None
    arguments, result = found
    if arguments[-1:] == ("…",):
        active = min(active, len(arguments) - 1)
    return Signature(name, arguments, result, active) if active < len(arguments) else None


def _call(tokens: Tokens, offset: int) -> tuple[str, int] | None:
    """The name in front of the innermost open parenthesis of a call, and the commas behind it."""
    level = commas = 0
    for index in reversed(range(tokens.before(offset))):
        word = tokens.text(index)
        if word in (")", "]"):
            level += 1
        elif word in ("(", "[") and level:
            level -= 1
        elif word == "," and not level:
            commas += 1
        elif word in ("{", "}"):
            return None
        elif word in ("(", "["):
            if word == "(" and index and is_word(tokens.kinds[index - 1]):
                before = tokens.text(index - 2) if index > 1 else ""
                return None if before == "function" else (tokens.text(index - 1), commas)
            commas = 0  # of a part in brackets
    return None


def _declared(analysis: Analysis, name: str) -> tuple[tuple[str, ...], str] | None:
    """The arguments and the result of a function of the model."""
    contents = analysis.contents
    if contents is None:
        return None
    scopes = [contents.types.values, *(c.types.values for c in contents.instances.values())]
    found: FunctionNode | None = next(
        (s.functions[name.lstrip("^")] for s in scopes if name.lstrip("^") in s.functions), None
    )
    if found is None:
        return None
    arguments = tuple(f"{p.name.text}: {p.type.span.text}" for p in found.parameters)
    return arguments, f": {found.type.span.text}"


def _built_in(name: str) -> tuple[tuple[str, ...], str] | None:
    if name in functions.GEOMETRY:
        objects, numbers, _, what = functions.GEOMETRY[name]
        return (what,) * objects + (operators.Operand.NUMBER.value,) * numbers, ""
    function = functions.FUNCTIONS.get(name)
    if function is None:
        return None
    arguments = tuple(operand.value for operand in function.arguments)
    return arguments + ("…",) * function.variadic, f": {function.result.value}"
