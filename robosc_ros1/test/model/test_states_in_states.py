"""States in states are the states without states in them, each with what applies in it."""

from __future__ import annotations

import random

import pytest
from model_text import behaviour_of, faults, resolve
from nested_models import PARTS, flat_text, nested_text, random_behaviour
from quick import quick_first

from robosc.errors import Severity, render_all
from robosc.expr.traversal import walk
from robosc.expr.tree import StateRef
from robosc.language.events import EventKind
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.build import lower
from robosc.plant.model_text import to_dsl
from robosc.plant.step import Verdict, outcome, valuations
from robosc.source import Source
from robosc.syntax.formatting.format import format_text


def robot_of(behaviour: str) -> Robot | None:
    """The robot; None if no marked state can be reached from some state."""
    robot, diagnostics = load(Source("model.rscd", f"robot Test {{ {PARTS % behaviour} }}"))
    errors = {d.code for d in diagnostics if d.severity is Severity.ERROR}
    assert errors <= {"no-marked-reachable"}, render_all(diagnostics)
    return robot


def behaves(plant: Plant) -> dict[tuple[PlantState, str], object]:
    """What each event with each value leads to, in each state that is reached."""
    found: dict[tuple[PlantState, str], object] = {}
    seen = set(plant.initial_states)
    todo = list(seen)
    while todo:
        state = todo.pop()
        for event in plant.events:
            paths = [parameter.path for parameter in event.parameters]
            for values in valuations(event):
                after = outcome(plant, event, values, state)
                given = sorted(zip(paths, values, strict=True))
                name = f"{event.kind} {event.key} {given}"
                if event.kind is EventKind.AFTER:  # they have other numbers
                    others = found.get((state, name), frozenset())
                    assert isinstance(others, frozenset)
                    found[state, name] = others | ({after} - {Verdict.IMPOSSIBLE})
                else:
                    found[state, name] = after
                if isinstance(after, tuple) and after not in seen:
                    seen.add(after)
                    todo.append(after)
    return found


@pytest.mark.parametrize("seeds", quick_first([range(8), range(8, 44)], 1))
def test_they_do_what_their_unfolded_form_does(seeds: range) -> None:
    compared = deep = 0
    for seed in seeds:
        whole = random_behaviour(random.Random(seed))
        paths = {place.path for place in whole.all()}
        robots = [robot_of(text) for text in (nested_text(whole, paths), flat_text(whole))]
        if None in robots:
            assert robots == [None, None]
            continue
        nested, unfolded_ = (lower(robot) for robot in robots if robot is not None)
        assert [v.marked for v in nested.variables] == [v.marked for v in unfolded_.variables]
        here, there = behaves(nested), behaves(unfolded_)
        assert {state for state, _ in here} == {state for state, _ in there}
        common = here.keys() & there.keys()
        assert all(here[key] == there[key] for key in common)
        compared += len(common)
        deep += any(place.path.count(".") == 2 for place in whole.all())
    assert compared > 25 * len(seeds)
    assert deep > len(seeds) / 4


DOCK = """
    initial marked state idle { on response from near if value goto docking }
    marked state docking {
        on response from near if last goto idle
        initial state far {
            on request to go goto moving
            transition if last goto docking
        }
        state moving {
            on response, error, cancel from go goto far
            on response from near goto %s
        }
    }
"""


def test_their_names_are_paths_and_what_is_marked() -> None:
    states = behaviour_of(resolve(PARTS % (DOCK % "docking")), "P").states
    assert [(s.name, s.initial, s.marked) for s in states] == [
        ("idle", True, True),
        ("docking.far", False, True),
        ("docking.moving", False, False),
    ]
    assert states[1].transitions[0].goto == "docking.moving"
    assert states[2].transitions[-1].goto == "docking.far"


@pytest.mark.parametrize(
    ("condition", "states"),
    [
        ("P.docking", {"docking.far", "docking.moving"}),
        ("P.docking.far", {"docking.far"}),
        ("P.moving", {"docking.moving"}),
        ("P.idle", {"idle"}),
    ],
)
def test_conditions_name_them(condition: str, states: set[str]) -> None:
    text = PARTS % (DOCK % "far") + f"requirement never {condition} and P.last"
    (requirement,) = resolve(text).requirements
    (state,) = (p for p in walk(requirement.condition) if isinstance(p, StateRef))
    assert {*state.places} == states


@pytest.mark.parametrize(
    "condition",
    [
        "P.docking",
        "P.docking.far",
        "!P.docking",
        "P.docking or P.idle and !P.last",
        "P.docking and !P.docking.moving",
        "P.tries = 1 and !P.docking => P.last",
    ],
)
def test_texts_name_the_outer_state(condition: str) -> None:
    robot = resolve(PARTS % (DOCK % "far") + f"requirement go needs {condition}")
    assert to_dsl(robot.requirements[0].condition, robot) == condition


@pytest.mark.parametrize(
    ("behaviour", "fault"),
    [
        (DOCK % "docking.away", ("unknown-state", "docking.away")),
        (DOCK % "docking.far.near", ("unknown-state", "docking.far.near")),
        (DOCK.replace("goto docking }", "goto moving }", 1) % "far", ("unknown-state", "moving")),
        ("initial marked state a { state b {} }", ("no-initial-state", "a")),
        (
            "initial marked state a { initial state b {} initial state c {} }",
            ("several-initial-states", "c"),
        ),
        ("initial marked state a { initial state b {} state b {} }", ("duplicate-name", "b")),
        (
            "initial marked state a { on error from go goto a initial state b"
            " { on error from go goto b } }",
            ("hidden-transition", "error"),
        ),
    ],
)
def test_faults_of_states_in_states(behaviour: str, fault: tuple[str, str]) -> None:
    assert fault in faults(PARTS % behaviour)


@pytest.mark.parametrize(
    ("inner", "outer", "where"),
    [
        ("value", "!value", None),
        ("value", "value", "all of 'a'"),
        ("value and tries = 1", "value and tries != 1", None),
        ("value and tries < 2", "value and tries > 0", "all of 'a'"),
        ("value", "last", "all of 'a'"),
    ],
)
def test_only_what_can_be_taken_at_all_is_hidden(inner: str, outer: str, where: str | None) -> None:
    around = f"on response from near if {outer} goto c"
    state = f"state b {{ on response from near if {inner} goto c }}"
    in_a_state = f"initial marked state a {{ {around} initial {state} }}"
    beside_all = f"{around} initial marked {state}"
    for text, place in ((in_a_state, where), (beside_all, where and "every state")):
        behaviour = PARTS % f"{text} marked state c {{}}"
        diagnostics = load(Source("model.rscd", f"robot Test {{ {behaviour} }}"))[1]
        told = [d.message for d in diagnostics if d.code == "hidden-transition"]
        assert [m.rpartition("applies in ")[2] for m in told] == ([place] if place else [])


def test_the_layout_of_states_in_states() -> None:
    text = (
        "robot R{component P{behaviour{initial state a{goto b marked state b{on error from c}}}}}"
    )
    text = text.replace("goto b ", "transition goto a.b ")
    assert (
        format_text(Source("m", text))
        == """\
robot R {
    component P {
        behaviour {
            initial state a {
                transition goto a.b
                marked state b {
                    on error from c
                }
            }
        }
    }
}
"""
    )
