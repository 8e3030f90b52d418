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
from functools import cached_property, lru_cache
from typing import Any

from pyparsing import ParseBaseException, ParseException, ParserElement

from robosc.errors import Note
from robosc.names import IDENTIFIER
from robosc.syntax.elements import Build, Fault, ModelText, skip_space, text_of
from robosc.syntax.keywords import LOOKS

__all__ = ["Block", "Child", "Items", "Rule"]

_WORD = re.compile(IDENTIFIER, re.ASCII)
_JUNK = re.compile(r"[^{}\n]{0,200}\{")
_CLOSE = "'}'"
_NO_START = re.compile(r"\s*(?:[:.,=)\]<>*/+]|and\b|or\b|\Z)")


@dataclass(frozen=True)
class Rule:
    """One kind of declaration: its grammar behind the first keyword, and its node.

    ``tail`` names what could still follow at the end of a node, for messages. ``refusal`` says why
    the declaration, though well formed, may not stand here; it is then reported and left out.
    """

    body: ParserElement
    build: Build
    tail: Callable[[Any], tuple[str, ...]] = lambda node: ()
    refusal: str = ""


@dataclass(frozen=True)
class Items:
    """What may stand in a block.

    ``words`` name the declarations in messages. ``rules`` are found by their first keyword. A block whose declarations begin with no keyword has
    ``free`` instead; ``begins`` is what one begins with, and ``resume`` where the next one may be
    sought: its group ``item`` begins one, behind its group ``past`` one begins. ``advice`` are
    patterns of what people write in such a block, each with its remedy.
    """

    words: tuple[str, ...]
    rules: dict[str, Rule]
    free: Rule | None = None
    begins: str = r"(?!)"
    resume: str = ""
    advice: tuple[tuple[str, str], ...] = ()


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
        for rule in (*items.rules.values(), items.free):
            if rule:
                # pyparsing does this only for what it can reach from the element it is started on.
                rule.body.streamline()
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
        return {word: re.compile(LOOKS[word], re.ASCII) for word in rules}

    @cached_property
    def _landmarks(self) -> re.Pattern[str]:
        """Everything that matters between a fault and the next declaration."""
        words = "|".join(self._looks)
        line = "" if self.items.free else r"|(?P<line>(?<=\n)[ \t]*(?=[A-Za-z_]))"
        resume = f"|{self.items.resume}" if self.items.resume else ""
        return re.compile(
            r"\"[^\"\n]*\"|'[^'\n]*'|(?P<open>\{)|(?P<close>\})"
            rf"{line}|(?<![\w^.])(?P<word>{words})\b{resume}",
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
        junk = _JUNK.match(text, loc)
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
        tail: tuple[str, ...] = ()
        while True:
            loc = skip_space(text, loc)
            if text.startswith("}", loc):
                return loc + 1, nodes + text.lifted.pop(self, [])
            if loc >= len(text) or text.exhausted:
                self._end_of_file(text, header)
                return len(text), nodes
            if text.startswith("{", loc) and not nodes:
                text.report("unexpected-brace", "this '{' opens nothing", loc)
                loc += 1
                continue
            rule, after = self._rule(text, loc)
            if rule:
                count = len(nodes)
                loc = self._declaration(text, loc, after, rule, nodes)
                tail = rule.tail(nodes[-1]) if len(nodes) > count else ()
                continue
            word = _word(text, loc)
            if self._belongs_outside(text, loc, word):
                if header and _is_nested(text, loc, header):
                    loc = self._misplaced(text, loc, word, header)
                    continue
                self._close_early(text, loc, header)
                return loc, nodes
            if word in self._inner:
                loc = self._open_again(text, loc, word, nodes)
            else:
                loc = self._unexpected(text, loc, tail, nodes)
            tail = ()

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
        self,
        text: ModelText,
        loc: int,
        after: int,
        rule: Rule,
        nodes: list[Any],
        told: bool = False,
    ) -> int:
        """Read one declaration; ``told`` says that a fault in it was reported already."""
        text.item_start = loc
        depth = text.depth
        try:
            end, parts = rule.body._parse(text, after)
            node = rule.build(text, loc, end, list(parts))
        except ParseBaseException as fault:
            fault.__traceback__ = None
            text.depth = depth
            return self._recover(text, loc, fault, told)
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

    def _recover(
        self, text: ModelText, start: int, fault: ParseBaseException, told: bool = False
    ) -> int:
        """Report the fault and find where to go on."""
        resume = self.resume(text, start, skip_space(text, fault.loc))
        text.skipped(start, resume)
        if not told:
            text.report_fault(start, resume, fault)
        text.settled = resume if resume < len(text) else text.body_end
        return resume

    def resume(self, text: ModelText, start: int, failed: int) -> int:
        """Where to go on after the declaration at ``start`` went wrong at ``failed``."""
        depth = max(0, text.count("{", start, failed) - text.count("}", start, failed))
        for match in self._landmarks.finditer(text, failed):
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
        """The brace that closes a file's outermost block is its last character."""
        return self.parent is None and at < text.body_end - 1

    def _resumes_at(self, text: ModelText, at: int, word: str, depth: int) -> bool:
        """Is the keyword the beginning of a declaration, and of one that is not skipped too?"""
        if depth and word not in self._outermost:
            return False
        if self._looks[word].match(text, at):
            return True
        first = text[text.rfind("\n", 0, at) + 1 : at].strip() in ("", "}", "{")
        return first and not _NO_START.match(text, at + len(word)) and not self.items.free

    def _is_misspelt(self, text: ModelText, loc: int) -> bool:
        """Does a line begin with what was meant as a keyword of this block?"""
        word = _word(text, loc)
        if _NO_START.match(text, loc + len(word)):
            return False
        if any(re.compile(pattern).match(text, loc) for pattern, _ in self.items.advice):
            return word not in ("if", "do")
        return _near(word, tuple(self.items.rules)) is not None

    @cached_property
    def _outermost(self) -> frozenset[str]:
        block = self
        while block.parent is not None:
            block = block.parent
        return frozenset(block.items.rules)

    def _unexpected(
        self, text: ModelText, loc: int, tail: tuple[str, ...], nodes: list[Any]
    ) -> int:
        word = _word(text, loc)
        if near := _near(word, tuple(self.items.rules)):
            return self._misspelt(text, loc, word, near, nodes)
        message = f"expected {_either((*tail, *self.items.words, _CLOSE))}"
        for pattern, hint in self.items.advice:
            if re.compile(pattern).match(text, loc):
                return self._recover(text, loc, Fault(text, loc, message, hint=hint))
        return self._recover(text, loc, ParseException(text, loc, message))

    def _misspelt(
        self, text: ModelText, loc: int, word: str, keyword: str, nodes: list[Any]
    ) -> int:
        """Report the keyword and read the declaration as what was meant."""
        message = f"expected {_either(self.items.words)}"
        text.report("syntax", message, loc, hint=f"did you mean '{keyword}'?")
        rule = self.items.rules[keyword]
        return self._declaration(text, loc, loc + len(word), rule, nodes, told=True)

    def _close_early(
        self, text: ModelText, loc: int, header: tuple[int, int] | None
    ) -> None:
        """A declaration of an outer block: this one was not closed."""
        if header is None or text.settled == loc:
            return
        text.settled = loc
        message = f"expected '}}' to close {_header(text, header)} before '{_word(text, loc)}'"
        text.report("missing-brace", message, loc, notes=_opened(text, header))

    def _misplaced(self, text: ModelText, loc: int, word: str, header: tuple[int, int]) -> int:
        """A declaration that stands one block too deep: read it, and give it to the right one."""
        message = f"'{word}' cannot stand inside {_header(text, header)}"
        text.report("misplaced", message, loc, notes=_opened(text, header))
        owner = self.parent
        while owner and word not in owner.items.rules:
            owner = owner.parent
        assert owner is not None
        return owner._declaration(
            text, loc, loc + len(word), owner.items.rules[word], text.lifted.setdefault(owner, [])
        )

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
            text.skipped(loc, end)
        return end


def _either(phrases: Sequence[str]) -> str:
    """``a``, ``a or b``, ``a, b or c``."""
    *first, last = phrases
    return f"{', '.join(first)} or {last}" if first else last


@lru_cache(maxsize=1024)
def _near(word: str, keywords: tuple[str, ...]) -> str | None:
    """The keyword that a misspelt word was meant to be."""
    if not 4 <= len(word) <= 20 or word in keywords:
        return None
    near = get_close_matches(word, keywords, 1, 0.75)
    return near[0] if near else None


def _word(text: ModelText, loc: int) -> str:
    match = _WORD.match(text, loc)
    return match.group() if match else ""


def _header(text: ModelText, header: tuple[int, int]) -> str:
    folded = " ".join(text[header[0] : header[1]].split())
    return f"'{folded[:60]}'"


def _quoted(text: ModelText, loc: int) -> str:
    return _header(text, (text.item_start, loc))


def _is_nested(text: ModelText, loc: int, header: tuple[int, int]) -> bool:
    """Does the line of ``loc`` begin there, and further in than the line of the header?"""
    indent = _indent(text, loc)
    return not indent.strip() and len(indent.expandtabs()) > len(
        re.match(r"[ \t]*", _indent(text, header[0])).group().expandtabs()
    )


def _indent(text: ModelText, loc: int) -> str:
    return text[text.rfind("\n", 0, loc) + 1 : loc]


def _opened(text: ModelText, header: tuple[int, int]) -> tuple[Note, ...]:
    return (Note("it is opened here", text.span(*header)),)
