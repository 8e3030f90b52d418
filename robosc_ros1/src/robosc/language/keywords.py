"""The table of keywords: what each of them is for, and in which blocks it begins a declaration.

Keywords are contextual: where a name is expected any word is one. Only the reserved words always
need the escape ``^``. The lexer, the grammar, error recovery, the formatter, the language server
and the highlighting of editors read this table.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from robosc.language.attributes import ATTRIBUTES
from robosc.language.operators import symbols

__all__ = [
    "BASIC_TYPES", "KEYWORDS", "RESERVED", "Keyword", "Role", "UNITS", "escape", "starts_of",
    "words_of",
]  # fmt: skip


class Role(Enum):
    """What a keyword does."""

    DECLARATION = "declaration"
    MODIFIER = "modifier"
    CLAUSE = "clause"
    EVENT = "event"
    LABEL = "label"
    OPERATOR = "operator"
    TYPE = "type"
    CONSTANT = "constant"
    VALUE = "value"


@dataclass(frozen=True, slots=True)
class Keyword:
    """One keyword. ``blocks`` are the kinds of blocks in which it begins a declaration."""

    word: str
    roles: tuple[Role, ...]
    blocks: tuple[str, ...] = ()

    @property
    def reserved(self) -> bool:
        """Whether a name that is spelt like it always needs the escape."""
        return not {Role.OPERATOR, Role.CONSTANT, Role.VALUE}.isdisjoint(self.roles)


_FILES = ("robot", "library")
_TRANSITIONS = ("behaviour", "state")


def _table() -> Iterator[Keyword]:
    declaration, modifier, clause = (Role.DECLARATION,), (Role.MODIFIER,), (Role.CLAUSE,)
    for word in _FILES:
        yield Keyword(word, declaration, ("file",))
    yield Keyword("component", declaration, _FILES)
    yield Keyword("requirement", declaration, ("robot", "for"))
    yield Keyword("provide", declaration, ("robot", "for"))
    yield Keyword("prefer", declaration, ("robot", "for"))
    yield Keyword("for", clause, ("robot", "for"))
    yield Keyword("constant", declaration, (*_FILES, "component"))
    yield Keyword("parameter", declaration, (*_FILES, "component"))
    yield Keyword("condition", declaration, (*_FILES, "component", "for"))
    yield Keyword("datatype", declaration, _FILES)
    yield Keyword("interface", declaration, _FILES)
    yield Keyword("object", declaration)
    yield Keyword("enum", declaration)
    yield Keyword("incoming", modifier, ("component",))
    yield Keyword("outgoing", modifier, ("component",))
    yield Keyword("message", declaration)
    yield Keyword("service", declaration, ("component",))
    yield Keyword("action", declaration, ("component",))
    yield Keyword("behaviour", declaration, ("component",))
    yield Keyword("variable", declaration, ("behaviour",))
    yield Keyword("initial", modifier, ("behaviour",))
    yield Keyword("marked", modifier, ("behaviour",))
    yield Keyword("state", declaration, ("behaviour",))
    yield Keyword("on", clause, _TRANSITIONS)
    yield Keyword("transition", clause, _TRANSITIONS)
    yield Keyword("after", clause, ("state",))
    yield Keyword("default", clause, ("enum",))
    for word in ("if", "do", "goto", "needs", "disables", "never", "always", "with", "links"):
        yield Keyword(word, clause)
    for word in ("from", "to", "use", "import", "over", "in"):
        yield Keyword(word, clause)
    events = ("request", "response", "feedback", "error", "cancel", "timeout")
    labels = (*(attribute.name for attribute in ATTRIBUTES), "prefix")
    for word in dict.fromkeys((*events, *labels)):
        roles = ((Role.EVENT, events), (Role.LABEL, labels))
        yield Keyword(word, tuple(role for role, words in roles if word in words))
    for word in ("string", "boolean", "integer", "double", "none", "array"):
        yield Keyword(word, (Role.TYPE,))
    for word in symbols(words=True):
        yield Keyword(word, (Role.OPERATOR,))
    for word in ("true", "false"):
        yield Keyword(word, (Role.CONSTANT,))
    yield Keyword("value", (Role.VALUE,))


KEYWORDS: dict[str, Keyword] = {keyword.word: keyword for keyword in _table()}

RESERVED = frozenset(word for word, keyword in KEYWORDS.items() if keyword.reserved)
"""Words that are never a name unless escaped; all other keywords depend on where they stand."""


UNITS = {"ms": 0.001, "s": 1.0, "min": 60.0, "h": 3600.0}
"""The units of a duration, each in seconds. They stand behind numbers only, and are no keywords."""


def words_of(role: Role) -> tuple[str, ...]:
    """The keywords with a role, in the order of the table."""
    return tuple(word for word, keyword in KEYWORDS.items() if role in keyword.roles)


def starts_of(block: str) -> tuple[str, ...]:
    """The keywords that begin the declarations of a kind of block."""
    return tuple(word for word, keyword in KEYWORDS.items() if block in keyword.blocks)


BASIC_TYPES = frozenset(words_of(Role.TYPE))
"""Words that, unescaped, are always the built-in type where a type is expected."""


def escape(name: str) -> str:
    """How a name is written where any name may stand."""
    return f"^{name}" if name in RESERVED else name
