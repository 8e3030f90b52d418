"""What is written out with all cases is told as a count again, and means the same."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest
from synthesis.differential import ENGINES, differences
from synthesis.oracle import Oracle
from synthesis.plants import guard_text, plant_of
from synthesis.subject import robot_of

from robosc.emit.controller.python import Attributes
from robosc.expr.evaluation import evaluate
from robosc.expr.quantified import at_least
from robosc.expr.traversal import walk
from robosc.expr.tree import Count, Expr, Leaf, StateRef, VariableRef
from robosc.expr.types import BooleanType
from robosc.plant.counting import with_counts
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.model_text import to_dsl
from robosc.synthesis import synthesize

STATIONS = """
robot Stations {{
    component Station[1..{count}] {{
        outgoing message call with identifier: "/s{{index}}/call", type: none
        incoming message serve with identifier: "/s{{index}}/serve", type: none
        outgoing message done with identifier: "/s{{index}}/done", type: boolean
        behaviour {{
            variable good: boolean = false
            initial marked state idle {{ on response from call goto waiting }}
            state waiting {{ on request to serve goto served }}
            state served {{ on response from done do good := value goto idle }}
        }}
    }}
    {requirement}
}}
"""
LITERALS: list[Callable[[int], Expr]] = [
    lambda i: StateRef(f"Station[{i}]", "served"),
    lambda i: negation(StateRef(f"Station[{i}]", "waiting")),
    lambda i: VariableRef(f"Station[{i}]", "good", BooleanType()),
]


def model(count: int, requirement: str) -> str:
    return STATIONS.format(count=count, requirement=requirement)


def text_of(expr: Expr) -> str:
    return to_dsl(expr, robot_of(model(5, "")))


def some_count(rng: random.Random) -> Expr:
    first = rng.randrange(1, 4)
    last = rng.randrange(first, 6)
    literal = rng.choice(LITERALS)
    conditions = [literal(i) for i in range(first, last + 1)]
    if rng.random() < 0.3:
        conditions = rng.sample([one(i) for one in LITERALS for i in range(1, 6)], 5)
    found = at_least(conditions, rng.randrange(1, 5))
    assert found is not None
    return negation(found) if rng.random() < 0.5 else found


def some_condition(rng: random.Random, depth: int) -> Expr:
    if depth == 0 or rng.random() < 0.3:
        return some_count(rng)
    parts = [some_condition(rng, depth - 1) for _ in range(rng.randrange(2, 4))]
    found = rng.choice([conjunction, disjunction])(parts)
    return negation(found) if rng.random() < 0.2 else found


def sampled(rng: random.Random) -> Callable[[Leaf], bool]:
    """A state at random: each leaf is true or false as long as it lives."""
    known: dict[Leaf, bool] = {}
    return lambda leaf: known.setdefault(leaf, rng.random() < 0.5)


@pytest.mark.parametrize("seed", range(10))
def test_texts_mean_what_they_stand_for(seed: int) -> None:
    """In the language, read again by the front end, and in Python."""
    rng = random.Random(seed)
    exprs = [some_condition(rng, 2) for _ in range(20)]
    robot = robot_of(model(5, ""))
    requirements = "\n".join(f"requirement always {to_dsl(expr, robot)}" for expr in exprs)
    read = [r.condition for r in robot_of(model(5, requirements)).requirements]
    names = {f"Station[{i}]": f"station_{i}" for i in range(1, 6)}
    good = {f"{n}.good": f"{a}_good" for n, a in names.items()}
    attributes = Attributes(robot, names, good, {}, {})
    texts = [attributes.text(expr) for expr in exprs]
    assert any("sum((" in text for text in texts)
    for _ in range(40):
        values = {
            name: (rng.choice(["idle", "waiting", "served"]), rng.random() < 0.5) for name in names
        }

        def look(leaf: Leaf) -> bool:
            if isinstance(leaf, StateRef):
                return values[leaf.component][0] == leaf.state  # noqa: B023
            assert isinstance(leaf, VariableRef)
            return values[leaf.component][1]  # noqa: B023

        class Controller:
            """The attributes that the texts read."""

        for name, attribute in names.items():
            state, good = values[name]
            setattr(Controller, attribute, state)
            setattr(Controller, f"{attribute}_good", good)
        for expr, again, text in zip(exprs, read, texts, strict=True):
            expected = evaluate(expr, look)
            assert evaluate(again, look) == expected, text
            assert eval(text, {"self": Controller}) == expected, text


@pytest.mark.parametrize(
    "condition",
    [
        "count(s.served for s in Station) < 2",
        "count(s.served for s in Station) >= 3",
        "count(s.good for s in Station[2..5]) >= 2",
        "count(!s.waiting for s in Station[1..4]) < 3",
        "any(s.served for s in Station)",
        "!any(s.served for s in Station[1..3])",
        "all(s.good for s in Station[2..5])",
        "Station[1].idle and !any(s.waiting for s in Station[2..5])",
        "count(s.served for s in Station) < 2 or !all(s.good for s in Station)",
        "count(x for x in [Station[3].good, Station[1].idle, !Station[2].idle, Station[4].good]) < 3",
        "count(x for x in [Station[5].good, Station[2].good, Station[4].good, Station[1].good]) >= 2",
        "Station[1].good and (count(s.served for s in Station) >= 2 or Station[2].good)",
        # What has no short form stays as it was written out.
        "Station[1].served or Station[3].served or Station[5].served",
        "Station[1].served and Station[2].served",
    ],
)
def test_what_the_model_says_comes_back(condition: str) -> None:
    robot = robot_of(model(5, f"requirement always {condition}"))
    assert to_dsl(robot.requirements[0].condition, robot) == condition


@pytest.mark.parametrize("length", range(4, 12))
def test_counts_of_lists_come_back_in_the_order_of_the_list(length: int) -> None:
    rng, robot = random.Random(length), robot_of(model(5, ""))
    every = [literal(i) for literal in LITERALS for i in range(1, 6)]
    for least in range(2, length):
        listed = rng.sample(every, length)
        written = at_least(listed, least)
        assert written is not None
        found = with_counts(written, robot)
        assert isinstance(found, Count)
        assert (found.conditions, found.least) == (tuple(listed), least)


def test_other_forms_are_no_counts() -> None:
    """Two of three, but one case is missing; and conditions that differ in more than the index."""
    robot = robot_of(model(5, ""))
    one, two, three = (LITERALS[0](i) for i in (1, 2, 3))
    missing = disjunction([conjunction([one, two]), conjunction([two, three])])
    assert not any(isinstance(part, Count) for part in walk(with_counts(missing, robot)))
    mixed = at_least([one, LITERALS[1](2), three], 2)
    assert mixed is not None
    assert not any(isinstance(part, Count) for part in walk(with_counts(mixed, robot)))


def test_the_variable_has_a_name_that_is_free() -> None:
    text = model(3, "requirement always count(x.served for x in Station) < 2")
    other = "component s { behaviour { initial marked state t {} } }"
    text = text.replace("component Station", f"{other} component Station")
    robot = robot_of(text)
    assert (
        to_dsl(robot.requirements[0].condition, robot) == "count(ss.served for ss in Station) < 2"
    )


IDLE = "for i in 2..4 { requirement Station[i].serve needs Station[1].idle }"


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("requirement", "guard"),
    [
        ("never count(s.served for s in Station) > 2", "count(s.served for s in Station) < 2"),
        ("never all(s.served for s in Station)", "count(s.served for s in Station) < 3"),
        (
            f"never count(s.served for s in Station[2..4]) >= 3 {IDLE}",
            "Station[1].idle and count(s.served for s in Station[2..4]) < 2",
        ),
    ],
)
def test_guards_are_counts(requirement: str, guard: str, engine: str) -> None:
    """With the command's own component in it, which is not in the state when it is asked."""
    text = model(4, f"requirement {requirement}").replace(" do good := value", "")
    text = text.replace("variable good: boolean = false", "")
    supervisor = synthesize(plant_of(text), engine)
    assert guard_text(supervisor, "Station[3].serve.request") == (guard, "restricted")
    robot = robot_of(text)
    assert differences(robot, Oracle(robot), engine) == []


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_guards_of_many_copies_are_counts(engine: str) -> None:
    """What is counted is looked for before a cover of all cases is."""
    text = model(9, "requirement never count(s.served for s in Station) > 4")
    text = text.replace(" do good := value", "").replace("variable good: boolean = false", "")
    guards = synthesize(plant_of(text), engine).guards
    robot = robot_of(text)
    told = {to_dsl(guard.expr, robot) for guard in guards}
    assert told == {"count(s.served for s in Station) < 4"}
