"""Symbol tables of one file: its components, and the names in the scope of each.

A component of a library is resolved again for each import, under the name of the import. Names
in its text refer to components of the library; :class:`ImportedSymbolTable` maps them to imports.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from robosc import dotted, errors, names, remedies, source
from robosc.expr import tree
from robosc.expr.types import IntegerType, Type
from robosc.language.events import (
    COMMUNICATIONS,
    CommunicationSort,
    Direction,
    EventKind,
    Kind,
    Phases,
    command_key,
)
from robosc.model import diagnostics, entities
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.names.occurrences import types_of
from robosc.runtime.core.places import DUE
from robosc.syntax import nodes


@dataclass
class CommunicationInfo:
    """A communication during resolution; None stands for a type with an error.

    ``entity`` is set once it is bound to a ROS interface without errors. ``heard``: something asks
    whether the message has ever arrived. ``misdirected``: it was reported that it is outgoing, and
    used as a command.
    """

    node: nodes.CommunicationNode
    instance: Instance
    kind: Kind
    request: Type | None
    response: Type | None
    feedback: Type | None
    entity: entities.Communication | None = None
    heard: bool = False
    misdirected: bool = False
    stands_for: EventKind | None = None
    """The answer alone for which it stands: feedback, or the error to a call."""

    @property
    def sort(self) -> CommunicationSort:
        """The row of the language's table for communications of this kind."""
        return COMMUNICATIONS[self.kind]

    @property
    def types(self) -> dict[Direction, Type | None]:
        """The types of what it carries, in the order in which a ROS definition has them."""
        carried: dict[Direction, Type | None] = {
            "request": self.request, "response": self.response, "feedback": self.feedback,
        }  # fmt: skip
        return {direction: carried[direction] for direction in types_of(self.node)}

    @property
    def has_timeout(self) -> bool:
        """Whether it has a timeout, even a faulty one."""
        return self.node.timeout is not None or (
            self.entity is not None and self.entity.timeout is not None
        )

    @property
    def phases(self) -> Phases | None:
        return self.sort.phases_of(self.has_timeout)

    @property
    def replaces(self) -> bool:
        """Whether a goal may replace the one that is busy."""
        return isinstance(self.node, nodes.ActionNode) and self.node.goals is not None

    @property
    def events(self) -> tuple[EventKind, ...]:
        return tuple(e.kind for e in self.sort.events_of(self.has_timeout))

    @property
    def sent(self) -> Type | None:
        """The type of the data that the controller gives; None after an error in it."""
        part = "feedback" if self.stands_for is EventKind.PROGRESS else self.sort.sends
        sent: Type | None = getattr(self, part)
        return sent

    @property
    def command(self) -> EventKind:
        """The event with which the controller gives them."""
        return self.stands_for or self.sort.command or EventKind.REQUEST

    def feedback_command(self) -> CommunicationInfo | None:
        """What stands for the feedback that the controller gives; None if it gives none."""
        has_feedback = self.sort.event(EventKind.PROGRESS) is not None
        return replace(self, stands_for=EventKind.PROGRESS) if has_feedback else None

    def error_command(self) -> CommunicationInfo:
        """What stands for the error to a call that the controller serves."""
        return replace(self, stands_for=EventKind.REFUSAL)

    def brought(self, event: EventKind) -> Type | None:
        """The type of an event's value; None if it has none, or the type has an error."""
        found = self.sort.event(event)
        if found is None or found.brings is None:
            return None
        brought: Type | None = getattr(self, found.brings)
        return brought

    @property
    def name(self) -> str:
        return command_key(self.node.name.text, self.command)

    @property
    def key(self) -> str:
        return f"{self.instance.name}.{self.name}"

    @property
    def whole_key(self) -> str:
        """The key of the communication, also where this stands for one of its answers."""
        return f"{self.instance.name}.{self.node.name.text}"

    @property
    def is_awaited(self) -> bool:
        """Whether its command is done when it is answered; all others are done when sent."""
        return self.phases is not None and not self.sort.served


PERFORMING, WAITING = "performing", "waiting"
"""The stages of a state that performs a command, after :data:`DUE`: its request was sent, and is
not done; and, with ``every``, it waits before it tries again. A component then stands in the path
of the state, a space and the stage; models write the stage behind a dot."""
RETRIES = "retries"
"""In the same way, how many errors in a row a state that performs a command has had."""


@dataclass
class Instance:
    """A component under the name that it has in the file being resolved.

    ``states`` has each state under its path: ``docking.near`` is state ``near`` of ``docking``.
    ``node`` and ``types`` are those of the declaration, in a library for an import; ``prefix`` is
    the whole chain of prefixes, joined, or None after an error; ``original`` and ``library`` are
    the instance that an import refers to and its table. ``performed`` has the commands that states
    perform, under the path of the state. The tables contain the first of two equal
    names; a variable whose type has an error is there with None. ``duplicate_behaviours`` are
    behaviours beyond the one that a component may have.
    """

    name: str
    node: nodes.ComponentNode
    types: TypeTable
    prefix: str | None = ""
    imported: nodes.ImportNode | None = None
    behaviour: nodes.BehaviourNode | None = None
    duplicate_behaviours: list[nodes.BehaviourNode] = field(default_factory=list)
    states: dict[str, nodes.StateNode] = field(default_factory=dict)
    variables: dict[str, Type | None] = field(default_factory=dict)
    variable_nodes: dict[str, nodes.VariableNode] = field(default_factory=dict)
    communications: dict[str, CommunicationInfo] = field(default_factory=dict)
    performed: dict[str, CommunicationInfo] = field(default_factory=dict)
    original: Instance | None = None
    library: ComponentTable | None = None

    @property
    def declaration(self) -> nodes.ComponentNode | nodes.ImportNode:
        """The node that gives the component its name in the file."""
        return self.imported or self.node

    def member(self, name: str) -> nodes.VariableNode | nodes.StateNode | None:
        """The variable or, if there is none, the state of a name; None if there is neither."""
        return self.variable_nodes.get(name) or self.states.get(name)

    def state(self, path: str) -> str | None:
        """The whole path of the state that a path in a condition means; None if it means none.

        The end of a path will do where it is unique.
        """
        ending = [state for state in self.states if state.endswith(f".{path}")]
        return path if path in self.states else ending[0] if len(ending) == 1 else None

    def leaves(self, path: str) -> list[str]:
        """The paths of the states without states in them that a state is, or contains."""
        node = self.states[path]
        if node.performs is not None:
            return [f"{path} {stage}" for stage in self.stages(path)]
        if not node.states:
            return [path]
        inner = [path_of(state, path) for state in node.states]
        return [leaf for state in dict.fromkeys(inner) for leaf in self.leaves(state)]

    def first_leaf(self, path: str) -> str:
        """The state in which one begins, through the initial states in it."""
        node = self.states[path]
        if node.performs is not None:
            return f"{path} {DUE}"
        states = node.states
        if not states:
            return path
        first = next((state for state in states if state.initial), states[0])
        return self.first_leaf(path_of(first, path))

    def stages(self, path: str) -> list[str]:
        """The stages of a state that performs a command."""
        command = self.performed.get(path)
        found = [DUE]
        if command is None or command.is_awaited:
            found.append(PERFORMING)
        items = self.states[path].items
        if any(isinstance(item, nodes.RetryNode) and item.every is not None for item in items):
            found.append(WAITING)
        return found

    def of_performing(self, path: str, span: source.Span) -> tree.Expr | None:
        """A stage of a state that performs a command, or its count of errors, if it is one."""
        word, outer = dotted.last(path), self.state(dotted.around(path))
        if outer is None or word not in self.parts_of_performing(outer):
            return None
        if word != RETRIES:
            return tree.StateRef(self.name, f"{outer} {word}", span)
        counted = IntegerType((0, self._retries(outer)[0]))
        return tree.VariableRef(self.name, f"{outer} {word}", counted, span)

    def parts_of_performing(self, path: str) -> list[str]:
        """The stages of a state if it performs a command, and the word for its count of errors."""
        if path not in self.performed:
            return []
        return [*self.stages(path), *(RETRIES for _ in self._retries(path))]

    def _retries(self, path: str) -> list[int]:
        retries = (item for item in self.states[path].items if isinstance(item, nodes.RetryNode))
        return [int(node.times.value) for node in retries if node.times is not None][:1]

    @property
    def members(self) -> list[str]:
        return [*self.variables, *self.states]


def path_of(state: nodes.StateNode, inside: str) -> str:
    """The path of a state that stands in the one with the path ``inside``; "": in none."""
    return f"{inside}.{state.name.text}" if inside else state.name.text


@dataclass
class ComponentTable:
    """All components of one file; ``broken`` are the names of imports that failed.

    ``by_name`` has the communications of each name, ``by_origin`` the instances of each declaration
    (by identity of its name). ``closed``: the robot is made, and its phases are known.
    """

    instances: dict[str, Instance] = field(default_factory=dict)
    broken: set[str] = field(default_factory=set)
    by_name: dict[str, list[CommunicationInfo]] = field(default_factory=dict)
    by_origin: dict[int, list[Instance]] = field(default_factory=dict)
    closed: bool = False

    def add(self, instance: Instance) -> None:
        """Add an instance under its name."""
        self.instances[instance.name] = instance
        self.by_origin.setdefault(id(instance.node.name), []).append(instance)

    @property
    def copies(self) -> Iterator[names.Copy]:
        """Those of all indexed components."""
        copies = (instance.declaration.copy for instance in self.instances.values())
        return (copy for copy in copies if copy is not None)

    def by_keys(self, keys: Iterable[str]) -> list[CommunicationInfo]:
        """The communications of keys, in their order."""
        infos = [c for i in self.instances.values() for c in i.communications.values()]
        reports = (report for c in infos if (report := c.feedback_command()) is not None)
        every = {c.key: c for c in (*infos, *reports)}
        return [every[key] for key in keys]

    def index_communications(self) -> None:
        """Fill ``by_name``; to be called once, when all instances are declared."""
        for instance in self.instances.values():
            for name, info in instance.communications.items():
                self.by_name.setdefault(name, []).append(info)


class SymbolTable:
    """Components and communications by name, in the scope of ``own`` (None: in statements)."""

    def __init__(self, component_table: ComponentTable, own: Instance | None = None) -> None:
        self.component_table = component_table
        self.own = own

    def is_broken(self, name: str) -> bool:
        return name in self.component_table.broken

    def component(self, name: str) -> Instance | None:
        return self.component_table.instances.get(name)

    def declaration(self, name: str) -> nodes.ComponentNode | nodes.ImportNode | None:
        """The declaration of a component; None if there is no such component."""
        found = self.component(name)
        return found.declaration if found is not None else None

    @property
    def components(self) -> Mapping[str, Instance]:
        return self.component_table.instances

    def communications(self, name: str) -> list[CommunicationInfo]:
        """The communications that a bare name can mean: an own one takes precedence."""
        if self.own is not None and name in self.own.communications:
            return [self.own.communications[name]]
        return self.component_table.by_name.get(name, [])

    def communication_names(self) -> Iterable[str]:
        return self.component_table.by_name


class ImportedSymbolTable(SymbolTable):
    """The names of a library in the text of one of its components that a robot imports.

    Another component of the library is the robot's import of it: the only one, or the one with the
    same prefix.
    """

    def __init__(
        self,
        component_table: ComponentTable,
        own: Instance,
        library: ComponentTable,
        original: Instance,
        report: diagnostics.Report,
    ) -> None:
        super().__init__(component_table, own)
        self.library = library
        self.original = original
        self._report = report

    def component(self, name: str) -> Instance | None:
        wanted = self.library.instances.get(name)
        return None if wanted is None else self._import_of(wanted)

    def communications(self, name: str) -> list[CommunicationInfo]:
        assert self.own is not None
        if name in self.own.communications:
            return [self.own.communications[name]]
        found = []
        for info in self.library.by_name.get(name, []):
            instance = self._import_of(info.instance)
            if instance is not None and name in instance.communications:
                found.append(instance.communications[name])
        return found

    def _import_to_add(self, name: str) -> remedies.Remedy:
        assert self.own is not None and self.own.imported is not None
        own = self.own.imported
        prefix = f" with prefix: {own.prefix.span.text}" if own.prefix is not None else ""
        text = f"component {name} from {own.library.text} import {name}{prefix}"
        return remedies.Remedy(f"add: {text}", remedies.Change.ADD_IMPORT, (text,))

    def _import_of(self, wanted: Instance) -> Instance | None:
        assert self.own is not None and self.own.imported is not None
        if wanted is self.original:
            return self.own
        found = self.component_table.by_origin.get(id(wanted.node.name), [])
        if len(found) > 1:
            found = [i for i in found if i.prefix == self.own.prefix]
        if len(found) == 1:
            return found[0]
        library = self.own.imported.library.text
        self._report.add(
            "import-incomplete",
            self.own.imported.component.span,
            f"{self.original.name} of library {library} refers to its component {wanted.name},"
            + (" which is not imported" if not found else " which is imported several times"),
            self._import_to_add(wanted.name)
            if not found
            else "give the imports that belong together one prefix",
            [errors.Note(f"{wanted.name} is declared here", wanted.node.name.span)],
        )
        return None
