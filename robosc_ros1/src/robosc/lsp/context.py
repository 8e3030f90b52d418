"""Where in the language a place in an unfinished text is: what the words before it are part of.

The parser has no use for half a declaration; completion lives on them. So only words and braces are
looked at here, and whatever is wrong further up does no harm beyond its block.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from robosc.source import Source
from robosc.syntax.scan import scan

__all__ = ["Block", "Context", "context_at"]

_TOKEN = re.compile(
    r"\"[^\"\n]*\"?|'[^'\n]*'?|\^?[A-Za-z_]\w*|\d[\w.]*|:=|=>|->|<=|>=|!=|\.\.|[^\s\w]", re.ASCII
)
_WORD = re.compile(r"\^?[A-Za-z_]\w*\Z", re.ASCII)

_STARTS = {
    "file": ("robot", "library"),
    "robot": ("component", "requirement", "provide", "datatype", "interface"),
    "library": ("component", "datatype", "interface"),
    "component": ("incoming", "outgoing", "service", "action", "behaviour"),
    "behaviour": ("variable", "initial", "marked", "state", "on", "transition"),
    "state": ("on", "transition"),
    "enum": ("default",),
}
"""The first words of the declarations of each block."""

_EXPECT_NAME = frozenset({
    ".", "robot", "library", "component", "requirement", "provide", "interface", "message",
    "service", "action", "variable", "state", "from", "to", "goto", "do", "if", "and", "or",
    "needs", "disables", "never", "always", "use", "import", "links", "object", "enum", "=", "!=",
    "<", "<=", ">", ">=", "+", "-", "*", "/", "=>", "->", ":=", "!", "(", ",", ":", "[",
})  # fmt: skip
"""After these a word is a name rather than the beginning of the next declaration."""


@dataclass(frozen=True, slots=True)
class Block:
    """An open brace: what it belongs to, the name of that, and the words in front of it."""

    kind: str
    name: str
    header: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Context:
    """The open blocks around a place from outside in, and the words of its own declaration.

    ``prefix`` is the word that is being typed, from ``start`` on; it is not among ``words``. In a
    comment or a string nothing is expected: ``inside_text``.
    """

    blocks: tuple[Block, ...]
    words: tuple[str, ...]
    prefix: str
    start: int
    inside_text: bool = False

    @property
    def block(self) -> Block:
        return self.blocks[-1]

    @property
    def last(self) -> str:
        return self.word(-1)

    def word(self, place: int) -> str:
        """One of the words, from the end if negative; empty if there are not so many."""
        return self.words[place] if -len(self.words) <= place < len(self.words) else ""

    def behind(self, word: str) -> str:
        """The word behind the first of these; empty if there is none."""
        return self.word(self.words.index(word) + 1) if word in self.words else ""

    def around(self, kind: str) -> Block | None:
        return next((b for b in reversed(self.blocks) if b.kind == kind), None)


_FILE = Block("file", "", ())


def context_at(source: Source, offset: int) -> Context:
    """The context of a place."""
    scanned = scan(source)
    if any(c.start < offset < c.end or _at_end(c.text, c.end, offset) for c in scanned.comments):
        return Context((_FILE,), (), "", offset, inside_text=True)
    text = scanned.text[:offset] if scanned.text else ""
    typed = _WORD.search(text)
    start = typed.start() if typed else offset
    blocks = [_FILE]
    words: list[str] = []
    outer: list[list[str]] = []
    last = ""
    for match in _TOKEN.finditer(text, 0, start):
        word = match.group()
        if word == "{":
            blocks.append(_opened(blocks[-1], words))
            outer.append(words)
            words = []
        elif word == "}":
            kind = blocks[-1].kind
            if len(blocks) > 1:
                blocks.pop()
                words = outer.pop()
            words = [*words, "}"] if kind in ("data", "commands") else []
        else:
            if _begins(blocks[-1].kind, word, words):
                words = []
            words.append(word)
        last = word
    unfinished = last[:1] in ("'", '"') and (len(last) < 2 or last[-1] != last[0])
    if unfinished and "\n" in text[text.rfind(last) :]:
        unfinished = False
    return Context(tuple(blocks), tuple(words), typed.group() if typed else "", start, unfinished)


def _at_end(comment: str, end: int, offset: int) -> bool:
    """A line comment goes on where it ends."""
    return offset == end and (comment.startswith("//") or not comment.endswith("*/"))


def _begins(kind: str, word: str, words: list[str]) -> bool:
    """Does a word begin the next declaration of a block?"""
    if not words:
        return True
    last = words[-1]
    if kind == "object":
        # NAME : type NAME : type: a name behind a type begins the next property.
        return len(words) > 2 and words[1] == ":" and last not in (":", "(", "..", "-", "array")
    if kind == "enum":
        return len(words) > 1 and words[-2] == "->"
    if kind in ("data", "commands"):
        return word == ","
    if word not in _STARTS.get(kind, ()) or last in _EXPECT_NAME:
        return False
    return not (word in ("state", "marked") and last in ("initial", "marked"))


def _opened(block: Block, words: list[str]) -> Block:
    """The block that a brace opens behind these words."""
    header = tuple(words)
    first = words[0] if words else ""
    name = words[1].lstrip("^") if len(words) > 1 else ""
    match block.kind:
        case "file":
            return Block("library" if first == "library" else "robot", name, header)
        case "robot" | "library":
            if first == "datatype":
                kind = "enum" if "enum" in words[1:2] else "object"
                return Block(kind, words[2].lstrip("^") if len(words) > 2 else "", header)
            if first == "requirement":
                return Block("commands", "", header)
            if first == "provide":
                return Block("data", "", header)
            return Block("component", name, header)
        case "component":
            return Block("behaviour", "", header)
        case "behaviour":
            state = words.index("state") if "state" in words else -1
            named = words[state + 1] if 0 <= state < len(words) - 1 else ""
            return Block("state", named.lstrip("^"), header)
        case "data":
            return Block("data", words[-2].lstrip("^") if len(words) > 1 else "", header)
    return Block("unknown", "", header)
