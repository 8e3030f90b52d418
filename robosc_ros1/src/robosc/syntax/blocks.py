"""Blocks ``{ … }`` of declarations: parsing them, and recovering from syntax errors.

The grammar parses one declaration at a time; of a declaration with a block, what precedes its
opening brace. A declaration that fails is reported once and skipped; parsing resumes at the next
token that looks like the beginning of a declaration of this block or of an enclosing one. A missing
or superfluous brace shows as a declaration in the wrong block: the block is then closed, or
reopened, as that declaration requires, so that one wrong brace gives one error.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache, cached_property
from typing import Any

from pyparsing import ParserElement

from robosc import errors, limits
from robosc.language.keywords import starts_of
from robosc.lazy_dataclasses import dataclass
from robosc.remedies import meant
from robosc.syntax.elements import ended
from robosc.syntax.nodes import ImportNode
from robosc.syntax.parse_state import Build, Fault, ParseState
from robosc.syntax.recovery import synchronise

# What the indentation of lines says about blocks whose braces are missing.


def is_nested(reading: ParseState, at: int, header: int) -> bool:
    """Whether a token begins its line, indented further than the line of a header."""
    inner, outer = _before(reading, at), _before(reading, header)
    indent = len(outer.expandtabs()) - len(outer.lstrip().expandtabs())
    return not inner.strip() and len(inner.expandtabs()) > indent


def outdented(reading: ParseState, header: int, opening: int, end: int) -> int:
    """The first token behind an opening brace that stands as far left as the block's header.

    ``end`` if there is none before, or the contents of the block are not indented. Closing braces
    do not count.
    """
    lines = [at for at in range(opening + 1, end) if not _before(reading, at).strip()]
    if not lines or not is_nested(reading, lines[0], header):
        return end
    left = (a for a in lines if reading.kind(a) != "}" and not is_nested(reading, a, header))
    return next(left, end)


def is_outdented(reading: ParseState, header: int, opening: int, at: int) -> bool:
    """Whether a token begins a line as far left as its block's header, unlike the first line."""
    if _before(reading, at).strip() or is_nested(reading, at, header):
        return False
    lines = (a for a in range(opening + 1, at) if not _before(reading, a).strip())
    first = next(lines, at)
    return first < at and is_nested(reading, first, header)


def unclosed(reading: ParseState, header: int, end: int) -> tuple[int, int, int] | None:
    """The block from ``header`` on whose closing brace is missing, as the indentation tells: the
    token where its line begins, that of its opening brace, and the brace that closes an outer one.

    None if all braces that begin a line stand below the line with the brace that they close.
    """
    lefts: list[tuple[int, int, int]] = []
    line = header
    for at in range(header, end):
        kind = reading.kind(at)
        if at > header and reading.tokens.begins_line(at):
            line = at
        if kind == "{":
            lefts.append((_left(reading, line), line, at))
        elif kind == "}" and lefts:
            left, begin, opening = lefts.pop()
            if line == at and _left(reading, at) < left:
                outer = any(_left(reading, at) == column for column, _, _ in lefts)
                return (begin, opening, at) if outer else None
    return None


def _left(reading: ParseState, at: int) -> int:
    """Return the column of a line's first token."""
    return len(_before(reading, at).expandtabs())


def _before(reading: ParseState, at: int) -> str:
    """The text before a token on its line."""
    text, end = reading.source.text, reading.tokens.offset(at)
    return text[text.rfind("\n", 0, end) + 1 : end]


_NEVER = re.compile(r"(?!)")


@dataclass(eq=False)
class Rule:
    """One kind of declaration: its grammar behind the first keyword, and how its node is built.

    ``make`` makes the grammar where it is first needed: few models have declarations of all kinds.
    ``block`` returns the block that follows, given the parts, or None; the declarations of that
    block become the last part. ``opening`` is the text for an "expected …" where the block does not
    begin. ``tail`` returns what could still follow at the end of a node, for messages. ``refusal``
    is the reason why the declaration is not allowed here although it is well formed; it is then
    reported and left out of the tree.
    """

    make: Callable[[], ParserElement]
    build: Build
    block: Callable[[list[Any]], Block | None] = lambda parts: None
    opening: str = ""
    tail: Callable[[Any], tuple[str, ...]] = lambda node: ()
    refusal: str = ""

    @property
    def grammar(self) -> ParserElement:
        return _grammar(self.make)


@cache
def _grammar(make: Callable[[], ParserElement]) -> ParserElement:
    """One for all rules that are made alike, in robots and libraries."""
    return ended(make())


@dataclass(frozen=True)
class Items:
    """The declarations that a block may contain.

    ``words`` name the declarations in messages. ``rules`` maps a first keyword to its rule. A block
    whose declarations begin with no keyword has the one rule ``free`` instead: ``begins`` is the
    pattern with which such a declaration begins, and ``item``, ``past`` and ``lines`` locate the
    next one after an error (see :class:`~robosc.syntax.recovery.synchronise.Synchroniser`).
    ``advice`` are patterns of frequent mistakes in such a block, each with a hint; ``meant`` are
    those patterns that stand for a whole declaration. ``kind`` is that of the block.
    """

    words: tuple[str, ...]
    rules: dict[str, Rule]
    free: Rule | None = None
    begins: re.Pattern[str] = _NEVER
    item: re.Pattern[str] = _NEVER
    past: re.Pattern[str] = _NEVER
    lines: bool = False
    advice: tuple[tuple[re.Pattern[str], str], ...] = ()
    meant: tuple[tuple[re.Pattern[str], str], ...] = ()
    kind: str = ""


_IN_MESSAGES = {
    "incoming": ("'incoming message'",),
    "outgoing": tuple(
        f"'outgoing {noun}'" for noun in ("message", "transform", "service", "action")
    ),
    "initial": (),
    "marked": (),
    "persistent": (),
}
"""How messages name the declarations of a first keyword, if not by that alone."""


def items_of(block: str, rules: Mapping[str, Rule], **others: Any) -> Items:
    """The declarations of a kind of block, according to the table of keywords."""
    starts = starts_of(block)
    words = (shown for word in starts for shown in _IN_MESSAGES.get(word, (f"'{word}'",)))
    found = {word: rules[word] for word in starts}
    return Items(tuple(words), found, kind=block, **others)


@dataclass(frozen=True)
class Child:
    """A nested block, and the function that adds declarations to the node of a closed one."""

    block: Block
    adopt: Callable[[Any, list[Any]], Any | None]


@dataclass(frozen=True)
class Header:
    """The tokens before the opening brace of a block: a half-open range of token indexes."""

    start: int
    end: int

    def quoted(self, reading: ParseState) -> str:
        """The text of the header, at most 60 characters, in quotes for messages."""
        words = " ".join(reading.tokens.texts(self.start, self.end))
        return f"'{words[:60]}'"

    def note(self, reading: ParseState) -> tuple[errors.Note, ...]:
        return (errors.Note("it is opened here", reading.span(self.start, self.end)),)


class Block:
    """The parser of one kind of block, ``{ declaration* }``."""

    def __init__(self, items: Items, *, child: Child | None = None) -> None:
        self.items = items
        self.child = child
        self.parent: Block | None = None
        if child:
            child.block.parent = self

    # --- which declaration belongs to which block ---

    @cached_property
    def _outer(self) -> frozenset[str]:
        """First keywords of the declarations of all enclosing blocks."""
        if self.parent is None:
            return frozenset()
        return self.parent._outer.union(self.parent.items.rules)

    @cached_property
    def _inner(self) -> Mapping[str, str]:
        """First keywords of the declarations of all nested blocks, with the outermost kind of block
        in which each stands."""
        if self.child is None:
            return {}
        block = self.child.block
        return {**block._inner, **dict.fromkeys(block.items.rules, block.items.kind)}

    @cached_property
    def synchroniser(self) -> synchronise.Synchroniser:
        outermost = self
        while outermost.parent is not None:
            outermost = outermost.parent
        items = self.items
        return synchronise.Synchroniser(
            tuple(items.rules),
            self._outer,
            frozenset(outermost.items.rules),
            items.item,
            items.past,
            items.lines,
            tuple(kinds for kinds, _ in items.meant),
        )

    def begins(self, reading: ParseState, at: int) -> bool:
        """Whether a declaration of this block seems to begin at a token."""
        if self.items.free:
            return self.items.begins.match(reading.kinds, at) is not None
        return reading.text(at) in self.items.rules

    def belongs(self, reading: ParseState, at: int) -> bool:
        """Whether a declaration of this block, or of a nested one, begins at a token."""
        word = reading.text(at)
        return word in self.items.rules or word in self._inner

    def _belongs_outside(self, reading: ParseState, at: int, word: str) -> bool:
        if word not in self._outer:
            return False
        return not self.items.free or self.synchroniser.looks_like(reading, at, word)

    def _is_outside(self, reading: ParseState, at: int, header: Header) -> bool:
        """Whether a declaration that may stand here or outside is, by its place, one outside.

        Where all braces match, they alone decide.
        """
        if reading.is_balanced or reading.text(at) not in self._outer or self.items.free:
            return False
        return is_outdented(reading, header.start, header.end, at)

    # --- parsing ---

    def enter(
        self, reading: ParseState, at: int, header: Header, opening: str = ""
    ) -> tuple[Any, int]:
        """The nodes of the block that begins at a token, and the token behind the block.

        Raises:
            Fault: the block does not begin here, or is nested too deep.
        """
        nodes: list[Any] = []
        inside = self._open(reading, at, header, opening)
        if reading.depth >= limits.BLOCKS_IN_BLOCKS:
            message = f"blocks are nested more than {limits.BLOCKS_IN_BLOCKS} deep"
            raise Fault(header.start, message, code="too-deep")
        reading.depth += 1
        end = self.read(reading, inside, header, nodes)
        reading.depth -= 1
        return tuple(nodes), end

    def _open(self, reading: ParseState, at: int, header: Header, opening: str) -> int:
        """The token behind ``{``, where the brace may be missing or come late."""
        if reading.kind(at) == "{":
            return at + 1
        message = f"expected '{{' to open {header.quoted(reading)}"
        closed = reading.kind(at) == "}" and not reading.tokens.begins_line(at)
        if closed or self.begins(reading, at):
            reading.report("missing-brace", message, at)
            reading.reported_at = at
            return at
        late = synchronise.late_brace(reading, at)
        if late is not None and not self.synchroniser.any_in(reading, at, late):
            fault = reading.expected(at, message)
            reading.report(fault.code, message, at, fault.hint, span=fault.span)
            return late + 1
        raise reading.expected(at, f"expected {opening}" if opening else message)

    def read(self, reading: ParseState, at: int, header: Header | None, nodes: list[Any]) -> int:
        """Add the declarations up to the closing brace to ``nodes``; return the token behind it.

        ``header`` is None for a block that is reopened: that its brace is missing is not reported.
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
            if rule and header and self._is_outside(reading, at, header):
                self._close_early(reading, at, reading.text(at), header)
                break
            if rule:
                count = len(nodes)
                at = self._declaration(reading, at, after, rule, nodes)
                tail = rule.tail(nodes[-1]) if len(nodes) > count else ()
                continue
            word = reading.text(at)
            if not self._belongs_outside(reading, at, word):
                at = self._stranger(reading, at, word, nodes, tail)
            elif header and is_nested(reading, at, header.start):
                at = self._misplaced(reading, at, word, header)
            else:
                self._close_early(reading, at, word, header)
                break
            tail = ()
        nodes += reading.lifted.pop(self, [])
        return at

    def _rule(self, reading: ParseState, at: int) -> tuple[Rule | None, int]:
        """The rule for the declaration at ``at``, and the token where its grammar continues."""
        word = reading.text(at)
        if self.items.free is None:
            return self.items.rules.get(word), at + 1
        opens = reading.kind(at) == "{" and not self.begins(reading, at)
        if opens or self._belongs_outside(reading, at, word):
            return None, at
        return self.items.free, at

    def _declaration(
        self,
        reading: ParseState,
        at: int,
        after: int,
        rule: Rule,
        nodes: list[Any],
        reported: bool = False,
    ) -> int:
        """Parse one declaration; return the token behind it.

        ``reported``: a fault in it was reported already.
        """
        try:
            parts, end = reading.parse(rule.grammar, after)
            block = rule.block(parts)
            if block:
                inside, end = block.enter(reading, end, Header(at, end), rule.opening)
                parts.append(inside)
            node = rule.build(reading, at, end, parts)
        except Fault as fault:
            return self._recover(reading, at, fault, reported)
        if rule.refusal:
            reading.report("misplaced", rule.refusal, at)
        else:
            nodes.append(node)
        return end

    # --- faults ---

    def _recover(self, reading: ParseState, at: int, fault: Fault, reported: bool = False) -> int:
        """Report the fault; return the token where parsing resumes."""
        resume = self.synchroniser.resume(reading, at, fault.at)
        reading.skipped(at, resume)
        if not reported:
            reading.report_fault(at, resume, fault)
        reading.reported_at = resume
        return resume

    def _stranger(
        self, reading: ParseState, at: int, word: str, nodes: list[Any], tail: tuple[str, ...]
    ) -> int:
        """Handle a token that begins no declaration of this block or of an enclosing one."""
        if reading.kind(at) == "{" and not nodes:
            reading.report("unexpected-brace", "this '{' opens nothing", at)
            while reading.kind(at) == "{":
                at += 1
            return at
        if word in self._inner:
            return self._open_again(reading, at, word, nodes)
        keyword = synchronise.nearest_keyword(word, tuple(self.items.rules))
        if keyword and reading.text(at + 1) not in self.items.rules:
            message = f"expected {errors.listing(self.items.words, 'or')}"
            reading.report("syntax", message, at, hint=meant(keyword))
            return self._declaration(reading, at, at + 1, self.items.rules[keyword], nodes, True)
        expected = (*tail, *self.items.words, "'}'")
        message = f"expected {errors.listing(expected, 'or')}"
        if reading.tokens.follows_fault(at):
            return self._recover(reading, at, Fault(at, message), reported=True)
        if reading.kind(at) == "{" and isinstance(nodes[-1], ImportNode):
            message = "an imported component cannot be extended"
            return self._recover(reading, at, Fault(at, message))
        for kinds, hint in (*self.items.advice, *self.items.meant):
            if kinds.match(reading.kinds, at):
                return self._recover(reading, at, Fault(at, message, hint=hint))
        fault = reading.expected(at, message)
        if nodes and fault.span and fault.span.start < reading.tokens.offset(at):
            nodes.pop()  # it ends in the midst of what was meant
        return self._recover(reading, at, fault)

    def _open_again(self, reading: ParseState, at: int, word: str, nodes: list[Any]) -> int:
        """Reopen the nested block, closed too early, to which the declaration here belongs."""
        assert self.child is not None
        if reading.reported_at != at:
            reading.reported_at = at
            hint = f"it stands in a {self._inner[word]}"
            if nodes and self.child.adopt(nodes[-1], []) is not None:
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

    def _misplaced(self, reading: ParseState, at: int, word: str, header: Header) -> int:
        """Parse a declaration of an enclosing block, and add it there."""
        message = f"'{word}' is not allowed inside {header.quoted(reading)}"
        reading.report("misplaced", message, at, notes=header.note(reading))
        owner = self.parent
        while owner and word not in owner.items.rules:
            owner = owner.parent
        assert owner is not None
        nodes = reading.lifted.setdefault(owner, [])
        return owner._declaration(reading, at, at + 1, owner.items.rules[word], nodes)

    def _close_early(self, reading: ParseState, at: int, word: str, header: Header | None) -> None:
        """Report that this block was not closed before a declaration of an enclosing one."""
        if header is None or reading.reported_at == at:
            return
        reading.reported_at = at
        if self._is_told_at_its_place(reading, at, header):
            return
        place = outdented(reading, header.start, header.end, at)
        message = f"expected '}}' to close {header.quoted(reading)} before '{reading.text(place)}'"
        reading.report("missing-brace", message, place, notes=header.note(reading))
        if place < at:
            reading.skipped(place, at)  # what is declared there may belong outside

    def _end_of_file(self, reading: ParseState, header: Header | None) -> None:
        ended = reading.reported_at >= len(reading.kinds)
        if header is None or ended or reading.reopened or reading.tokens.open_end:
            return
        reading.reported_at = len(reading.kinds)
        if self._is_told_at_its_place(reading, len(reading.kinds), header):
            return
        message = f"expected '}}' to close {header.quoted(reading)}"
        reading.report("missing-brace", message, len(reading.kinds), notes=header.note(reading))

    def _is_told_at_its_place(self, reading: ParseState, at: int, header: Header) -> bool:
        """Report the block inside, before a token, that its indentation says is not closed."""
        if (found := unclosed(reading, header.start, at)) is None:
            return False
        begin, opening, brace = found
        inner = Header(begin, opening)
        message = f"expected '}}' to close {inner.quoted(reading)} before this one"
        reading.report("missing-brace", message, brace, notes=inner.note(reading))
        return True
