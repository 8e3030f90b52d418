"""From model text to the syntax tree, with every fault of the file in one go."""

from __future__ import annotations

import re
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, cast

from pyparsing import ParserElement

from robosc.errors import Diagnostic, Severity, UsageError, sort_diagnostics
from robosc.names import IDENTIFIER
from robosc.source import Source, Span
from robosc.syntax.blocks import Block, Header
from robosc.syntax.elements import ModelText, skip_space, text_of
from robosc.syntax.expressions import make_name
from robosc.syntax.grammar import library_block, robot_block
from robosc.syntax.keywords import NAME
from robosc.syntax.nodes import FileNode
from robosc.syntax.scan import MAX_FAULTS, scan

__all__ = ["parse", "read_source"]

_WORD = re.compile(IDENTIFIER, re.ASCII)
_NAME = re.compile(NAME, re.ASCII)
_TO_BRACE = re.compile(r"[^{}\n]*(?=\{)")


_LARGEST = 2**26
"""Bytes of a model file; a device such as /dev/zero has no end at all."""


def read_source(path: str) -> tuple[Source | None, tuple[Diagnostic, ...]]:
    """The model file at ``path``; None and the reason if it is no UTF-8 text.

    A byte order mark is dropped, and line ends become ``\\n``. Raises UsageError if the file cannot
    be read at all.
    """
    try:
        with Path(path).open("rb") as file:
            data = file.read(_LARGEST + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise UsageError(f"cannot read {path}: {reason or error}") from error
    if len(data) > _LARGEST:
        raise UsageError(f"cannot read {path}: no model has more than {_LARGEST >> 20} MB")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return None, (_invalid_utf8(path, data, error),)
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n")), ()


def parse(source: Source) -> tuple[FileNode | None, tuple[Diagnostic, ...]]:
    """The tree of what could be read, and every fault found on the way, in reading order.

    The tree is None where no robot or library begins, and after too many errors. Declarations with
    faults are left out of it; ``FileNode.broken`` has the words in them. Never raises for any text.
    """
    scanned = scan(source)
    text = ModelText.of(source, scanned)
    if not scanned.binary:
        _File().parse_with_tabs().parse_string(text)
    found = sort_diagnostics(text.diagnostics)
    if len(found) > MAX_FAULTS:
        last = found[MAX_FAULTS]
        message = f"there are more than {MAX_FAULTS} errors: the others are not shown"
        found[MAX_FAULTS:] = [Diagnostic(Severity.ERROR, "too-many-errors", message, last.span)]
        return None, tuple(found)
    return text.tree, tuple(found)


def _invalid_utf8(path: str, data: bytes, error: UnicodeDecodeError) -> Diagnostic:
    before = data[: error.start].decode("utf-8-sig", "replace")
    source = Source(path, data.decode("utf-8-sig", "replace").replace("\r\n", "\n"))
    start = len(before.replace("\r\n", "\n"))
    message = f"the byte 0x{data[error.start]:02X} is no UTF-8 text"
    utf16 = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    hint = "this looks like UTF-16: save the file as UTF-8" if utf16 else "save the file as UTF-8"
    span = Span(source, start, start + 1)
    return Diagnostic(Severity.ERROR, "invalid-utf8", message, span, hint)


class _File(ParserElement):
    """One robot or library and nothing else; the tree goes into the text."""

    def __init__(self) -> None:
        super().__init__()
        self.mayIndexError = False

    def _generateDefaultName(self) -> str:
        return "file"

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        text = text_of(instring)
        start = skip_space(text, 0)
        kind, loc = _kind(text, start)
        if kind is None:
            return len(text), []
        block = robot_block() if kind == "robot" else library_block()
        name, loc = _name(text, loc, kind)
        loc = skip_space(text, loc)
        text.item_start = start
        opened = _opening(text, start, loc, name is not None, kind, block)
        if opened is None:
            return len(text), []
        declarations: list[Any] = []
        end = block.read(text, opened, Header(start, loc), declarations)
        end = _rest(text, end, block, kind, declarations)
        if name is not None:
            span = text.span(start, end)
            broken = frozenset(text.broken)
            text.tree = FileNode(kind, name, tuple(declarations), broken, span=span)
        return len(text), []


def _kind(text: ModelText, start: int) -> tuple[Literal["robot", "library"] | None, int]:
    match = _WORD.match(text, start)
    word = match.group() if match else ""
    if match and word in ("robot", "library"):
        return cast(Literal["robot", "library"], word), match.end()
    near = get_close_matches(word[:40], ["robot", "library"], 1, 0.7)
    if not text.has_lexical_fault(0, start + 1):
        hint = f"did you mean '{near[0]}'?" if near else None
        text.report("syntax", "expected 'robot' or 'library'", start, hint=hint)
    if match and near:
        text.settled = skip_space(text, match.end())
        return cast(Literal["robot", "library"], near[0]), match.end()
    return None, start


def _name(text: ModelText, loc: int, kind: str) -> tuple[Any, int]:
    loc = skip_space(text, loc)
    match = _NAME.match(text, loc)
    if match:
        return make_name(text, loc, match.end(), match.group()), match.end()
    if text.settled != loc and not text.has_lexical_fault(0, loc + 1):
        text.report("syntax", f"expected a name for the {kind}", loc)
    text.settled = loc
    return None, loc


def _opening(
    text: ModelText, start: int, loc: int, named: bool, kind: str, block: Block
) -> int | None:
    """The place behind the opening brace, if what follows can be read at all."""
    if text.startswith("{", loc):
        return loc + 1
    if named and not text.has_lexical_fault(start, loc + 1):
        text.report("syntax", f"expected '{{' after the name of the {kind}", loc)
    text.settled = loc
    if block.begins(text, loc):
        return loc
    junk = _TO_BRACE.match(text, loc)
    return junk.end() + 1 if junk else None


def _rest(text: ModelText, end: int, block: Block, kind: str, declarations: list[Any]) -> int:
    """Read what follows the closing brace: nothing, or the traces of a brace too many.

    Only the first trace is reported; further declarations are read all the same.
    """
    told = False
    while True:
        loc = skip_space(text, end)
        word = _WORD.match(text, loc)
        if loc >= text.body_end:
            return end
        if not told:
            _trailing(text, loc, kind, block)
            told = True
        if word and word.group() in ("robot", "library"):
            return end
        text.settled = loc
        if block.belongs(text, loc):
            end = block.read(text, loc, None, declarations)
        else:
            end = text.settled = max(loc + 1, block.landmarks.resume(text, loc, loc))


def _trailing(text: ModelText, loc: int, kind: str, block: Block) -> None:
    word = _WORD.match(text, loc)
    if block.belongs(text, loc):
        if text.settled != loc:
            hint = "is there a '}' too many above?"
            message = f"the {kind} has ended before this"
            text.report("unexpected-brace", message, loc, hint=hint)
    elif text.startswith("}", loc):
        text.report("unexpected-brace", "this '}' closes nothing", loc)
    elif word and word.group() in ("robot", "library"):
        message = f"a file holds one robot or library, and there is a {kind} above"
        text.report("several-robots", message, loc, hint="move this to a file of its own")
    elif not text.has_lexical_fault(loc, len(text)):
        text.report("syntax", f"expected the end of the file after the {kind}", loc)
