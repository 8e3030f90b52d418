"""Comparisons of data against the same model with an enum written by hand."""

from __future__ import annotations

import random
from typing import Any

import pytest
from quick import quick_first
from synthesis.test_data_differential import robot_of

from robosc import pipeline
from robosc.supervisor import Supervisor
from robosc.synthesis import explore

THRESHOLDS = {"double": [-2.5, 0.0, 0.1, 0.5], "integer": [-1, 0, 2, 3]}

BASE = """
    component Base {{
        incoming message go with type: none
        incoming message home with type: none
        behaviour {{
            initial marked state here {{ on request to go goto away }}
            {away} state away {{
                on request to home goto here
                on response from {seen} if {c2} goto here
            }}
        }}
    }}
    requirement go needs {c3} and {asked}
    requirement {c4} disables home
    requirement never Base.away and {c5}
"""
"""What drives in both kinds of models, and what the conditions forbid."""

MODEL = (
    """
robot R {{
    component Sensor {{
        outgoing message sense with type: {type}
        behaviour {{
            variable v: {type} = {start}
            variable w: {type} = {start}
            initial marked state s {{
                on response from sense if {quiet} and {c0} do v := value
                on response from sense if {quiet} and !{c0} do w := v {goto}
            }}
            {marked} state t {{
                on response from sense if {quiet} do w := value {swap}
                transition if {c1} goto s
            }}
        }}
    }}
    {enum}
"""
    + BASE
    + "}}"
)
LEAVES = ["value", "v", "value", "Sensor.v", "Sensor.w", "Sensor.v"]
"""What the conditions of the model are about."""


def two_models(rng: random.Random) -> tuple[str, str]:
    """One robot twice: with an enum of the bands between thresholds, and with bare comparisons."""
    type_ = rng.choice(list(THRESHOLDS))
    thresholds = sorted(rng.sample(THRESHOLDS[type_], rng.randint(1, 3)), reverse=True)
    above = [">" if type_ == "integer" else rng.choice([">", ">="]) for _ in thresholds]
    rules = [f"{sign} {limit}" for sign, limit in zip(above, thresholds, strict=True)]
    names = [f"band{number}" for number in range(len(rules))]
    picked = [(leaf, rng.randrange(len(rules))) for leaf in LEAVES]
    every = [("Sensor.v", number) for number in range(len(rules))]

    def by_name(leaf: str, number: int) -> str:
        """That it is in one of the bands from the highest down to this one."""
        return "(" + " or ".join(f"{leaf} = {name}" for name in names[: number + 1]) + ")"

    def by_number(leaf: str, number: int) -> str:
        return f"({leaf} {rules[number]})"

    converted = " ".join(f"value {r} -> {n}" for r, n in zip(rules, names, strict=True))
    same = {
        "goto": rng.choice(["", "goto t"]),
        "swap": rng.choice(["", ", v := w"]),
        "quiet": rng.choice(["Base.here", "Base.here", "true"]),
        "marked": (marked := rng.choice(["marked", ""])),
        "away": marked,
        "seen": "sense",
    }
    # Requirements that ask for little leave something to synthesis.
    constants = {n: text for n, text in {3: "true", 4: "false"}.items() if rng.random() < 0.6}
    texts = []
    for text_of, fields in (
        (by_name, {"type": "Band", "start": "rest"}),
        (by_number, {"type": type_, "start": "-100.0" if type_ == "double" else "-100"}),
    ):
        conditions = {f"c{n}": text_of(*asked) for n, asked in enumerate(picked)}
        conditions |= {f"c{n}": constant for n, constant in constants.items()}
        asked = " and ".join(f"({text_of(*one)} or true)" for one in every)
        enum = f"datatype enum Band from {type_} to {{ {converted} default -> rest }}"
        declared = enum if fields["type"] == "Band" else ""
        texts.append(MODEL.format(**same, **fields, **conditions, asked=asked, enum=declared))
    return texts[0], texts[1]


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
@pytest.mark.parametrize("seed", quick_first(range(20), 6))
def test_an_enum_by_hand_and_bare_comparisons_are_the_same(seed: int, engine: str) -> None:
    texts = two_models(random.Random(seed))
    by_hand, bare = (pipeline.synthesize(robot_of(text), engine) for text in texts)
    assert (by_hand.plant_states, by_hand.controlled_states, by_hand.controlled_transitions) == (
        bare.plant_states,
        bare.controlled_states,
        bare.controlled_transitions,
    )
    assert by_hand.properties == bare.properties
    assert [g.status for g in by_hand.guards] == [g.status for g in bare.guards]
    assert isomorphic(by_hand, bare), texts


OF_ELEMENTS = (
    """
robot R {{
    datatype object Scan {{ items: array({type}) }}
    interface scans use Scan from some_robot_msgs
    {enum}
    component Sensor {{
        outgoing message scan with type: {incoming} links scans
        outgoing message probe with type: {incoming} links scans
        incoming message keep with type: none
        behaviour {{
            variable v: {held}
            variable w: {held}
            variable far: boolean
            initial marked state s {{
                on response from scan do v := {value}
                on response from probe if Base.here and {c0} do w := {value}, far := {far}
                on request to keep {goto}
            }}
            {marked} state t {{
                on response from scan {quiet} do v := {value} goto s
                on response from probe do far := {far}
                transition if {c1} goto s
            }}
        }}
    }}
    requirement {last} disables keep
"""
    + BASE
    + "}}"
)


def two_models_of_elements(rng: random.Random) -> tuple[str, str]:
    """One robot twice: with an enum of an element of an array, and with the element compared."""
    type_ = rng.choice(["double", "integer"])
    thresholds = sorted(rng.sample(THRESHOLDS[type_], rng.randint(1, 3)), reverse=True)
    signs = [">"] if type_ == "integer" else [">", ">="]  # no integer lies between > 2 and >= 3
    rules = [f"{rng.choice(signs)} {limit}" for limit in thresholds]
    index = rng.randrange(3)
    element = f"items[{index}]"
    names = [f"band{number}" for number in range(len(rules))]
    leaves = ["value", "v", "value", "Sensor.v", "Sensor.w", "Sensor.v"]
    picked = [(leaf, rng.randrange(len(rules))) for leaf in leaves]
    every = [(leaf, n) for leaf in ("Sensor.v", "Sensor.w") for n in range(len(rules))]
    turned = {n for n in range(len(picked)) if rng.random() < 0.3}

    def by_name(leaf: str, number: int, opposite: bool = False) -> str:
        """That it is in one of the bands down to this one, or, if it is there, in none of them."""
        chosen = [*names[number + 1 :], "below"] if opposite else names[: number + 1]
        return f"{leaf} in {{ {', '.join(chosen)} }}"

    def by_number(leaf: str, number: int, opposite: bool = False) -> str:
        read = f"{leaf}{'.' + element if leaf == 'value' else f'[{index}]'} {rules[number]}"
        return f"!({read})" if opposite else read

    converted = " ".join(f"value.{element} {r} -> {n}" for r, n in zip(rules, names, strict=True))
    below = f"!(value.{element} {rules[-1]}) -> below"
    enum = f"datatype enum Band from Scan to {{ {converted} {below} default -> missing }}"
    same = {
        "type": type_,
        "goto": rng.choice(["goto s", "goto t"]),
        "quiet": rng.choice(["if Base.here", "if Base.here", ""]),
        "marked": rng.choice(["marked", ""]),
        "last": rng.choice(["Sensor.far", "!Sensor.far"]),
        "away": "",
        "seen": "scan",
    }
    assigned = rng.choice(["v", "w"]), rng.randrange(len(rules)), rng.random() < 0.3
    flag = rng.choice(["", "and Base.here", "or Base.away"])
    texts = []
    for text_of, fields in (
        (by_name, {"incoming": "Band", "held": "Band", "value": "value", "enum": enum}),
        (by_number, {"incoming": "Scan", "held": f"array({type_})", "value": "value.items"}),
    ):
        far = f"({text_of(*assigned)} {flag})"
        if text_of is by_name:  # nothing is assigned where there is no such element
            far = f"{assigned[0]} != missing and {far} or {assigned[0]} = missing and far"
        conditions = {f"c{n}": text_of(*one, n in turned) for n, one in enumerate(picked)}
        # An undefined part makes what stands left of it undefined, too, and nothing right of true.
        asked = " and ".join(
            f"(true or {text_of(*one, opposite)})" for one in every for opposite in (False, True)
        )
        texts.append(
            OF_ELEMENTS.format(**{"enum": "", **same, **fields, **conditions}, asked=asked, far=far)
        )
    return texts[0], texts[1]


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
@pytest.mark.parametrize("seed", quick_first(range(20), 4))
def test_an_enum_by_hand_and_compared_elements_are_the_same(seed: int, engine: str) -> None:
    texts = two_models_of_elements(random.Random(seed))
    by_hand, bare = (pipeline.synthesize(robot_of(text), engine) for text in texts)
    assert bare.plant.view.free == {}
    assert by_hand.plant_states == bare.plant_states
    assert by_hand.properties == bare.properties
    assert [g.status for g in by_hand.guards] == [g.status for g in bare.guards]
    assert isomorphic(by_hand, bare), texts


def isomorphic(by_hand: Supervisor, bare: Supervisor) -> bool:
    """Whether the controlled systems are the same but for the names of values."""
    if by_hand.empty:
        return bare.empty
    first, second = labelled(by_hand, downwards=True), labelled(bare, downwards=False)
    image, waiting = {0: 0}, [0]
    while waiting:
        state = waiting.pop()
        ours, theirs = first[state], second[image[state]]
        if ours.keys() != theirs.keys():
            return False
        for step, target in ours.items():
            if target not in image:
                image[target] = theirs[step]
                waiting.append(target)
            if image[target] != theirs[step]:
                return False
    return len(set(image.values())) == len(image) == len(second)


def labelled(supervisor: Supervisor, downwards: bool) -> list[dict[Any, int]]:
    """Per state, where each event leads, its values counted from what is missing or the lowest."""
    graph = explore(supervisor)
    found: list[dict[Any, int]] = [{} for _ in graph.states]
    for t in graph.transitions:
        parameters = graph.plant.events[t.event].parameters
        numbers = [
            (p.values.index(v) + 1) % len(p.values) if None in p.values else p.values.index(v)
            for p, v in zip(parameters, t.values, strict=True)
        ]
        if downwards:
            numbers = [len(p.values) - 1 - n for p, n in zip(parameters, numbers, strict=True)]
        assert found[t.source].setdefault((t.event, tuple(numbers)), t.target) == t.target
    return found
