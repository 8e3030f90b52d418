"""Reading lines from a terminal, with completion and history; or from whatever input is.

prompt_toolkit does it where it is installed (Debian: python3-prompt-toolkit), else readline.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TextIO

from robosc.simulate.machines.machine import label
from robosc.simulate.script.session import WORDS, Session

_PROMPT = "> "
_LAST_WORD = re.compile(r"[\w.^\[\]]*$", re.ASCII)
_CONDITIONS = ("goto", "expect")


def line_reader(session: Session, source: TextIO) -> Callable[[], str | None]:
    """A function that gives the next line, or None at the end of input.

    At a terminal, Ctrl-C gives up the line that is being typed; elsewhere it ends everything.
    """
    if not source.isatty():
        return lambda: source.readline() or None
    read = _prompt_toolkit(session) or _readline(session)

    def next_line() -> str | None:
        while True:
            try:
                return read()
            except KeyboardInterrupt:
                print("\nto leave, type quit or press Ctrl-D")

    return next_line


def completions(session: Session, before: str) -> list[str]:
    """What the last word of a line can become."""
    match = _LAST_WORD.search(before)
    start = match.group() if match else ""
    words = before[: len(before) - len(start)].replace("(", " ").split()
    return [word for word in dict.fromkeys(_words(session, words)) if word.startswith(start)]


def _words(session: Session, before: list[str]) -> Iterator[str]:
    machine = session.machine
    if not before:
        yield from (label(c.event) for c in session.menu())
        yield from WORDS
        return
    first = before[0]
    if first == "why":
        yield from (label(c.event) for c in machine.commands())
    elif first in _CONDITIONS:
        if first == "expect" and len(before) == 1:
            yield from ("enabled", "disabled", "sent", "data", "marked", "mismatch", "stopped")
        if before[-1] in ("enabled", "disabled", "sent", "data"):
            yield from (label(e) for e in machine.plant.events)
        yield from _conditions(session)
    elif first not in WORDS:
        for choice in session.menu():
            if label(choice.event).startswith(first) and choice.given:
                yield from (str(v) for v in choice.given.values() if isinstance(v, str))


def _conditions(session: Session) -> Iterator[str]:
    for component in session.machine.plant.robot.components:
        yield from (f"{component.name}.{s.name}" for s in component.states)
        yield from (f"{component.name}.{v.name}" for v in component.variables)


def _prompt_toolkit(session: Session) -> Callable[[], str | None] | None:
    try:
        from prompt_toolkit import PromptSession
        from prompt_toolkit.completion import Completer, Completion
        from prompt_toolkit.utils import is_dumb_terminal
    except ImportError:
        return None
    if is_dumb_terminal():  # which shows what newer versions send to move the cursor
        return None

    class Words(Completer):  # type: ignore[misc, unused-ignore]
        def get_completions(self, document: Any, complete_event: Any) -> Iterable[Any]:
            before = document.text_before_cursor
            match = _LAST_WORD.search(before)
            start = match.group() if match else ""
            for word in completions(session, before):
                yield Completion(word, start_position=-len(start))

    prompt: Any = PromptSession(completer=Words(), complete_while_typing=False)

    def read() -> str | None:
        try:
            return str(prompt.prompt(_PROMPT))
        except EOFError:
            return None

    return read


def _readline(session: Session) -> Callable[[], str | None]:
    try:
        import readline
    except ImportError:  # not on every platform: then without completion and history
        pass
    else:

        def complete(text: str, number: int) -> str | None:
            found = completions(session, readline.get_line_buffer()[: readline.get_endidx()])
            return found[number] if number < len(found) else None

        readline.set_completer_delims(" \t(),")
        readline.set_completer(complete)
        readline.parse_and_bind("tab: complete")

    def read() -> str | None:
        try:
            return input(_PROMPT)
        except EOFError:
            print()
            return None

    return read
