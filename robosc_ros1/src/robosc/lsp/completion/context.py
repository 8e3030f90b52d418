"""Where in the language a place in an unfinished text is: what the words before it are part of.

The parser has no use for half a declaration; completion lives on them. So only words and braces are
looked at here, and whatever is wrong further up does no harm beyond its block.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import replace

from robosc.language import keywords, operators
from robosc.language.tokens import STRING, Tokens, is_word, tokenize
from robosc.lazy_dataclasses import dataclass
from robosc.source import Source, common_ends

_EXPECT_NAME = frozenset({
    ".", "robot", "library", "component", "constant", "parameter", "condition", "function",
    "requirement", "assume", "provide", "interface", "message", "service", "action",
    "variable", "state",
    "from", "to", "goto", "do", "if", "needs", "disables", "never", "always", "possible", "while",
    "use", "import", "links", "object", "enum", "->", ":=", "(", ",", ":", "[",
    *operators.symbols(words=True), *operators.symbols(words=False),
})  # fmt: skip
"""After these a word is a name rather than the beginning of the next declaration."""


@dataclass(frozen=True, slots=True)
class OpenBlock:
    """An open brace: what it belongs to, the name of that, and the words in front of it."""

    kind: str
    name: str
    header: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Context:
    """The open blocks around a place from outside in, and the words of its own declaration.

    ``kinds`` are those of its tokens behind its first keyword, if it has one; the braces of data
    and of commands are among them.
    ``prefix`` is the word that is being typed, from ``start`` on; it is not among ``words``.
    ``ahead`` are the words that follow soon. In a comment or a string nothing is expected:
    ``inside_text``.
    """

    blocks: tuple[OpenBlock, ...]
    words: tuple[str, ...]
    prefix: str
    start: int
    inside_text: bool = False
    ahead: tuple[str, ...] = ()
    kinds: str = ""

    @property
    def block(self) -> OpenBlock:
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

    @property
    def home(self) -> OpenBlock:
        """The block of which the declaration is one."""
        return next(b for b in reversed(self.blocks) if b.kind not in WITHIN)

    @property
    def head(self) -> tuple[str, ...]:
        """The words of the declaration, up to the first brace that is open in it."""
        return next((b.header for b in self.blocks if b.kind in WITHIN), self.words)

    def around(self, kind: str) -> OpenBlock | None:
        return next((b for b in reversed(self.blocks) if b.kind == kind), None)


WITHIN = ("data", "commands")
"""The blocks that are part of a declaration."""

_WITHOUT_KEYWORDS = ("object", "enum")
"""The blocks whose declarations begin with no keyword."""

_AHEAD = 200
"""So many characters behind a place, and the rest of that line, are read as well."""

_FILE = OpenBlock("file", "", ())


class Landmarks:
    """Places in a text that is being typed from which on it can be read: behind a block that ended.

    So what a place is part of is known without reading all that stands before it.
    """

    def __init__(self) -> None:
        self._text = ""
        self._places: list[tuple[int, tuple[OpenBlock, ...]]] = [(0, (_FILE,))]

    def last(self, text: str, offset: int) -> tuple[int, tuple[OpenBlock, ...]]:
        """The last known place up to an offset in a text, and the blocks that are open there."""
        same, _ = common_ends(self._text, text)
        behind_same = bisect_right(self._places, same, key=lambda place: place[0])
        del self._places[max(1, behind_same) :]
        self._text = text
        return self._places[bisect_right(self._places, offset, key=lambda place: place[0]) - 1]

    def add(self, offset: int, blocks: tuple[OpenBlock, ...]) -> None:
        if offset > self._places[-1][0]:
            self._places.append((offset, blocks))


def context_at(source: Source, offset: int, landmarks: Landmarks | None = None) -> Context:
    """The context of a place; ``landmarks`` are those of an earlier text of this document."""
    landmarks = landmarks or Landmarks()
    begin, opened = landmarks.last(source.text, offset)
    line_end = source.text.find("\n", offset + _AHEAD)
    tokens = tokenize(source, begin, line_end if line_end >= 0 else None)
    if any(c.start < offset < c.end or _at_end(c.text, c.end, offset) for c in tokens.comments):
        return Context((_FILE,), (), "", offset, inside_text=True)
    end = tokens.before(offset)
    ahead = tuple(tokens.texts(end))
    prefix, start, inside = "", offset, False
    if end and tokens.ends[end - 1] >= offset:
        start = tokens.starts[end - 1]
        prefix = source.text[start:offset]
        inside = tokens.kinds[end - 1] == STRING and _is_open(tokens, end - 1, offset)
        if is_word(tokens.kinds[end - 1]):
            end -= 1
        else:
            prefix, start = "", offset
    blocks = [*opened]
    words: list[str] = []
    outer: list[list[str]] = [[] for _ in blocks[1:]]
    first = 0
    for index, word in enumerate(tokens.texts(0, end)):
        if word == "{":
            blocks.append(_opened(blocks[-1], words))
            if blocks[-1].kind not in WITHIN:
                first = index + 1
            outer.append(words)
            words = []
        elif word == "}":
            kind = blocks[-1].kind
            if len(blocks) > 1:
                blocks.pop()
                words = outer.pop()
            words = [*words, "}"] if kind in WITHIN else []
            if not words:
                first = index + 1
            if len(blocks) == 2 and not words:
                landmarks.add(tokens.ends[index], tuple(blocks))
        else:
            if _begins(blocks[-1].kind, word, words):
                words = []
                if blocks[-1].kind not in WITHIN:
                    first = index
            words.append(word)
    context = Context(tuple(blocks), tuple(words), prefix, start, inside, ahead)
    first += context.home.kind not in _WITHOUT_KEYWORDS
    return replace(context, kinds=tokens.kinds[first:end])


def _is_open(tokens: Tokens, index: int, offset: int) -> bool:
    """Is a place in a string, or at the end of one that is not closed?"""
    return offset < tokens.ends[index] or tokens.is_fault(index)


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
    if kind in WITHIN:
        return word == "," and not _is_within(words, "[", "]") and not _is_within(words, "(", ")")
    if word == "for" and _is_within(words, "(", ")"):
        return False  # of an aggregate: any(s.on for s in Station)
    if word not in keywords.starts_of(kind) or last in _EXPECT_NAME:
        return False
    if word in ("service", "action") and words == ["outgoing"]:
        return False
    if word == "variable" and last == "persistent":
        return False
    return not (word in ("state", "marked") and last in ("initial", "marked"))


def _is_within(words: list[str], opening: str, closing: str) -> bool:
    return words.count(opening) > words.count(closing)


_STATEMENTS = {
    **dict.fromkeys(("requirement", "prefer"), "commands"),
    **dict.fromkeys(("provide", "constant", "parameter", "function"), "data"),
}


def _statement(header: tuple[str, ...]) -> OpenBlock | None:
    """The block in a statement; None if the words do not begin one with a block."""
    kind = _STATEMENTS.get(header[0]) if header else None
    return None if kind is None else OpenBlock(kind, "", header)


def _opened(block: OpenBlock, words: list[str]) -> OpenBlock:
    """The block that a brace opens behind these words."""
    header = tuple(words)
    first = words[0] if words else ""
    name = words[1].lstrip("^") if len(words) > 1 else ""
    match block.kind:
        case "file":
            return OpenBlock("library" if first == "library" else "robot", name, header)
        case "robot" | "library" | "for":
            if first == "datatype":
                kind = "enum" if "enum" in words[1:2] else "object"
                return OpenBlock(kind, words[2].lstrip("^") if len(words) > 2 else "", header)
            if first == "for":
                return OpenBlock("for", "", header)
            return _statement(header) or OpenBlock("component", name, header)
        case "component":
            return _statement(header) or OpenBlock("behaviour", "", header)
        case "behaviour" | "state" if first == "on":
            return OpenBlock("commands", "", header)
        case "behaviour" | "state" if words[-1:] == ["with"]:
            return OpenBlock("data", "", header)
        case "behaviour" | "state":
            state = words.index("state") if "state" in words else -1
            named = words[state + 1] if 0 <= state < len(words) - 1 else ""
            return OpenBlock("state", named.lstrip("^"), header)
        case "data":
            place = words.index(":") if ":" in words else 0
            return OpenBlock("data", words[place - 1].lstrip("^") if place else "", header)
    return OpenBlock("unknown", "", header)


# Names with dots in unfinished text, and what the variables of aggregates stand for there.
#
# A chain is a list of names, ``[]`` for an index: ``value.a[0].b`` is value, a, [], b.


_CLOSING = {"(": ")", "[": "]", "{": "}"}


def names_before(words: Sequence[str]) -> list[str]:
    """The chain before the last dot: ``value.a[0].`` gives value, a, []."""
    names: list[str] = []
    place = len(words) - 2
    while place >= 0:
        if words[place] == "]" and "[" in words[:place]:
            names.append("[]")
            place -= words[place::-1].index("[") + 1
            continue
        names.append(words[place].lstrip("^"))
        if place == 0 or words[place - 1] != ".":
            break
        place -= 2
    return names[::-1]


def aggregate_variables(context: Context) -> dict[str, list[str]]:
    """The variables of the aggregates around a place, each with the chain of one element.

    A position, which is a number, has none.

    In ``any(d.| for d in value.seen[1..3])`` d is value, seen, [].
    """
    words = (*context.words, *context.ahead)
    variables: dict[str, list[str]] = {}
    closed = 0
    for place in reversed(range(len(context.words))):
        if words[place] in _CLOSING.values():
            closed += 1
        elif words[place] in _CLOSING and closed:
            closed -= 1
        elif words[place] in ("(", "["):
            begin = _for_of(words, place + 1)
            if begin is not None:
                behind = words.index("in", begin)
                variables[words[behind - 1].lstrip("^")] = _element(words[behind + 1 :])
                if behind > begin + 2:
                    variables[words[begin + 1].lstrip("^")] = []
    return variables


def _for_of(words: Sequence[str], begin: int) -> int | None:
    """The place of ``for NAME in`` or ``for NAME, NAME in``, in the bracket open at ``begin``."""
    opened = 0
    for place in range(begin, len(words) - 3):
        if words[place] in _CLOSING:
            opened += 1
        elif words[place] in _CLOSING.values():
            opened -= 1
            if opened < 0:
                break
        elif (
            words[place] == "for"
            and not opened
            and "in" in (words[place + 2], *words[place + 4 : place + 5])
        ):
            return place
    return None


def _element(words: Sequence[str]) -> list[str]:
    """The chain of one element of the array, list or components that these words begin with."""
    if words[0] == "[":
        chain, begin = _chain(words[1:]), _for_of(words, 1)
        behind = 0 if begin is None else words.index("in", begin)
        if begin is not None and chain[:1] == [words[behind - 1].lstrip("^")]:
            return [*_element(words[behind + 1 :]), *chain[1:]]
        return chain
    return [*_chain(words), "[]"]


def _chain(words: Sequence[str]) -> list[str]:
    """The chain that words begin with; a slice is as the whole array."""
    chain = [words[0].lstrip("^")] if words else []
    place = 1
    while place < len(words) - 1:
        if words[place] == ".":
            chain.append(words[place + 1].lstrip("^"))
            place += 2
        elif words[place] == "[" and "]" in words[place:]:
            end = words.index("]", place)
            chain += [] if ".." in words[place:end] else ["[]"]
            place = end + 1
        else:
            break
    return chain
