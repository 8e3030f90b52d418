"""Missions at random: states in states that perform and try again, of which something is assumed,
required, or to be possible always. Both engines against the oracle, and against the same behaviour
unfolded by hand."""

from __future__ import annotations

import random
from collections import defaultdict

import pytest
from performing_models import PARTS, Performer, Unfolded, flat, performing_text, random_machine
from synthesis.subject import robot_of
from synthesis.test_oracle_differential import SMALL, check, each_of, engines

from robosc import pipeline
from robosc.errors import Severity, render_all
from robosc.language.events import EventKind
from robosc.model.resolve import load
from robosc.source import Source
from robosc.synthesis.explore import Graph, explore

SECOND = """
    component Q {
        service other with request: none, response: boolean links link
        behaviour {
            initial marked state rest { on response from near if value goto work.first }
            marked state work {
                on response from near if !value goto rest
                initial state first performs other then goto second { retry 1 times else goto rest }
                state second performs other then goto rest { after 3 s goto first }
            }
        }
    }
"""
"""It listens to the same message, and performs something of its own."""


class Conditions:
    """Conditions on a behaviour, as text about its states and about the unfolded ones."""

    def __init__(self, draw: random.Random, states: list[Performer]) -> None:
        self._draw = draw
        self._unfolded = Unfolded(states)

    def one(self) -> tuple[str, str]:
        """A condition, and the same about the unfolded behaviour."""
        draw = self._draw
        first, second = self._atom(), self._atom()
        operator = draw.choice(("", "", " and ", " or "))
        if not operator:
            return first
        return f"({first[0]}{operator}{second[0]})", f"({first[1]}{operator}{second[1]})"

    def _atom(self) -> tuple[str, str]:
        draw = self._draw
        if draw.random() < 0.3:
            fact = draw.choice(("P.last", "P.tries = 1", "go.busy", "ask.idle"))
            return fact, fact
        path = draw.choice([*self._unfolded.states, *self._unfolded.stages])
        stages = [
            s for s in self._unfolded.stages if s == path or s.startswith((f"{path}.", f"{path} "))
        ]
        sign = draw.choice(("", "", "!"))
        listed = " or ".join(f"P.{flat(stage)}" for stage in stages)
        return f"{sign}P.{path.replace(' ', '.')}", f"{sign}({listed})"


def requirements(draw: random.Random, states: list[Performer]) -> list[tuple[str, str]]:
    """What is asked of a mission, as two texts."""
    conditions = Conditions(draw, states)
    found = []
    for form in ("{} needs {}", "never {1} and {2}", "possible {1}", "possible {1} from {2}"):
        if draw.random() < 0.5:
            command = draw.choice(("go", "ask", "say"))
            (one, flat_one), (two, flat_two) = conditions.one(), conditions.one()
            if "needs" in form:
                form = "{0} needs {1}"
            texts = (form.format(command, one, two), form.format(command, flat_one, flat_two))
            found.append(tuple(f"requirement {text}" for text in texts))
    if draw.random() < 0.5:
        kind = draw.choice(("near needs", "go needs", "never"))
        one, flat_one = conditions.one()
        value = draw.choice(("value or ", "")) if kind == "near needs" else ""
        found.append((f"assume {kind} {value}{one}", f"assume {kind} {value}{flat_one}"))
    return [(one, other) for one, other in found]


def mission(seed: int) -> tuple[str, str]:
    """A robot, and the same with its first component unfolded by hand."""
    draw = random.Random(seed)
    states = random_machine(draw)
    unfolded = Unfolded(states)
    asked = requirements(draw, states)
    by_hand = unfolded.requirements()
    second = SECOND if seed % 2 else ""
    return (
        "\n".join(
            ("robot R {", PARTS % performing_text(states), second, *(a for a, _ in asked), "}")
        ),
        "\n".join(
            ("robot R {", PARTS % unfolded.text(), second, *(b for _, b in asked), *by_hand, "}")
        ),
    )


def valid(seeds: range) -> list[tuple[int, str, str]]:
    """Those of which neither form has an error."""
    found = []
    for seed in seeds:
        texts = mission(seed)
        errors = [_has_errors(text) for text in texts]
        assert errors[0] == errors[1], f"seed {seed}\n{texts[0]}\n{texts[1]}"
        if not errors[0]:
            found.append((seed, *texts))
    return found


def _has_errors(text: str) -> bool:
    """Whether from some state no marked one can be reached, which no model may have."""
    robot, diagnostics = load(Source("model.rscd", text))
    errors = {d.code for d in diagnostics if d.severity is Severity.ERROR}
    assert errors <= {"no-marked-reachable"}, text + render_all(diagnostics)
    return robot is None


@pytest.mark.slow
@pytest.mark.timeout(0)
@engines
def test_random_missions_against_the_oracle(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    tried = valid(range(first, first + (8 if count is None else count)))
    assert tried
    for seed, text, _ in tried:
        check(text, engine, seed, SMALL if count is None else None)


Steps = list[dict[str, set[int]]]


def steps_of(graph: Graph) -> Steps:
    """The states to which each event leads; those of time have other numbers, and are one."""
    found: Steps = [defaultdict(set) for _ in graph.states]
    for step in graph.transitions:
        event = graph.plant.events[step.event]
        name = (
            f"{event.kind} {event.key} {step.values if event.kind is not EventKind.AFTER else ''}"
        )
        found[step.source][name].add(step.target)
    return found


def assert_alike(one: Graph, other: Graph, told: str) -> None:
    """The same events are possible after the same ones, and the same states are marked."""
    sides = steps_of(one), steps_of(other)
    start = frozenset({0}), frozenset({0})
    todo, known = [start], {start}
    while todo:
        here, there = todo.pop()
        marks = [
            {g.plant.is_marked(g.states[n]) for n in s} for g, s in ((one, here), (other, there))
        ]
        assert marks[0] == marks[1], told
        follow = []
        for side, states in zip(sides, (here, there), strict=True):
            merged: dict[str, set[int]] = defaultdict(set)
            for state in states:
                for name, targets in side[state].items():
                    merged[name] |= targets
            follow.append(merged)
        assert follow[0].keys() == follow[1].keys(), (
            f"{follow[0].keys() ^ follow[1].keys()}\n{told}"
        )
        for name, targets in follow[0].items():
            pair = frozenset(targets), frozenset(follow[1][name])
            if pair not in known:
                known.add(pair)
                todo.append(pair)


@pytest.mark.slow
@pytest.mark.timeout(0)
@each_of("explicit", "bdd")
def test_random_missions_against_their_unfolded_forms(
    engine: str, pytestconfig: pytest.Config
) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    sorts = set()
    for seed, text, unfolded in valid(range(first, first + (30 if count is None else count))):
        told = f"seed {seed}, engine {engine}\n{text}\n{unfolded}"
        found = [pipeline.synthesize(robot_of(t), engine) for t in (text, unfolded)]
        assert found[0].empty == found[1].empty, told
        sorts.add("empty" if found[0].empty else "not empty")
        statuses = [
            {g.event.name + g.event.kind.word: g.status for g in s.guards if not g.event.index}
            for s in found
        ]
        sorts |= set(statuses[0].values())
        if not found[0].empty:
            assert_alike(explore(found[0]), explore(found[1]), told)
    assert count is not None or sorts >= {"empty", "not empty", "restricted", "never"}
