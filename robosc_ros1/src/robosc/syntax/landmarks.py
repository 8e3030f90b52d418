"""Where reading goes on after a fault.

Between the fault and the next declaration only a few things matter: braces, the first keywords of
declarations, and the beginnings of lines.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property, lru_cache

from robosc.names import IDENTIFIER
from robosc.syntax.elements import ModelText, skip_space
from robosc.syntax.keywords import LOOKS

__all__ = ["Landmarks", "nearest_keyword", "word_at"]

_WORD = re.compile(IDENTIFIER, re.ASCII)
_NO_START = re.compile(r"\s*(?:[:.,=)\]<>*/+]|and\b|or\b|\Z)")


@dataclass(frozen=True)
class Landmarks:
    """What to look for in one kind of block.

    ``own`` are the first keywords of its declarations, ``outer`` those of the blocks around it,
    ``outermost`` those of the file's block (which may be this one). ``marks`` is a pattern for
    blocks whose declarations begin with no keyword: its group ``item`` begins one, behind its
    group ``past`` one begins. ``meant`` are patterns of what people write instead of a keyword.
    """

    own: tuple[str, ...]
    outer: frozenset[str]
    outermost: frozenset[str]
    marks: str
    meant: tuple[str, ...]

    @cached_property
    def _pattern(self) -> re.Pattern[str]:
        words = "|".join(sorted(self.outer.union(self.own)))
        line = r"|(?P<line>(?<=\n)[ \t]*(?=[A-Za-z_]))" if self.own else ""
        marks = f"|{self.marks}" if self.marks else ""
        return re.compile(
            r"\"[^\"\n]*\"|'[^'\n]*'|(?P<open>\{)|(?P<close>\})"
            rf"{line}|(?<![\w^.])(?P<word>{words})\b{marks}",
            re.ASCII,
        )

    @cached_property
    def _looks(self) -> dict[str, re.Pattern[str]]:
        return {w: re.compile(LOOKS[w], re.ASCII) for w in self.outer.union(self.own)}

    @cached_property
    def _meant(self) -> list[re.Pattern[str]]:
        return [re.compile(pattern, re.ASCII) for pattern in self.meant]

    def looks_like(self, text: ModelText, loc: int, word: str) -> bool:
        """Is it beyond doubt that the keyword at ``loc`` begins a declaration?"""
        return self._looks[word].match(text, loc) is not None

    def any_in(self, text: ModelText, start: int, end: int) -> bool:
        return self._pattern.search(text, start, end) is not None

    def resume(self, text: ModelText, start: int, failed: int) -> int:
        """Where to go on after the declaration at ``start`` went wrong at ``failed``."""
        depth = max(0, text.count("{", start, failed) - text.count("}", start, failed))
        for match in self._pattern.finditer(text, failed):
            kind, at = match.lastgroup, match.start()
            if kind == "open":
                depth += 1
            elif kind == "close":
                if depth == 0 and not self._closes_nothing(text, at):
                    return at
                depth = max(0, depth - 1)
            elif at <= start or kind is None:
                continue
            elif kind == "line":
                if depth == 0 and self._is_misspelt(text, match.end()):
                    return match.end()
            elif kind == "word":
                if self._resumes_at(text, at, match.group(), depth):
                    return at
            elif depth == 0:
                return match.end() if kind == "past" else at
        return len(text)

    def _closes_nothing(self, text: ModelText, at: int) -> bool:
        """Only the end of the file, or a second robot, follows the last closing brace."""
        if self.outer or at >= text.body_end - 1:
            return False
        return word_at(text, skip_space(text, at + 1)) not in ("robot", "library")

    def _resumes_at(self, text: ModelText, at: int, word: str, depth: int) -> bool:
        """Does the keyword begin a declaration, and one that is not to be skipped as well?"""
        if depth and word not in self.outermost:
            return False
        if self.looks_like(text, at, word):
            return True
        before = text[text.rfind("\n", 0, at) + 1 : at].strip()
        follows = _NO_START.match(text, at + len(word)) is None
        return bool(self.own) and follows and before in ("", "}", "{")

    def _is_misspelt(self, text: ModelText, loc: int) -> bool:
        """Does a line begin with what was meant as a keyword of this block?"""
        word = word_at(text, loc)
        if _NO_START.match(text, loc + len(word)):
            return False
        if any(pattern.match(text, loc) for pattern in self._meant):
            return True
        return nearest_keyword(word, self.own) is not None


@lru_cache(maxsize=1024)
def nearest_keyword(word: str, keywords: tuple[str, ...]) -> str | None:
    """The keyword that a misspelt word was meant to be."""
    if not 4 <= len(word) <= 20 or word in keywords:
        return None
    near = get_close_matches(word, keywords, 1, 0.75)
    return near[0] if near else None


def word_at(text: str, loc: int) -> str:
    match = _WORD.match(text, loc)
    return match.group() if match else ""
