"""Code actions: what the hint of a diagnostic says, done.

Hints are sentences for people. The forms that can be carried out without knowing more are listed
here; all others stay words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from robosc.errors import Diagnostic
from robosc.lsp.analysis import Analysis
from robosc.lsp.carriers import fits
from robosc.model.tables import CommunicationInfo
from robosc.source import Source, Span
from robosc.syntax.nodes import (
    BehaviourNode,
    ComponentNode,
    EnumNode,
    FileNode,
    ImportNode,
    MessageNode,
    StateNode,
)

__all__ = ["Action", "Edit", "actions_for"]


@dataclass(frozen=True, slots=True)
class Edit:
    """``text`` in place of a range."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Action:
    title: str
    edits: tuple[Edit, ...]


_NAME = r"\^?[A-Za-z_]\w*"
_INDENT = "    "


def actions_for(analysis: Analysis, diagnostic: Diagnostic) -> list[Action]:
    """What can be done about a diagnostic of this text, if anything."""
    hint = diagnostic.hint
    contents = analysis.contents
    if hint is None or diagnostic.span.source is not analysis.source:
        return []
    place = _Place(analysis, contents.scope.node if contents is not None else None, diagnostic)
    return [action for rule in _RULES for action in rule(place, hint)]


@dataclass(frozen=True)
class _Place:
    analysis: Analysis
    file: FileNode | None
    diagnostic: Diagnostic

    @property
    def source(self) -> Source:
        return self.analysis.source

    @property
    def span(self) -> Span:
        return self.diagnostic.span

    def insert(self, offset: int, text: str) -> Edit:
        return Edit(Span(self.source, offset, offset), text)

    def indent(self, offset: int) -> str:
        line = self.source.line(self.source.position(offset)[0])
        return line[: len(line) - len(line.lstrip())]

    def inside(self, block: Span, line: str) -> Edit:
        """A line at the end of a block in braces."""
        brace = block.end - 1
        begin = self.source.line_start(self.source.position(brace)[0])
        outer = self.indent(block.start)
        if self.source.text[begin:brace].strip():
            # The brace shares its line with something: give it one of its own.
            return self.insert(brace, f"\n{outer}{_INDENT}{line}\n{outer}")
        return self.insert(begin, f"{outer}{_INDENT}{line}\n")

    def component(self, name: str) -> ComponentNode | None:
        found = (d for d in (self.file.declarations if self.file else ()))
        return next(
            (d for d in found if isinstance(d, ComponentNode) and d.name.text == name), None
        )

    def message(self, name: str) -> MessageNode | None:
        """The only message of that name, or ``Component.name``."""
        component, _, bare = name.rpartition(".")
        found = [
            item
            for owner in (self.file.declarations if self.file else ())
            if isinstance(owner, ComponentNode) and component in ("", owner.name.text)
            for item in owner.items
            if isinstance(item, MessageNode) and item.name.text == bare
        ]
        return found[0] if len(found) == 1 else None

    def state(self, component: str, name: str) -> StateNode | None:
        owner = self.component(component)
        for item in owner.items if owner is not None else ():
            for part in item.items if isinstance(item, BehaviourNode) else ():
                if isinstance(part, StateNode) and part.name.text == name:
                    return part
        return None


_Rule = Callable[[_Place, str], Iterator[Action]]


def _replace(place: _Place, hint: str) -> Iterator[Action]:
    """``did you mean 'x'?``, ``write 'x'``, ``write: x``, ``write integer(1..2)``."""
    first = hint.split("\n", 1)[0]
    found = (
        re.fullmatch(r"did you mean '([^']+)'\?", first)
        or re.fullmatch(
            r"write '([^']+)'(?: with its colon| if this is a name| for 'not'.*)?", first
        )
        or re.fullmatch(r"write (integer\(-?\d+\.\.-?\d+\))", first)
        or re.fullmatch(r"write: (value = .+)", first)
    )
    if found:
        yield Action(f"Write '{found[1]}'", (Edit(place.span, found[1]),))


def _choose(place: _Place, hint: str) -> Iterator[Action]:
    """``write A.x or B.x``."""
    qualified = rf"{_NAME}\.{_NAME}"
    if re.fullmatch(rf"write {qualified}(?: or {qualified})+", hint):
        for name in hint.removeprefix("write ").split(" or "):
            yield Action(f"Write '{name}'", (Edit(place.span, name),))


def _remove(place: _Place, hint: str) -> Iterator[Action]:
    code = place.diagnostic.code
    if code == "bad-character" and hint == "no separator stands between declarations":
        yield Action("Remove it", (Edit(place.span, ""),))
    elif code == "several-defaults":
        yield Action("Remove this default", (Edit(_line_of(place.span), ""),))
    found = re.fullmatch(rf"remove 'initial' from '({_NAME})' or from '{_NAME}'", hint)
    if found:
        text = place.source.text
        start = text.rfind("initial", 0, place.span.start)
        match = re.compile(r"initial\s+").match(text, start) if start >= 0 else None
        if match:
            span = Span(place.source, match.start(), match.end())
            yield Action(f"Remove 'initial' from '{found[1]}'", (Edit(span, ""),))


def _close(place: _Place, hint: str) -> Iterator[Action]:
    found = re.fullmatch(r"close it with (\S+)", hint)
    if found:
        # A forgotten quote swallows the line; what was meant to be quoted has no blanks or commas.
        meant = re.match(r"[\"'][^\s,]*", place.span.text)
        end = place.span.start + meant.end() if meant else place.span.end
        if place.diagnostic.code == "unterminated-comment":
            line, _ = place.source.position(place.span.start)
            end = place.source.line_start(line) + len(place.source.line(line))
        yield Action(f"Close it with {found[1]}", (place.insert(end, found[1]),))


def _default(place: _Place, hint: str) -> Iterator[Action]:
    found = re.fullmatch(rf"add: (default -> {_NAME})", hint)
    if not found or place.file is None:
        return
    for node in place.file.declarations:
        if isinstance(node, EnumNode) and node.name.span == place.span:
            yield Action(f"Add '{found[1]}'", (place.inside(node.span, found[1]),))


def _initial(place: _Place, hint: str) -> Iterator[Action]:
    component = place.component(place.span.text.lstrip("^"))
    found = re.fullmatch(rf"write: initial (?:marked )?state ({_NAME})", hint)
    if component is None:
        return
    behaviour = next((i for i in component.items if isinstance(i, BehaviourNode)), None)
    if found:
        state = place.state(component.name.text, found[1])
        if state is not None:
            edit = place.insert(state.span.start, "initial ")
            yield Action(f"Make '{found[1]}' the initial state", (edit,))
    elif hint == "add: initial marked state idle {}" and behaviour is not None:
        edit = place.inside(behaviour.span, hint.removeprefix("add: "))
        yield Action("Add an initial state", (edit,))


def _links(place: _Place, hint: str) -> Iterator[Action]:
    """To an interface that the model declares and that fits, else to what the hint names."""
    contents = place.analysis.contents
    if place.diagnostic.code != "missing-links" or contents is None or place.file is None:
        return
    communications = (c for i in contents.instances.values() for c in i.communications.values())
    info = next((c for c in communications if place.span in (c.node.name.span, _type(c))), None)
    if info is None:
        return
    end = info.node.span.end
    interfaces = contents.scope.interfaces
    fitting = [
        name for name, node in interfaces.items() if fits(info, node, place.analysis.definitions)
    ]
    for name in fitting:
        yield Action(f"Link '{name}'", (place.insert(end, f" links {name}"),))
    found = re.fullmatch(
        rf"add: links ({_NAME})\nand declare: (interface {_NAME} use {_NAME} from {_NAME})", hint
    )
    if fitting or not found or found[1] in interfaces or "PACKAGE" in found[2]:
        return
    edits = (place.insert(end, f" links {found[1]}"), place.inside(place.file.span, found[2]))
    yield Action(f"Link '{found[1]}'", edits)


def _type(info: CommunicationInfo) -> Span | None:
    return info.node.type.span if isinstance(info.node, MessageNode) else None


def _import(place: _Place, hint: str) -> Iterator[Action]:
    found = re.fullmatch(rf"add: (component {_NAME} from {_NAME} import {_NAME}.*)", hint)
    if not found or place.file is None:
        return
    for node in place.file.declarations:
        if isinstance(node, ImportNode) and node.span.start <= place.span.start < node.span.end:
            text = f"\n{place.indent(node.span.start)}{found[1]}"
            yield Action(f"Add '{found[1]}'", (place.insert(node.span.end, text),))


def _transition(place: _Place, hint: str) -> Iterator[Action]:
    """What synthesis says is missing."""
    found = re.match(rf"add '(on [^']+)' in state ({_NAME}) of ({_NAME})", hint)
    state = place.state(found[3], found[2]) if found else None
    if found and state is not None:
        yield Action(f"Add '{found[1]}'", (place.inside(state.span, found[1]),))


def _timeout(place: _Place, name: str, text: str) -> Edit | None:
    """Give a message of this file its timeout."""
    message = place.message(name)
    if message is None:
        return None
    before = re.search(r"type\s*:\s*\Z", place.source.text[: message.type.span.start])
    return place.insert(before.start(), f"{text} ") if before else None


def _missing_timeout(place: _Place, hint: str) -> Iterator[Action]:
    """``give scan a 'timeout: 500 ms,'``."""
    found = re.fullmatch(rf"give ((?:{_NAME}\.)?{_NAME}) a '(timeout: [^']+,)'", hint)
    edit = _timeout(place, found[1], found[2]) if found else None
    if found and edit is not None:
        yield Action(f"Add '{found[2]}' to {found[1]}", (edit,))


def _freshness(place: _Place, hint: str) -> Iterator[Action]:
    """A timeout of the message, and a requirement of one of the commands that rest on it."""
    name = rf"(?:{_NAME}\.)?{_NAME}"
    found = re.fullmatch(
        rf"give ({name}) a '(timeout: .+,)' and add"
        rf" 'requirement ({name}) needs ({name}\.fresh)'(?:, or for ((?:{name}(?:, )?)+))?",
        hint,
    )
    timeout = _timeout(place, found[1], found[2]) if found else None
    if not found or timeout is None or place.file is None:
        return
    statement = next(
        (d for d in place.file.declarations if d.span.start <= place.span.start < d.span.end), None
    )
    if statement is None:
        return
    start = statement.span.start
    for command in (found[3], *(found[5] or "").split(", ")):
        if command:
            requirement = f"requirement {command} needs {found[4]}"
            edits = (
                timeout,
                place.insert(start, f"{requirement}\n{place.indent(start)}"),
            )
            yield Action(f"Add a timeout and '{requirement}'", edits)


def _line_of(span: Span) -> Span:
    """The whole line if nothing else is on it."""
    source = span.source
    line = span.line
    start, end = source.line_start(line), source.line_start(line + 1)
    if span.end_line == line and source.line(line).strip() == span.text:
        return Span(source, start, end)
    return span


_RULES: tuple[_Rule, ...] = (
    _replace, _choose, _remove, _close, _default, _initial, _links, _import, _transition,
    _missing_timeout, _freshness,
)  # fmt: skip
