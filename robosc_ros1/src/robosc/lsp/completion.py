"""What can stand at a place in an unfinished model."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from robosc.lsp.analysis import Analysis, Desk
from robosc.lsp.context import Context, context_at
from robosc.lsp.declared import Declared
from robosc.lsp.interfaces import model_type, offered_types
from robosc.model.communications import EVENTS_OF
from robosc.model.entities import EventKind, Kind
from robosc.model.types import ArrayType, BooleanType, EnumType, ObjectType, Type
from robosc.model.world import CommunicationInfo, Instance

__all__ = ["Candidate", "complete"]


@dataclass(frozen=True, slots=True)
class Candidate:
    """``kind`` is a word of :class:`~robosc.lsp.symbols.SymbolKind`, ``keyword`` or ``snippet``.

    ``text`` is what is inserted if that is not the label. ``rank`` orders: what fits best is 0.
    """

    label: str
    kind: str
    detail: str = ""
    text: str | None = None
    rank: int = 1


_BLOCK_WORDS = {
    "file": ("robot", "library"),
    "robot": ("component", "requirement", "provide", "datatype object", "datatype enum",
              "interface"),
    "library": ("component", "datatype object", "datatype enum", "interface"),
    "component": ("incoming message", "outgoing message", "service", "action", "behaviour"),
    "behaviour": ("variable", "initial state", "initial marked state", "marked state", "state",
                  "on", "transition"),
    "state": ("on", "transition"),
    "object": (),
    "enum": ("default ->", "value"),
}  # fmt: skip
_BASIC = ("boolean", "integer", "double", "string", "none", "array")
_LABELS = {"service": ("request", "response"), "action": ("request", "response", "feedback")}
_OPERATORS = ("and", "or")
_COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")
_EVENTS = tuple(kind.value for kind in EventKind if kind is not EventKind.TAU)
_SENT = (EventKind.REQUEST, EventKind.CANCEL)


def complete(desk: Desk, path: str, offset: int) -> list[Candidate]:
    """Everything that can stand at a place, each label once, the likeliest first."""
    source = desk.source(path)
    if source is None:
        return []
    context = context_at(source, offset)
    if context.inside_text:
        return []
    known = [a for a in (desk.analysis(path), desk.whole(path)) if a is not None]
    found: dict[str, Candidate] = {}
    for candidate in _Completer(desk, path, context, known).candidates():
        best = found.get(candidate.label)
        if best is None or candidate.rank < best.rank:
            found[candidate.label] = candidate
    return sorted(found.values(), key=lambda c: (c.rank, c.label.casefold()))


class _Completer:
    """Candidates for one context. Names come from the text as it is, and as it was when whole."""

    def __init__(self, desk: Desk, path: str, context: Context, known: Iterable[Analysis]) -> None:
        self._desk = desk
        self._path = path
        self._context = context
        self._known: list[Declared] = [
            a.index.declared for a in known if a.index.declared is not None
        ]
        component = context.around("component")
        self._own = component.name if component is not None else ""

    def candidates(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        if last == ".":
            yield from self._members()
            return
        match self._context.block.kind:
            case "file" | "behaviour" | "component" | "state" | "robot" | "library" if not words:
                yield from _keywords(_BLOCK_WORDS[self._context.block.kind])
            case "robot" | "library":
                yield from self._statement()
            case "component":
                yield from self._communication()
            case "behaviour" | "state":
                yield from self._behaviour()
            case "object":
                yield from self._object()
            case "enum":
                yield from self._enum()
            case "commands":
                yield from self._communications(_SENT)
            case "data":
                yield from self._data()

    # --- robots and libraries --------------------------------------------------------------------

    def _statement(self) -> Iterator[Candidate]:
        match self._context.word(0):
            case "component":
                yield from self._import()
            case "requirement":
                yield from self._requirement()
            case "provide":
                yield from self._provide()
            case "datatype":
                yield from self._datatype()
            case "interface":
                yield from self._interface()

    def _import(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        if last == "from":
            for name in self._desk.libraries(self._path):
                yield Candidate(name, "library")
        elif last == "import":
            yield from self._library_components(self._context.behind("from"))
        elif len(words) == 2:
            yield from _keywords(("from",))
        elif self._context.word(-2) == "from":
            yield from _keywords(("import",))
        elif self._context.word(-2) == "import":
            yield Candidate("with prefix:", "keyword", text='with prefix: "')
            yield from self._next()
        elif last == "with":
            yield Candidate("prefix:", "keyword", text='prefix: "')
        elif "prefix" in words:
            yield from self._next()

    def _library_components(self, library: str) -> Iterator[Candidate]:
        for file in self._desk.all_files(self._path):
            analysis = self._desk.analysis(file)
            declared = analysis.index.declared if analysis is not None else None
            if declared is not None and declared.scope.node.name.text == library:
                for name in declared.scope.components:
                    yield Candidate(name, "component", f"component of {library}", rank=0)

    def _requirement(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        if len(words) == 1:
            yield from self._communications(_SENT, rank=0)
            yield from _keywords(("never", "always"))
            yield from self._expression(None)
            return
        if (
            "needs" not in words
            and "disables" not in words
            and self._context.word(1) not in ("never", "always")
        ):
            if _ends_operand(last):
                yield from _keywords(("needs", "disables"), rank=0)
            if len(words) == 2:
                return
        elif last == "disables":
            yield from self._communications(_SENT)
            return
        yield from self._expression_or_more()

    def _provide(self) -> Iterator[Candidate]:
        words = self._context.words
        if len(words) == 1:
            yield from self._communications((EventKind.REQUEST,))
        elif "with" not in words:
            yield from _keywords(("with",))
        elif self._context.word(-1) == "with":
            yield Candidate("{ }", "keyword", text="{ $0 }")
            yield from self._expression(self._request(words[1 : words.index("with")]))
        elif "if" not in words and _ends_operand(self._context.word(-1)):
            yield from _keywords(("if",))
            yield from self._next()
        else:
            yield from self._expression_or_more()

    def _datatype(self) -> Iterator[Candidate]:
        words = self._context.words
        if len(words) == 1:
            yield from _keywords(("object", "enum"))
        elif self._context.word(1) == "enum" and len(words) > 2:
            if self._context.word(-1) == "from":
                yield from self._types(sources=True)
            else:
                yield from _keywords(("to",) if "from" in words else ("from",))

    def _interface(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        definitions = self._desk.definitions(self._path)
        if last == "use":
            for package, type_, folder in offered_types(definitions):
                yield Candidate(
                    type_, "ROS type", f"{package} ({folder})", f"{type_} from {package}"
                )
        elif last == "from" and len(words) > 3:
            for package, type_, folder in offered_types(definitions):
                if type_ in (self._context.word(3), self._context.word(3).removesuffix("Action")):
                    yield Candidate(package, "ROS package", f"{type_}.{folder}", rank=0)
                else:
                    yield Candidate(package, "ROS package", rank=2)
        elif len(words) == 2:
            yield from _keywords(("use",))
        elif len(words) == 4:
            yield from _keywords(("from",))
        elif len(words) > 5:
            yield from self._next()

    def _next(self) -> Iterator[Candidate]:
        """What may begin behind a declaration that could end here."""
        yield from _keywords(_BLOCK_WORDS[self._context.block.kind], rank=2)

    # --- communications --------------------------------------------------------------------------

    def _communication(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        first = self._context.word(0)
        if first in ("incoming", "outgoing") and len(words) == 1:
            yield from _keywords(("message",))
        elif first == "behaviour":
            return
        elif last == "links":
            yield from self._interfaces()
        elif last == ":" and self._context.word(-2) in ("type", "request", "response", "feedback"):
            yield from self._types()
        elif last in ("with", ","):
            wanted = _LABELS.get(first, ("type",))
            missing = [w for w in wanted if w not in words[2:]]
            yield from (Candidate(f"{w}:", "keyword", rank=0) for w in missing[:1])
            if "identifier" not in words:
                yield Candidate("identifier:", "keyword", text='identifier: "')
        elif "with" not in words:
            if len(words) == (3 if "message" in words else 2):
                yield from _keywords(("with",))
        elif _ends_operand(last) or last == ")":
            yield from _keywords(("links",))
            yield from self._next()

    # --- behaviour -------------------------------------------------------------------------------

    def _behaviour(self) -> Iterator[Candidate]:
        words = self._context.words
        match self._context.word(0):
            case "variable":
                yield from self._variable()
            case "initial" if len(words) == 1:
                yield from _keywords(("state", "marked state"))
            case "marked" if len(words) == 1:
                yield from _keywords(("state",))
            case "on":
                yield from self._on()
            case "transition":
                yield from self._clauses(("if", "goto"))

    def _variable(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        if last == ":":
            yield from self._types(variable=True)
        elif last == "=":
            type_ = self._type_named(self._context.behind(":"))
            yield from self._values(type_)
            if self._context.behind(":") == "boolean":
                yield from _keywords(("false", "true"), rank=0)
        elif ":" in words:
            yield Candidate("=", "keyword")
            yield from self._next()

    def _on(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        if len(words) == 1:
            for event in _EVENTS:
                way = "to" if event == "request" else "from"
                yield Candidate(f"{event} {way}", "keyword")
        elif len(words) == 2:
            yield from _keywords(("to",) if last == "request" else ("from", "to"))
        elif len(words) == 3:
            yield from self._communications(
                (EventKind(self._context.word(1)),) if self._context.word(1) in _EVENTS else ()
            )
        else:
            yield from self._clauses(("if", "do", "goto"))

    def _clauses(self, clauses: tuple[str, ...]) -> Iterator[Candidate]:
        """The parts of a transition behind what it reacts to."""
        words, last = self._context.words, self._context.last
        clause = next((w for w in reversed(words) if w in clauses), "")
        if last == "goto":
            for owner in self._owners(self._own):
                for name, state in owner.states.items():
                    detail = " ".join(["initial"] * state.initial + ["marked"] * state.marked)
                    yield Candidate(name, "state", detail or "state", rank=0)
        elif clause == "do" and last in ("do", ","):
            for owner in self._owners(self._own):
                for name, node in owner.variable_nodes.items():
                    text = f"{name} := "
                    yield Candidate(name, "variable", node.type.span.text, text, rank=0)
        elif clause == "do" and len(words) > 1 and last == ":=":
            yield from self._expression(self._variable_type(self._context.word(-2)))
        elif clause in ("if", "do") and not _ends_operand(last):
            yield from self._expression(self._expected())
        else:
            rest = clauses[clauses.index(clause) + 1 :] if clause else clauses
            yield from _keywords(rest, rank=0)
            if clause in ("if", "do"):
                yield from _keywords((*_OPERATORS, *_COMPARISONS))
            yield from self._next()

    # --- datatypes -------------------------------------------------------------------------------

    def _object(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        if last == ":" or (len(words) > 2 and last in ("(", "array")):
            field = self._field_type(self._context.word(0))
            if field and last == ":":
                yield Candidate(field, "object", "the type of the real field", rank=0)
            yield from self._types(none=False)
            return
        if words and len(words) < 3:
            return
        name = self._context.block.name
        for declared in self._known:
            definition = declared.carriers.get(name)
            node = declared.scope.datatypes.get(name)
            present = {p.name.text for p in getattr(node, "properties", ())}
            for field_ in definition.fields if definition is not None else ():
                if field_.name not in present or field_.name.startswith(
                    self._context.prefix or " "
                ):
                    text = f"{field_.name}: {model_type(field_.type)}"
                    detail = f"{field_.type} of {definition.name if definition else ''}"
                    yield Candidate(field_.name, "property", detail, text, rank=0)

    def _field_type(self, name: str) -> str:
        for declared in self._known:
            definition = declared.carriers.get(self._context.block.name)
            field = definition.field(name.lstrip("^")) if definition is not None else None
            if field is not None:
                return model_type(field.type)
        return ""

    def _enum(self) -> Iterator[Candidate]:
        words, last = self._context.words, self._context.last
        name = self._context.block.name
        if last == "->":
            for declared in self._known:
                enum = declared.enum(name)
                for value in enum.values if enum is not None else ():
                    yield Candidate(value, "enum value", f"value of {name}", rank=0)
        elif words == ("default",):
            yield from _keywords(("->",))
        elif not words or words[-2:-1] == ("->",):
            yield from _keywords(_BLOCK_WORDS["enum"])
        elif _ends_operand(last):
            yield from _keywords(("->", *_OPERATORS, *_COMPARISONS))
        else:
            yield from _keywords(("value", "true", "false"))

    # --- provided data ---------------------------------------------------------------------------

    def _data(self) -> Iterator[Candidate]:
        """In the braces of a provide statement."""
        words, last = self._context.words, self._context.last
        type_ = self._data_type()
        if not words or last == ",":
            if isinstance(type_, ObjectType):
                for name, inner in type_.properties:
                    text = f"{name}: {{ $0 }}" if isinstance(inner, ObjectType) else f"{name}: "
                    yield Candidate(name, "property", str(inner), text, rank=0)
        elif ":" in words:
            inner_type = None
            if isinstance(type_, ObjectType):
                place = len(words) - 1 - words[::-1].index(":")
                inner_type = type_.property(words[place - 1].lstrip("^"))
            if isinstance(inner_type, ObjectType) and last == ":":
                yield Candidate("{ }", "keyword", text="{ $0 }", rank=0)
            elif _ends_operand(last):
                yield from _keywords((*_OPERATORS, *_COMPARISONS))
            else:
                yield from self._expression(inner_type)

    def _data_type(self) -> Type | None:
        """The type of the object whose braces are open."""
        braces = [b for b in self._context.blocks if b.kind == "data"]
        header = braces[0].header
        end = header.index("with") if "with" in header else len(header)
        type_ = self._request(header[1:end])
        for brace in braces[1:]:
            type_ = type_.property(brace.name) if isinstance(type_, ObjectType) else None
        return type_

    def _request(self, words: tuple[str, ...]) -> Type | None:
        info = self._communication_of(words)
        return info.request if info is not None else None

    # --- names -----------------------------------------------------------------------------------

    def _owners(self, name: str) -> Iterator[Instance]:
        for declared in self._known:
            owner = declared.instances.get(name)
            if owner is not None:
                yield owner

    def _infos(self) -> Iterator[CommunicationInfo]:
        for declared in self._known:
            for instance in declared.instances.values():
                yield from instance.communications.values()

    def _communications(self, events: tuple[EventKind, ...], rank: int = 1) -> Iterator[Candidate]:
        """Those that have one of the events; own ones first."""
        names: dict[str, set[str]] = {}
        for info in self._infos():
            names.setdefault(info.name, set()).add(info.key)
        for info in self._infos():
            if events and not any(event in EVENTS_OF[info.kind] for event in events):
                continue
            if EventKind.REQUEST in events and info.kind is Kind.OUTGOING:
                continue
            own = info.instance.name == self._own
            label = info.name if own or len(names[info.name]) == 1 else info.key
            yield Candidate(
                label,
                "communication",
                f"{info.kind.value} of {info.instance.name}",
                rank=0 if own else rank,
            )

    def _communication_of(self, words: tuple[str, ...]) -> CommunicationInfo | None:
        name = [w.lstrip("^") for w in words if w != "."]
        for declared in self._known:
            if len(name) in (1, 2):
                member = name[1] if len(name) == 2 else None
                info = declared.resolve(name[0], member, declared.instances.get(self._own))
                if info is not None:
                    return info
        return None

    def _interfaces(self) -> Iterator[Candidate]:
        for declared in self._known:
            for name, node in declared.scope.interfaces.items():
                detail = f"{node.package.text}/{node.type.text}"
                yield Candidate(name, "interface", detail, rank=0)

    def _types(
        self, *, none: bool = True, variable: bool = False, sources: bool = False
    ) -> Iterator[Candidate]:
        for word in _BASIC:
            if (word == "none" and (not none or variable or sources)) or (
                word == "array" and (none or variable)
            ):
                continue
            yield Candidate(word, "keyword", "built-in type")
        for declared in self._known:
            for name in declared.scope.datatypes:
                is_enum = declared.enum(name) is not None
                if not (is_enum if sources else variable and not is_enum):
                    kind = "enum" if is_enum else "object"
                    yield Candidate(name, kind, f"datatype {kind}", rank=0)

    def _type_named(self, name: str) -> Type | None:
        found = (declared.types.known(name.lstrip("^")) for declared in self._known)
        return next((type_ for type_ in found if type_ is not None), None)

    def _variable_type(self, name: str) -> Type | None:
        found = (owner.variables.get(name.lstrip("^")) for owner in self._owners(self._own))
        return next((type_ for type_ in found if type_ is not None), None)

    # --- expressions -----------------------------------------------------------------------------

    def _expression_or_more(self) -> Iterator[Candidate]:
        if _ends_operand(self._context.last):
            yield from _keywords((*_OPERATORS, *_COMPARISONS))
            yield from self._next()
        else:
            yield from self._expression(self._expected())

    def _expected(self) -> Type | None:
        """The type on the other side of a comparison that is being typed."""
        words = self._context.words
        if len(words) < 2 or self._context.word(-1) not in ("=", "!="):
            return None
        if len(words) > 3 and self._context.word(-3) == ".":
            for owner in self._owners(self._context.word(-4).lstrip("^")):
                return owner.variables.get(self._context.word(-2).lstrip("^"))
        if self._context.word(-2) == "value":
            return self._incoming()
        return self._variable_type(self._context.word(-2))

    def _expression(self, expected: Type | None) -> Iterator[Candidate]:
        """What an expression can begin with."""
        yield from self._values(expected)
        if isinstance(expected, BooleanType) or expected is None:
            yield from _keywords(("true", "false"), rank=2)
        if self._incoming() is not None:
            yield Candidate("value", "value", str(self._incoming()), rank=0)
        if self._own:
            for owner in self._owners(self._own):
                for name, node in owner.variable_nodes.items():
                    yield Candidate(name, "variable", node.type.span.text)
                for name in owner.states:
                    yield Candidate(name, "state", f"state of {self._own}")
        for declared in self._known:
            for name, owner in declared.instances.items():
                if owner.members:
                    yield Candidate(name, "component")
            if expected is None:
                for value in declared.types.enum_values():
                    yield Candidate(value, "enum value", rank=2)

    def _values(self, type_: Type | None) -> Iterator[Candidate]:
        if isinstance(type_, EnumType):
            for value in type_.values:
                yield Candidate(value, "enum value", f"value of {type_.name}", rank=0)

    def _incoming(self) -> Type | None:
        """What ``value`` is here."""
        words = self._context.words
        if self._context.block.kind == "enum":
            for declared in self._known:
                known = declared.types.known(self._context.block.name)
                if isinstance(known, EnumType):
                    return known.source
        if (
            len(words) < 4
            or self._context.word(0) != "on"
            or self._context.word(1) not in ("response", "feedback")
        ):
            return None
        end = next((i for i, w in enumerate(words) if w in ("if", "do", "goto")), len(words))
        info = self._communication_of(words[3:end])
        if info is None:
            return None
        return info.response if self._context.word(1) == "response" else info.feedback

    def _members(self) -> Iterator[Candidate]:
        """Behind a dot."""
        chain = _chain(self._context.words)
        if chain[:1] == ["value"]:
            yield from self._parts(chain[1:])
            return
        if len(chain) != 1:
            return
        statement = self._context.word(0)
        before = self._context.words[-3:-2]
        commands = before and before[0] in ("to", "from", "provide", "requirement", "disables")
        for owner in self._owners(chain[0]):
            if commands:
                for name, info in owner.communications.items():
                    yield Candidate(name, "communication", info.kind.value, rank=0)
            if not (commands and statement in ("on", "provide")):
                for name, node in owner.variable_nodes.items():
                    yield Candidate(name, "variable", node.type.span.text)
                for name in owner.states:
                    yield Candidate(name, "state", f"state of {owner.name}")
        for declared in self._known:
            enum = declared.enum(chain[0])
            yield from self._values(enum)

    def _parts(self, path: list[str]) -> Iterator[Candidate]:
        """The properties of what comes in."""
        type_ = self._incoming()
        for part in path:
            if part == "[]":
                type_ = type_.element if isinstance(type_, ArrayType) else None
            else:
                type_ = type_.property(part) if isinstance(type_, ObjectType) else None
        if isinstance(type_, ObjectType):
            for name, inner in type_.properties:
                yield Candidate(name, "property", str(inner), rank=0)


def _keywords(words: Iterable[str], rank: int = 1) -> Iterator[Candidate]:
    return (Candidate(word, "keyword", rank=rank) for word in words)


def _ends_operand(word: str) -> bool:
    """Could an expression end with this word?"""
    return (word[-1:].isalnum() or word[-1:] in ("_", ")", "]", "}", '"', "'")) and word not in (
        "and", "or", "needs", "disables", "never", "always", "if", "do", "goto", "with",
    )  # fmt: skip


def _chain(words: tuple[str, ...]) -> list[str]:
    """The names before the last dot, ``[]`` for an index: ``value.a[0].`` gives value, a, []."""
    found: list[str] = []
    place = len(words) - 2
    while place >= 0:
        if words[place] == "]" and place >= 2:
            found.append("[]")
            place -= 3
            continue
        found.append(words[place].lstrip("^"))
        if place == 0 or words[place - 1] != ".":
            break
        place -= 2
    return found[::-1]
