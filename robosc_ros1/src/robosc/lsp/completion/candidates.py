"""What there is to offer: names by what they can be used for, and expressions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import takewhile

from robosc.expr.types import BooleanType, EnumType, Type
from robosc.language.events import FOLDERS, Kind
from robosc.language.keywords import Role, starts_of, words_of
from robosc.language.operators import BINARY, symbols
from robosc.lazy_dataclasses import dataclass
from robosc.lsp.analysis import Analysis, Workspace
from robosc.lsp.completion.context import Context, aggregate_variables
from robosc.lsp.ros_definitions import offered_types
from robosc.model.file_resolver import FileContents
from robosc.model.names import tables, value_scope
from robosc.names import copy_name
from robosc.syntax import nodes


@dataclass(frozen=True, slots=True)
class Candidate:
    """``kind`` is one of :data:`~robosc.lsp.outline.KINDS`.

    ``text`` is what is inserted if that is not the label. ``rank`` orders: what fits best is 0.
    Of one rank the smaller ``order`` comes first, then the alphabet decides.
    """

    label: str
    kind: str
    detail: str = ""
    text: str | None = None
    rank: int = 1
    order: int = 0

    @property
    def sort_key(self) -> tuple[int, int, str]:
        return self.rank, self.order, self.label.casefold()


_MORE = {
    "datatype": ("datatype object", "datatype enum"),
    "incoming": ("incoming message",),
    "outgoing": tuple(f"outgoing {noun}" for noun in ("message", "transform", "service", "action")),
    "initial": ("initial state", "initial marked state"),
    "marked": ("marked state",),
    "persistent": ("persistent variable",),
    "default": ("default ->", "value"),
}
"""What is offered for a keyword that others must follow."""

_BASIC = words_of(Role.TYPE)
EVENTS = words_of(Role.EVENT)
OPERATORS = symbols(words=True)
COMPARISONS = tuple(o.spelling for o in BINARY.values() if o.is_comparison)


class Candidates:
    """Candidates for one context. Names come from the text as it is, and as it was when whole."""

    def __init__(
        self, workspace: Workspace, path: str, context: Context, known: Iterable[Analysis]
    ) -> None:
        self.workspace = workspace
        self.path = path
        self.context = context
        self.analyses = list(known)
        self.known = [a.contents for a in self.analyses if a.contents is not None]
        self.aggregates = aggregate_variables(context)
        self.several = {name: at for c in self.known for name, at in several(c).items()}
        component = context.around("component")
        self.own = component.name if component is not None else ""
        if self.own in self.several:
            self.own = copy_name(self.own, self.several[self.own].first)

    # --- names -----------------------------------------------------------------------------------

    def _is_further_copy(self, instance: tables.Instance) -> bool:
        """Whether it is one of several of a kind, of which another one is offered for all."""
        copy = instance.declaration.copy
        return copy is not None and copy.index != self.several[copy.family].first

    def _indexed(self, name: str) -> str:
        """A name with the index of a copy as one would write it here, perhaps ``Station[i]``."""
        loop = self.context.around("for")
        several, bracket, rest = name.partition("[")
        if not bracket or loop is None or len(loop.header) < 2:
            return name
        return f"{several}[{loop.header[1]}{rest[rest.index(']') :]}"

    def indexes(self) -> Iterator[Candidate]:
        """Behind ``Station[``."""
        indexes = self.several.get(self.context.word(-2).lstrip("^"))
        if indexes is None:
            return
        loop = self.context.around("for")
        if loop is not None and len(loop.header) > 1:
            yield Candidate(loop.header[1], "variable", "of this for", rank=0)
        if self.own.endswith("]"):
            yield Candidate("index", "variable", "of this copy", rank=0)
        for index in range(indexes.first, indexes.last + 1):
            yield Candidate(str(index), "value", rank=1, order=index)

    def owners(self, name: str) -> Iterator[tables.Instance]:
        if name in self.several:
            name = copy_name(name, self.several[name].first)
        for contents in self.known:
            owner = contents.instances.get(name)
            if owner is not None:
                yield owner

    def behaviour_of(self, owner: tables.Instance, name: str) -> Iterator[Candidate]:
        """What a component of that name has in its behaviour, and its named values."""
        for variable, node in owner.variable_nodes.items():
            yield Candidate(variable, "variable", node.type.span.text)
        for state in owner.states:
            yield Candidate(state, "state", f"state of {name}")
        yield from self.named_values(owner.types.values)

    def infos(self) -> Iterator[tables.CommunicationInfo]:
        for contents in self.known:
            for instance in contents.instances.values():
                if not self._is_further_copy(instance):
                    yield from instance.communications.values()

    def communications(self, events: tuple[str, ...], rank: int = 1) -> Iterator[Candidate]:
        """Those that have one of the events; own ones first."""
        names: dict[str, set[str]] = {}
        for info in self.infos():
            names.setdefault(info.name, set()).add(info.key)
        for info in self.infos():
            known = {kind.word for kind in info.events}
            if events and not known.intersection(events):
                continue
            if "request" in events and info.kind is Kind.OUTGOING:
                continue
            own = info.instance.name == self.own
            alone = len(names[info.name]) == 1 and "[" not in info.key
            label = info.name if own or alone else self._indexed(info.key)
            yield Candidate(
                label,
                "communication",
                f"{info.kind.value} of {info.instance.name}",
                rank=0 if own else rank,
            )

    def communication_of(self, words: tuple[str, ...]) -> tables.CommunicationInfo | None:
        name = [w.lstrip("^") for w in words if w != "."]
        for contents in self.known:
            own = contents.instances.get(self.own)
            found: tables.CommunicationInfo | None = None
            if len(name) == 1:
                known = tables.SymbolTable(contents.component_table, own).communications(name[0])
                found = known[0] if known else None
            elif len(name) == 2 and name[0] in contents.instances:
                found = contents.instances[name[0]].communications.get(name[1])
            if found is not None:
                return found
        return None

    def interfaces(self) -> Iterator[Candidate]:
        for contents in self.known:
            for name, node in contents.scope.interfaces.items():
                detail = f"{node.package.text}/{node.type.text}"
                yield Candidate(name, "interface", detail, rank=0)

    def types(
        self, *, none: bool = True, variable: bool = False, sources: bool = False
    ) -> Iterator[Candidate]:
        for word in _BASIC:
            if (word == "none" and (not none or variable or sources)) or (
                word == "array" and (none or variable)
            ):
                continue
            if word == "duration" and self.context.word(0) not in ("constant", "parameter"):
                continue
            yield Candidate(word, "keyword", "built-in type")
        for contents in self.known:
            for name in contents.scope.datatypes:
                is_enum = contents.types.enum(name) is not None
                if not (is_enum if sources else variable and not is_enum):
                    kind = "enum" if is_enum else "object"
                    yield Candidate(name, kind, f"datatype {kind}", rank=0)

        yield from self.ros_packages("msg")

    def ros_folder(self) -> str:
        """Which definitions a type of the declaration that is being typed can name."""
        first, noun = self.context.word(0), self.context.word(1)
        folder = FOLDERS.get(f"{first} {noun}", FOLDERS.get(first, "msg"))
        return folder if self.context.behind("type") == ":" else "msg"

    def is_ros_package(self, name: str) -> bool:
        return self.workspace.definitions(self.path).packages.find(name) is not None

    def ros_packages(self, folder: str) -> Iterator[Candidate]:
        """Packages with definitions of a kind; behind the slash come their types."""
        for package, _, of in offered_types(self.workspace.definitions(self.path)):
            if of == folder:
                yield Candidate(package, "ROS package", text=f"{package}/", rank=2)

    def ros_types(self, package: str, folder: str) -> Iterator[Candidate]:
        for home, name, of in offered_types(self.workspace.definitions(self.path)):
            if home == package and of == folder:
                yield Candidate(name, "ROS type", f"{package}/{name}", rank=0)

    def type_named(self, name: str) -> Type | None:
        found = (contents.types.known(name.lstrip("^")) for contents in self.known)
        return next((type_ for type_ in found if type_ is not None), None)

    def variable_type(self, name: str) -> Type | None:
        found = (owner.variables.get(name.lstrip("^")) for owner in self.owners(self.own))
        return next((type_ for type_ in found if type_ is not None), None)

    # --- expressions -----------------------------------------------------------------------------

    def expected(self) -> Type | None:
        """The type on the other side of a comparison that is being typed."""
        words = self.context.words
        if len(words) < 2 or self.context.word(-1) not in ("=", "!="):
            return None
        if len(words) > 3 and self.context.word(-3) == ".":
            for owner in self.owners(self.context.word(-4).lstrip("^")):
                return owner.variables.get(self.context.word(-2).lstrip("^"))
        if self.context.word(-2) == "value":
            return self.incoming()
        return self.variable_type(self.context.word(-2))

    def expression(self, expected: Type | None) -> Iterator[Candidate]:
        """What an expression can begin with."""
        yield from self.values(expected)
        for name in self.aggregates:
            yield Candidate(name, "variable", "of this aggregate", rank=0)
        if isinstance(expected, BooleanType) or expected is None:
            yield from keywords(("true", "false"), rank=2)
        if self.incoming() is not None:
            # Most requirements are about the state.
            rank = 2 if self.context.words[:1] == ("requirement",) else 0
            yield Candidate("value", "value", str(self.incoming()), rank=rank)
        if self.own:
            for owner in self.owners(self.own):
                yield from self.behaviour_of(owner, self.own)
        for contents in self.known:
            yield from self.named_values(contents.types.values)
            for name in contents.types.libraries:
                yield Candidate(name, "library", rank=2)
            for name, owner in contents.instances.items():
                named = owner.members or list(owner.types.values.declared)
                if named and not self._is_further_copy(owner):
                    yield Candidate(self._indexed(name), "component")
            if expected is None:
                for value in contents.types.enum_values():
                    yield Candidate(value, "enum value", rank=2)

    def named_values(self, scope: value_scope.ValueScope, rank: int = 1) -> Iterator[Candidate]:
        """The constants, parameters and conditions that a file or a component declares."""
        for name, function in scope.functions.items():
            head = function.span.text.partition("(")[2].partition("=")[0]
            detail = f"({' '.join(head.split())}"
            yield Candidate(name, "function", detail, f"{name}(", rank=rank)
        for name in scope.declared:
            node = scope.node(name)
            if isinstance(node, nodes.ConditionNode):
                yield Candidate(name, "condition", rank=rank)
            elif node is not None:
                kind = "parameter" if isinstance(node, nodes.ParameterNode) else "constant"
                yield Candidate(name, kind, node.type.span.text, rank=rank)

    def durations(self) -> Iterator[Candidate]:
        """Names of durations, behind ``timeout:`` and ``after``."""
        for contents in self.known:
            scopes = [contents.types.values]
            scopes += [owner.types.values for owner in self.owners(self.own)]
            for candidate in (c for scope in scopes for c in self.named_values(scope, rank=0)):
                if candidate.detail == "duration":
                    yield candidate

    def values(self, type_: Type | None) -> Iterator[Candidate]:
        if isinstance(type_, EnumType):
            for value in type_.values:
                yield Candidate(value, "enum value", f"value of {type_.name}", rank=0)

    def incoming(self) -> Type | None:
        """What ``value`` is here."""
        words = self.context.words
        if self.context.block.kind == "enum":
            for contents in self.known:
                known = contents.types.known(self.context.block.name)
                if isinstance(known, EnumType):
                    return known.source
        if words[:1] == ("requirement",) and "needs" in words:
            command = self.communication_of(words[1 : words.index("needs")])
            return None if command is None else command.sent
        events = listed_events(words)
        if not events:
            return None
        end = next(
            (i for i, w in enumerate(words) if w in ("if", "else", "do", "goto")), len(words)
        )
        info = self.communication_of(words[2 * len(events) + 1 : end])
        kind = None if info is None else info.sort.named(events[0])
        return None if info is None or kind is None else info.brought(kind)


def listed_events(words: Sequence[str]) -> tuple[str, ...]:
    """The events that the words of a transition list between ``on`` and ``from`` or ``to``."""
    if not words or words[0] != "on":
        return ()
    names = takewhile(lambda word: word not in ("from", "to"), words[1:])
    return tuple(name for name in names if name in EVENTS)


def several(contents: FileContents) -> Mapping[str, nodes.RangeNode]:
    """The indexes of each component of a file that stands for several of a kind."""
    written = contents.scope.node.written
    return {
        node.name.text: node.indexes
        for node in (written.declarations if written is not None else ())
        if isinstance(node, nodes.ComponentNode | nodes.ImportNode) and node.indexes is not None
    }


def block_words(block: str) -> list[str]:
    """What the declarations of a kind of block begin with."""
    return [offer for word in starts_of(block) for offer in _MORE.get(word, (word,))]


def keywords(words: Iterable[str], rank: int = 1) -> Iterator[Candidate]:
    return (Candidate(word, "keyword", rank=rank) for word in words)
