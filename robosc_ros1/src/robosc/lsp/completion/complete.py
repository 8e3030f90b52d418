"""What can stand at a place in an unfinished model.

What may follow the words before it says the grammar, in the texts of its messages: a keyword in
quotes, or ``a type``. Which types, names and values there are comes from the model.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial

from robosc.expr.types import ArrayType, ObjectType, Type
from robosc.language.attributes import ATTRIBUTES, Value
from robosc.language.events import EventKind
from robosc.language.keywords import NOTHING
from robosc.language.reasons import REASONS
from robosc.lsp.analysis import Workspace
from robosc.lsp.completion.candidates import (
    COMPARISONS,
    EVENTS,
    OPERATORS,
    Candidate,
    Candidates,
    block_words,
    keywords,
    listed_events,
)
from robosc.lsp.completion.context import WITHIN, names_before
from robosc.lsp.completion.snippets import SNIPPETS
from robosc.lsp.ros_definitions import model_type, offered_types
from robosc.model.file_resolver import FileContents
from robosc.model.names.tables import Instance
from robosc.model.ros.interfaces import Definition, Missing
from robosc.syntax import elements, grammar

# What can stand behind a dot.


_NAMES_COMMANDS = {"provide", "requirement", "disables", "performs", "prefer", "over"}
"""What stands before the name of a command."""


class MemberCandidates(Candidates):
    """The members of components, libraries, enums, values and what else has any."""

    def behind_dot(self) -> Iterator[Candidate]:
        """Behind a dot."""
        chain = names_before(self.context.words)
        aggregates = dict(self.aggregates)
        while chain and chain[0] in aggregates:
            chain = aggregates.pop(chain[0]) + chain[1:]
        if not chain:
            return
        if chain[:1] == ["value"]:
            yield from self._parts(chain[1:])
            return
        if len(chain) != 1 and not (chain[1:] == ["[]"] and chain[0] in self.several):
            yield from self._further(chain)
            return
        if self.context.words[-3:-2] == ("/",):
            yield from self._constants(self.context.word(-4), chain[0])
            return
        yield from self._further(chain)
        statement = self.context.word(0)
        before = self.context.words[-3:-2]
        commands = before and before[0] in ("to", "from", "provide", "requirement", "disables")
        for owner in self.owners(chain[0]):
            if commands:
                for name, info in owner.communications.items():
                    yield Candidate(name, "communication", info.kind.value, rank=0)
            if not (commands and statement in ("on", "provide")):
                yield from self.behaviour_of(owner, owner.name)
        for contents in self.known:
            library = contents.types.libraries.get(chain[0])
            if library is not None:
                yield from self.named_values(library.values)
                for name in library.scope.datatypes:
                    yield Candidate(name, "enum" if library.enum(name) else "object", rank=0)
            enum = contents.types.enum(chain[0])
            yield from self.values(enum)

    def _in_state(self, owner: Instance, path: list[str]) -> Iterator[Candidate]:
        """The states in a state; the stages of one that performs a command, and its count."""
        place = owner.state(".".join(path))
        if place is None:
            return
        whole = f"{owner.name}.{place}"
        for inner in owner.states[place].states:
            yield Candidate(inner.name.text, "state", f"state in {whole}", rank=0)
        for word in owner.parts_of_performing(place):
            yield Candidate(word, "condition", f"of {whole}", rank=0)

    def _further(self, chain: list[str]) -> Iterator[Candidate]:
        """What only some names have behind them: parts, phases, constants of an interface, and the
        values of a library's enum."""
        first, *rest = chain
        for owner in self.owners(self.own):
            yield from self._parts_of(owner.variables.get(first), rest)
            yield from self._in_state(owner, chain)
        for owner in self.owners(first) if rest else ():
            yield from self._parts_of(owner.variables.get(rest[0]), rest[1:])
            yield from self._in_state(owner, rest)
        for info in self.infos():
            if chain not in ([info.name], [info.instance.name, info.name]):
                continue
            before = self.context.words[-3:-2] if len(chain) == 1 else self.context.words[-5:-4]
            if info.sort.served and {*before} & _NAMES_COMMANDS:
                yield from keywords((e.word for e in info.events if e.served), rank=0)
            elif info.phases is not None:
                yield from keywords(info.phases.names, rank=0)
            if info.sort.may_be_heard:
                yield from keywords(("heard",), rank=0)
        for contents in self.known:
            library = contents.types.libraries.get(first)
            if library is not None and len(rest) == 1:
                yield from self.values(library.enum(rest[0]))
            interface = contents.scope.interfaces.get(first)
            if interface is not None and not rest:
                yield from self._constants(interface.package.text, interface.type.text)

    def _constants(self, package: str, type_: str) -> Iterator[Candidate]:
        """The constants of a real definition."""
        for contents in self.known:
            found = contents.types.type_declarations.ros.constants(package, type_)
            if not isinstance(found, Missing):
                for name, value in found.items():
                    yield Candidate(name, "constant", repr(value), rank=0)

    def _parts(self, path: list[str]) -> Iterator[Candidate]:
        """The properties of what comes in."""
        return self._parts_of(self.incoming(), path)

    def _parts_of(self, type_: Type | None, path: list[str]) -> Iterator[Candidate]:
        """The properties of a part of a type."""
        for part in path:
            if part == "[]":
                type_ = type_.element if isinstance(type_, ArrayType) else None
            else:
                type_ = type_.property(part) if isinstance(type_, ObjectType) else None
        if isinstance(type_, ObjectType):
            for name, inner in type_.properties:
                yield Candidate(name, "property", str(inner), rank=0)


_STRINGS = frozenset(("prefix", *(a.name for a in ATTRIBUTES if a.value is Value.STRING)))
_TYPES = tuple(attribute.name for attribute in ATTRIBUTES if attribute.required)
_LIKELY = frozenset(("needs", "disables", "if", "do", "goto"))
"""The keywords that are offered before others."""
_NOT_TOGETHER = (("request", "from"), ("marked", "marked"))
_QUOTED = re.compile(r"'([a-z_]+(?: ->|:)?|:=|=|->)'")
OPERANDS = (
    "a value",
    "a condition",
    "a communication or",
    "a rule",
    "an array",
    "an expression",
    "an index",
    "an initial value",
)
"""How the texts for what an operand may begin begin."""

_VALUES = ("constant", "parameter", "condition", "function", "variable", "persistent")
_SENT = ("request", "cancel")
"""The events of what the controller sends."""

_COMMUNICATIONS = ("incoming", "outgoing", "service", "action")
_EVENTS = {"requirement": _SENT, "prefer": _SENT, "assume": ("response",)}


def complete(workspace: Workspace, path: str, offset: int) -> list[Candidate]:
    """Everything that can stand at a place, each label once, the likeliest first."""
    context = workspace.context(path, offset)
    if context is None or context.inside_text:
        return []
    known = [a for a in (workspace.recent(path), workspace.whole(path)) if a is not None]
    found: dict[str, Candidate] = {}
    for candidate in _Completer(workspace, path, context, known).candidates():
        best = found.get(candidate.label)
        if best is None or candidate.rank < best.rank:
            found[candidate.label] = candidate
    return sorted(found.values(), key=lambda c: c.sort_key)


class _Completer(MemberCandidates):
    """What can follow the words of a declaration."""

    def candidates(self) -> Iterator[Candidate]:
        last, kind = self.context.last, self.context.home.kind
        if last == ".":
            yield from self.behind_dot()
        elif last == "[" and self.context.word(-2).lstrip("^") in self.several:
            yield from self.indexes()
        elif last == "/" and self.is_ros_package(self.context.word(-2)):
            yield from self.ros_types(self.context.word(-2), self.ros_folder())
        elif kind == "unknown" or (kind == "file" and self.context.words):
            return
        elif (free := grammar.block_of(kind).items.free) is not None:
            expected, whole = elements.expectations(free.grammar, self.context.kinds)
            yield from self._expected(expected)
            if whole is not None:
                yield from self._expected(elements.expectations(free.grammar, "")[0])
        elif not self.context.head:
            yield from self._beginnings()
        elif rule := grammar.block_of(kind).items.rules.get(self.context.head[0]):
            expected, whole = elements.expectations(rule.grammar, self.context.kinds)
            yield from self._expected(expected)
            if self.context.block.kind == "commands" and not expected:  # requirements in braces
                yield from self.communications(_SENT)
            if whole is not None and rule.block(whole) is None:
                yield from keywords(block_words(kind), rank=2)

    def _beginnings(self) -> Iterator[Candidate]:
        """What a declaration of the block can begin with, and whole declarations to fill in."""
        block = self.context.block.kind
        yield from keywords(block_words(block))
        for one in SNIPPETS.get(block, ()):
            yield Candidate(one.label, "snippet", one.meaning, one.text, rank=2)

    def _expected(self, expected: Iterable[str]) -> Iterator[Candidate]:
        """What there is of what the grammar expects."""
        whats = [re.split(" after | and ", text)[0] for text in expected]
        yield from self._words([word for what in whats for word in _QUOTED.findall(what)])
        for what in dict.fromkeys(whats):
            if what.startswith(OPERANDS):
                yield from self._operand(what)
            elif what in NAMES:
                yield from NAMES[what](self)

    def _words(self, words: Sequence[str]) -> Iterator[Candidate]:
        """Keywords, and the labels of attributes that are not given yet; types in their order."""
        context, given = self.context, self.context.words
        labels = [word[:-1] for word in words if word.endswith(":") and word[:-1] not in given]
        missing = [name for name in _TYPES if name in labels and "type" not in given]
        if "request" in given and "type" in missing:
            missing.remove("type")
        likely = ["prefix", *missing[: 2 if missing[:1] == ["type"] else 1]]
        for label in labels:
            if label in likely or label not in _TYPES:
                text = f'{label}: "' if label in _STRINGS else None
                yield Candidate(f"{label}:", "keyword", text=text, rank=label not in likely)
        for word in words:
            if context.word(0) == "on" and word in EVENTS:
                way = "to" if word == "request" else "from"
                yield Candidate(f"{word} {way}", "keyword")
            elif context.word(0) == "component" and word == "with":
                yield Candidate("with prefix:", "keyword", text='with prefix: "')
            elif not word.endswith(":") and (context.last, word) not in _NOT_TOGETHER:
                yield from keywords((word,), rank=word not in _LIKELY)

    # --- names -----------------------------------------------------------------------------------

    def _communications(self, rank: int = 1) -> Iterator[Candidate]:
        """Those that a statement or a transition can be about."""
        first = self.context.head[0]
        events = listed_events(self.context.head) or _EVENTS.get(first, ("request",))
        yield from self.communications(events, rank)
        if first in ("on", "requirement", "prefer") and self.context.block.kind not in WITHIN:
            yield Candidate("all", "keyword", "all commands of the robot", rank=2)

    def _stopping(self) -> Iterator[Candidate]:
        yield from self.communications(("request",))
        yield from keywords((NOTHING,), rank=2)

    def _states(self) -> Iterator[Candidate]:
        for owner in self.owners(self.own):
            for name, state in owner.states.items():
                detail = " ".join(["initial"] * state.initial + ["marked"] * state.marked)
                yield Candidate(name, "state", detail or "state", rank=0)

    def _assignable(self) -> Iterator[Candidate]:
        for owner in self.owners(self.own):
            for name, node in owner.variable_nodes.items():
                yield Candidate(name, "variable", node.type.span.text, f"{name} := ", rank=0)

    def _types(self) -> Iterator[Candidate]:
        first = self.context.word(0)
        if self.context.home.kind != "object":
            yield from self.types(variable=first in _VALUES, sources=first == "datatype")
            return
        definition = self._definition()
        field = definition and definition.field(first.lstrip("^"))
        if field and self.context.last == ":":
            type_ = model_type(field.type)
            yield Candidate(type_, "object", "the type of the real field", rank=0)
        yield from self.types(none=False)

    def _libraries(self) -> Iterator[Candidate]:
        for name in self.workspace.libraries(self.path):
            yield Candidate(name, "library")

    def _library(self) -> Iterator[FileContents]:
        """That from which is imported, among the files that may have to do with this one."""
        for file in self.workspace.all_files(self.path):
            analysis = self.workspace.analysis(file)
            contents = analysis.contents if analysis is not None else None
            if contents and contents.scope.node.name.text == self.context.behind("from"):
                yield contents

    def _components(self) -> Iterator[Candidate]:
        for contents in self._library():
            for name in contents.scope.components:
                detail = f"component of {contents.scope.node.name.text}"
                yield Candidate(name, "component", detail, rank=0)

    def _arguments(self) -> Iterator[Candidate]:
        """What an import can set of a component and has not set yet."""
        words = self.context.words
        for contents in self._library():
            owner = contents.instances.get(self.context.behind("import"))
            for name in owner.types.values.settable if owner is not None else ():
                if name not in words[words.index("with") :]:
                    yield Candidate(f"{name}:", "constant", text=f"{name}: ")

    def _used_types(self) -> Iterator[Candidate]:
        for package, type_, folder in offered_types(self.workspace.definitions(self.path)):
            text = f"{type_} from {package}"
            yield Candidate(type_, "ROS type", f"{package} ({folder})", text)

    def _used_packages(self) -> Iterator[Candidate]:
        name = self.context.word(3)
        for package, type_, folder in offered_types(self.workspace.definitions(self.path)):
            if type_ in (name, name.removesuffix("Action")):
                yield Candidate(package, "ROS package", f"{type_}.{folder}", rank=0)
            else:
                yield Candidate(package, "ROS package", rank=2)

    def _results(self) -> Iterator[Candidate]:
        """The values of the enum of which a rule is being typed."""
        for contents in self.known:
            yield from self.values(contents.types.enum(self.context.block.name))

    # --- operands --------------------------------------------------------------------------------

    def _operand(self, what: str) -> Iterator[Candidate]:
        """What an expression can begin with."""
        first, words = self.context.word(0), self.context.words
        if self.context.home.kind == "enum" or ("with" in words and first in _COMMUNICATIONS):
            # It reads what was received only.
            yield from keywords(("value", "true", "false"))
            for contents in self.known:
                yield from self.named_values(contents.types.values)
        elif what == "an initial value":
            yield from self.values(self._wanted())
            if self.context.behind(":") == "boolean":
                yield from keywords(("false", "true"), rank=0)
        else:
            if what.startswith("a communication"):
                yield from self._communications(rank=0)
            yield from self.expression(self._wanted())
            if "error" in listed_events(self.context.head):
                yield Candidate("reason", "variable", "why it failed")
            if "reason" in (self.context.word(-2), self.context.word(-3)):  # = timeout, in { lost
                for reason in REASONS:
                    yield Candidate(reason.word, "enum value", reason.meaning, rank=0)

    def _object(self) -> Iterator[Candidate]:
        any_data = self.context.last == "with"
        if any_data or isinstance(self._wanted(), ObjectType):
            yield Candidate("{ }", "keyword", text="{ $0 }", rank=any_data)

    def _wanted(self) -> Type | None:
        """The type of the value that is being typed."""
        words, last = self.context.words, self.context.last
        if self.context.block.kind == "data":
            type_ = self._data_type()
            name = words[words.index(":") - 1] if ":" in words else ""
            type_ = type_.property(name.lstrip("^")) if isinstance(type_, ObjectType) else None
            return type_.element if isinstance(type_, ArrayType) and "[" in words else type_
        if last == "with":
            return self._sent()
        if last == ":=":
            return self.variable_type(self.context.word(-2))
        if last == "=" and words[0] in _VALUES:
            return self.type_named(self.context.behind(":"))
        return self.expected()

    def _sent(self) -> Type | None:
        """What the command takes, or the named value is, of which the data are being typed."""
        head = self.context.head
        if head[0] in _VALUES:
            return self.type_named(head[head.index("=") - 1]) if "=" in head else None
        ends = [head.index(word) for word in ("meanwhile", "with") if word in head]
        start = head.index("performs") if "performs" in head else 0
        words = head[start + 1 : min(ends, default=len(head))]
        info = self.communication_of(words)
        if info is None and words:
            *call, answer = (word for word in words if word != ".")
            info = self.communication_of(tuple(call))
            if info is not None and answer == EventKind.PROGRESS.word:
                info = info.feedback_command()
        return info.sent if info is not None else None

    # --- properties ------------------------------------------------------------------------------

    def _definition(self) -> Definition | None:
        """The real definition behind the object whose properties are being typed."""
        known = (analysis.carriers.get(self.context.block.name) for analysis in self.analyses)
        return next((found for found in known if found is not None), None)

    def _fields(self) -> Iterator[Candidate]:
        """The fields of the real definition that an object does not have yet."""
        definition, name = self._definition(), self.context.block.name
        objects = [contents.scope.datatypes.get(name) for contents in self.known]
        present = {p.name.text for node in objects[:1] for p in getattr(node, "properties", ())}
        for field in definition.fields if definition is not None else ():
            if field.name not in present or field.name.startswith(self.context.prefix or " "):
                text = f"{field.name}: {model_type(field.type)}"
                detail = f"{field.type} of {definition.name if definition else ''}"
                yield Candidate(field.name, "property", detail, text, rank=0)

    def _properties(self) -> Iterator[Candidate]:
        """Those of the object whose braces are open."""
        type_ = self._data_type()
        for name, inner in type_.properties if isinstance(type_, ObjectType) else ():
            text = f"{name}: {{ $0 }}" if isinstance(inner, ObjectType) else f"{name}: "
            yield Candidate(name, "property", str(inner), text, rank=0)

    def _data_type(self) -> Type | None:
        """The type of the object whose braces are open."""
        type_ = self._sent()
        for brace in [b for b in self.context.blocks if b.kind == "data"][1:]:
            type_ = type_.property(brace.name) if isinstance(type_, ObjectType) else None
            type_ = type_.element if isinstance(type_, ArrayType) else type_
        return type_


NAMES: Mapping[str, Callable[[_Completer], Iterable[Candidate]]] = {
    "an operator": lambda here: keywords((*OPERATORS, *COMPARISONS), rank=2),
    "an object": _Completer._object,
    "the name of a communication": _Completer._communications,
    "the name of a command": _Completer._communications,
    "a communication, 'always' or 'never'": partial(_Completer._communications, rank=0),
    "the name of an incoming message": _Completer._stopping,
    "the name of a state": _Completer._states,
    "a variable to assign to": _Completer._assignable,
    "a duration": _Completer.durations,
    "a type": _Completer._types,
    "a ROS type 'package/Type'": lambda here: here.ros_packages(here.ros_folder()),
    "the name of an interface": _Completer.interfaces,
    "the name of a library": _Completer._libraries,
    "the name of a component": _Completer._components,
    "the name of a constant or parameter": _Completer._arguments,
    "the name of the ROS type": _Completer._used_types,
    "the name of the ROS package": _Completer._used_packages,
    "a property name": _Completer._properties,
    "a property name or '}'": _Completer._fields,
    "the name of the value": _Completer._results,
}
"""What there is of what the grammar expects, by the text of its message."""
