"""Parsing: from the text of a model to its syntax tree, and all syntax errors of the file."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any, Literal, cast

from robosc import errors, limits
from robosc.language.tokens import is_word, tokenize
from robosc.remedies import meant
from robosc.source import Source, Span, opened
from robosc.syntax import grammar, leaves
from robosc.syntax.blocks import Block, Header
from robosc.syntax.nodes import FileNode, Name
from robosc.syntax.parse_state import ParseState
from robosc.syntax.recovery.synchronise import late_brace

_FILES = ("robot", "library")


def read_source(path: str) -> tuple[Source | None, tuple[errors.Diagnostic, ...]]:
    """The model file at ``path``; None and the reason if it is not UTF-8 text.

    Raises:
        UsageError: the file cannot be read, or is too large to be a model.
    """
    return source_of(path, read_bytes(path))


def read_bytes(path: str, what: str = "model") -> bytes:
    """The content of a file; ``-`` is standard input.

    Raises:
        UsageError: it cannot be read, or is too large to be a model (or ``what`` it is to be).
    """
    try:
        with opened(path) as file:
            data = file.read(limits.FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise errors.UsageError(f"cannot read {path}: {reason or error}") from error
    if len(data) > limits.FILE_BYTES:
        raise errors.UsageError(
            f"cannot read {path}: no {what} has more than {limits.FILE_BYTES >> 20} MB"
        )
    return data


def source_of(path: str, data: bytes) -> tuple[Source | None, tuple[errors.Diagnostic, ...]]:
    """The source in the bytes of a model file; None and the reason if they are not UTF-8 text.

    A byte order mark is dropped, and line ends become ``\\n``.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return None, (_invalid_utf8(path, data, error),)
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n")), ()


def parse(source: Source) -> tuple[FileNode | None, tuple[errors.Diagnostic, ...]]:
    """The syntax tree of a text, and the syntax errors in reading order.

    The tree is None if the text begins with neither a robot nor a library, and after too many
    errors. Faulty declarations are left out of it; ``FileNode.broken`` has the words in them. Does
    not raise for any text.
    """
    tokens = tokenize(source)
    reading = ParseState(tokens)
    tree = None if tokens.binary else _file(reading)
    found = errors.at_most(errors.sort_diagnostics(reading.diagnostics), limits.LEXICAL_ERRORS)
    return tree if len(found) <= limits.LEXICAL_ERRORS else None, tuple(found)


def _invalid_utf8(path: str, data: bytes, error: UnicodeDecodeError) -> errors.Diagnostic:
    before = data[: error.start].decode("utf-8-sig", "replace")
    source = Source(path, data.decode("utf-8-sig", "replace").replace("\r\n", "\n"))
    start = len(before.replace("\r\n", "\n"))
    message = f"the byte 0x{data[error.start]:02X} is not UTF-8 text"
    utf16 = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    hint = "this looks like UTF-16: save the file as UTF-8" if utf16 else "save the file as UTF-8"
    span = Span(source, start, start + 1)
    return errors.Diagnostic(errors.Severity.ERROR, "invalid-utf8", message, span, hint)


def _file(reading: ParseState) -> FileNode | None:
    """The tree of one robot or library; None if there is none, or it has no name."""
    kind, at = _kind(reading)
    if kind is None:
        return None
    block = grammar.robot_block() if kind == "robot" else grammar.library_block()
    name, at = _name(reading, at, kind)
    opened = _opening(reading, at, name is not None, kind, block)
    if opened is None:
        return None
    declarations: list[Any] = []
    end = block.read(reading, opened, Header(0, at), declarations)
    end = _rest(reading, end, block, kind, declarations)
    if name is None:
        return None
    broken = frozenset(reading.broken)
    return FileNode(kind, name, tuple(declarations), broken, span=reading.span(0, end))


def _kind(reading: ParseState) -> tuple[Literal["robot", "library"] | None, int]:
    word = reading.text(0)
    if word in _FILES:
        return cast(Literal["robot", "library"], word), 1
    near = get_close_matches(word[:40], _FILES, 1, 0.7)
    if not reading.tokens.has_fault(0, reading.tokens.offset(0) + 1):
        fault = reading.expected(0, "expected 'robot' or 'library'")
        reading.report(fault.code, fault.message, 0, meant(near[0]) if near else fault.hint)
    if near:
        reading.reported_at = 1
        return cast(Literal["robot", "library"], near[0]), 1
    return None, 0


def _name(reading: ParseState, at: int, kind: str) -> tuple[Name | None, int]:
    if is_word(reading.kind(at)):
        return leaves.make_name(reading, at, at + 1, []), at + 1
    if reading.reported_at != at and not reading.tokens.has_fault(0, reading.tokens.offset(at) + 1):
        reading.report("syntax", f"expected a name for the {kind}", at)
    reading.reported_at = at
    return None, at


def _opening(reading: ParseState, at: int, named: bool, kind: str, block: Block) -> int | None:
    """The token behind the opening brace; None if no declarations can be found."""
    if reading.kind(at) == "{":
        return at + 1
    if named and not reading.tokens.has_fault(0, reading.tokens.offset(at) + 1):
        reading.report("syntax", f"expected '{{' after the name of the {kind}", at)
    reading.reported_at = at
    if block.begins(reading, at):
        return at
    brace = late_brace(reading, at)
    return None if brace is None else brace + 1


def _rest(reading: ParseState, end: int, block: Block, kind: str, declarations: list[Any]) -> int:
    """Parse what follows the closing brace, due to a superfluous brace; return the last token.

    Only the first such text is reported; declarations in it are added all the same.
    """
    reported = False
    while end < len(reading.kinds):
        at = end
        if not reported:
            _trailing(reading, at, kind, block)
            reported = True
        if reading.text(at) in _FILES:
            return end
        reading.reported_at = at
        if block.belongs(reading, at):
            end = block.read(reading, at, None, declarations)
        else:
            end = reading.reported_at = max(at + 1, block.synchroniser.resume(reading, at, at))
    return end


def _trailing(reading: ParseState, at: int, kind: str, block: Block) -> None:
    if block.belongs(reading, at):
        if reading.reported_at != at:
            hint = "is there an extra '}' above?"
            reading.report("unexpected-brace", f"the {kind} has ended before this", at, hint)
    elif reading.kind(at) == "}":
        reading.report("unexpected-brace", "this '}' closes nothing", at)
    elif reading.text(at) in _FILES:
        message = f"a file holds one robot or library, and there is a {kind} above"
        reading.report("several-robots", message, at, "move this to a file of its own")
    elif not reading.tokens.has_fault(reading.tokens.offset(at), len(reading.source.text)):
        reading.report("syntax", f"expected the end of the file after the {kind}", at)
