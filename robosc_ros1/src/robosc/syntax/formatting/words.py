"""The tokens of a model one by one, and the comments between them, for the formatter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from robosc.language.tokens import Comment, Tokens
from robosc.source import Source
from robosc.syntax.formatting.pretty_printing import Doc, Group, Line, Remark


@dataclass(frozen=True, slots=True)
class _Gap:
    """The comments between two words: ``behind`` the first, and ``before`` the second.

    ``blank`` says whether an empty line precedes each of the latter, and the second word.
    """

    behind: tuple[Remark, ...]
    before: tuple[Remark, ...]
    blank: tuple[bool, ...]

    @property
    def ends_line(self) -> bool:
        return bool(self.before) or any(remark.ends_line for remark in self.behind)


_PLAIN = (_Gap((), (), (False,)), _Gap((), (), (True,)))
"""Gaps without comments, without and with an empty line."""


class Words:
    """The words (tokens) of a model in order, each taken once, with its comments.

    ``index`` counts the words that were taken.
    """

    def __init__(self, tokens: Tokens) -> None:
        source = tokens.source
        spans = list(zip(tokens.starts, tokens.ends, strict=True))
        self._texts = [source.text[start:end] for start, end in spans]
        self._starts = [start for start, _ in spans]
        self._gaps = list(_gaps(source, spans, tokens.comments))
        self._ends_line = list(accumulate((gap.ends_line for gap in self._gaps), initial=0))
        self._line_ends = [
            "\n" in source.text[end:start] for (_, end), (start, _) in pairwise(spans)
        ]
        self._comments_taken = False
        self.index = 0

    @property
    def start(self) -> int:
        """The character offset of the next word."""
        return self._starts[self.index]

    def next_is(self, *texts: str) -> bool:
        return self.index < len(self._texts) and self._texts[self.index] in texts

    @property
    def line_ends_behind(self) -> bool:
        """Whether the next word is the last one on its line."""
        return self._line_ends[self.index]

    def take(self) -> Doc:
        """The next word with its comments."""
        before = () if self._comments_taken else self._gaps[self.index].before
        text = self._texts[self.index]
        self._comments_taken = False
        self.index += 1
        behind = self._gaps[self.index].behind
        return [*before, text, *behind] if before or behind else text

    def until(self, end: int) -> list[Doc]:
        """All words that begin before the offset ``end``, with no blanks between them."""
        docs: list[Doc] = []
        while self.index < len(self._texts) and self.start < end:
            docs.append(self.take())
        return docs

    def comments(self, first: bool) -> list[Doc]:
        """The comments before the next word, each on its line; no empty line first if ``first``."""
        gap = self._gaps[self.index]
        docs: list[Doc] = []
        for remark, blank in zip(gap.before, gap.blank, strict=False):
            docs += [Line(hard=True, blank=blank and not first), remark]
            first = False
        self._comments_taken = True
        return docs

    def beginning(self, first: bool) -> list[Doc]:
        """The line end before a declaration, with the comments and empty lines before it."""
        gap = self._gaps[self.index]
        docs = self.comments(first)
        first = first and not gap.before
        return [*docs, Line(hard=True, blank=gap.blank[-1] and not first)]

    def group(self, begin: int, docs: Sequence[Doc], broken: bool = False) -> Group:
        """A group of the words from index ``begin`` on; a comment among them breaks it."""
        ends = self._ends_line[self.index] - self._ends_line[begin + 1] if begin < self.index else 0
        return Group(docs, broken or ends > 0)


def _gaps(source: Source, spans: list[tuple[int, int]], comments: Sequence[Comment]) -> list[_Gap]:
    """One gap before each word and one behind the last."""
    gaps: list[_Gap] = []
    text = source.text
    end = 0
    index = 0
    upcoming = comments[0].start if comments else len(text)
    for start, next_end in [*spans, (len(text), len(text))]:
        if start <= upcoming:
            gaps.append(_PLAIN[text.count("\n", end, start) > 1])
            end = next_end
            continue
        behind: list[Remark] = []
        before: list[Remark] = []
        blank: list[bool] = []
        while index < len(comments) and comments[index].start < start:
            comment = comments[index]
            white = text[end : comment.start]
            own_line = bool(before) or "\n" in white or not gaps
            remark = Remark(comment.text, own_line, source.position(comment.start)[1] - 1)
            if own_line:
                before.append(remark)
                blank.append(white.count("\n") > 1)
            else:
                behind.append(remark)
            end = comment.end
            index += 1
        blank.append(text.count("\n", end, start) > 1)
        gaps.append(_Gap(tuple(behind), tuple(before), tuple(blank)))
        end = next_end
        upcoming = comments[index].start if index < len(comments) else len(text)
    return gaps
