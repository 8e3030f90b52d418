"""The text about the name that the pointer rests on, as Markdown."""

from __future__ import annotations

import textwrap
from bisect import bisect_right
from collections.abc import Iterator

from robosc.language import events, functions, keywords, operators
from robosc.language.tokens import Tokens, is_word, tokenize
from robosc.lazy_dataclasses import dataclass
from robosc.lsp.analysis import Analysis
from robosc.lsp.ros_definitions import definition_file, field_place, interface_of
from robosc.lsp.synthesis_process import Derived
from robosc.model.entities import Requirement
from robosc.model.file_resolver import FileContents
from robosc.model.names.occurrences import Occurrence, Symbol, SymbolKind
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import KINDS, Interface
from robosc.source import Source, Span
from robosc.syntax.nodes import FunctionNode

# What a text does not say and the reader may want to see: the messages behind basic types.


def inlay_hints(analysis: Analysis, start: int, end: int) -> Iterator[tuple[Span, str]]:
    """The declarations of communications between two offsets, each with the type of ROS that
    carries it, where that is inferred from its data."""
    contents = analysis.contents
    if contents is None:
        return
    seen = set()
    for instance in contents.instances.values():
        for info in instance.communications.values():
            span = info.node.span
            if span.source is not analysis.source or span in seen or info.node.links is not None:
                continue
            seen.add(span)
            interface = interface_of(info, analysis.definitions)
            if interface is None or not start <= span.end <= end:
                continue
            name = f"{interface.package}/{interface.type}"
            if name not in span.text:
                yield span, name


_LONGEST = 30
"""Lines of a declaration or definition that are shown."""


def hover_text(analysis: Analysis, occurrence: Occurrence, derived: Derived | None) -> str:
    """Declaration, real definition, and what synthesis says, whichever there is."""
    symbol = occurrence.symbol
    parts = [_headline(symbol)]
    if symbol.kind in (SymbolKind.ROS_TYPE, SymbolKind.ROS_PACKAGE):
        parts += _ros(analysis.definitions, symbol)
        parts += _type_behind(analysis, occurrence)
    elif symbol.kind is SymbolKind.INCOMING:
        parts += _datatype(analysis, symbol.owner)
    else:
        parts += _declaration(symbol)
    if symbol.kind is SymbolKind.COMMUNICATION:
        parts += _communication(analysis, symbol, derived)
    if symbol.kind is SymbolKind.INTERFACE and analysis.contents is not None:
        node = analysis.contents.scope.interfaces.get(symbol.name)
        if node is not None:
            parts += _definition(analysis.definitions, node.package.text, node.type.text)
    if symbol.kind in (SymbolKind.OBJECT, SymbolKind.PROPERTY):
        parts += _carrier(analysis, symbol)
    return "\n\n".join(parts)


def keyword_hover(source: Source, offset: int) -> tuple[str, Span] | None:
    """What the keyword at an offset means, and its place; None where there is none."""
    tokens = tokenize(source)
    index = bisect_right(tokens.starts, offset) - 1
    if index < 0 or tokens.ends[index] < offset:
        return None
    keyword = keywords.KEYWORDS.get(tokens.text(index))
    if keyword is None or tokens.text(index - 1 if index else len(tokens)) == ".":
        return None
    return f"`{keyword.word}`: {keyword.meaning}", tokens.span(index, index + 1)


def _headline(symbol: Symbol) -> str:
    match symbol.kind:
        case SymbolKind.INCOMING if symbol.name == "reason":
            return f"`reason`: why it failed, one of {symbol.owner}"
        case SymbolKind.INCOMING:
            return f"`value`: what comes in, {symbol.owner or 'of a type that is not known'}"
        case SymbolKind.ROS_TYPE:
            return f"`{symbol.owner}/{symbol.name}`"
        case SymbolKind.ROS_PACKAGE:
            return f"ROS package `{symbol.name}`"
    name = f"{symbol.owner}.{symbol.name}" if symbol.owner else symbol.name
    return f"**{name}**: {symbol.detail}"


def _declaration(symbol: Symbol) -> Iterator[str]:
    if symbol.whole is None or symbol.declared is None:
        return
    yield _fenced("rscd", _text(symbol.whole))


def _text(span: Span) -> str:
    """A declaration as written, without the indentation of its first line."""
    line = span.source.line(span.line)
    indent = line[: len(line) - len(line.lstrip())]
    return textwrap.dedent(indent + span.text)


def _fenced(language: str, text: str) -> str:
    lines = text.strip("\n").splitlines()
    if len(lines) > _LONGEST:
        lines[_LONGEST:] = ["…"]
    fence = "````" if "```" in text else "```"
    return "\n".join([f"{fence}{language}", *lines, fence])


def _datatype(analysis: Analysis, name: str) -> Iterator[str]:
    node = analysis.contents.scope.datatypes.get(name) if analysis.contents is not None else None
    if node is not None:
        yield _fenced("rscd", _text(node.span))


# --- ROS -----------------------------------------------------------------------------------------


def _ros(definitions: MessageDefinitions, symbol: Symbol) -> Iterator[str]:
    if symbol.kind is SymbolKind.ROS_TYPE:
        yield from _definition(definitions, symbol.owner, symbol.name)
        return
    home = definitions.packages.find(symbol.name)
    yield f"`{home}`" if home is not None else "It is not found, so nothing can be checked."


def _type_behind(analysis: Analysis, occurrence: Occurrence) -> Iterator[str]:
    """Of the package in ``package/Type``: what the type is."""
    behind = analysis.index.at(occurrence.span.end + 1)
    if (
        occurrence.symbol.kind is SymbolKind.ROS_PACKAGE
        and behind is not None
        and behind.symbol.kind is SymbolKind.ROS_TYPE
        and behind.symbol.owner == occurrence.symbol.name
    ):
        yield _headline(behind.symbol)
        yield from _ros(analysis.definitions, behind.symbol)


def _definition(definitions: MessageDefinitions, package: str, type_: str) -> Iterator[str]:
    """The file as it is, or what Python bindings contain."""
    file = definition_file(definitions, package, type_)
    if file is not None:
        try:
            yield _fenced("", _brief(file.read_text(encoding="utf-8", errors="replace")))
        except OSError:
            return
        return
    for folder in KINDS:
        interface = definitions.interface(package, type_, folder)
        if isinstance(interface, Interface):
            yield _fenced("", _interface(interface))
            return
    yield "Its definition is not found, so nothing can be checked against it."


def _brief(text: str) -> str:
    """A definition; one that is too long to be shown has no lines that are only comments."""
    lines = text.splitlines()
    if len(lines) <= _LONGEST:
        return text
    return "\n".join(line for line in lines if line.strip() and not line.lstrip().startswith("#"))


def _interface(interface: Interface) -> str:
    parts = ("\n".join(f"{f.type} {f.name}" for f in part.fields) for part in interface.parts)
    return "\n---\n".join(parts) or "# empty"


def _carrier(analysis: Analysis, symbol: Symbol) -> Iterator[str]:
    """The real fields behind an object or a property."""
    if symbol.kind is SymbolKind.OBJECT:
        definition = analysis.carriers.get(symbol.name)
        if definition is not None:
            fields = "\n".join(f"{f.type} {f.name}" for f in definition.fields)
            yield f"Carried by `{definition.name}`:\n\n{_fenced('', fields)}"
        return
    definition = analysis.carriers.get(symbol.owner)
    field = definition.field(symbol.name) if definition is not None else None
    if definition is not None and field is not None:
        yield f"`{field.type} {field.name}` of `{definition.name}`"


# --- communications ------------------------------------------------------------------------------


def _communication(analysis: Analysis, symbol: Symbol, derived: Derived | None) -> Iterator[str]:
    contents = analysis.contents
    if contents is None:
        return
    owner = contents.instances.get(symbol.owner)
    info = owner.communications.get(symbol.name) if owner is not None else None
    if info is None:
        return
    interface = interface_of(info, analysis.definitions)
    if interface is not None:
        name = f"{interface.package}/{interface.type}"
        yield f"Carried by `{name}`:\n\n{_fenced('', _interface(interface))}"
    own = (r for r in contents.robot.requirements if not r.implied)
    found = [r for r in own if info.key in r.communications]
    if found:
        cancels = events.EventKind.CANCEL in info.events
        texts = (_requirement(r, cancels, contents.robot.span) for r in found)
        yield "Requirements:\n\n" + _fenced("rscd", "\n".join(texts))
    if derived is not None:
        yield from _guards(info.key, derived)


def _requirement(requirement: Requirement, is_action: bool, model: Span) -> str:
    text = f"{' '.join(requirement.span.text.split())}  // {requirement.span.told_from(model)}"
    cancels = is_action and requirement.concerns(events.EventKind.CANCEL)
    return f"{text}, also a reason to cancel it" if cancels else text


def _guards(key: str, derived: Derived) -> Iterator[str]:
    for guard in derived.guards:
        if guard.communication != key:
            continue
        head = f"`{guard.event}` is {_STATUS[guard.status]}"
        if guard.status == "never":
            yield head
        elif guard.text == "true":
            yield f"{head}: always allowed where its component does not block it"
        else:
            yield f"{head}. Synthesis allows it where\n\n{_fenced('rscd', guard.text)}"
        for reason, remedy in guard.reasons:
            yield f"Why: {reason}" + (f"\n\nRemedy: {remedy}" if remedy else "")


_STATUS = {
    "as required": "allowed as the requirements say",
    "restricted": "restricted further than the requirements say",
    "never": "never allowed",
}


# Where what a name stands for is declared: in this file, in a library, in a ROS definition.


def definition_of(analysis: Analysis, occurrence: Occurrence) -> Span | None:
    """A declaration itself leads on: an import to the library, a property to the real field."""
    symbol = occurrence.symbol
    if symbol.kind is SymbolKind.ROS_TYPE:
        file = definition_file(analysis.definitions, symbol.owner, symbol.name)
        return field_place(file, 0, "") if file is not None else None
    if symbol.kind is SymbolKind.ROS_PACKAGE:
        home = analysis.definitions.packages.find(symbol.name)
        manifest = home / "package.xml" if home is not None else None
        return field_place(manifest, 0, "") if manifest and manifest.is_file() else None
    if symbol.declared is None and symbol.kind in (SymbolKind.PROPERTY, SymbolKind.ROS_CONSTANT):
        return _field_of(analysis, symbol.owner, symbol.name)
    if occurrence.declaration and analysis.contents is not None:
        further = _further(analysis, symbol, analysis.contents)
        if further is not None:
            return further
    return symbol.declared


def _further(analysis: Analysis, symbol: Symbol, contents: FileContents) -> Span | None:
    if symbol.kind is SymbolKind.COMPONENT:
        instance = contents.instances.get(symbol.name)
        if instance is not None and instance.imported is not None:
            return instance.node.name.span
    if symbol.kind is SymbolKind.PROPERTY:
        return _field(analysis, symbol.owner, symbol.name)
    if symbol.kind is SymbolKind.OBJECT:
        return _field(analysis, symbol.name, "")
    if symbol.kind is SymbolKind.INTERFACE:
        node = contents.scope.interfaces.get(symbol.name)
        if node is not None:
            file = definition_file(analysis.definitions, node.package.text, node.type.text)
            return field_place(file, 0, "") if file is not None else None
    return None


_PARTS = {"Request": 0, "Goal": 0, "Response": 1, "Result": 1, "Feedback": 2}


def _field(analysis: Analysis, object_: str, name: str) -> Span | None:
    carrier = analysis.carriers.get(object_)
    return _field_of(analysis, carrier.name, name) if carrier is not None else None


def _field_of(analysis: Analysis, definition: str, name: str) -> Span | None:
    """Where a field or constant of ``package/Type``, or of a part of it, is defined."""
    package, _, type_ = definition.partition("/")
    candidates = [(type_, 0)]
    candidates += [(type_.removesuffix(s), p) for s, p in _PARTS.items() if type_.endswith(s)]
    for stem, part in candidates:
        file = definition_file(analysis.definitions, package, stem)
        if file is not None:
            return field_place(file, part, name)
    return None


# What a call takes: the function in whose parentheses a place is, and which argument it is in.


@dataclass(frozen=True, slots=True)
class Signature:
    """A call as it is written: its arguments as texts, of which one is ``active``."""

    name: str
    arguments: tuple[str, ...]
    result: str
    active: int

    @property
    def label(self) -> str:
        return f"{self.name}({', '.join(self.arguments)}){self.result}"

    @property
    def places(self) -> Iterator[tuple[int, int]]:
        """Where each argument begins and ends in the label."""
        start = len(self.name) + 1
        for argument in self.arguments:
            yield start, start + len(argument)
            start += len(argument) + len(", ")


def signature_at(analysis: Analysis, offset: int) -> Signature | None:
    """The call around an offset; None where there is none, or it has more arguments than it may."""
    tokens = tokenize(analysis.source)
    if any(comment.start < offset < comment.end for comment in tokens.comments):
        return None
    call = _call(tokens, offset)
    if call is None:
        return None
    name, active = call
    found = _declared(analysis, name) or _built_in(name)
    if found is None:
        return None
    arguments, result = found
    if arguments[-1:] == ("…",):
        active = min(active, len(arguments) - 1)
    return Signature(name, arguments, result, active) if active < len(arguments) else None


def _call(tokens: Tokens, offset: int) -> tuple[str, int] | None:
    """The name in front of the innermost open parenthesis of a call, and the commas behind it."""
    level = commas = 0
    for index in reversed(range(tokens.before(offset))):
        word = tokens.text(index)
        if word in (")", "]"):
            level += 1
        elif word in ("(", "[") and level:
            level -= 1
        elif word == "," and not level:
            commas += 1
        elif word in ("{", "}"):
            return None
        elif word in ("(", "["):
            if word == "(" and index and is_word(tokens.kinds[index - 1]):
                before = tokens.text(index - 2) if index > 1 else ""
                return None if before == "function" else (tokens.text(index - 1), commas)
            commas = 0  # of a part in brackets
    return None


def _declared(analysis: Analysis, name: str) -> tuple[tuple[str, ...], str] | None:
    """The arguments and the result of a function of the model."""
    contents = analysis.contents
    if contents is None:
        return None
    scopes = [contents.types.values, *(c.types.values for c in contents.instances.values())]
    found: FunctionNode | None = next(
        (s.functions[name.lstrip("^")] for s in scopes if name.lstrip("^") in s.functions), None
    )
    if found is None:
        return None
    arguments = tuple(f"{p.name.text}: {p.type.span.text}" for p in found.parameters)
    return arguments, f": {found.type.span.text}"


def _built_in(name: str) -> tuple[tuple[str, ...], str] | None:
    if name in functions.GEOMETRY:
        objects, numbers, _, what = functions.GEOMETRY[name]
        return (what,) * objects + (operators.Operand.NUMBER.value,) * numbers, ""
    function = functions.FUNCTIONS.get(name)
    if function is None:
        return None
    arguments = tuple(operand.value for operand in function.arguments)
    return arguments + ("…",) * function.variadic, f": {function.result.value}"
