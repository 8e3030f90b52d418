"""Decisions over data against a second reading that knows nothing of classes.

The oracle takes the numbers and strings themselves, a sample of every class there can be, and finds
the supervisor by exhaustive search. What only compares with constants must come out exactly alike.
"""

from __future__ import annotations

import math
import random
from typing import Any

import pytest
from data_models import SAMPLES, data_model
from quick import quick_first
from synthesis.oracle import Event, Oracle, OracleState

from robosc import pipeline
from robosc.ir.automaton import Plant, PlantState, VariableKind
from robosc.ir.formulas import exact
from robosc.ir.lower import lower
from robosc.ir.step import holds
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.model.types import ArrayType, DoubleType, IntegerType, StringType
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import explore, synthesize
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.verify.verification import verify

TYPES = {"double": DoubleType(), "integer": IntegerType(), "string": StringType()}


def robot_of(text: str) -> Robot:
    robot, diagnostics = load(Source("model.rscd", text))
    assert robot is not None, (text, diagnostics)
    return robot


def classified(supervisor: Supervisor, oracle: Oracle, state: OracleState) -> PlantState:
    """The state of the plant that a state of the oracle belongs to."""
    kinds = {
        "at": VariableKind.LOCATION,
        "var": VariableKind.DATA,
        "phase": VariableKind.PHASE,
        "parameter": VariableKind.TEST,
    }
    found = {
        (kinds[what], name): value for (what, name), value in zip(oracle.slots, state, strict=True)
    }
    return tuple(v.values.index(found[v.kind, v.name]) for v in supervisor.plant.variables)


def differences(text: str, engine: str) -> list[Any]:
    robot = robot_of(text)
    oracle = Oracle(robot, {TYPES[name]: values for name, values in SAMPLES.items()})
    supervisor = pipeline.synthesize(robot, engine)
    states, _ = oracle.controlled
    if supervisor.empty or oracle.empty:
        return [] if supervisor.empty == oracle.empty else ["one is empty"]
    found: list[Any] = []
    ours = set(explore(supervisor).states)
    theirs = {classified(supervisor, oracle, state) for state in states}
    if ours != theirs:
        found.append(f"states: {len(ours)}, oracle {len(theirs)}")
    if supervisor.controlled_states != len(theirs):
        found.append(f"counted: {supervisor.controlled_states}, oracle {len(theirs)}")
    plants = {classified(supervisor, oracle, state) for state in oracle.plant[0]}
    if supervisor.plant_states != len(plants):
        found.append(f"plant: {supervisor.plant_states}, oracle {len(plants)}")
    for guard in supervisor.guards:
        event = Event(guard.event.kind, guard.event.key, guard.event.index)
        for state in states:
            if event in oracle.possible(state):
                ours_allow = oracle.holds(exact(guard.expr), state)
                if ours_allow != (event in oracle.enabled(state)):
                    found.append((event, state, ours_allow))
                    break
        if guard.status != oracle.status(event):
            found.append((event, guard.status, oracle.status(event)))
    return found


CASES = [(seed, "") for seed in range(20)]
CASES += [(seed, "parameter") for seed in range(8)]
CASES += [(seed, extra) for extra in ("failure", "enum") for seed in range(4)]
"""Seeds of random models, and what they have besides."""


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "extra"), CASES)
def test_comparisons_with_constants_are_exact(seed: int, extra: str) -> None:
    text = data_model(random.Random(seed), extra=extra)
    for engine in ("dense", "bdd"):
        assert not differences(text, engine), text


ARRAYS = {
    "double": [(), (0.3,), (math.nan,), (0.1, 1e308), (-2.5, 0.5, 0.0)],
    "integer": [(), (0,), (2, 3), (-1, 2**53 + 1, 3)],
    "string": [(), ("a",), ("b", "")],
}


@pytest.mark.parametrize("seed", range(16))
def test_what_goes_through_arrays_keeps_the_requirements(seed: int) -> None:
    """The plant takes it as free: that is more than can happen, and never less."""
    rng = random.Random(seed)
    robot = robot_of(data_model(rng, extra="array"))
    supervisor = pipeline.synthesize(robot)
    if supervisor.empty:
        return
    name = str(robot.communications["Sensor.sense"].response)
    samples = {TYPES[name]: SAMPLES[name], ArrayType(TYPES[name]): ARRAYS[name]}
    oracle = Oracle(robot, samples)
    guards = {
        Event(g.event.kind, g.event.key, g.event.index): exact(g.expr) for g in supervisor.guards
    }
    for _ in range(20):
        state = rng.choice(oracle.initials)
        for _ in range(20):
            assert not oracle.unsafe(state)
            allowed = [
                (occurrence, target)
                for occurrence, target in oracle.successors(state)
                if occurrence.event not in guards or oracle.holds(guards[occurrence.event], state)
            ]
            assert all(oracle.required(state, occurrence.event) for occurrence, _ in allowed)
            _, state = rng.choice(allowed)


# --- the same model with an enum written by hand -------------------------------------------------

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


@pytest.mark.parametrize("engine", ["dense", "bdd"])
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


@pytest.mark.parametrize("engine", ["dense", "bdd"])
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


# --- tests that are taken as free ----------------------------------------------------------------


class Search:
    """The supervisor of a plant by going through all of its states, again and again."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        graph = explore(plant)
        self.states = graph.states
        self.starts = set(range(graph.starts))
        self.targets: dict[tuple[int, int], set[int]] = {}
        for t in graph.transitions:
            self.targets.setdefault((t.source, t.event), set()).add(t.target)
        self.kept = {
            number
            for number, state in enumerate(self.states)
            if all(holds(plant, condition, state) for condition, _ in plant.invariants)
        }
        while (kept := self._smaller()) != self.kept:
            self.kept = kept

    def allowed(self, state: int, event: int) -> bool:
        """Whether a command may be given: required, and good whatever comes of it."""
        requirement = self.plant.events[event].requirement
        if requirement is not None and not holds(self.plant, requirement, self.states[state]):
            return False
        return self.targets[state, event] <= self.kept

    def moves(self) -> list[tuple[int, set[int]]]:
        """From where to where the kept states lead, under control."""
        return [
            (state, targets)
            for (state, event), targets in self.targets.items()
            if state in self.kept
            and (not self.plant.events[event].controllable or self.allowed(state, event))
        ]

    def _smaller(self) -> set[int]:
        moves = self.moves()
        leaving = {state for state, targets in moves if not targets <= self.kept}
        reaching = {n for n in self.kept if self.plant.is_marked(self.states[n])}
        while more := {s for s, t in moves if t & reaching and s not in reaching}:
            reaching |= more
        return (self.kept & reaching) - leaving

    def reached(self) -> set[int]:
        moves = self.moves()
        found = self.starts
        while more := {t for s, targets in moves if s in found for t in targets} - found:
            found = found | more
        return found


@pytest.mark.parametrize(("seed", "extra"), quick_first(CASES, 8))
def test_free_outcomes_are_the_choice_of_the_environment(seed: int, extra: str) -> None:
    rng = random.Random(seed)
    plant = lower(robot_of(data_model(rng, computed=True, extra=extra)))
    while any(weight(event) > 300 for event in plant.events):
        plant = lower(robot_of(data_model(rng, computed=True, extra=extra)))
    search = Search(plant)
    for engine in ("dense", "bdd"):
        supervisor = synthesize(plant, engine)
        assert supervisor.empty == (not search.starts <= search.kept)
        if supervisor.empty:
            continue
        reached = search.reached()
        assert supervisor.controlled_states == len(reached)
        guards = {id(guard.event): guard.expr for guard in supervisor.guards}
        for state, event in search.targets:
            if state in reached and plant.events[event].controllable:
                ours = holds(plant, guards[id(plant.events[event])], search.states[state])
                assert ours == search.allowed(state, event)
    assert supervisor.empty or verify(supervisor).verified
