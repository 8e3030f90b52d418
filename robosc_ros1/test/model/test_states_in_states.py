"""States in states are the states without states in them, each with what applies in it."""

from __future__ import annotations

import random
from collections.abc import Container
from dataclasses import dataclass, field
from itertools import product

import pytest
from model_text import behaviour_of, faults, resolve

from robosc.errors import Severity, render_all
from robosc.ir.automaton import Plant, PlantState
from robosc.ir.formulas import to_dsl
from robosc.ir.lower import lower
from robosc.ir.step import outcome, valuations
from robosc.model.entities import Robot
from robosc.model.expr import StateRef
from robosc.model.resolve import load
from robosc.model.traversal import walk
from robosc.source import Source
from robosc.syntax.format import format_text

PARTS = """
    interface link use Work from some_package
    component P {
        outgoing message near with type: boolean
        action go with request: none, response: boolean, feedback: none links link
        behaviour {
            variable last: boolean
            variable tries: integer(0..2)
            %s
        }
    }
"""
EVENTS = {
    "response from near": ("value", "!value", "last"),
    "response from go": ("value", "last and !value"),
    "error from go": ("last", "tries = 1"),
    "cancel from go": ("last",),
    "request to go": ("last", "tries < 2"),
}
EFFECTS = ("last := true", "last := !last", "tries := 1")


@dataclass(frozen=True)
class Reaction:
    """``on EVENT if GUARD do EFFECT goto TARGET``; empty parts are left out."""

    event: str
    guard: str
    effects: tuple[str, ...]
    target: str

    def text(self, target: str) -> str:
        guard = f" if {self.guard}" if self.guard else ""
        effects = f" do {', '.join(self.effects)}" if self.effects else ""
        return f"on {self.event}{guard}{effects}" + (f" goto {target}" if target else "")


@dataclass
class Place:
    """A state, or the whole automaton; the first state in it is the initial one."""

    path: str
    marked: bool = False
    reactions: list[Reaction] = field(default_factory=list)
    states: list[Place] = field(default_factory=list)

    def all(self) -> list[Place]:
        return [self, *(place for state in self.states for place in state.all())]

    @property
    def first(self) -> Place:
        return self.states[0].first if self.states else self


def random_place(draw: random.Random, path: str, depth: int) -> Place:
    place = Place(path, draw.random() < 0.5)
    if depth < 3 and (not path or draw.random() < 0.6):
        names = "ab" if depth else "pqr"
        prefix = f"{path}." if path else ""
        place.states = [random_place(draw, prefix + name, depth + 1) for name in names]
    return place


def random_behaviour(draw: random.Random) -> Place:
    whole = random_place(draw, "", 0)
    paths = [place.path for place in whole.all() if place.path]
    for place in whole.all():
        for event, guards in EVENTS.items():
            if draw.random() < 0.4:
                guard = draw.choice(("", *guards))
                found = [guard, f"!({guard})"] if guard and draw.random() < 0.4 else [guard]
                for one in found:
                    effects = [e for e in EFFECTS if draw.random() < 0.3]
                    assigned = {effect.split()[0]: effect for effect in effects}
                    target = draw.choice(paths) if draw.random() < 0.5 else ""
                    place.reactions.append(Reaction(event, one, tuple(assigned.values()), target))
    return whole


def as_written(target: str, inside: str, paths: Container[str]) -> str:
    """The name of a state where it is the nearest one of that name, else its path."""
    name = target.rpartition(".")[2]
    steps = inside.split(".")
    around = [".".join(steps[:n]) for n in range(len(steps), 0, -1)]
    nearest = next((f"{a}.{name}" for a in around if f"{a}.{name}" in paths), name)
    return name if nearest == target else target


def nested_text(place: Place, paths: Container[str]) -> str:
    lines = [r.text(r.target and as_written(r.target, place.path, paths)) for r in place.reactions]
    for number, state in enumerate(place.states):
        words = ["initial"] * (number == 0) + ["marked"] * state.marked + ["state"]
        name = state.path.rpartition(".")[2]
        lines.append(f"{' '.join(words)} {name} {{ {nested_text(state, paths)} }}")
    return "\n".join(lines)


def flat_text(whole: Place) -> str:
    """The same by hand: one state for each state without states in it, and nothing around them."""
    places = {place.path: place for place in whole.all()}
    lines = []
    for leaf in (place for place in whole.all() if not place.states):
        steps = leaf.path.split(".")
        levels = [places[".".join(steps[:n])] for n in range(len(steps), -1, -1)]
        marked = any(level.marked and level.first is leaf for level in levels[:-1])
        head = ["initial"] * (whole.first is leaf) + ["marked"] * marked + ["state"]
        body = "\n".join(line for event in EVENTS for line in unfolded(event, levels, places))
        lines.append(f"{' '.join(head)} {flat(leaf)} {{ {body} }}")
    return "\n".join(lines)


def flat(place: Place) -> str:
    return place.path.replace(".", "_")


def unfolded(event: str, levels: list[Place], places: dict[str, Place]) -> list[str]:
    """What a state does on an event: each combination of what its levels do, with its condition."""
    own = [[r for r in level.reactions if r.event == event] for level in levels]
    own = [reactions for reactions in own if reactions]
    if event.startswith("request"):
        return [r.text(flat(places[r.target].first) if r.target else "") for r in (*own[:1], [])[0]]
    found = []
    for chosen in product(*([*reactions, None] for reactions in own)):
        guards: list[str] = []
        taken: list[Reaction] = []
        if any(c is None and not all(r.guard for r in o) for o, c in zip(own, chosen, strict=True)):
            continue  # one without a guard is taken in any case
        for reactions, one in zip(own, chosen, strict=True):
            if one is None:
                guards += [f"!({other.guard})" for other in reactions]
            else:
                guards += [f"({one.guard})"] if one.guard else []
                taken += [one] if not taken or not one.target else []
        effects = {e.split()[0]: e for one in reversed(taken) for e in one.effects}
        target = next((one.target for one in taken if one.target), "")
        if taken:
            joined = Reaction(event, " and ".join(guards), tuple(effects.values()), target)
            found.append(joined.text(flat(places[target].first) if target else ""))
    return found


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
                found[state, f"{event.kind} {event.key} {given}"] = after
                if isinstance(after, tuple) and after not in seen:
                    seen.add(after)
                    todo.append(after)
    return found


@pytest.mark.parametrize("first", range(0, 80, 40))
def test_they_do_what_their_unfolded_form_does(first: int) -> None:
    compared = deep = 0
    for seed in range(first, first + 40):
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
    assert compared > 1000
    assert deep > 10


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
    assert {p.state for p in walk(requirement.condition) if isinstance(p, StateRef)} == states


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
        ("initial marked state a { initial state b {} after 1 s goto b }", ("misplaced", "after")),
        (
            "initial marked state a { on error from go goto a initial state b"
            " { on error from go goto b } }",
            ("hidden-transition", "error"),
        ),
    ],
)
def test_faults_of_states_in_states(behaviour: str, fault: tuple[str, str]) -> None:
    assert fault in [(code, text.split(" 1 s")[0]) for code, text in faults(PARTS % behaviour)]


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
