"""Feeding lines to a session: from a script, from another program, from whoever types."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any, TextIO

from robosc.lazy_dataclasses import dataclass
from robosc.runtime.core.telemetry import dump
from robosc.simulate.faults import Failed, LineFault
from robosc.simulate.script import documents, junit, render
from robosc.simulate.script.session import Done, Session, code_of


@dataclass(frozen=True, slots=True)
class Followed:
    """What came of a script: the exit code, and each line that had to come true."""

    exit_code: int
    cases: tuple[junit.Case, ...]


def follow_script(
    session: Session, lines: Iterable[str], name: str, out: TextIO, messages: TextIO, json: bool
) -> Followed:
    """Run the lines of a script.

    A failed expectation is reported, and the script goes on; any other fault ends it, since what
    follows would be done in another state than its writer had in mind. Without ``json`` only what
    lines ask for is written (``show``, ``why``), and how many expectations were met.
    """
    codes = {0}
    cases: list[junit.Case] = []
    if json:
        _begin(session, out)
    for number, line in enumerate(lines, 1):
        try:
            done = session.do(line, numbers=False)
        except LineFault as fault:
            codes.add(code_of(fault))
            cases.append(case := junit.Case(number, line, fault))
            if json:
                _write(out, documents.fault_document(number, fault))
            print(f"{name}:{number}: {fault.kind}: {fault}", file=messages)
            if isinstance(fault, Failed) and case.is_expectation:
                continue
            break
        case = junit.Case(number, line)
        if case.is_expectation:
            cases.append(case)
        if json:
            _write(out, documents.done_document(session, number, done))
        else:
            out.write(done_text(session, done, render.Style(), quiet=True))
        if done.quit:
            break
    expectations = [case for case in cases if case.is_expectation]
    met = sum(case.fault is None for case in expectations)
    if not json:
        print(f"{name}: {met} of {len(expectations)} expectations met", file=out)
    return Followed(max(codes), tuple(cases))


def follow_documents(session: Session, lines: Iterable[str], out: TextIO) -> int:
    """Answer documents until there are no more; the exit code.

    The first answer is the beginning, line 0. Faults are answers as well; an expectation that
    failed makes the exit code 1.
    """
    code = 0
    _begin(session, out)
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        document, result = documents.answer(session, number, line)
        _write(out, document)
        if isinstance(result, Failed):
            code = 1
        if isinstance(result, Done) and result.quit:
            break
    return code


def follow_typing(
    session: Session,
    next_line: Callable[[], str | None],
    out: TextIO,
    style: render.Style,
) -> int:
    """Do what is typed until the end of input. Faults are reported; the exit code is 0."""
    text = "an event by its number or name; help lists all that can be typed\n"
    text += render.happenings_text(session.latest, style) + render.session_text(session, style)
    while True:
        _show(out, text)
        line = next_line()
        if line is None:
            return 0
        try:
            done = session.do(line)
        except LineFault as fault:
            text = style("31", str(fault)) + "\n"
            continue
        except KeyboardInterrupt:
            if not line.startswith("goto"):
                raise
            text = "the search was interrupted\n"  # it changes nothing before it has found a way
            continue
        text = done_text(session, done, style)
        if done.quit:
            _show(out, text)
            return 0


def _show(out: TextIO, text: str) -> None:
    """Write as wide as the terminal is at the moment; elsewhere lines are left whole."""
    if out.isatty():
        with suppress(OSError):
            text = render.fitted(text, os.get_terminal_size(out.fileno()).columns or 80)
    out.write(text)
    out.flush()


def done_text(session: Session, done: Done, style: render.Style, quiet: bool = False) -> str:
    """What to write about a line that was done; quietly, only what it asked for."""
    text = "" if quiet else render.happenings_text(done.happenings, style)
    if done.text and not (quiet and done.changed):
        text += f"{done.text}\n"
    if done.show or (done.changed and not quiet):
        text += render.session_text(session, style)
    return text


def _begin(session: Session, out: TextIO) -> None:
    _write(out, documents.done_document(session, 0, Done(session.latest)))


def _write(out: TextIO, document: dict[str, Any]) -> None:
    """One document, at once: the other program waits for it."""
    out.write(dump(document) + "\n")
    out.flush()
