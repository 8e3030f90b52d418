"""Names of the answers to calls that the controller serves: ``order.response``, ``order.error``."""

from __future__ import annotations

from dataclasses import replace

from robosc.language.events import EventKind
from robosc.model.names.tables import SymbolTable
from robosc.syntax.nodes import Access, Name


def answer_named(access: Access, symbols: SymbolTable) -> tuple[Access, EventKind] | None:
    """Return the call in a name of an answer, and the answer; None if it names something else."""
    *before, last = (access.root, *access.path)
    if not before or not isinstance(last, Name) or access.index is not None:
        return None
    component = symbols.component(access.root.text)
    if len(before) == 2 and component is not None and isinstance(before[1], Name):
        found = [component.communications.get(before[1].text)]
    elif len(before) == 1 and component is None:
        found = list(symbols.communications(access.root.text))
    else:
        return None
    kinds = (info.sort.named(last.text) for info in found if info is not None)
    kind = next((kind for kind in kinds if kind is not None and kind.served), None)
    if kind is None:
        return None
    start, end = access.span.start, before[-1].span.end
    span = type(access.span)(access.span.source, start, end)
    return replace(access, path=access.path[:-1], span=span), kind
