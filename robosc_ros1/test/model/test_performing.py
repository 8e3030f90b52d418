"""States that perform commands do what their forms unfolded by hand do."""

from __future__ import annotations

import random

import pytest
from performing_models import PARTS, Unfolded, flat, performing_text, random_machine
from quick import quick_first

from robosc.errors import Severity, render_all
from robosc.language.events import EventKind
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.build import lower
from robosc.plant.step import Outcome, Verdict, holds, outcome, valuations
from robosc.source import Source


def robot_of(behaviour: str) -> Robot | None:
    """The robot; None if no marked state can be reached from some state."""
    robot, diagnostics = load(Source("model.rscd", f"robot Test {{ {PARTS % behaviour} }}"))
    errors = {d.code for d in diagnostics if d.severity is Severity.ERROR}
    assert errors <= {"no-marked-reachable"}, behaviour + render_all(diagnostics)
    return robot


class Side:
    """One of two plants that are compared, with what of a state is to be equal."""

    def __init__(self, robot: Robot, unfolded: Unfolded) -> None:
        self.plant: Plant = lower(robot)
        self.names = [flat(v.name.removeprefix("P.")) for v in self.plant.variables]
        self.scopes = {}
        for state in unfolded.counted:
            around = state.path[:1] if "." in state.path else ""
            self.scopes[state.count] = (around,) if around else (state.path, state.via)

    def seen(self, state: PlantState) -> dict[str, object]:
        found = {
            name: variable.values[index]
            for name, variable, index in zip(self.names, self.plant.variables, state, strict=True)
        }
        here = str(found["P"])
        place = flat(here)
        found["P"] = place
        for count, scope in self.scopes.items():
            paths = [flat(path) for path in scope if path]
            if not any(place == path or place.startswith(f"{path}_") for path in paths):
                found.pop(count, None)
        return found

    def steps(self, state: PlantState) -> dict[str, list[Outcome]]:
        """What each event leads to; those of time, which have other numbers, are one."""
        found: dict[str, list[Outcome]] = {}
        for event in self.plant.events:
            for values in valuations(event):
                paths = [parameter.path for parameter in event.parameters]
                given = dict(zip(paths, values, strict=True)).get((), "")
                after = outcome(self.plant, event, values, state)
                name = f"{event.kind} {event.name}"
                if event.kind is EventKind.AFTER and after is Verdict.IMPOSSIBLE:
                    continue
                for value in (
                    (given,) if given != "" or event.kind is EventKind.AFTER else ((True, False))
                ):
                    found.setdefault(f"{name} {value}", []).append(after)
        return found


@pytest.mark.parametrize("seeds", quick_first([range(5), range(5, 14)], 1))
def test_they_do_what_their_unfolded_form_does(seeds: range) -> None:
    compared = retried = 0
    for seed in seeds:
        machine = random_machine(random.Random(seed))
        unfolded = Unfolded(machine)
        texts = performing_text(machine), unfolded.text()
        robots = [robot_of(text) for text in texts]
        if None in robots:
            assert robots == [None, None], "\n\n".join(texts)
            continue
        here, there = (Side(robot, unfolded) for robot in robots if robot is not None)
        start = here.plant.initial, there.plant.initial
        todo, known = [start], {start}
        while todo:
            one, other = todo.pop()
            assert here.seen(one) == there.seen(other), "\n\n".join(texts)
            assert here.plant.is_marked(one) == there.plant.is_marked(other)
            cancels(here.plant, one)
            left, right = here.steps(one), there.steps(other)
            assert left.keys() == right.keys(), (seed, *texts)
            for name, outcomes in left.items():
                pairs = paired(here, there, outcomes, right[name], f"{seed} {name}\n{texts}")
                todo += pairs - known
                known |= pairs
        compared += len(known)
        retried += any(state.times for state in unfolded.counted)
    assert compared > 33 * len(seeds)
    assert retried > len(seeds) / 4


def paired(
    here: Side, there: Side, ours: list[Outcome], theirs: list[Outcome], text: str
) -> set[tuple[PlantState, PlantState]]:
    """The states in which one event leaves both, which must be the same."""

    def seen(side: Side, found: Outcome) -> object:
        return found if isinstance(found, Verdict) else sorted(side.seen(found).items())

    assert {str(seen(here, o)) for o in ours} == {str(seen(there, t)) for t in theirs}, text
    return {
        (one, other)
        for one in ours
        for other in theirs
        if isinstance(one, tuple)
        and isinstance(other, tuple)
        and seen(here, one) == seen(there, other)
    }


def cancels(plant: Plant, state: PlantState) -> None:
    """A goal is cancelled where no state has it under way, and nowhere else."""
    place = str(plant.variables[0].values[state[0]])
    owner = place.partition(" ")[0]
    robot = plant.robot
    performed = [path for _, path in robot.performed.get("P.go", ())]
    cancel = next(event for event in plant.events if event.kind is EventKind.CANCEL)
    if performed:
        assert cancel.requirement is not None
        keeps = owner in performed and place.endswith("performing")
        assert holds(plant, cancel.requirement, state) is not keeps


@pytest.mark.parametrize(
    ("retry", "at"),
    [
        ("", "go"),
        ("{ retry 2 times every 1 s else goto idle }", "retry 2 times every 1 s else goto idle"),
        ("{ on error from go if last goto idle }", "error"),
    ],
)
def test_what_follows_an_error_hides_the_transitions_around(retry: str, at: str) -> None:
    text = f"""initial marked state idle {{ on response from near goto work }}
        state work {{
            on error from go if last goto idle
            initial state going performs go then goto idle {retry}
        }}"""
    _, diagnostics = load(Source("model.rscd", f"robot Test {{ {PARTS % text} }}"))
    hidden = [d for d in diagnostics if d.code == "hidden-transition"]
    assert [d.span.text for d in hidden] == [at], render_all(diagnostics)
    assert hidden[0].message.startswith(
        "in state 'work.going' this hides the transition for 'error'"
    )


@pytest.mark.parametrize("via", ["", "goto asking"])
def test_a_retry_that_waits_counts_on(via: str) -> None:
    """A retry that goes to the state itself is that state's own, and no other entry."""
    text = f"""initial marked state asking performs ask then
        {{ retry 1 times every 1 s {via} else goto given_up }}
        marked state given_up {{}}"""
    robot = robot_of(text)
    assert robot is not None
    plant = lower(robot)
    state, places = plant.initial, []
    for step in ("request", "error", "after", "request", "error"):
        events = [e for e in plant.events if e.kind.word == step and e.name in ("ask", "P")]
        found = [outcome(plant, e, values, state) for e in events for values in valuations(e)]
        state = next(after for after in found if not isinstance(after, Verdict))
        places.append(str(plant.variables[0].values[state[0]]))
    assert places[1] == "asking waiting" and places[-1] == "given_up"


def test_an_action_whose_type_is_not_known_is_the_only_error() -> None:
    text = """robot Test {
        component Base {
            action drive with identifier: "/drive", type: missing_msgs/Drive
            behaviour {
                initial marked state idle {}
                marked state driving performs drive then goto idle
                transition if idle goto driving
            }
        }
    }"""
    robot, diagnostics = load(Source("model.rscd", text))
    assert robot is None
    errors = [d.code for d in diagnostics if d.severity is Severity.ERROR]
    assert errors == ["ros-type-unknown"], render_all(diagnostics)
