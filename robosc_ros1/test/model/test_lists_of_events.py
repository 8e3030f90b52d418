"""One transition for several events and communications is that of each of them by itself."""

from __future__ import annotations

import random

import pytest
from model_text import behaviour_of, faults, resolve

from robosc.language.events import EventKind
from robosc.plant.build import lower
from robosc.source import Source
from robosc.syntax.formatting.format import format_text

PARTS = """
    interface link use Work from some_package
    component Other {
        outgoing message seen with timeout: 1 s, type: boolean
        service ask with request: none, response: boolean links link
    }
    component P {
        outgoing message near with type: boolean
        action go with request: none, response: boolean, feedback: boolean links link
        behaviour {
            variable last: boolean
            %s
            initial marked state a { %s }
            marked state b { %s }
        }
    }
"""
EVENTS = {
    "near": ("response",),
    "seen": ("response", "timeout"),
    "Other.ask": ("request", "response", "error"),
    "go": ("request", "response", "feedback", "error", "cancel"),
}
CLAUSES = ("", "do last := true", "goto b", "if last goto b", "if !last do last := true goto a")
VALUE = ("do last := value", "if value goto b", "if value do last := !value goto a")
CARRIERS = ("response", "feedback")


def listed_and_single(draw: random.Random) -> tuple[str, str]:
    """Random lists, and the same written out; the lists share no event of a communication."""
    free = {(event, name) for name, events in EVENTS.items() for event in events}
    listed, single = [], []
    for _ in range(draw.randint(1, 3)):
        names = draw.sample(sorted(EVENTS), draw.randint(1, 4))
        having = sorted({event for name in names for event in EVENTS[name]})
        events = draw.sample(having, draw.randint(1, len(having)))
        pairs = [(event, name) for event in events for name in names if event in EVENTS[name]]
        if not free.issuperset(pairs):
            continue
        free.difference_update(pairs)
        carries = all(event in CARRIERS for event in events)
        clause = draw.choice([*CLAUSES, *(VALUE if carries else ())])
        among = names[0] if len(names) == 1 else f"{{ {', '.join(names)} }}"
        listed.append(f"on {', '.join(events)} from {among} {clause}")
        single += [f"on {event} from {name} {clause}" for event, name in pairs]
    return "\n".join(listed), "\n".join(single)


@pytest.mark.parametrize("seed", range(60))
def test_a_list_is_its_transitions_written_out(seed: int) -> None:
    draw = random.Random(seed)
    places = [listed_and_single(draw) for _ in range(3)]
    short, long = (PARTS % tuple(place[form] for place in places) for form in (0, 1))
    first, second = resolve(short), resolve(long)
    assert behaviour_of(first, "P") == behaviour_of(second, "P")
    plants = [lower(robot) for robot in (first, second)]
    assert plants[0].variables == plants[1].variables
    assert plants[0].events == plants[1].events


def test_the_list_keeps_the_order_of_its_events_and_communications() -> None:
    robot = resolve(PARTS % ("on error, response from { go, Other.ask }", "", ""))
    assert [(t.event, t.communication) for t in behaviour_of(robot, "P").transitions] == [
        (EventKind.ERROR, "P.go"),
        (EventKind.ERROR, "Other.ask"),
        (EventKind.RESPONSE, "P.go"),
        (EventKind.RESPONSE, "Other.ask"),
    ]


@pytest.mark.parametrize(
    ("transition", "expected"),
    [
        ("on response, error, response from go", ("duplicate-transition", "response")),
        ("on response from { near, go, near }", ("repeated-communication", "near")),
        ("on timeout from { near, go }", ("event-not-available", "timeout")),
        ("on response, feedback from near", ("event-not-available", "feedback")),
        ("on response from { near, sen }", ("unknown-communication", "sen")),
        (
            "on response, error from { go, near } on error from go",
            ("duplicate-transition", "error"),
        ),
        ("on response, cancel from go do last := value", ("value-not-allowed", "value")),
    ],
)
def test_faults_of_lists(transition: str, expected: tuple[str, str]) -> None:
    assert expected in faults(PARTS % (transition, "", ""))


def test_a_fault_in_the_clauses_is_told_once() -> None:
    found = faults(PARTS % ("on response, error from { go, near } if lost goto nowhere", "", ""))
    assert [f for f in found if f[1] in ("lost", "nowhere")] == [
        ("unknown-name", "lost"),
        ("unknown-state", "nowhere"),
    ]


def test_a_list_of_a_state_hides_what_applies_in_every_state() -> None:
    found = faults(PARTS % ("on error from go goto b", "on response, error from go goto b", ""))
    assert ("hidden-transition", "error") in found
    assert ("hidden-transition", "response") not in found


def test_the_layout_of_lists() -> None:
    text = "robot R{component P{behaviour{on  response ,error from{go , Other.ask}goto a}}}"
    assert "on response, error from { go, Other.ask } goto a\n" in format_text(Source("m", text))
