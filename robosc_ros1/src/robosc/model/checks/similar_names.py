"""Checks of names that may be confused: of one spelling but for case, of one topic."""

from __future__ import annotations

from collections.abc import Iterable

from robosc import errors, source
from robosc.language.events import Kind
from robosc.model.diagnostics import Report
from robosc.model.names.scope import FileScope
from robosc.model.names.tables import CommunicationInfo, ComponentTable
from robosc.syntax.nodes import Name


def check_case(scope: FileScope, component_table: ComponentTable, report: Report) -> None:
    """Report names of one kind that differ only in case."""
    _similar((c.name for c in scope.components.values()), "components", report)
    _similar((d.name for d in scope.datatypes.values()), "datatypes", report)
    _similar((i.name for i in scope.interfaces.values()), "interfaces", report)
    local = [i for i in component_table.instances.values() if i.imported is None]
    communications = [c.node.name for i in local for c in i.communications.values()]
    _similar(communications, "communications", report)
    for instance in local:
        _similar((s.name for s in instance.states.values()), "states", report)
        _similar((v.name for v in instance.variable_nodes.values()), "variables", report)
    for datatype in scope.datatypes.values():
        rules = getattr(datatype, "rules", ())
        _similar((r.value for r in rules), "enum values", report)
        properties = getattr(datatype, "properties", ())
        _similar((p.name for p in properties), "properties", report)


def _similar(names: Iterable[Name], what: str, report: Report) -> None:
    seen: dict[str, Name] = {}
    for name in names:
        first = seen.setdefault(name.text.casefold(), name)
        if first.text != name.text:
            report.add(
                "names-differ-in-case",
                name.span,
                f"the {what} '{first.text}' and '{name.text}' differ only in case",
                None,
                [errors.Note("the other one is here", first.span)],
            )


def check_topics(component_table: ComponentTable, report: Report) -> None:
    """Report messages on one topic that have different types, or of which two are received."""
    first: dict[str, CommunicationInfo] = {}
    outgoing: dict[str, CommunicationInfo] = {}
    for instance in component_table.instances.values():
        for info in instance.communications.values():
            if info.entity is None or info.sort.folder != "msg":
                continue
            other = first.setdefault(info.entity.ros_name, info)
            _check_topic_types(other, info, report)
            if info.kind is Kind.OUTGOING:
                sender = outgoing.setdefault(info.entity.ros_name, info)
                if sender is not info and not (sender.misdirected or info.misdirected):
                    _shared_topic(sender, info, report)


def _check_topic_types(first: CommunicationInfo, second: CommunicationInfo, report: Report) -> None:
    assert first.entity is not None and second.entity is not None
    one, two = (f"{e.binding.package}/{e.binding.type}" for e in (first.entity, second.entity))
    if one != two:
        report.add(
            "topic-types",
            _topic_span(second),
            f"topic '{second.entity.identifier}' carries {two} here and {one} elsewhere",
            "ROS connects only publishers and subscribers of one type",
            [errors.Note("the other message is here", _topic_span(first))],
        )


def _shared_topic(first: CommunicationInfo, second: CommunicationInfo, report: Report) -> None:
    assert second.entity is not None
    report.add(
        "topic-shared",
        _topic_span(second),
        f"'{first.key}' and '{second.key}' are received on one topic,"
        f" '{second.entity.identifier}': each message counts as both",
        "use one communication, to which any component can react",
        [errors.Note("the other message is here", _topic_span(first))],
    )


def _topic_span(info: CommunicationInfo) -> source.Span:
    """The place that gives a message its topic: the import, for a component of a library."""
    imported = info.instance.imported
    if imported is not None:
        return (imported.prefix or imported.component).span
    return (info.node.identifier or info.node.name).span
