"""Code actions: what the hint of a diagnostic says, done.

Hints are sentences for people. Those that can be carried out without knowing more are listed in
``_RULES``; all others stay words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from robosc.errors import Diagnostic
from robosc.lsp.analysis import Analysis
from robosc.lsp.carriers import fits
from robosc.names import IDENTIFIER
from robosc.source import Source, Span
from robosc.syntax.nodes import (
    BehaviourNode,
    ComponentNode,
    DeclarationNode,
    EnumNode,
    FileNode,
    ImportNode,
    MessageNode,
    StateNode,
)


@dataclass(frozen=True, slots=True)
class Edit:
    """``text`` in place of a range."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Action:
    title: str
    edits: tuple[Edit, ...]


_INDENT = "    "


def actions_for(analysis: Analysis, diagnostic: Diagnostic) -> list[Action]:
    """What can be done about a diagnostic of this text, if anything."""
    hint = diagnostic.hint
    if hint is None or diagnostic.span.source is not analysis.source:
        return []
    place = _Place(analysis, diagnostic)
    matches = ((rule, re.fullmatch(pattern, hint)) for pattern, rule in _RULES)
    return [action for rule, found in matches if found for action in rule(place, found)]


@dataclass(frozen=True)
class _Place:
    """A diagnostic in a text, what is declared there, and edits of it."""

    analysis: Analysis
    diagnostic: Diagnostic

    @property
    def source(self) -> Source:
        return self.analysis.source

    @property
    def span(self) -> Span:
        return self.diagnostic.span

    def insert(self, offset: int, text: str) -> Edit:
        return Edit(Span(self.source, offset, offset), text)

    def replace(self, text: str) -> Action:
        """Write a text in place of what the diagnostic marks."""
        return Action(f"Write '{text}'", (Edit(self.span, text),))

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

    @property
    def file(self) -> FileNode | None:
        """The file as it is written; None if it could not be read."""
        contents = self.analysis.contents
        return (contents.scope.node.written or contents.scope.node) if contents else None

    @property
    def components(self) -> list[ComponentNode]:
        declarations = self.file.declarations if self.file else ()
        return [node for node in declarations if isinstance(node, ComponentNode)]

    @property
    def declaration(self) -> DeclarationNode | None:
        """The declaration of the file around the diagnostic."""
        declarations = self.file.declarations if self.file else ()
        around = (d for d in declarations if d.span.start <= self.span.start < d.span.end)
        return next(around, None)

    def message(self, name: str) -> MessageNode | None:
        """The only message of that name, or ``Component.name``."""
        component, _, bare = name.rpartition(".")
        found = [
            item
            for owner in self.components
            if component in ("", owner.name.text)
            for item in owner.items
            if isinstance(item, MessageNode) and item.name.text == bare
        ]
        return found[0] if len(found) == 1 else None


def _behaviour(component: object) -> BehaviourNode | None:
    items = component.items if isinstance(component, ComponentNode) else ()
    return next((item for item in items if isinstance(item, BehaviourNode)), None)


def _state(component: object, name: str) -> StateNode | None:
    behaviour = _behaviour(component)
    states = [i for i in (behaviour.items if behaviour else ()) if isinstance(i, StateNode)]
    for state in states:  # appended to below
        states.extend(state.states)
    return next((state for state in states if state.name.text == name), None)


# --- the rules -----------------------------------------------------------------------------------


def _replace(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    yield place.replace(found[1])


def _choose(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    yield from map(place.replace, found[1].split(" or "))


def _remove(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    if place.diagnostic.code == "several-defaults":
        yield Action("Remove this default", (Edit(_line_of(place.span), ""),))
    elif place.diagnostic.code == "bad-character":
        yield Action("Remove it", (Edit(place.span, ""),))


def _remove_initial(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    start = place.source.text.rfind("initial", 0, place.span.start)
    match = re.compile(r"initial\s+").match(place.source.text, start) if start >= 0 else None
    if match:
        edit = Edit(Span(place.source, match.start(), match.end()), "")
        yield Action(f"Remove 'initial' from '{found[1]}'", (edit,))


def _close(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    # A forgotten quote swallows the line; what was meant to be quoted has no blanks or commas.
    meant = re.match(r"[\"'][^\s,]*", place.span.text)
    end = place.span.start + meant.end() if meant else place.span.end
    if place.diagnostic.code == "unterminated-comment":
        line = place.span.line
        end = place.source.line_start(line) + len(place.source.line(line))
    yield Action(f"Close it with {found[1]}", (place.insert(end, found[1]),))


def _add_default(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    if isinstance(place.declaration, EnumNode):
        yield Action(f"Add '{found[1]}'", (place.inside(place.declaration.span, found[1]),))


def _make_initial(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    if state := _state(place.declaration, found[1]):
        edit = place.insert(state.span.start, "initial ")
        yield Action(f"Make '{found[1]}' the initial state", (edit,))


def _add_initial(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    if behaviour := _behaviour(place.declaration):
        yield Action("Add an initial state", (place.inside(behaviour.span, found[1]),))


def _link(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    """To an interface that the model declares and that fits, else to what the hint names."""
    contents = place.analysis.contents
    if place.diagnostic.code != "missing-links" or contents is None or place.file is None:
        return
    infos = (info for i in contents.instances.values() for info in i.communications.values())
    marked = (i for i in infos if place.span in (i.node.name.span, _type(i.node)))
    if (info := next(marked, None)) is None:
        return
    end = info.node.span.end
    interfaces = contents.scope.interfaces
    definitions = place.analysis.definitions
    fitting = [name for name, node in interfaces.items() if fits(info, node, definitions)]
    for name in fitting:
        yield Action(f"Link '{name}'", (place.insert(end, f" links {name}"),))
    name, declaration = found[1], found[2]
    if not fitting and declaration and name not in interfaces and "PACKAGE" not in declaration:
        edits = (place.insert(end, f" links {name}"), place.inside(place.file.span, declaration))
        yield Action(f"Link '{name}'", edits)


def _type(node: object) -> Span | None:
    return node.type.span if isinstance(node, MessageNode) else None


def _add_import(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    if isinstance(node := place.declaration, ImportNode):
        text = f"\n{place.indent(node.span.start)}{found[1]}"
        yield Action(f"Add '{found[1]}'", (place.insert(node.span.end, text),))


def _add_transition(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    """What synthesis says is missing."""
    transition, name, component = found.groups()
    owner = next((node for node in place.components if node.name.text == component), None)
    if state := _state(owner, name):
        yield Action(f"Add '{transition}'", (place.inside(state.span, transition),))


def _timeout(place: _Place, name: str, text: str) -> Edit | None:
    """Give a message of this file its timeout."""
    message = place.message(name)
    if message is None:
        return None
    before = re.search(r"type\s*:\s*\Z", place.source.text[: message.type.span.start])
    return place.insert(before.start(), f"{text} ") if before else None


def _add_timeout(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    if edit := _timeout(place, found[1], found[2]):
        yield Action(f"Add '{found[2]}' to {found[1]}", (edit,))


def _add_freshness(place: _Place, found: re.Match[str]) -> Iterator[Action]:
    """A timeout of the message, and a requirement of one of the commands that rest on it."""
    message, text, command, condition, others = found.groups()
    timeout = _timeout(place, message, text)
    if timeout is None or place.declaration is None:
        return
    start = place.declaration.span.start
    for one in (command, *(others.split(", ") if others else ())):
        requirement = f"requirement {one} needs {condition}"
        edit = place.insert(start, f"{requirement}\n{place.indent(start)}")
        yield Action(f"Add a timeout and '{requirement}'", (timeout, edit))


def _line_of(span: Span) -> Span:
    """The whole line if nothing else is on it."""
    source = span.source
    line = span.line
    start, end = source.line_start(line), source.line_start(line + 1)
    if span.end_line == line and source.line(line).strip() == span.text:
        return Span(source, start, end)
    return span


_NAME = rf"\^?{IDENTIFIER}"
_MEMBER = rf"{_NAME}\.{_NAME}"
_MESSAGE = rf"(?:{_NAME}\.)?{_NAME}"

_RULES: tuple[tuple[str, Callable[[_Place, re.Match[str]], Iterator[Action]]], ...] = (
    (r"did you mean '([^']+)'\?(?:\n[\s\S]*)?", _replace),
    (
        r"write '([^']+)'(?: with its colon| if this is a name| for 'not'.*)?(?:\n[\s\S]*)?",
        _replace,
    ),
    (r"write (integer\(-?\d+\.\.-?\d+\))(?:\n[\s\S]*)?", _replace),
    (r"write: (value = .+)(?:\n[\s\S]*)?", _replace),
    (rf"write ({_MEMBER}(?: or {_MEMBER})+)", _choose),
    (r"no separator stands between declarations|remove one of them", _remove),
    (rf"remove 'initial' from '({_NAME})' or from '{_NAME}'", _remove_initial),
    (r"close it with (\S+)", _close),
    (rf"add: (default -> {_NAME})", _add_default),
    (rf"write: initial (?:marked )?state ({_NAME})", _make_initial),
    (r"add: (initial marked state idle \{\})", _add_initial),
    (
        rf"add: links ({_NAME})"
        rf"(?:, and .*|\nand declare: (interface {_NAME} use {_NAME} from {_NAME}))",
        _link,
    ),
    (rf"add: (component {_NAME} from {_NAME} import {_NAME}.*)", _add_import),
    (rf"add '(on [^']+)' in state ({_NAME}) of ({_NAME})[\s\S]*", _add_transition),
    (rf"give ({_MESSAGE}) a '(timeout: [^']+,)'", _add_timeout),
    (
        rf"give ({_MESSAGE}) a '(timeout: .+,)' and add"
        rf" 'requirement ({_MESSAGE}) needs ({_MESSAGE}\.fresh)'"
        rf"(?:, or for ((?:{_MESSAGE}(?:, )?)+))?",
        _add_freshness,
    ),
)
"""Patterns of hints, each with what does what the hint says."""
