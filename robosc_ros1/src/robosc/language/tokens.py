"""The lexer: model text to tokens, comments and lexical errors.

Each token has a *kind*, one character, so that the kinds of a text form a string: the grammar,
error recovery and other searches for sequences of tokens match regular expressions against it.
White space and comments are not part of it. Each keyword has two kinds: the second one is used
where it clearly starts the next declaration or clause, so that it cannot be a name.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from functools import cache, cached_property, lru_cache

from robosc import errors, limits, remedies
from robosc.language.keywords import KEYWORDS, UNITS, Role, words_of
from robosc.language.operators import infix_signs, symbols
from robosc.lazy_dataclasses import dataclass
from robosc.source import Source, Span

_PLAIN, INTEGER, NUMBER, BAD_NUMBER, STRING = "n", "0", "1", "9", "s"
_FIRST, _MARKED = 0x100, 0x100

ESCAPES = {"n": "\n", "t": "\t", "\\": "\\", '"': '"', "'": "'"}
"""The escape sequences of strings: the character after the backslash, and what it stands for."""

FOREIGN = {"==": "=", "<>": "!=", "=/=": "!=", "=<": "<="}
"""Operators of other languages, each with the equivalent one of this language."""

_SYMBOLS = ("{", "}", "(", ")", "[", "]", ",", ".", ":", "^", "->", ":=", "..")
_SIGNS = sorted({*_SYMBOLS, *FOREIGN, *symbols(words=False)})
_LONG = {sign: chr(0xA1 + n) for n, sign in enumerate(s for s in _SIGNS if len(s) > 1)}
_SHORT = "".join(sign for sign in _SIGNS if len(sign) == 1)
_MORE = ("not", "Hz", "once", "replace")
_WORDS = {word: chr(_FIRST + n) for n, word in enumerate((*KEYWORDS, *UNITS, *_MORE))}
"""Units and some more words are not keywords, but patterns refer to their kinds."""

_SPELLINGS = {**_LONG, **{symbol: symbol for symbol in _SHORT}, **_WORDS}

NAME = f"[{_PLAIN}{chr(_FIRST)}-{chr(_FIRST + _MARKED - 1)}]"
"""A pattern for the kinds of the words that can be a name."""

ANY_NAME = f"[{_PLAIN}{chr(_FIRST)}-{chr(_FIRST + 2 * _MARKED - 1)}]"
"""A pattern for the kinds of all words, including those that start the next declaration."""

_TOKEN = re.compile(
    rf"""
      (?P<word>\^?[A-Za-z_]\w*)
    | (?P<line>//[^\n]*)
    | (?P<block>/\*.*?(?:\*/|\Z))
    | (?P<symbol>{"|".join(re.escape(s) for s in sorted(_LONG, key=len, reverse=True))}
                |[{re.escape(_SHORT)}])
    | (?P<number>\d\w*(?:\.\d\w*)?(?:(?<=[eE])[+-]\w+)?)
    | (?P<string>"[^"\\\n]*(?:\\[^\n][^"\\\n]*)*\\?"?|'[^'\\\n]*(?:\\[^\n][^'\\\n]*)*\\?'?)
    | (?P<hash>\#[^\n]*)
    | (?P<bad>[^ \t\r\n\w"'{re.escape(_SHORT)}]+)
    """,
    re.VERBOSE | re.DOTALL | re.ASCII,
)

_DOUBLE = re.compile(r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?", re.ASCII)

_ADVICE: dict[str, remedies.Hint] = {
    ";": remedies.Remedy("no separator stands between declarations", remedies.Change.REMOVE),
    "&": "write 'and'; has(number, mask) tells whether bits are set",
    "|": "write 'or'; has(number, mask) tells whether bits are set",
    "&&": remedies.write("and"),
    "||": remedies.write("or"),
    "?": "there is no conditional expression: use 'provide … if', or 'if' in transitions",
    "#": "a comment begins with '//'",
    "~": remedies.write("!", " for 'not'"),
    "\u00a0": "a plain space is meant",
    "\u201c": "a straight quote is meant",
    "\u201d": "a straight quote is meant",
    "\u2018": "a straight quote is meant",
    "\u2019": "a straight quote is meant",
    "\u2013": "a plain '-' is meant",
    "\u2212": "a plain '-' is meant",
    "\u2264": remedies.write("<="),
    "\u2265": remedies.write(">="),
    "\u2260": remedies.write("!="),
}


_PART = re.compile(r"'(?P<symbol>\S+)'|(?P<word>[A-Z]?[a-z_]+)|(?P<class>[A-Z]+)|(?P<meta>\S+?)")
_CLASSES = {
    "NAME": NAME,
    "WORD": ANY_NAME,
    "INTEGER": INTEGER,
    "NUMBER": f"[{INTEGER}{NUMBER}{BAD_NUMBER}]",
    "STRING": STRING,
    "INFIX": "[" + "".join(re.escape(_SPELLINGS[sign]) for sign in infix_signs()) + "]",
    "FOREIGN": "[" + "".join(re.escape(_SPELLINGS[sign]) for sign in FOREIGN) + "]",
    "QUALIFIED": f"{NAME}(?:\\.{ANY_NAME})*",
}


@cache
def pattern(text: str) -> re.Pattern[str]:
    """Return a regular expression on kinds, compiled from the form that :func:`on_kinds` reads."""
    return re.compile(on_kinds(text))


def on_kinds(text: str) -> str:
    """Return a regular expression on kinds from a readable form.

    In ``NAME ':' (?! integer )`` words are keywords, symbols are quoted, and capitals are classes
    of tokens; all else is the syntax of regular expressions.
    """

    def kinds(match: re.Match[str]) -> str:
        if symbol := match["symbol"]:
            return re.escape(_SPELLINGS[symbol])
        if word := match["word"]:
            return f"[{''.join(kinds_of(word))}]"
        return _CLASSES[match["class"]] if match["class"] else match["meta"]

    return _PART.sub(kinds, text).replace(" ", "")


def kind_of(symbol: str) -> str:
    """Return the kind of a symbol."""
    return _SPELLINGS[symbol]


def kinds_of(spelling: str) -> tuple[str, ...]:
    """Return the kind of a symbol, or both kinds of a keyword (the second: not a name)."""
    kind = _SPELLINGS[spelling]
    return (kind, chr(ord(kind) + _MARKED)) if spelling in _WORDS else (kind,)


def is_word(kind: str) -> bool:
    return kind == _PLAIN or ord(kind[:1] or " ") >= _FIRST


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment with its delimiters."""

    text: str
    start: int
    end: int


@dataclass(frozen=True)
class Tokens:
    """The tokens of one source: their kinds, and where each begins and ends.

    ``faults`` are the offsets of all lexical errors, ascending; ``diagnostics`` describe the first
    of them. ``open_end``: an unterminated comment extends to the end of the file. ``binary``: the
    file is not a text file.
    """

    source: Source
    kinds: str
    starts: list[int]
    ends: list[int]
    comments: tuple[Comment, ...]
    diagnostics: tuple[errors.Diagnostic, ...]
    faults: tuple[int, ...]
    open_end: bool
    binary: bool = False

    def __len__(self) -> int:
        return len(self.starts)

    def text(self, index: int) -> str:
        """Return the text of a token; empty before the first and past the last one."""
        if not 0 <= index < len(self.starts):
            return ""
        return self.source.text[self.starts[index] : self.ends[index]]

    def texts(self, start: int = 0, end: int | None = None) -> Iterator[str]:
        """Yield the texts of the tokens from ``start`` up to, but not including, ``end``."""
        text = self.source.text
        for begin, stop in zip(self.starts[start:end], self.ends[start:end], strict=True):
            yield text[begin:stop]

    def offset(self, index: int) -> int:
        """Return the offset at which a token starts; the length of the text past the last one."""
        return self.starts[index] if index < len(self.starts) else len(self.source.text)

    def before(self, offset: int) -> int:
        """Return the number of tokens that start before ``offset``."""
        return bisect_left(self.starts, offset)

    def span(self, start: int, end: int) -> Span:
        """Return the span of the tokens from ``start`` up to, but not including, ``end``."""
        return Span(self.source, self.starts[start], self.ends[max(start, end - 1)])

    @cached_property
    def end(self) -> int:
        """The offset of the end of the last token."""
        return self.ends[-1] if self.ends else 0

    def begins_line(self, index: int) -> bool:
        """Whether a token is the first one on its line."""
        before = self.ends[index - 1] if index else 0
        return not index or "\n" in self.source.text[before : self.offset(index)]

    def is_fault(self, index: int) -> bool:
        """Whether a token is itself a lexical error, such as an unterminated string."""
        return self.has_fault(self.starts[index], self.starts[index] + 1)

    def has_fault(self, start: int, end: int) -> bool:
        """Whether there is a lexical error between two offsets."""
        index = bisect_left(self.faults, start)
        return index < len(self.faults) and self.faults[index] < end

    def follows_fault(self, index: int) -> bool:
        """Whether a lexical error directly precedes a token."""
        place = bisect_right(self.faults, self.offset(index)) - 1
        return place >= 0 and (not index or self.faults[place] >= self.ends[index - 1])


@lru_cache(maxsize=8)
def tokenize(source: Source, start: int = 0, end: int | None = None) -> Tokens:
    """Return the tokens of a source, or of the part between two offsets; never raises.

    The tokens of the latest sources are cached: the language server needs them several times, for
    parsing, highlighting and folding.
    """
    text = source.text
    end = len(text) if end is None else end
    if (nul := text.find("\0")) >= 0:
        fault = _error(source, "bad-character", nul, nul + 1, "the file contains a NUL character")
        return Tokens(source, "", [], [], (), (fault,), (nul,), False, binary=True)
    kinds: list[str] = []
    starts: list[int] = []
    ends: list[int] = []
    comments: list[Comment] = []
    faults: list[tuple[str, int, int]] = []
    mark = not start and text.startswith("\ufeff")
    for match in _TOKEN.finditer(text, 1 if mark else start, end):
        what, found = match.lastgroup or "", match.group()
        if kind := _kind(what, found):
            kinds.append(kind)
            starts.append(match.start())
            ends.append(match.end())
        elif what in ("line", "block"):
            comments.append(Comment(found, match.start(), match.end()))
        if _is_faulty(what, found):
            faults.append((what, match.start(), match.end()))
    return Tokens(
        source,
        _marked(text, "".join(kinds), starts, ends),
        starts,
        ends,
        tuple(comments),
        tuple(_fault(source, *fault) for fault in faults[: limits.LEXICAL_ERRORS + 1]),
        tuple(place for _, place, _ in faults),
        open_end=bool(faults) and faults[-1][0] == "block",
    )


def _kind(what: str, text: str) -> str:
    """The kind of a match of ``_TOKEN``; empty for what is no token."""
    if what in ("word", "symbol"):
        return _SPELLINGS.get(text, _PLAIN)
    if what == "number":
        return INTEGER if text.isdigit() else NUMBER if _DOUBLE.fullmatch(text) else BAD_NUMBER
    return STRING if what == "string" and len(text) > 1 else ""


def _is_faulty(what: str, text: str) -> bool:
    """Whether a match of ``_TOKEN`` is a lexical error."""
    if what == "string":
        body = text[1:-1]
        escaped = (len(body) - len(body.rstrip("\\"))) % 2
        return len(text) < 2 or text[-1] != text[0] or bool(escaped)
    if what == "block":
        return len(text) < 4 or not text.endswith("*/")
    return what in ("hash", "bad")


_EVENT = " | ".join(words_of(Role.EVENT))

LOOKS = {
    word: on_kinds(f"{word} {rest}")
    for word, rest in {
        "component": "(?= NAME (?: '{' | '[' | from ) )",
        "requirement": "(?! and | or | needs | disables )"
        " (?= QUALIFIED (?! ':' ) | '(' | '{' | '!' | STRING )",
        "provide": "(?= QUALIFIED with )",
        "datatype": "(?= (?: object | enum ) (?! ':' | '.' ) )",
        "interface": "(?= NAME use )",
        "incoming": "(?= message (?! ':' | '.' ) )",
        "outgoing": "(?= (?: message | service | transform ) (?! ':' | '.' ) )",
        "service": "(?= NAME with )",
        "action": "(?= NAME with )",
        "behaviour": "(?= '{' )",
        "variable": "(?= NAME ':' )",
        "persistent": "(?= variable )",
        "initial": "(?= marked? state )",
        "marked": "(?= state )",
        "state": "(?= NAME '{' )",
        "on": f"(?= (?: {_EVENT} ) (?: ',' (?: {_EVENT} ) )* (?: from | to ) )",
        "after": "(?= (?: NUMBER | NAME ) (?: WORD )? (?: if | do | goto ) )",
        "constant": "(?= NAME ':' WORD )",
        "parameter": "(?= NAME ':' WORD )",
        "condition": "(?= NAME '=' )",
        "function": "(?= NAME '(' NAME ':' )",
        "prefer": "(?= QUALIFIED (?: over | except ) | '{' | STRING )",
        "assume": "(?= STRING | (?: always | never | QUALIFIED needs ) )",
        "stop": "(?= with )",
        "for": "(?= NAME in )",
        "transition": "(?= if | goto )",
    }.items()
}
"""The first keyword of each declaration, with a pattern that hardly anything else matches."""

_NO_NAME = " | ".join((*LOOKS, *words_of(Role.CLAUSE), *words_of(Role.OPERATOR)))
_CLAUSE = pattern(f"(?: do | goto | needs | disables | not ) (?! {_NO_NAME} ) (?= NAME )")
_DECLARATION = re.compile("|".join(LOOKS.values()))


def _marked(text: str, kinds: str, starts: list[int], ends: list[int]) -> str:
    """Return the kinds with the second kind for words that clearly start a declaration or clause.

    Where a name is expected, it is then reported as missing.
    """
    found = [
        match.start()
        for match in _CLAUSE.finditer(kinds)
        if "\n" not in text[ends[match.start()] : starts[match.end()]]
    ]
    for match in _DECLARATION.finditer(kinds):
        index = match.start()
        if not index or "\n" in text[ends[index - 1] : starts[index]]:
            found.append(index)
    changed = list(kinds)
    for index in found:
        changed[index] = chr(ord(kinds[index]) + _MARKED)
    return "".join(changed)


def _fault(source: Source, what: str, start: int, end: int) -> errors.Diagnostic:
    if what == "hash":  # what follows is meant as a comment
        return _bad_character(source, start, start + 1)
    if what == "bad":
        return _bad_character(source, start, end)
    if what == "string":
        message = "this string has no end"
        return _error(
            source, "unterminated-string", start, end, message, _close(source.text[start])
        )
    message = "this comment has no end"
    return _error(source, "unterminated-comment", start, start + 2, message, _close("*/"))


def _close(sign: str) -> remedies.Remedy:
    return remedies.Remedy(f"close it with {sign}", remedies.Change.CLOSE, (sign,))


def _bad_character(source: Source, start: int, end: int) -> errors.Diagnostic:
    found = source.text[start:end]
    shown = found if found.isprintable() else " ".join(f"U+{ord(c):04X}" for c in found[:4])
    if len(shown) > 20:
        shown = shown[:20] + "…"
    if found.isalpha():
        hint: remedies.Hint | None = "names have the letters a-z and A-Z, digits and '_'"
    else:
        hint = _ADVICE.get(found) or _ADVICE.get(found[0])
    return _error(source, "bad-character", start, end, f"'{shown}' has no meaning here", hint)


def _error(
    source: Source, code: str, start: int, end: int, message: str, hint: remedies.Hint | None = None
) -> errors.Diagnostic:
    return errors.Diagnostic(errors.Severity.ERROR, code, message, Span(source, start, end), hint)
