"""What can stand at a place in an unfinished model."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from robosc.expr.types import ArrayType, ObjectType, Type
from robosc.language.attributes import ATTRIBUTES, TRANSFORM, Value
from robosc.language.events import FOLDERS
from robosc.language.keywords import starts_of
from robosc.language.reasons import REASONS
from robosc.lsp.analysis import Workspace
from robosc.lsp.completion import member_candidates, statement_candidates
from robosc.lsp.completion.candidates import (
    COMPARISONS,
    EVENTS,
    OPERATORS,
    Candidate,
    block_words,
    ends_operand,
    keywords,
    listed_events,
)
from robosc.lsp.interfaces import model_type

_TYPES = tuple(attribute for attribute in ATTRIBUTES if attribute.value is Value.TYPE)
_DURATIONS = frozenset(a.name for a in ATTRIBUTES if a.value is Value.DURATION)
_CONDITIONS = frozenset(a.name for a in ATTRIBUTES if a.value is Value.CONDITION)
_WORDS = {"goals": "replace", "rate": "once", "stop": "none"}
"""The words that are values of attributes."""
_LABELS = {
    word: tuple(a.name for a in ATTRIBUTES if a.required and word in a.communications)
    for word in ("service", "action", "outgoing service", "outgoing action", TRANSFORM)
}
_OPTIONAL = {
    word: tuple(a.name for a in ATTRIBUTES if word in a.communications and not a.required)
    for word in ("incoming", "outgoing", *_LABELS)
}
_NOT_MESSAGES = [word for word in _LABELS if word.startswith("outgoing")]
_STRINGS = frozenset(a.name for a in ATTRIBUTES if a.value is Value.STRING)


def _opened(label: str) -> str | None:
    """What is inserted for a label, if more than that: the string of one that has such a value."""
    return f'{label}: "' if label in _STRINGS else None


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


class _Completer(member_candidates.MemberCandidates, statement_candidates.StatementCandidates):
    """What can follow the words of a declaration, for each kind of it."""

    def candidates(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        if last == ".":
            yield from self.behind_dot()
            return
        if last == "[" and self.context.word(-2).lstrip("^") in self.several:
            yield from self.indexes()
            return
        if last == "/" and self.is_ros_package(self.context.word(-2)):
            yield from self.ros_types(self.context.word(-2), self.ros_folder())
            return
        match self.context.block.kind:
            case "file" | "behaviour" | "component" | "state" | "robot" | "library" | "for" if (
                not words
            ):
                yield from self.beginnings()
            case "robot" | "library" | "for":
                yield from self.statement()
            case "component" if words[0] in starts_of("for"):
                yield from self.statement()
            case "component":
                yield from self._communication()
            case "behaviour" | "state":
                yield from self._behaviour()
            case "object":
                yield from self._object()
            case "enum":
                yield from self._enum()
            case "commands":
                yield from self.communications(
                    listed_events(self.context.block.header) or statement_candidates.SENT
                )
            case "data":
                yield from self._data()

    # --- communications --------------------------------------------------------------------------

    def _communication(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        first = self.context.word(0)
        noun = self.context.word(1)
        sort = f"outgoing {noun}" if f"{first} {noun}" in _NOT_MESSAGES else first
        if first in ("incoming", "outgoing") and len(words) == 1:
            others = ("transform", "service", "action") if first == "outgoing" else ()
            yield from keywords(("message", *others))
        elif first == "behaviour":
            return
        elif first in ("constant", "parameter", "function"):
            yield from self.value()
        elif last == ":" and self.context.word(-2) in _DURATIONS:
            yield from self.durations()
        elif last == ":" and self.context.word(-2) in _WORDS:
            yield Candidate(_WORDS[self.context.word(-2)], "keyword")
        elif self._is_expectation():
            yield from self._received()
        elif last == "links":
            yield from self.interfaces()
        elif last == ":" and self.context.word(-2) in (a.name for a in _TYPES):
            if sort in _LABELS and self.context.word(-2) == "type":
                yield from self.ros_packages(FOLDERS[sort])
            else:
                yield from self.types()
        elif last in ("with", ","):
            wanted = _LABELS.get(sort, ("type",))
            missing = [w for w in wanted if w not in words[words.index("with") :]]
            if sort in _LABELS and sort != TRANSFORM and wanted[0] in missing:
                missing.insert(1, "type")  # of a service or action: all of its types at once
            labels = missing[:2] if missing[1:2] == ["type"] else missing[:1]
            yield from (Candidate(f"{w}:", "keyword", rank=0, text=_opened(w)) for w in labels)
            for name in _OPTIONAL.get(sort, ()):
                if name not in words:
                    yield Candidate(f"{name}:", "keyword", text=_opened(name))
        elif "with" not in words:
            if len(words) == (3 if first in ("incoming", "outgoing") else 2):
                yield from keywords(("with",))
        elif ends_operand(last) or last == ")":
            yield from keywords(("links",) if sort != TRANSFORM else ())
            yield from self.next_declaration()

    def _is_expectation(self) -> bool:
        """Whether an operand may stand here, of what an attribute expects."""
        words = self.context.words
        labels = [word for word, colon in pairwise(words) if colon == ":"]
        return labels[-1:] in [[name] for name in _CONDITIONS] and not (
            self.context.last == "," or ends_operand(self.context.last)
        )

    def _received(self) -> Iterator[Candidate]:
        """The operands of conditions that read a received value only."""
        yield from keywords(("value", "true", "false"))
        for contents in self.known:
            yield from self.named_values(contents.types.values)

    # --- behaviour -------------------------------------------------------------------------------

    def _behaviour(self) -> Iterator[Candidate]:
        words = self.context.words
        if "state" in words[:-1]:
            yield from self._performs(words[words.index("state") + 2 :])
            return
        match self.context.word(0):
            case "persistent" if len(words) == 1:
                yield from keywords(("variable",))
            case "variable" | "persistent":
                yield from self._variable()
            case "initial" if len(words) == 1:
                yield from keywords(("state", "marked state"))
            case "marked" if len(words) == 1:
                yield from keywords(("state",))
            case "on":
                yield from self._on()
            case "transition":
                guard = "else" if "else" in words else "if"
                yield from keywords(("else",) if len(words) == 1 else ())
                yield from self._clauses((guard, "do", "goto"))
            case "after":
                yield from self._after()

    def _performs(self, words: tuple[str, ...]) -> Iterator[Candidate]:
        """Behind the name of a state."""
        if not words:
            yield from keywords(("performs",))
        elif words == ("performs",):
            yield from self.communications(("request",))
        elif "then" in words:
            yield from self._clauses(("do", "goto"))
        elif self.context.last == "with":
            yield Candidate("{ }", "keyword", text="{ $0 }")
            yield from self.expression(self.request(words[1:-1]))
        else:
            behind = ("meanwhile", "with", "then")
            last = max((behind.index(word) for word in words if word in behind), default=-1)
            yield from keywords(behind[last + 1 :])

    def _after(self) -> Iterator[Candidate]:
        if len(self.context.words) == 1:
            yield from self.durations()
        else:
            yield from self._clauses(("if", "do", "goto"))

    def _variable(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        if last == ":":
            yield from self.types(variable=True)
        elif last == "=":
            type_ = self.type_named(self.context.behind(":"))
            yield from self.values(type_)
            if self.context.behind(":") == "boolean":
                yield from keywords(("false", "true"), rank=0)
        elif ":" in words:
            yield Candidate("=", "keyword")
            yield from self.next_declaration()

    def _on(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        if last in ("on", ",") and not {"from", "to"} & {*words}:
            for event in EVENTS:
                way = "to" if event == "request" else "from"
                yield Candidate(f"{event} {way}", "keyword")
        elif not {"from", "to"} & {*words}:
            yield from keywords(("to",) if last == "request" else ("from", "to"))
        elif last in ("from", "to"):
            yield from self.communications(listed_events(words))
            yield statement_candidates.ALL_COMMANDS
        else:
            yield from keywords(("except",) if {"if", "do", "goto"}.isdisjoint(words) else ())
            guard = "else" if "else" in words else "if"
            yield from keywords(("else",) if words[-2] in ("from", "to") else ())
            yield from self._clauses((guard, "do", "goto"))

    def _clauses(self, clauses: tuple[str, ...]) -> Iterator[Candidate]:
        """The parts of a transition behind what it reacts to."""
        words, last = self.context.words, self.context.last
        clause = next((w for w in reversed(words) if w in clauses), "")
        if last == "goto":
            for owner in self.owners(self.own):
                for name, state in owner.states.items():
                    detail = " ".join(["initial"] * state.initial + ["marked"] * state.marked)
                    yield Candidate(name, "state", detail or "state", rank=0)
        elif clause == "do" and last in ("do", ","):
            for owner in self.owners(self.own):
                for name, node in owner.variable_nodes.items():
                    text = f"{name} := "
                    yield Candidate(name, "variable", node.type.span.text, text, rank=0)
        elif clause == "do" and len(words) > 1 and last == ":=":
            yield from self.expression(self.variable_type(self.context.word(-2)))
        elif clause in ("if", "do") and not ends_operand(last):
            yield from self.expression(self.expected())
            if "error" in listed_events(words):
                yield Candidate("reason", "variable", "why it failed")
            if "reason" in (self.context.word(-2), self.context.word(-3)):  # = timeout, in { lost
                for reason in REASONS:
                    yield Candidate(reason.word, "enum value", reason.meaning, rank=0)
        else:
            rest = clauses[clauses.index(clause) + 1 :] if clause else clauses
            yield from keywords(rest, rank=0)
            if clause in ("if", "do"):
                yield from keywords((*OPERATORS, *COMPARISONS))
            yield from self.next_declaration()

    # --- datatypes -------------------------------------------------------------------------------

    def _object(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        if last == ":" or (len(words) > 2 and last in ("(", "array")):
            field = self._field_type(self.context.word(0))
            if field and last == ":":
                yield Candidate(field, "object", "the type of the real field", rank=0)
            yield from self.types(none=False)
            return
        if words and len(words) < 3:
            return
        name = self.context.block.name
        for analysis in self.analyses:
            definition = analysis.carriers.get(name)
            contents = analysis.contents
            node = contents.scope.datatypes.get(name) if contents is not None else None
            present = {p.name.text for p in getattr(node, "properties", ())}
            for field_ in definition.fields if definition is not None else ():
                if field_.name not in present or field_.name.startswith(self.context.prefix or " "):
                    text = f"{field_.name}: {model_type(field_.type)}"
                    detail = f"{field_.type} of {definition.name if definition else ''}"
                    yield Candidate(field_.name, "property", detail, text, rank=0)

    def _field_type(self, name: str) -> str:
        for analysis in self.analyses:
            definition = analysis.carriers.get(self.context.block.name)
            field = definition.field(name.lstrip("^")) if definition is not None else None
            if field is not None:
                return model_type(field.type)
        return ""

    def _enum(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        name = self.context.block.name
        if last == "->":
            for contents in self.known:
                enum = contents.types.enum(name)
                for value in enum.values if enum is not None else ():
                    yield Candidate(value, "enum value", f"value of {name}", rank=0)
        elif words == ("default",):
            yield from keywords(("->",))
        elif not words or words[-2:-1] == ("->",):
            yield from keywords(block_words("enum"))
        elif ends_operand(last):
            yield from keywords(("->", *OPERATORS, *COMPARISONS))
        else:
            yield from self._received()

    # --- provided data ---------------------------------------------------------------------------

    def _data(self) -> Iterator[Candidate]:
        """In the braces of a provide statement."""
        words, last = self.context.words, self.context.last
        type_ = self._data_type()
        if words in ((), (",",)):
            if isinstance(type_, ObjectType):
                for name, inner in type_.properties:
                    text = f"{name}: {{ $0 }}" if isinstance(inner, ObjectType) else f"{name}: "
                    yield Candidate(name, "property", str(inner), text, rank=0)
        elif ":" in words:
            inner_type = None
            if isinstance(type_, ObjectType):
                inner_type = type_.property(words[words.index(":") - 1].lstrip("^"))
            if isinstance(inner_type, ArrayType) and "[" in words:
                inner_type = inner_type.element
            if isinstance(inner_type, ObjectType) and last in (":", "[", ","):
                yield Candidate("{ }", "keyword", text="{ $0 }", rank=0)
            elif ends_operand(last):
                yield from keywords((*OPERATORS, *COMPARISONS))
            else:
                yield from self.expression(inner_type)

    def _data_type(self) -> Type | None:
        """The type of the object whose braces are open."""
        braces = [b for b in self.context.blocks if b.kind == "data"]
        header = braces[0].header
        end = header.index("with") if "with" in header else len(header)
        start = header.index("performs") if "performs" in header else 0
        type_ = self.request(header[start + 1 : end])
        for brace in braces[1:]:
            type_ = type_.property(brace.name) if isinstance(type_, ObjectType) else None
            type_ = type_.element if isinstance(type_, ArrayType) else type_
        return type_
