"""What a text does not say and the reader may want to see: the messages behind basic types."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.lsp.analysis import Analysis
from robosc.lsp.ros_definitions import interface_of
from robosc.source import Span


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
