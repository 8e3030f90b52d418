"""Error recovery: the token at which parsing resumes after a fault.

Between the fault and the next declaration only a few tokens matter, the *synchronising* ones (Aho,
Lam, Sethi, Ullman, *Compilers*, section 4.1.4): braces, the first keywords of declarations, and the
beginnings of lines.
"""

from __future__ import annotations

import re
from difflib import get_close_matches
from functools import cached_property, lru_cache

from robosc.language.tokens import LOOKS, is_word, pattern
from robosc.lazy_dataclasses import dataclass
from robosc.syntax.parse_state import ParseState
from robosc.syntax.recovery.habits import FOREIGN_WORDS

_NO_START = pattern("':' | '.' | '..' | ',' | INFIX | FOREIGN | ')' | ']' | ':=' | and | or")
_FAR = 50
"""How many tokens behind its place a late opening brace is searched for."""


@dataclass(frozen=True)
class Synchroniser:
    """The synchronising tokens of one kind of block.

    ``own`` are the first keywords of its declarations, ``outer`` those of the enclosing blocks,
    ``outermost`` those of the file's block (which may be this one). In blocks whose declarations
    begin with no keyword, one begins where the pattern ``item`` matches, behind a match of
    ``past``, and, if ``lines``, at the beginning of a line. ``meant`` are patterns of what people
    write instead of a keyword.
    """

    own: tuple[str, ...]
    outer: frozenset[str]
    outermost: frozenset[str]
    item: re.Pattern[str]
    past: re.Pattern[str]
    lines: bool
    meant: tuple[re.Pattern[str], ...]

    @cached_property
    def _words(self) -> frozenset[str]:
        return self.outer.union(self.own)

    def looks_like(self, reading: ParseState, at: int, word: str) -> bool:
        """Whether the tokens behind a keyword confirm that it begins a declaration."""
        return re.compile(LOOKS[word]).match(reading.kinds, at) is not None

    def any_in(self, reading: ParseState, start: int, end: int) -> bool:
        """Whether parsing could resume at any of the tokens ``start..end``."""
        return any(
            self._is_keyword(reading, at) or self._item_at(reading, at) for at in range(start, end)
        )

    def _is_keyword(self, reading: ParseState, at: int) -> bool:
        is_word_of_block = reading.text(at) in self._words and not _is_member(reading, at)
        return is_word_of_block and not _in_brackets(reading, at)

    def _item_at(self, reading: ParseState, at: int) -> bool:
        return self.item.match(reading.kinds, at) is not None and not _is_member(reading, at)

    def resume(self, reading: ParseState, start: int, failed: int) -> int:
        """The token at which to resume after the declaration at ``start`` failed at ``failed``."""
        kinds = reading.kinds
        depth = max(0, kinds.count("{", start, failed) - kinds.count("}", start, failed))
        at = failed
        while at < len(kinds):
            kind = kinds[at]
            if kind == "{":
                depth += 1
            elif kind == "}":
                if depth == 0 and not self._closes_nothing(reading, at):
                    return at
                depth = max(0, depth - 1)
            elif at > start and self._is_synchronising(reading, at, failed, depth):
                return at
            elif depth == 0 and (past := self.past.match(kinds, at)):
                return past.end()
            at += 1
        return len(kinds)

    def _closes_nothing(self, reading: ParseState, at: int) -> bool:
        """Whether a ``}`` of the file's block is superfluous, as more than the end follows it."""
        if self.outer or at >= len(reading.kinds) - 1:
            return False
        return reading.text(at + 1) not in ("robot", "library")

    def _is_synchronising(self, reading: ParseState, at: int, failed: int, depth: int) -> bool:
        """Whether a declaration begins at a token that is no brace."""
        if is_word(reading.kinds[at]) and self._resumes_at(reading, at, failed, depth):
            return True
        return depth == 0 and self._begins_item(reading, at, failed)

    def _begins_item(self, reading: ParseState, at: int, failed: int) -> bool:
        if self.lines and at > failed and reading.tokens.begins_line(at):
            return True
        return self._item_at(reading, at)

    def _resumes_at(self, reading: ParseState, at: int, failed: int, depth: int) -> bool:
        """Whether a word begins a declaration, or is a misspelt keyword that does."""
        word = reading.text(at)
        first = reading.tokens.begins_line(at)
        if self.own and first and at > failed and depth == 0 and self._is_misspelt(reading, at):
            return True
        if not self._is_keyword(reading, at) or (depth and word not in self.outermost):
            return False
        if self.looks_like(reading, at, word):
            return True
        follows = self._something_follows(reading, at)
        return bool(self.own) and follows and (first or reading.kind(at - 1) in ("{", "}"))

    def _something_follows(self, reading: ParseState, at: int) -> bool:
        """Whether the tokens behind a word could belong to a declaration that it begins."""
        if at + 1 >= len(reading.kinds):
            return False
        return _NO_START.match(reading.kinds, at + 1) is None

    def _is_misspelt(self, reading: ParseState, at: int) -> bool:
        """Whether a word was probably meant as a keyword of this block."""
        if not self._something_follows(reading, at) or reading.text(at + 1) in self.own:
            return False
        if any(kinds.match(reading.kinds, at) for kinds in self.meant):
            return True
        return nearest_keyword(reading.text(at), self.own) is not None


def late_brace(reading: ParseState, at: int) -> int | None:
    """The next ``{`` on the line of a token; None if a ``}`` or the line's end comes first."""
    for place in range(at, min(at + _FAR, len(reading.kinds))):
        if reading.kinds[place] == "}" or (place > at and reading.tokens.begins_line(place)):
            return None
        if reading.kinds[place] == "{":
            return place
    return None


def _in_brackets(reading: ParseState, at: int) -> bool:
    """Whether a bracket is open before a word on its line: an aggregate has 'for' and 'if'."""
    depth = 0
    while at and not reading.tokens.begins_line(at):
        at -= 1
        depth += (reading.kinds[at] in ")]") - (reading.kinds[at] in "([")
        if depth < 0:
            return True
    return False


def _is_member(reading: ParseState, at: int) -> bool:
    """Whether a word follows a dot or an escape without a blank between."""
    tokens = reading.tokens
    return at > 0 and reading.kinds[at - 1] in ".^" and tokens.ends[at - 1] == tokens.starts[at]


@lru_cache(maxsize=1024)
def nearest_keyword(word: str, keywords: tuple[str, ...]) -> str | None:
    """The keyword that a misspelt word was probably meant to be; None if there is none near."""
    if not 4 <= len(word) <= 20 or word in keywords or word in FOREIGN_WORDS:
        return None
    near = get_close_matches(word, keywords, 1, 0.75)
    return near[0] if near else None
