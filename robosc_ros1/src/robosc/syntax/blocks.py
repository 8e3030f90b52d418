"""Blocks ``{ … }`` of declarations, and what is done about faults in them.

The grammar reads one declaration at a time, or, of one that has a block itself, what stands before
its brace. A declaration that fails is reported once and skipped; reading resumes at the next thing
that looks like a declaration of this block or of one around it. A brace that is missing or too many
shows as a declaration in the wrong block: the block is then closed, or opened again, as the
declaration demands, so that one wrong brace is one error.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pyparsing import ParserElement

from robosc.errors import Note
from robosc.language.tokens import pattern
from robosc.syntax.elements import ended, in_words
from robosc.syntax.nodes import ImportNode
from robosc.syntax.reading import Build, Fault, Reading
from robosc.syntax.synchronise import Synchroniser, nearest_keyword

__all__ = ["Block", "Child", "Header", "Items", "Rule", "late_brace"]

_NEVER = r"(?!)"
_MAX_DEPTH = 20
"""How deep blocks may be nested: the text must not exhaust the stack."""

_FAR = 50
"""How many tokens behind its place an opening brace may come."""


class Rule:
    """One kind of declaration: its grammar behind the first keyword, and its node.

    ``block`` returns, given the parts, which block follows, if any; its declarations become the
    last part. ``opening`` says what was expected where it does not begin. ``tail`` names what could
    still follow at the end of a node, for messages. ``refusal`` says why the declaration, though
    well formed, may not stand here; it is then reported and left out.
    """

    def __init__(
        self,
        grammar: ParserElement,
        build: Build,
        *,
        block: Callable[[list[Any]], Block | None] = lambda parts: None,
        opening: str = "",
        tail: Callable[[Any], tuple[str, ...]] = lambda node: (),
        refusal: str = "",
    ) -> None:
        self.grammar = ended(grammar)
        self.build = build
        self.block = block
        self.opening = opening
        self.tail = tail
        self.refusal = refusal


@dataclass(frozen=True)
class Items:
    """What may stand in a block.

    ``words`` name the declarations in messages. ``rules`` are found by their first keyword. A block
    whose declarations begin with no keyword has ``free`` instead: ``begins`` is what one begins
    with, and ``item``, ``past`` and ``lines`` how the next one is found (see Synchroniser).
    ``advice`` are patterns of what people write in such a block, each with its remedy; ``meant``
    are those that stand for a whole declaration.
    """

    words: tuple[str, ...]
    rules: dict[str, Rule]
    free: Rule | None = None
    begins: str = _NEVER
    item: str = _NEVER
    past: str = _NEVER
    lines: bool = False
    advice: tuple[tuple[str, str], ...] = ()
    meant: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Child:
    """A block inside another, and how late declarations are added to the node they belong to."""

    block: Block
    adopt: Callable[[Any, list[Any]], Any | None]


@dataclass(frozen=True)
class Header:
    """What stands before the opening brace of a block, in tokens."""

    start: int
    end: int

    def quoted(self, reading: Reading) -> str:
        words = " ".join(reading.tokens.texts(self.start, self.end))
        return f"'{words[:60]}'"

    def note(self, reading: Reading) -> tuple[Note, ...]:
        return (Note("it is opened here", reading.span(self.start, self.end)),)


class Block:
    """``{ declaration* }``."""

    def __init__(self, items: Items, *, child: Child | None = None) -> None:
        self.items = items
        self.child = child
        self.parent: Block | None = None
        if child:
            child.block.parent = self

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
    def synchroniser(self) -> Synchroniser:
        outermost = self
        while outermost.parent is not None:
            outermost = outermost.parent
        items = self.items
        return Synchroniser(
            tuple(items.rules),
            self._outer,
            frozenset(outermost.items.rules),
            items.item,
            items.past,
            items.lines,
            tuple(pattern(kinds) for kinds, _ in items.meant),
        )

    @cached_property
    def _begins(self) -> re.Pattern[str]:
        return re.compile(self.items.begins)

    @cached_property
    def _advice(self) -> list[tuple[re.Pattern[str], str]]:
        advice = (*self.items.advice, *self.items.meant)
        return [(re.compile(pattern(kinds)), hint) for kinds, hint in advice]

    def begins(self, reading: Reading, at: int) -> bool:
        """Does a declaration of this block seem to begin here?"""
        if self.items.free:
            return self._begins.match(reading.kinds, at) is not None
        return reading.text(at) in self.items.rules

    def belongs(self, reading: Reading, at: int) -> bool:
        """Does a declaration of this block, or of one inside it, begin here?"""
        word = reading.text(at)
        return word in self.items.rules or word in self._inner

    def _belongs_outside(self, reading: Reading, at: int, word: str) -> bool:
        if word not in self._outer:
            return False
        return not self.items.free or self.synchroniser.looks_like(reading, at, word)

    # --- reading ---

    def enter(
        self, reading: Reading, at: int, header: Header, opening: str = ""
    ) -> tuple[Any, int]:
        """The nodes of the block that begins at a token, and the place behind it. Raises Fault."""
        nodes: list[Any] = []
        inside = self._open(reading, at, header, opening)
        if reading.depth >= _MAX_DEPTH:
            message = f"blocks are nested more than {_MAX_DEPTH} deep"
            raise Fault(header.start, message, code="too-deep")
        reading.depth += 1
        end = self.read(reading, inside, header, nodes)
        reading.depth -= 1
        return tuple(nodes), end

    def _open(self, reading: Reading, at: int, header: Header, opening: str) -> int:
        """The place behind ``{``, which may be missing or come late."""
        if reading.kind(at) == "{":
            return at + 1
        message = f"expected '{{' to open {header.quoted(reading)}"
        closed = reading.kind(at) == "}" and not reading.tokens.begins_line(at)
        if closed or self.begins(reading, at):
            reading.report("missing-brace", message, at)
            reading.reported_at = at
            return at
        late = late_brace(reading, at)
        if late is not None and not self.synchroniser.any_in(reading, at, late):
            reading.report("syntax", message, at)
            return late + 1
        raise reading.expected(at, f"expected {opening}" if opening else message)

    def read(self, reading: Reading, at: int, header: Header | None, nodes: list[Any]) -> int:
        """Read declarations up to the closing brace into ``nodes``; the place behind it.

        ``header`` is None for a block that is opened again, whose end nobody will miss.
        """
        tail: tuple[str, ...] = ()
        while True:
            if at >= len(reading.kinds) or reading.exhausted:
                self._end_of_file(reading, header)
                at = len(reading.kinds)
                break
            if reading.kind(at) == "}":
                at += 1
                break
            rule, after = self._rule(reading, at)
            if rule:
                count = len(nodes)
                at = self._declaration(reading, at, after, rule, nodes)
                tail = rule.tail(nodes[-1]) if len(nodes) > count else ()
                continue
            word = reading.text(at)
            if not self._belongs_outside(reading, at, word):
                at = self._stranger(reading, at, word, nodes, tail)
            elif header and _is_nested(reading, at, header):
                at = self._misplaced(reading, at, word, header)
            else:
                self._close_early(reading, at, word, header)
                break
            tail = ()
        nodes += reading.lifted.pop(self, [])
        return at

    def _rule(self, reading: Reading, at: int) -> tuple[Rule | None, int]:
        """The rule for the declaration at ``at``, and where its grammar goes on."""
        word = reading.text(at)
        if self.items.free is None:
            return self.items.rules.get(word), at + 1
        if reading.kind(at) == "{" or self._belongs_outside(reading, at, word):
            return None, at
        return self.items.free, at

    def _declaration(
        self,
        reading: Reading,
        at: int,
        after: int,
        rule: Rule,
        nodes: list[Any],
        told: bool = False,
    ) -> int:
        """Read one declaration; ``told`` says that a fault in it was reported already."""
        try:
            parts, end = reading.parse(rule.grammar, after)
            block = rule.block(parts)
            if block:
                inside, end = block.enter(reading, end, Header(at, end), rule.opening)
                parts.append(inside)
            node = rule.build(reading, at, end, parts)
        except Fault as fault:
            return self._recover(reading, at, fault, told)
        if rule.refusal:
            reading.report("misplaced", rule.refusal, at)
        else:
            nodes.append(node)
        return end

    # --- faults ---

    def _recover(self, reading: Reading, start: int, fault: Fault, told: bool = False) -> int:
        """Report the fault and find where to go on."""
        resume = self.synchroniser.resume(reading, start, fault.at)
        reading.skipped(start, resume)
        if not told:
            reading.report_fault(start, resume, fault)
        reading.reported_at = resume
        return resume

    def _stranger(
        self, reading: Reading, at: int, word: str, nodes: list[Any], tail: tuple[str, ...]
    ) -> int:
        """Something that begins no declaration of this block or of one around it."""
        if reading.kind(at) == "{" and not nodes:
            reading.report("unexpected-brace", "this '{' opens nothing", at)
            while reading.kind(at) == "{":
                at += 1
            return at
        if word in self._inner:
            return self._open_again(reading, at, word, nodes)
        keyword = nearest_keyword(word, tuple(self.items.rules))
        if keyword:
            message = f"expected {in_words(self.items.words)}"
            reading.report("syntax", message, at, hint=f"did you mean '{keyword}'?")
            rule = self.items.rules[keyword]
            return self._declaration(reading, at, at + 1, rule, nodes, told=True)
        message = f"expected {in_words((*tail, *self.items.words, _CLOSE))}"
        if reading.tokens.follows_fault(at):
            return self._recover(reading, at, Fault(at, message), told=True)
        if reading.kind(at) == "{" and isinstance(nodes[-1], ImportNode):
            message = "an imported component cannot be extended"
            return self._recover(reading, at, Fault(at, message))
        for kinds, hint in self._advice:
            if kinds.match(reading.kinds, at):
                return self._recover(reading, at, Fault(at, message, hint=hint))
        return self._recover(reading, at, reading.expected(at, message))

    def _open_again(self, reading: Reading, at: int, word: str, nodes: list[Any]) -> int:
        """A declaration of an inner block: that one was closed too early."""
        assert self.child is not None
        if reading.reported_at != at:
            reading.reported_at = at
            hint = "is there an extra '}' above?"
            reading.report("unexpected-brace", f"'{word}' is not allowed here", at, hint=hint)
        reading.reopened = True
        late: list[Any] = []
        end = self.child.block.read(reading, at, None, late)
        if nodes and (node := self.child.adopt(nodes[-1], late)) is not None:
            nodes[-1] = node
        else:
            reading.skipped(at, end)
        return end

    def _misplaced(self, reading: Reading, at: int, word: str, header: Header) -> int:
        """A declaration that stands one block too deep: read it, and give it to the right one."""
        message = f"'{word}' is not allowed inside {header.quoted(reading)}"
        reading.report("misplaced", message, at, notes=header.note(reading))
        owner = self.parent
        while owner and word not in owner.items.rules:
            owner = owner.parent
        assert owner is not None
        nodes = reading.lifted.setdefault(owner, [])
        return owner._declaration(reading, at, at + 1, owner.items.rules[word], nodes)

    def _close_early(self, reading: Reading, at: int, word: str, header: Header | None) -> None:
        """A declaration of an outer block: this one was not closed."""
        if header is None or reading.reported_at == at:
            return
        reading.reported_at = at
        message = f"expected '}}' to close {header.quoted(reading)} before '{word}'"
        reading.report("missing-brace", message, at, notes=header.note(reading))

    def _end_of_file(self, reading: Reading, header: Header | None) -> None:
        ended = reading.reported_at >= len(reading.kinds)
        if header is None or ended or reading.reopened or reading.tokens.open_end:
            return
        reading.reported_at = len(reading.kinds)
        message = f"expected '}}' to close {header.quoted(reading)}"
        reading.report("missing-brace", message, len(reading.kinds), notes=header.note(reading))


_CLOSE = "'}'"


def late_brace(reading: Reading, at: int) -> int | None:
    """The next ``{`` on the line of a token, with no ``}`` before it."""
    for place in range(at, min(at + _FAR, len(reading.kinds))):
        if reading.kinds[place] == "}" or (place > at and reading.tokens.begins_line(place)):
            return None
        if reading.kinds[place] == "{":
            return place
    return None


def _is_nested(reading: Reading, at: int, header: Header) -> bool:
    """Does a token begin its line, and further in than the line of the header?"""
    inner, outer = _before(reading, at), _before(reading, header.start)
    indent = len(outer.expandtabs()) - len(outer.lstrip().expandtabs())
    return not inner.strip() and len(inner.expandtabs()) > indent


def _before(reading: Reading, at: int) -> str:
    """What stands before a token on its line."""
    text, end = reading.source.text, reading.tokens.offset(at)
    return text[text.rfind("\n", 0, end) + 1 : end]
