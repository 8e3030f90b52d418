"""Blocks ``{ … }`` of declarations, and what is done about faults in them.

A declaration that fails is reported once and skipped; reading resumes at the next thing that looks
like a declaration of this block or of one around it. A brace that is missing or too many shows as
a declaration in the wrong block: the block is then closed, or opened again, as the declaration
demands, so that one wrong brace is one error.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pyparsing import ParseBaseException, ParseException, ParserElement

from robosc.errors import Note
from robosc.syntax.elements import Build, Fault, ModelText, skip_space, text_of
from robosc.syntax.landmarks import Landmarks, nearest_keyword, word_at
from robosc.syntax.nodes import ImportNode

__all__ = ["Block", "Child", "Header", "Items", "Rule"]

_JUNK = re.compile(r"[^{}\n]{0,200}\{")


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

    ``words`` name the declarations in messages. ``rules`` are found by their first keyword. A block
    whose declarations begin with no keyword has ``free`` instead: ``begins`` is what one begins
    with, and ``marks`` how the next one is found (see Landmarks). ``advice`` are patterns of what
    people write in such a block, each with its remedy; ``meant`` are those that stand for a whole
    declaration.
    """

    words: tuple[str, ...]
    rules: dict[str, Rule]
    free: Rule | None = None
    begins: str = r"(?!)"
    marks: str = ""
    advice: tuple[tuple[str, str], ...] = ()
    meant: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Child:
    """A block inside another, and how late declarations are added to the node they belong to."""

    block: Block
    adopt: Callable[[Any, list[Any]], Any | None]


@dataclass(frozen=True)
class Header:
    """What stands before the opening brace of a block."""

    start: int
    end: int

    def quoted(self, text: ModelText) -> str:
        folded = " ".join(text[self.start : self.end].split())
        return f"'{folded[:60]}'"

    def note(self, text: ModelText) -> tuple[Note, ...]:
        return (Note("it is opened here", text.span(self.start, self.end)),)


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
        self.mayIndexError = False

    def _generateDefaultName(self) -> str:
        return "block"

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        text = text_of(instring)
        header = Header(text.item_start, loc)
        nodes: list[Any] = []
        return self.read(text, self._open(text, loc, header), header, nodes), nodes

    # --- what may stand where ---

    @cached_property
    def _outer(self) -> frozenset[str]:
        """First keywords of the declarations in all blocks around this one."""
        if self.parent is None:
            return frozenset()
        return self.parent._outer.union(self.parent.items.rules)

    @cached_property
    def _inner(self) -> frozenset[str]:
        """First keywords of the declarations in the blocks below this one."""
        if self.child is None:
            return frozenset()
        return self.child.block._inner.union(self.child.block.items.rules)

    @cached_property
    def landmarks(self) -> Landmarks:
        outermost = self
        while outermost.parent is not None:
            outermost = outermost.parent
        return Landmarks(
            tuple(self.items.rules),
            self._outer,
            frozenset(outermost.items.rules),
            self.items.marks,
            tuple(pattern for pattern, _ in self.items.meant),
        )

    @cached_property
    def _begins(self) -> re.Pattern[str]:
        return re.compile(self.items.begins, re.ASCII)

    @cached_property
    def _advice(self) -> list[tuple[re.Pattern[str], str]]:
        advice = (*self.items.advice, *self.items.meant)
        return [(re.compile(pattern, re.ASCII), hint) for pattern, hint in advice]

    def begins(self, text: ModelText, loc: int) -> bool:
        """Does a declaration of this block seem to begin here?"""
        if self.items.free:
            return self._begins.match(text, loc) is not None
        return word_at(text, loc) in self.items.rules

    def belongs(self, text: ModelText, loc: int) -> bool:
        """Does a declaration of this block, or of one inside it, begin here?"""
        word = word_at(text, loc)
        return word in self.items.rules or word in self._inner

    def _belongs_outside(self, text: ModelText, loc: int, word: str) -> bool:
        if word not in self._outer:
            return False
        return not self.items.free or self.landmarks.looks_like(text, loc, word)

    # --- reading ---

    def _open(self, text: ModelText, loc: int, header: Header) -> int:
        """The place behind ``{``, which may be missing or come late."""
        if text.startswith("{", loc):
            return loc + 1
        message = f"expected '{{' to open {header.quoted(text)}"
        closed = text.startswith("}", loc) and "\n" not in text[text.trimmed(loc) : loc]
        if closed or self.begins(text, loc):
            text.report("missing-brace", message, loc)
            text.settled = loc
            return loc
        junk = _JUNK.match(text, loc)
        if junk and not self.landmarks.any_in(text, loc, junk.end() - 1):
            text.report("syntax", message, loc)
            return junk.end()
        raise ParseException(text, loc, message, self)

    def read(self, text: ModelText, loc: int, header: Header | None, nodes: list[Any]) -> int:
        """Read declarations up to the closing brace into ``nodes``; the place behind it.

        ``header`` is None for a block that is opened again, whose end nobody will miss.
        """
        tail: tuple[str, ...] = ()
        while True:
            loc = skip_space(text, loc)
            if loc >= len(text) or text.exhausted:
                self._end_of_file(text, header)
                loc = len(text)
                break
            if text.startswith("}", loc):
                loc += 1
                break
            rule, after = self._rule(text, loc)
            if rule:
                count = len(nodes)
                loc = self._declaration(text, loc, after, rule, nodes)
                tail = rule.tail(nodes[-1]) if len(nodes) > count else ()
                continue
            word = word_at(text, loc)
            if not self._belongs_outside(text, loc, word):
                loc = self._stranger(text, loc, word, nodes, tail)
            elif header and _is_nested(text, loc, header):
                loc = self._misplaced(text, loc, word, header)
            else:
                self._close_early(text, loc, word, header)
                break
            tail = ()
        nodes += text.lifted.pop(self, [])
        return loc

    def _rule(self, text: ModelText, loc: int) -> tuple[Rule | None, int]:
        """The rule for the declaration at ``loc``, and where its grammar goes on."""
        word = word_at(text, loc)
        if self.items.free is None:
            return self.items.rules.get(word), loc + len(word)
        if text.startswith("{", loc) or self._belongs_outside(text, loc, word):
            return None, loc
        return self.items.free, loc

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
            node = rule.build(text, loc, text.trimmed(end), list(parts))
        except ParseBaseException as fault:
            # The traceback would keep every frame of the parse alive.
            fault.__traceback__ = None
            text.depth = depth
            return self._recover(text, loc, fault, told)
        if rule.refusal:
            text.report("misplaced", rule.refusal, loc)
        else:
            nodes.append(node)
        return int(end)

    # --- faults ---

    def _recover(
        self, text: ModelText, start: int, fault: ParseBaseException, told: bool = False
    ) -> int:
        """Report the fault and find where to go on."""
        resume = self.landmarks.resume(text, start, skip_space(text, fault.loc))
        text.skipped(start, resume)
        if not told:
            text.report_fault(start, resume, fault)
        text.settled = resume if resume < len(text) else text.body_end
        return resume

    def _stranger(
        self, text: ModelText, loc: int, word: str, nodes: list[Any], tail: tuple[str, ...]
    ) -> int:
        """Something that begins no declaration of this block or of one around it."""
        if text.startswith("{", loc) and not nodes:
            text.report("unexpected-brace", "this '{' opens nothing", loc)
            return len(text) - len(text[loc:].lstrip("{ \t\n"))
        if word in self._inner:
            return self._open_again(text, loc, word, nodes)
        keyword = nearest_keyword(word, tuple(self.items.rules))
        if keyword:
            message = f"expected {_either(self.items.words)}"
            text.report("syntax", message, loc, hint=f"did you mean '{keyword}'?")
            rule = self.items.rules[keyword]
            return self._declaration(text, loc, loc + len(word), rule, nodes, told=True)
        message = f"expected {_either((*tail, *self.items.words, _CLOSE))}"
        if text.follows_lexical_fault(loc):
            return self._recover(text, loc, ParseException(text, loc, message), told=True)
        if text.startswith("{", loc) and isinstance(nodes[-1], ImportNode):
            message = "an imported component cannot be extended"
            return self._recover(text, loc, Fault(text, loc, message))
        for pattern, hint in self._advice:
            if pattern.match(text, loc):
                return self._recover(text, loc, Fault(text, loc, message, hint=hint))
        return self._recover(text, loc, ParseException(text, loc, message))

    def _open_again(self, text: ModelText, loc: int, word: str, nodes: list[Any]) -> int:
        """A declaration of an inner block: that one was closed too early."""
        assert self.child is not None
        if text.settled != loc:
            text.settled = loc
            hint = "is there a '}' too many above?"
            text.report("unexpected-brace", f"'{word}' cannot stand here", loc, hint=hint)
        text.reopened = True
        late: list[Any] = []
        end = self.child.block.read(text, loc, None, late)
        if nodes and (node := self.child.adopt(nodes[-1], late)) is not None:
            nodes[-1] = node
        else:
            text.skipped(loc, end)
        return end

    def _misplaced(self, text: ModelText, loc: int, word: str, header: Header) -> int:
        """A declaration that stands one block too deep: read it, and give it to the right one."""
        message = f"'{word}' cannot stand inside {header.quoted(text)}"
        text.report("misplaced", message, loc, notes=header.note(text))
        owner = self.parent
        while owner and word not in owner.items.rules:
            owner = owner.parent
        assert owner is not None
        nodes = text.lifted.setdefault(owner, [])
        return owner._declaration(text, loc, loc + len(word), owner.items.rules[word], nodes)

    def _close_early(self, text: ModelText, loc: int, word: str, header: Header | None) -> None:
        """A declaration of an outer block: this one was not closed."""
        if header is None or text.settled == loc:
            return
        text.settled = loc
        message = f"expected '}}' to close {header.quoted(text)} before '{word}'"
        text.report("missing-brace", message, loc, notes=header.note(text))

    def _end_of_file(self, text: ModelText, header: Header | None) -> None:
        told = text.reopened or text.scan.open_end or text.settled >= text.body_end
        if header is None or told:
            return
        text.settled = text.body_end
        message = f"expected '}}' to close {header.quoted(text)}"
        text.report("missing-brace", message, len(text), notes=header.note(text))


_CLOSE = "'}'"


def _either(phrases: Sequence[str]) -> str:
    """``a``, ``a or b``, ``a, b or c``."""
    *first, last = phrases
    return f"{', '.join(first)} or {last}" if first else last


def _is_nested(text: ModelText, loc: int, header: Header) -> bool:
    """Does the line of ``loc`` begin there, and further in than the line of the header?"""
    inner, outer = _before(text, loc), _before(text, header.start)
    indent = len(outer.expandtabs()) - len(outer.lstrip().expandtabs())
    return not inner.strip() and len(inner.expandtabs()) > indent


def _before(text: ModelText, loc: int) -> str:
    return text[text.rfind("\n", 0, loc) + 1 : loc]
