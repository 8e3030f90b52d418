"""Blocks ``{ … }`` of declarations, and how reading goes on after a fault in one of them.

A declaration that fails is reported once and skipped; reading resumes at the next thing that looks
like a declaration of this block or of one around it. A brace that is missing or too many shows as
a declaration in the wrong block: the block is then closed, or opened again, as the declaration
demands, so that one wrong brace is one error.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from typing import Any

from pyparsing import ParseBaseException, ParseException, ParserElement

from robosc.errors import Note
from robosc.names import IDENTIFIER
from robosc.syntax.elements import Build, ModelText, skip_space, text_of

__all__ = ["Block", "Child", "Items", "Rule"]

_WORD = re.compile(IDENTIFIER, re.ASCII)
_NO_START = re.compile(r"\s*(?:[:.,=)\]<>*/+]|and\b|or\b|\Z)")


@dataclass(frozen=True)
class Rule:
    """One kind of declaration: its grammar behind the first keyword, and its node.

    ``look`` is a pattern that only such a declaration matches, wherever it stands. ``tail`` names
    what could still follow at its end, for messages. ``refusal`` says why the declaration, though
    well formed, may not stand here; it is then reported and left out.
    """

    body: ParserElement
    build: Build
    look: str
    tail: str = ""
    refusal: str = ""


@dataclass(frozen=True)
class Items:
    """What may stand in a block.

    ``rules`` are found by their first keyword. A block whose declarations begin with no keyword has
    ``free`` instead; ``begins`` is what one begins with, and ``resume`` where the next one may be
    sought: its group ``item`` begins one, behind its group ``past`` one begins.
    """

    words: str
    rules: dict[str, Rule]
    free: Rule | None = None
    begins: str = r"(?!)"
    resume: str = ""
    advice: dict[str, str] | None = None


@dataclass(frozen=True)
class Child:
    """A block inside this one, and how its late declarations are added to the node they belong to."""

    block: Block
    adopt: Callable[[Any, list[Any]], Any | None]


class Block(ParserElement):
    """``{ declaration* }``; leaves the nodes of its declarations."""

    def __init__(self, items: Items, *, child: Child | None = None) -> None:
        super().__init__()
        self.items = items
        self.child = child
        self.parent: Block | None = None
        if child:
            child.block.parent = self
        self.errmsg = "expected '{'"
        self.mayIndexError = False

    def inside(self, parent: Block) -> Block:
        """Tell a further block which one surrounds it."""
        self.parent = parent
        return self

    def _generateDefaultName(self) -> str:
        return "block"

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        text = text_of(instring)
        header = text.item_start, loc
        return self.read(text, self._open(text, loc), header)

    # --- what may stand where ---

    @cached_property
    def _outer(self) -> dict[str, Rule]:
        """First keywords of the declarations in all blocks around this one."""
        if self.parent is None:
            return {}
        return {**self.parent._outer, **self.parent.items.rules}

    @cached_property
    def _inner(self) -> frozenset[str]:
        """First keywords of the declarations in the blocks below this one."""
        if self.child is None:
            return frozenset()
        block = self.child.block
        return frozenset(block.items.rules) | block._inner

    @cached_property
    def _begins(self) -> re.Pattern[str]:
        return re.compile(self.items.begins, re.ASCII)

    @cached_property
    def _looks(self) -> dict[str, re.Pattern[str]]:
        rules = {**self._outer, **self.items.rules}
        return {word: re.compile(rule.look, re.ASCII) for word, rule in rules.items()}

    @cached_property
    def _landmarks(self) -> re.Pattern[str]:
        """Everything that matters between a fault and the next declaration."""
        words = "|".join(self._looks)
        resume = f"|{self.items.resume}" if self.items.resume else ""
        return re.compile(
            r"\"[^\"\n]*\"|'[^'\n]*'|(?P<open>\{)|(?P<close>\})"
            rf"|(?<![\w^.])(?P<word>{words})\b{resume}",
            re.ASCII,
        )

    def begins(self, text: ModelText, loc: int) -> bool:
        """Does a declaration of this block seem to begin here?"""
        if self.items.free:
            return self._begins.match(text, loc) is not None
        word = _WORD.match(text, loc)
        return word is not None and word.group() in self.items.rules

    # --- the opening brace ---

    def _open(self, text: ModelText, loc: int) -> int:
        """The place behind ``{``, which may be missing or come late."""
        if text.startswith("{", loc):
            return loc + 1
        if self.begins(text, loc):
            text.report("syntax", f"expected '{{' to open {_quoted(text, loc)}", loc)
            text.settled = loc
            return loc
        junk = re.compile(r"[^{}\n]*\{").match(text, loc)
        if junk and not self._landmarks.search(text, loc, junk.end() - 1):
            text.report("syntax", f"expected '{{' to open {_quoted(text, loc)}", loc)
            return junk.end()
        raise ParseException(text, loc, self.errmsg, self)

    # --- the declarations ---

    def belongs(self, text: ModelText, loc: int) -> bool:
        """Does a declaration of this block, or of one inside it, begin here?"""
        word = _word(text, loc)
        return word in self.items.rules or word in self._inner

    def read(
        self,
        text: ModelText,
        loc: int,
        header: tuple[int, int] | None,
        before: Sequence[Any] = (),
    ) -> tuple[int, list[Any]]:
        """Declarations up to the closing brace; the place behind it, and their nodes.

        ``header`` is the extent of what stands before the opening brace, for messages; None for a
        block that is opened again, whose end nobody will miss. ``before`` are the nodes that such a
        block has already.
        """
        nodes: list[Any] = list(before)
        tail = ""
        while True:
            loc = skip_space(text, loc)
            if text.startswith("}", loc):
                return loc + 1, nodes
            if loc >= len(text):
                self._end_of_file(text, header)
                return loc, nodes
            rule, after = self._rule(text, loc)
            if rule:
                loc = self._declaration(text, loc, after, rule, nodes)
                tail = rule.tail
                continue
            word = _word(text, loc)
            if self._belongs_outside(text, loc, word):
                self._close_early(text, loc, header)
                return loc, nodes
            if word in self._inner:
                loc = self._open_again(text, loc, word, nodes)
            else:
                loc = self._unexpected(text, loc, tail)
            tail = ""

    def _rule(self, text: ModelText, loc: int) -> tuple[Rule | None, int]:
        """The rule for the declaration at ``loc``, and where its grammar goes on."""
        if self.items.free:
            outside = self._belongs_outside(text, loc, _word(text, loc))
            return (None if outside else self.items.free), loc
        match = _WORD.match(text, loc)
        if match is None:
            return None, loc
        return self.items.rules.get(match.group()), match.end()

    def _declaration(
        self, text: ModelText, loc: int, after: int, rule: Rule, nodes: list[Any]
    ) -> int:
        text.item_start = loc
        depth = text.depth
        try:
            end, parts = rule.body._parse(text, after)
            node = rule.build(text, loc, end, list(parts))
        except ParseBaseException as fault:
            fault.__traceback__ = None
            text.depth = depth
            return self._recover(text, loc, fault)
        if rule.refusal:
            text.report("misplaced", rule.refusal, loc)
        else:
            nodes.append(node)
        return int(end)

    def _belongs_outside(self, text: ModelText, loc: int, word: str) -> bool:
        if word not in self._outer:
            return False
        return not self.items.free or self._looks[word].match(text, loc) is not None

    # --- faults ---

    def _recover(self, text: ModelText, start: int, fault: ParseBaseException) -> int:
        """Report the fault and find where to go on."""
        resume = self._resume(text, start, skip_space(text, fault.loc))
        text.report_fault(start, resume, fault)
        text.settled = resume if resume < len(text) else text.body_end
        return resume

    def _resume(self, text: ModelText, start: int, failed: int) -> int:
        depth = max(0, text.count("{", start, failed) - text.count("}", start, failed))
        for match in self._landmarks.finditer(text, failed):
            kind, at = match.lastgroup, match.start()
            if kind == "open":
                depth += 1
            elif kind == "close":
                if depth == 0:
                    return at
                depth -= 1
            elif at <= start or kind is None:
                continue
            elif kind == "word":
                if self._resumes_at(text, at, match.group(), depth):
                    return at
            elif depth == 0:
                return match.end() if kind == "past" else at
        return len(text)

    def _resumes_at(self, text: ModelText, at: int, word: str, depth: int) -> bool:
        """Is the keyword the beginning of a declaration, and of one that is not skipped too?"""
        if depth and word not in self._outermost:
            return False
        if self._looks[word].match(text, at):
            return True
        first = text[text.rfind("\n", 0, at) + 1 : at].strip() in ("", "}", "{")
        return first and not _NO_START.match(text, at + len(word)) and not self.items.free

    @cached_property
    def _outermost(self) -> frozenset[str]:
        block = self
        while block.parent is not None:
            block = block.parent
        return frozenset(block.items.rules)

    def _unexpected(self, text: ModelText, loc: int, tail: str) -> int:
        word = _word(text, loc)
        near = get_close_matches(word, self.items.rules, 1, 0.75) if word else []
        if near and len(word) < 40:
            return self._misspelt(text, loc, word, near[0])
        message = f"expected {tail + ', ' if tail else ''}{self.items.words} or '}}'"
        hint = (self.items.advice or {}).get(word)
        fault = ParseException(text, loc, message)
        if hint:
            text.report("syntax", message, loc, hint=hint)
            text.settled = loc
            return self._resume(text, loc, loc)
        return self._recover(text, loc, fault)

    def _misspelt(self, text: ModelText, loc: int, word: str, keyword: str) -> int:
        """Report the keyword; what follows is skipped like any faulty declaration."""
        text.report("syntax", f"expected {self.items.words}", loc, hint=f"did you mean '{keyword}'?")
        resume = self._resume(text, loc, loc + len(word))
        text.broken.update(_WORD.findall(text[loc:resume]))
        text.settled = resume
        return resume

    def _close_early(
        self, text: ModelText, loc: int, header: tuple[int, int] | None
    ) -> None:
        """A declaration of an outer block: this one was not closed."""
        if header is None or text.settled == loc:
            return
        text.settled = loc
        message = f"expected '}}' to close {_header(text, header)} before '{_word(text, loc)}'"
        text.report("missing-brace", message, loc, notes=_opened(text, header))

    def _end_of_file(self, text: ModelText, header: tuple[int, int] | None) -> None:
        told = text.reopened or text.scan.open_end or text.settled >= text.body_end
        if header is None or told:
            return
        text.settled = text.body_end
        message = f"expected '}}' to close {_header(text, header)}"
        text.report("missing-brace", message, len(text), notes=_opened(text, header))

    def _open_again(self, text: ModelText, loc: int, word: str, nodes: list[Any]) -> int:
        """A declaration of an inner block: that one was closed too early."""
        assert self.child is not None
        if text.settled != loc:
            text.settled = loc
            hint = "is there a '}' too many above?"
            text.report("unexpected-brace", f"'{word}' cannot stand here", loc, hint=hint)
        text.reopened = True
        end, late = self.child.block.read(text, loc, None)
        if nodes and (node := self.child.adopt(nodes[-1], late)) is not None:
            nodes[-1] = node
        else:
            text.broken.update(_WORD.findall(text[loc:end]))
        return end


def _word(text: ModelText, loc: int) -> str:
    match = _WORD.match(text, loc)
    return match.group() if match else ""


def _header(text: ModelText, header: tuple[int, int]) -> str:
    folded = " ".join(text[header[0] : header[1]].split())
    return f"'{folded[:60]}'"


def _quoted(text: ModelText, loc: int) -> str:
    return _header(text, (text.item_start, loc))


def _opened(text: ModelText, header: tuple[int, int]) -> tuple[Note, ...]:
    return (Note("it is opened here", text.span(*header)),)
