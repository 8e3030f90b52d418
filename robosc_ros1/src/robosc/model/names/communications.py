"""Name resolution of communications."""

from __future__ import annotations

from dataclasses import replace

from robosc import errors, remedies, source
from robosc.language.events import EventKind
from robosc.model.diagnostics import Report
from robosc.model.names.scope import FileScope
from robosc.model.names.tables import CommunicationInfo, SymbolTable
from robosc.syntax.nodes import Access, Name

_SENT = "what the controller publishes is incoming: incoming message {}"
HEARD = "what the robot publishes is outgoing: outgoing message {}"
"""A hint where an incoming message is used as one that the robot sends."""

_KEYWORDS = ("message", "service", "action")


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
