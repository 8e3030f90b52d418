"""Labels of communications are accepted where the language has them, with the values it wants."""

from __future__ import annotations

from itertools import product

import pytest

from robosc.errors import Severity
from robosc.language.attributes import ATTRIBUTES, Attribute, Value
from robosc.model.resolve import load
from robosc.source import Source

SERVED = ("outgoing service", "outgoing action")
CALLS = ("service", "action", *SERVED)
NAMED = ("incoming", "outgoing", *CALLS)
TRANSFORM = "outgoing transform"
EVERYWHERE = (*NAMED, TRANSFORM)
HAVE = {
    "identifier": (Value.STRING, NAMED, False),
    "from": (Value.STRING, (TRANSFORM,), True),
    "to": (Value.STRING, (TRANSFORM,), True),
    "timeout": (Value.DURATION, ("outgoing", TRANSFORM, "service", "action"), False),
    "within": (Value.DURATION, ("action",), False),
    "expect": (Value.CONDITION, ("service", "action"), False),
    "goals": (Value.REPLACE, ("action",), False),
    "rate": (Value.RATE, ("incoming", TRANSFORM, *CALLS), False),
    "stop": (Value.NONE, ("incoming",), False),
    "type": (Value.TYPE, ("incoming", "outgoing"), True),
    "request": (Value.TYPE, CALLS, True),
    "response": (Value.TYPE, CALLS, True),
    "feedback": (Value.TYPE, ("action", "outgoing action"), True),
}
TEXTS = {
    Value.STRING: '"/name"', Value.DURATION: "2 s", Value.CONDITION: "true", Value.TYPE: "none",
    Value.RATE: "20 Hz",
    Value.REPLACE: "replace",
    Value.NONE: "none",
}  # fmt: skip

NO_FAULTS = ("unanswered", "interface-not-found")
"""Nobody answers calls here, and no package may be installed."""


def is_accepted(kind: str, given: dict[str, str]) -> bool:
    labels = ", ".join(f"{name}: {text}" for name, text in given.items())
    links = " links l" * (kind in CALLS)
    head = f"{kind} message" if kind in ("incoming", "outgoing") else kind
    text = f"robot R {{ component A {{ {head} m with {labels}{links} }} interface l use L from p }}"
    _, found = load(Source("model.rscd", text))
    return not any(d.severity is Severity.ERROR and d.code not in NO_FAULTS for d in found)


def all_of(kind: str) -> dict[str, str]:
    own = {name: TEXTS[value] for name, (value, kinds, _) in HAVE.items() if kind in kinds}
    return own | ({"to": '"/other"'} if "to" in own else {})


def test_the_rows_say_what_the_language_says() -> None:
    rows = {row.name: (row.value, row.communications, row.required) for row in ATTRIBUTES}
    assert {name: (v, set(k), r) for name, (v, k, r) in rows.items() if name in HAVE} == {
        name: (v, set(k), r) for name, (v, k, r) in HAVE.items()
    }


@pytest.mark.parametrize("kind", EVERYWHERE)
def test_labels_that_are_needed_and_those_that_are_not(kind: str) -> None:
    whole = all_of(kind)
    assert is_accepted(kind, whole)
    for name in whole:
        rest = {other: text for other, text in whole.items() if other != name}
        assert is_accepted(kind, rest) is not HAVE[name][2], name


@pytest.mark.parametrize(("kind", "row"), product(EVERYWHERE, ATTRIBUTES), ids=str)
def test_a_label_of_another_kind_or_with_another_value(kind: str, row: Attribute) -> None:
    whole = all_of(kind)
    if kind not in row.communications:
        assert not is_accepted(kind, {row.name: TEXTS[row.value], **whole})
        return
    for text in TEXTS.values():
        if text != TEXTS[row.value] and row.name in whole:
            # 'none' could be the name of a constant, were it no keyword.
            assert not is_accepted(kind, {**whole, row.name: text}), text
