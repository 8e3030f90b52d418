"""Code actions: what the hint of a diagnostic says, done.

Hints are sentences for people; those that are remedies can be carried out without knowing more.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

from robosc import dotted, errors, names, remedies
from robosc.lazy_dataclasses import dataclass
from robosc.lsp.analysis import Analysis
from robosc.lsp.ros_definitions import fits
from robosc.source import Source, Span
from robosc.syntax import nodes


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


def actions_for(analysis: Analysis, diagnostic: errors.Diagnostic) -> list[Action]:
    """What can be done about a diagnostic of this text, if anything."""
    remedy = diagnostic.remedy
    if remedy is None or diagnostic.span.source is not analysis.source:
        return []
    return [*_RULES[remedy.change](_Place(analysis, diagnostic), *remedy.parts)]


@dataclass(frozen=True)
class _Place:
    """A diagnostic in a text, what is declared there, and edits of it."""

    analysis: Analysis
    diagnostic: errors.Diagnostic

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
    def file(self) -> nodes.FileNode | None:
        """The file as it is written; None if it could not be read."""
        contents = self.analysis.contents
        return (contents.scope.node.written or contents.scope.node) if contents else None

    @property
    def components(self) -> list[nodes.ComponentNode]:
        declarations = self.file.declarations if self.file else ()
        return [node for node in declarations if isinstance(node, nodes.ComponentNode)]

    @property
    def declaration(self) -> nodes.DeclarationNode | None:
        """The declaration of the file around the diagnostic."""
        declarations = self.file.declarations if self.file else ()
        around = (d for d in declarations if d.span.start <= self.span.start < d.span.end)
        return next(around, None)

    def message(self, name: str) -> nodes.MessageNode | None:
        """The only message of that name, or ``Component.name``."""
        component, bare = dotted.around(name), dotted.last(name)
        declared = names.declared(component)
        found = [
            item
            for owner in self.components
            if declared in ("", owner.name.text)
            for item in owner.items
            if isinstance(item, nodes.MessageNode) and item.name.text == bare
        ]
        return found[0] if len(found) == 1 else None


def _behaviour(component: object) -> nodes.BehaviourNode | None:
    items = component.items if isinstance(component, nodes.ComponentNode) else ()
    return next((item for item in items if isinstance(item, nodes.BehaviourNode)), None)


def _state(component: object, name: str) -> nodes.StateNode | None:
    behaviour = _behaviour(component)
    states = [i for i in (behaviour.items if behaviour else ()) if isinstance(i, nodes.StateNode)]
    for state in states:  # appended to below
        states.extend(state.states)
    return next((state for state in states if state.name.text == name), None)


# --- the rules -----------------------------------------------------------------------------------


def _replace(place: _Place, *texts: str) -> Iterator[Action]:
    yield from map(place.replace, texts)


def _remove(place: _Place) -> Iterator[Action]:
    yield Action(f"Remove '{place.span.text}'", (Edit(_line_of(place.span), ""),))


def _remove_initial(place: _Place) -> Iterator[Action]:
    start = place.source.text.rfind("initial", 0, place.span.start)
    match = re.compile(r"initial\s+").match(place.source.text, start) if start >= 0 else None
    if match:
        edit = Edit(Span(place.source, match.start(), match.end()), "")
        yield Action(f"Remove 'initial' from '{place.span.text}'", (edit,))


def _close(place: _Place, sign: str) -> Iterator[Action]:
    # A forgotten quote swallows the line; what was meant to be quoted has no blanks or commas.
    meant = re.match(r"[\"'][^\s,]*", place.span.text)
    end = place.span.start + meant.end() if meant else place.span.end
    if place.diagnostic.code == "unterminated-comment":
        line = place.span.line
        end = place.source.line_start(line) + len(place.source.line(line))
    yield Action(f"Close it with {sign}", (place.insert(end, sign),))


def _add_default(place: _Place, rule: str) -> Iterator[Action]:
    if isinstance(place.declaration, nodes.EnumNode):
        yield Action(f"Add '{rule}'", (place.inside(place.declaration.span, rule),))


def _make_initial(place: _Place, name: str) -> Iterator[Action]:
    if state := _state(place.declaration, name):
        edit = place.insert(state.span.start, "initial ")
        yield Action(f"Make '{name}' the initial state", (edit,))


def _add_initial(place: _Place, state: str) -> Iterator[Action]:
    if behaviour := _behaviour(place.declaration):
        yield Action("Add an initial state", (place.inside(behaviour.span, state),))


def _link(place: _Place, name: str, declaration: str | None = None) -> Iterator[Action]:
    """To an interface that the model declares and that fits, else to what the hint names."""
    contents = place.analysis.contents
    if contents is None or place.file is None:
        return
    infos = (info for i in contents.instances.values() for info in i.communications.values())
    marked = (i for i in infos if place.span in (i.node.name.span, _type(i.node)))
    if (info := next(marked, None)) is None:
        return
    end = info.node.span.end
    interfaces = contents.scope.interfaces
    definitions = place.analysis.definitions
    fitting = [name for name, node in interfaces.items() if fits(info, node, definitions)]
    for found in fitting:
        yield Action(f"Link '{found}'", (place.insert(end, f" links {found}"),))
    if not fitting and declaration is not None and name not in interfaces:
        edits = (place.insert(end, f" links {name}"), place.inside(place.file.span, declaration))
        yield Action(f"Link '{name}'", edits)


def _type(node: object) -> Span | None:
    return node.type.span if isinstance(node, nodes.MessageNode) else None


def _add_import(place: _Place, text: str) -> Iterator[Action]:
    if isinstance(node := place.declaration, nodes.ImportNode):
        below = f"\n{place.indent(node.span.start)}{text}"
        yield Action(f"Add '{text}'", (place.insert(node.span.end, below),))


def _add_transition(place: _Place, transition: str, name: str, component: str) -> Iterator[Action]:
    """What synthesis says is missing."""
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


def _add_timeout(place: _Place, message: str, text: str) -> Iterator[Action]:
    if edit := _timeout(place, message, text):
        yield Action(f"Add '{text}' to {message}", (edit,))


def _add_freshness(place: _Place, message: str, text: str, *commands: str) -> Iterator[Action]:
    """A timeout of the message, and a requirement of one of the commands that rest on it."""
    timeout = _timeout(place, message, text)
    if timeout is None or place.declaration is None:
        return
    start = place.declaration.span.start
    for command in commands:
        requirement = f"requirement {command} needs {message}.fresh"
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


_RULES: Mapping[remedies.Change, Callable[..., Iterator[Action]]] = {
    remedies.Change.REPLACE: _replace,
    remedies.Change.REMOVE: _remove,
    remedies.Change.REMOVE_INITIAL: _remove_initial,
    remedies.Change.CLOSE: _close,
    remedies.Change.ADD_DEFAULT: _add_default,
    remedies.Change.MAKE_INITIAL: _make_initial,
    remedies.Change.ADD_INITIAL: _add_initial,
    remedies.Change.LINK: _link,
    remedies.Change.ADD_IMPORT: _add_import,
    remedies.Change.ADD_TRANSITION: _add_transition,
    remedies.Change.ADD_TIMEOUT: _add_timeout,
    remedies.Change.ADD_FRESHNESS: _add_freshness,
}
"""What carries out each change: it takes the place and the parts of the remedy."""
