"""The table of events says what SEMANTICS says: written here once more, and compared column by column.

The stages read the table, so none of them notices a wrong entry; the second reading of the tests
(``synthesis/oracle_events.py``) has its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any

import pytest
from synthesis import oracle_events

from robosc.language.events import (
    ACTIVE,
    COMMUNICATIONS,
    FOLDERS,
    CommunicationSort,
    EventKind,
    EventSort,
    Kind,
    words_of_events,
)

# Communication: event, from which phases, to which, its data, and whose decision it is.
EVENTS = """
incoming:         request     -                 -           request    controller
outgoing:         response    unheard,heard,silent,fresh fresh response robot
outgoing:         timeout     fresh             silent      -          time
service:          request     idle              busy        request    controller
service:          response    busy              idle        response   robot
service:          error       busy              idle        response?  robot
action:           request     idle              busy        request    controller
action:           response    busy,cancelling   idle        response   robot
action:           feedback    busy              busy        feedback   robot
action:           error       busy,cancelling   idle        response?  robot
action:           cancel      busy              cancelling  -          controller
action:           cancelled   cancelling        idle        -          robot
outgoing service: request     idle              busy        request    robot
outgoing service: response    busy              idle        response   controller
outgoing service: error       busy              idle        -          controller
outgoing action:  request     idle              busy        request    robot
outgoing action:  response    busy,ending       idle        response   controller
outgoing action:  feedback    busy              busy        feedback   controller
outgoing action:  error       busy,ending       idle        -          controller
outgoing action:  cancel      busy              ending      -          robot
"""
PHASES = {
    "service": ("idle", ("busy",), ("idle",)),
    "action": ("idle", ("busy", "cancelling"), ("idle",)),
    "outgoing": ("silent", ("fresh",), ("silent", "fresh")),
    "outgoing service": ("idle", ("busy",), ("idle",)),
    "outgoing action": ("idle", ("busy", "ending"), ("idle",)),
}
"""The initial phase, the others, and those that are marked."""
HEARD = {"unheard", "heard"}
"""More phases of a message of which a model asks whether it has ever arrived."""
DEFINITIONS = {
    "incoming": ("msg", ("request",), "request", "request"),
    "outgoing": ("msg", ("response",), "request", None),
    "service": ("srv", ("request", "response"), "request", "request"),
    "action": ("action", ("request", "response", "feedback"), "request", "request"),
    "outgoing service": ("srv", ("request", "response"), "response", "answer"),
    "outgoing action": ("action", ("request", "response", "feedback"), "response", "answer"),
}
"""Folder, parts, what the controller gives, and the event with which it does."""


def rows() -> Iterator[tuple[str, list[str]]]:
    for line in EVENTS.strip().splitlines():
        name, _, rest = line.partition(":")
        yield name, rest.split()


def row(sort: CommunicationSort, event: EventSort) -> tuple[str, list[str]]:
    """A row of the table as it is written above."""
    by_time = event.kind.clocked
    return sort.name, [
        event.kind.word,
        ",".join(event.sources) or "-",
        event.target or "-",
        (event.brings or "-") + "?" * event.optional,
        "time" if by_time else "controller" if event.kind.controllable else "robot",
    ]


def table(sorts: Any) -> list[tuple[str, list[str]]]:
    return [row(sort, event) for sort in sorts for event in sort.events]


def test_events_are_possible_where_they_should_be_and_lead_where_they_should() -> None:
    assert table(COMMUNICATIONS.values()) == list(rows())


@pytest.mark.parametrize("kind", list(Kind))
def test_each_entry_of_an_event_counts(kind: Kind) -> None:
    """Any entry that is replaced by one of another row is seen."""
    sort = COMMUNICATIONS[kind]
    others = [event for other in COMMUNICATIONS.values() for event in other.events]
    here = [event for event in rows() if event[0] == sort.name]
    for number, event in enumerate(sort.events):
        for column in fields(EventSort):
            for value in {getattr(other, column.name) for other in others}:
                if value == getattr(event, column.name) or column.name == "with_timeout":
                    continue
                wrong = replace(event, **{column.name: value})
                events = (*sort.events[:number], wrong, *sort.events[number + 1 :])
                found = table([replace(sort, events=events)])
                assert found != here, (event, column.name, value)


def test_only_what_has_a_timeout_has_the_phases_and_the_event_of_silence() -> None:
    for kind, sort in COMMUNICATIONS.items():
        conditional = [e.kind for e in sort.events if e.with_timeout]
        assert conditional == ([EventKind.TIMEOUT] if kind is Kind.OUTGOING else [])
        assert (sort.phases_of(False) is None) == (kind in (Kind.INCOMING, Kind.OUTGOING))
        assert [e.kind for e in sort.events_of(True)] == [e.kind for e in sort.events]
        assert [e.kind for e in sort.events_of(False)] == [
            e.kind for e in sort.events if e.kind is not EventKind.TIMEOUT
        ]


def test_phases_begin_and_are_marked_as_they_should() -> None:
    for sort in COMMUNICATIONS.values():
        phases = sort.phases_of(True)
        found = None if phases is None else (phases.names[0], phases.active, phases.marked)
        assert found == PHASES.get(sort.name)
        for event in sort.events:
            names = set() if phases is None else set(phases.names)
            names |= HEARD if sort.name == "outgoing" else set()
            assert {*event.sources, event.target} - {""} <= names
    active = {phase for _, others, _ in PHASES.values() for phase in others}
    assert set(ACTIVE) == active | {"heard"}


def test_definitions_in_ros() -> None:
    for sort in COMMUNICATIONS.values():
        command = None if sort.command is None else sort.command.value
        assert (sort.folder, sort.parts, sort.sends, command) == DEFINITIONS[sort.name]
        assert sort.served == (sort.name in ("outgoing service", "outgoing action"))
        given = {sort.sends} if command else set()
        given |= {"feedback"} if sort.name == "outgoing action" else set()
        assert set(sort.received) == set(sort.parts) - given
        for event in sort.events:
            assert sort.named(event.kind.word) is event.kind
            assert sort.event(event.kind) is event
    assert {name: folder for name, (folder, *_) in DEFINITIONS.items()} == FOLDERS


def test_the_second_reading_has_the_same_events() -> None:
    for kind, sort in COMMUNICATIONS.items():
        kinds = {event.kind for event in sort.events if not event.with_timeout}
        assert kinds == set(oracle_events.KINDS[kind])
    for kind in EventKind:
        assert kind.controllable == (kind in oracle_events.CONTROLLABLE)
        assert kind.synchronised == (kind in oracle_events.AGREED or kind.of_component)


def test_properties_of_kinds() -> None:
    """Words in the order of the enumeration; what holds of which."""
    holds = {
        "sent": "request answer progress",
        "served": "answer refusal progress",
        "restricted": "request cancel answer progress tau",
        "to_component": "request answer refusal progress",
        "of_component": "tau after",
        "synchronised": "request answer refusal progress tau after",
        "clocked": "timeout after",
        "controllable": "request cancel answer refusal progress tau",
    }
    for name, kinds in holds.items():
        assert [k.value for k in EventKind if getattr(k, name)] == kinds.split(), name
    assert words_of_events() == (
        "request", "response", "feedback", "error", "cancel", "cancelled", "timeout",
    )  # fmt: skip
