"""Name resolution of communications."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TypeAlias

from robosc import errors, remedies, source
from robosc.language.events import EventKind, Kind
from robosc.model.diagnostics import Report
from robosc.model.names import tables
from robosc.model.names.scope import FileScope
from robosc.model.names.tables import CommunicationInfo, SymbolTable
from robosc.syntax.nodes import Access, ExceptNode, Group, Name

_SENT = "what the controller publishes is incoming: incoming message {}"
HEARD = "what the robot publishes is outgoing: outgoing message {}"
"""A hint where an incoming message is used as one that the robot sends."""

_KEYWORDS = ("message", "service", "action", "transform")


def resolve_communication(
    access: Access, symbols: SymbolTable, scope: FileScope, report: Report
) -> CommunicationInfo | None:
    """The communication that a bare or qualified name refers to; None after an error."""
    if access.index is not None:
        message = f"{access.root.text} has no indexes: it is not declared as an indexed component"
        report.add("bad-index", access.span, message)
        return None
    match access.path:
        case ():
            return _bare(access, symbols, scope, report)
        case (Name() as member,):
            return _qualified(access, member, symbols, scope, report)
    report.add(
        "unknown-communication",
        access.span,
        "this is not a communication",
        "write its name, or Component.name",
    )
    return None


def report_misdirected(
    info: CommunicationInfo, code: str, span: source.Span, message: str, report: Report
) -> None:
    """Report that an outgoing message is used as a command, at the first of all places."""
    if not info.misdirected:
        info.misdirected = True
        report.add(code, span, message, _SENT.format(info.name))


def report_repeated(access: Access, first: source.Span, report: Report) -> None:
    """Report a communication that a statement names a second time."""
    report.add(
        "repeated-communication",
        access.span,
        f"'{access.span.text}' appears twice in this statement",
        None,
        [errors.Note("the first one is here", first)],
    )


def _bare(
    access: Access, symbols: SymbolTable, scope: FileScope, report: Report
) -> CommunicationInfo | None:
    name = access.root.text
    infos = symbols.communications(name)
    if infos:
        scope.names.use(access.root, infos[0].node, infos[0].instance.name)
    if len(infos) == 1:
        return infos[0]
    if infos:
        local = [i for i in infos if i.instance.imported is None and i.instance.node.copy is None]
        if len(local) == len(infos):
            return infos[0]  # all in this file: the duplicate name was reported
        report.add(
            "ambiguous-name",
            access.span,
            f"there are {len(infos)} communications '{name}'",
            remedies.write_one([i.key for i in infos]),
        )
        return None
    # It may be one of a component that could not be imported.
    if scope.is_unresolved(name, *_KEYWORDS) or symbols.component_table.broken:
        return None
    component = symbols.component(name)
    if component is not None:
        message = f"'{name}' is a component, not a communication"
        hint = report.suggest(name, [f"{name}.{c}" for c in component.communications], "it has")
    else:
        message = f"there is no communication '{name}'"
        hint = report.suggest(name, symbols.communication_names())
    report.add("unknown-communication", access.span, message, hint)
    return None


def _qualified(
    access: Access, member: Name, symbols: SymbolTable, scope: FileScope, report: Report
) -> CommunicationInfo | None:
    root = access.root.text
    component = symbols.component(root)
    scope.names.use(access.root, symbols.declaration(root))
    if component is None:
        infos = symbols.communications(root)
        if len(infos) == 1 and member.text in (e.word for e in infos[0].events):
            message = f"'{access.span.text}' is an event, and this is about its communication"
            report.add("unknown-communication", access.span, message, remedies.write(root))
        elif not symbols.is_broken(root) and not scope.is_unresolved(root, "component"):
            report.add(
                "unknown-name",
                access.root.span,
                f"there is no component '{root}'",
                report.suggest(root, symbols.components),
            )
        return None
    info = component.communications.get(member.text)
    if info is not None:
        scope.names.use(member, info.node, component.name)
    if info is None and not scope.is_unresolved(member.text, *_KEYWORDS):
        report.add(
            "unknown-communication",
            member.span,
            f"{root} has no communication '{member.text}'",
            report.suggest(member.text, component.communications, "it has"),
        )
    return info


def communications_named(access: Access, symbols: SymbolTable) -> list[CommunicationInfo]:
    """Return the communications that a bare or qualified name can mean."""
    component = symbols.component(access.root.text)
    match access.path:
        case ():
            return list(symbols.communications(access.root.text))
        case (Name() as member,) if component is not None:
            info = component.communications.get(member.text)
            return [] if info is None else [info]
    return []


def answer_named(access: Access, symbols: SymbolTable) -> tuple[Access, EventKind] | None:
    """Return the call in a name of an answer, and the answer; None if it names something else."""
    *before, last = (access.root, *access.path)
    if not before or not isinstance(last, Name) or access.index is not None:
        return None
    start, end = access.span.start, before[-1].span.end
    span = type(access.span)(access.span.source, start, end)
    call = replace(access, path=access.path[:-1], span=span)
    if not call.path and symbols.component(access.root.text) is not None:
        return None
    kinds = (info.sort.named(last.text) for info in communications_named(call, symbols))
    kind = next((kind for kind in kinds if kind is not None and kind.served), None)
    return None if kind is None else (call, kind)


# Groups of commands: ``all``, components, and what is left out of them.


_FREE = (
    "'error to {0}' is neither restricted nor preferred: a call that was accepted can always be"
    " answered with an error; name the response: {0}"
)
_EMPTY = "the group is empty: 'except' removes every command"
_Members: TypeAlias = dict[str, tuple[Access, tables.CommunicationInfo]]


def is_all(access: Access) -> bool:
    """Whether an access is the word ``all``, and no name."""
    return access.root.text == "all" and not access.root.escaped and not access.path


class GroupResolver:
    """Resolves the commands that a statement names."""

    def __init__(self, symbols: tables.SymbolTable, scope: FileScope, report: Report) -> None:
        self._symbols = symbols
        self._scope = scope
        self._report = report

    def commands(
        self,
        group: Group,
        code: str,
        why: str,
        *,
        left_out: Iterable[str] = (),
        may_be_empty: bool = False,
    ) -> tuple[str, ...] | None:
        """The keys of the commands, each once, in order; None after an error.

        ``code`` and ``why`` are those of an outgoing message; of ``all`` and of components, the
        commands ``left_out`` are no part. In a library, ``all`` may be nobody: its commands are
        those of the robot that imports it.
        """
        keys, whole = self._resolved(
            group,
            lambda access: self.command(access, code, why),
            left_out=left_out,
            may_be_empty=may_be_empty,
        )
        return tuple(keys) if whole else None

    def reports(self, group: Group) -> dict[str, str]:
        """By the keys of the calls in a group that are named without an answer, the keys of the
        feedback that the controller gives of them."""
        named = (item for item in group if isinstance(item, Access))
        infos = (info for item in named for info in communications_named(item, self._symbols))
        pairs = ((info, info.feedback_command()) for info in infos)
        return {info.key: report.key for info, report in pairs if report is not None}

    def listed(self, group: Group) -> tuple[list[tuple[Access, tables.CommunicationInfo]], bool]:
        """The communications of a transition, each once, and whether none of them has an error.

        Each is there with what names it first. Outgoing messages are named one by one.
        """
        members, whole = self._resolved(group, self._communication)
        return list(members.values()), whole

    def _resolved(
        self,
        group: Group,
        named: Callable[[Access], tables.CommunicationInfo | None],
        *,
        left_out: Iterable[str] = (),
        may_be_empty: bool = False,
    ) -> tuple[_Members, bool]:
        """The members of a group by key, each with its place, and whether there is no error.

        ``named`` resolves the name of one of them.
        """
        resolved: _Members = {}
        own_names: dict[str, source.Span] = {}
        whole = True
        for item in group:
            if isinstance(item, ExceptNode):
                return self._without(resolved, item, named) if whole else (resolved, False)
            members = self._members(item)
            if members is not None:
                whole &= may_be_empty or self._has_commands(item, members)
                new = [m for m in members if m.key not in {*resolved, *left_out}]
                resolved.update((m.key, (item, m)) for m in new)
            elif (info := named(item)) is None:
                whole = False
            elif info.key in own_names:
                report_repeated(item, own_names[info.key], self._report)
            else:
                own_names[info.key] = item.span
                resolved.setdefault(info.key, (item, info))
        return resolved, whole

    def _without(
        self,
        members: _Members,
        node: ExceptNode,
        named: Callable[[Access], tables.CommunicationInfo | None],
    ) -> tuple[_Members, bool]:
        """What is left of a group."""
        others, whole = self._resolved(node.communications, named, may_be_empty=True)
        left = {key: member for key, member in members.items() if key not in others}
        if whole and not left and self._scope.node.kind == "robot":
            self._report.add("unknown-communication", node.span, _EMPTY)
            return left, False
        return left, whole

    def _communication(self, access: Access) -> tables.CommunicationInfo | None:
        return resolve_communication(access, self._symbols, self._scope, self._report)

    def command(
        self, access: Access, code: str, why: str, *, given: bool = False
    ) -> tables.CommunicationInfo | None:
        """The command of a name; None after an error.

        A call that the controller serves stands for its response. ``given``: the name is that of
        what carries data, which the error to a call does, too.
        """
        answer = answer_named(access, self._symbols)
        if answer is not None:
            access, kind = answer
            if kind is EventKind.REFUSAL and given:
                info = self._communication(access)
                return None if info is None else info.error_command()
            if kind is EventKind.REFUSAL:
                self._report.add("error-is-free", access.span, _FREE.format(access.span.text))
                return None
        info = self._communication(access)
        if info is not None and answer is not None and answer[1] is EventKind.PROGRESS:
            return info.feedback_command()
        if info is not None and info.kind is Kind.OUTGOING:
            message = f"'{info.name}' is an outgoing message: {why}"
            report_misdirected(info, code, access.span, message, self._report)
            return None
        return info

    def _members(self, access: Access) -> list[tables.CommunicationInfo] | None:
        """The commands of ``all`` or of a component; None if one communication is named."""
        if is_all(access):
            return _commands_of(self._symbols.components.values())
        name = access.root.text
        component = self._symbols.component(name)
        if component is None or access.path or access.index or self._symbols.communications(name):
            return None
        self._scope.names.use(access.root, component.declaration)
        return _commands_of([component])

    def _has_commands(self, access: Access, members: list[tables.CommunicationInfo]) -> bool:
        if members or self._symbols.component_table.broken:
            return not self._symbols.component_table.broken
        if is_all(access) and self._scope.node.kind == "library":
            return True
        what = "the robot" if is_all(access) else access.root.text
        message = f"{what} has no commands: no incoming message, service or action"
        self._report.add("unknown-communication", access.span, message)
        return False


def _commands_of(components: Iterable[tables.Instance]) -> list[tables.CommunicationInfo]:
    return [
        info
        for component in components
        for info in component.communications.values()
        if info.kind is not Kind.OUTGOING and not info.sort.served
    ]
