"""Names of the answers to calls that the controller serves: ``order.response``, ``order.error``."""

from __future__ import annotations

from dataclasses import replace

from robosc.language.events import EventKind
from robosc.model.names.tables import CommunicationInfo, SymbolTable
from robosc.syntax.nodes import Access, Name


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
