"""Parameters of the node in the plant: what they come to is not known at the start."""

from __future__ import annotations

import random

import pytest
from emit.generated_code import supervisor_of
from synthesis.explored import explore_document

from robosc import pipeline
from robosc.model.resolve import load
from robosc.plant.automaton import VariableKind
from robosc.plant.build import lower
from robosc.plant.step import holds
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import explore

ENGINES = ("explicit", "bdd")


def synthesized(text: str, engine: str) -> Supervisor:
    robot, diagnostics = load(Source("model.rscd", text))
    assert robot is not None, diagnostics
    return pipeline.synthesize(robot, engine)


CELL = """robot Cell {
    parameter fast: boolean = false
    parameter limit: double = 0.5
    parameter other: boolean = true
    component Motor {
        incoming message move with type: none
        outgoing message bump with type: none
        behaviour {
            initial marked state still { on request to move goto moving %s }
            marked state moving { }
            state stuck { on response from bump if !fast goto still }
        }
    }
    %s
}
"""


@pytest.mark.parametrize("engine", ENGINES)
def test_an_empty_supervisor_names_the_outcome_that_is_to_blame(engine: str) -> None:
    bump = "on response from bump if fast and limit > 2.0 goto stuck"
    found = synthesized(CELL % (bump, "requirement move needs other"), engine)
    assert found.empty
    (why,) = found.explanations
    assert why.reason == (
        "no controller can satisfy the requirements: if fast and limit > 2.0 at the start, after"
        " bump.response, which no controller can prevent, Motor is stuck in Motor.stuck, from"
        " where no marked state can be reached"
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_an_explanation_names_the_outcome_that_matters(engine: str) -> None:
    never = "requirement never Motor.moving and limit > 2.0 requirement move needs other or fast"
    found = synthesized(CELL % ("", never), engine)
    (guard,) = found.guards
    assert guard.status == "restricted"
    (why,) = found.explanations
    assert why.reason == (
        "move.request is restricted further: if limit > 2.0 at the start, after move.request,"
        " 'requirement never Motor.moving and limit > 2.0' fails"
    )


def test_a_parameter_is_a_number_and_not_nan() -> None:
    both = "requirement move needs limit > 2.0 requirement never Motor.moving and limit <= 1.0"
    plant = supervisor_of(CELL % ("", both)).plant
    (limit,) = (v for v in plant.variables if v.name == "limit")
    labels = [limit.shown(index) for index in limit.start_indexes]
    assert labels == ["limit <= 1.0", "!(limit <= 1.0 or limit > 2.0)", "limit > 2.0"]
    assert limit.kind is VariableKind.TEST
    assert len(list(plant.initial_states)) == 6  # with those of fast


def test_all_initial_states_are_explored_and_told() -> None:
    supervisor = supervisor_of(CELL % ("", "requirement move needs other and fast"))
    graph = explore(supervisor)
    assert graph.starts == 4
    assert graph.states[:4] == tuple(supervisor.plant.initial_states)
    document = explore_document(graph)
    assert (document["initial"], document["initials"]) == (0, [0, 1, 2, 3])
    first = document["states"][0]["variables"]
    assert first == {"other": True, "fast": False}  # the defaults come first
    assert "initials" not in explore_document(explore(supervisor_of("robot R { }")))


UNION = """robot Union {{
    {declared}
    component Counter {{
        outgoing message tick with type: none
        incoming message go with type: none
        incoming message back with type: none
        behaviour {{
            variable n: integer(0..3) = {start}
            on response from tick if n {op1} p do n := {value}
            initial marked state low {{ on request to go if n {op2} 2 goto high }}
            {marked} state high {{
                on request to back goto low
                on response from tick if n = {number} goto {target}
            }}
        }}
    }}
    requirement go needs n_is or Counter.n {op3} p
    condition n_is = Counter.n = {other}
    requirement never Counter.n {op4} p and Counter.n > {low}
}}
"""


def union_models(rng: random.Random) -> list[str]:
    """The same robot with a parameter, and with a constant for each of its values."""

    def op() -> str:
        return rng.choice(["=", "!=", "<", "<=", ">", ">="])

    parts = {
        "start": rng.randint(0, 3), "op1": op(), "op2": op(), "op3": op(), "op4": op(),
        "value": rng.choice(["p", "3 - n", str(rng.randint(0, 3)), "3 - p"]),
        "marked": rng.choice(["marked", ""]), "number": rng.randint(0, 3),
        "target": rng.choice(["low", "high"]), "other": rng.randint(0, 3),
        "low": rng.choice([0, 1, 3, 3]),
    }  # fmt: skip
    declared = ["parameter p: integer(0..3) = 1"]
    declared += [f"constant p: integer = {value}" for value in range(4)]
    return [UNION.format(declared=one, **parts) for one in declared]


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_parameter_is_the_union_of_its_values(engine: str) -> None:
    seen = set()
    for seed in range(30):
        whole, *each = (synthesized(text, engine) for text in union_models(random.Random(seed)))
        seen.add(whole.empty)
        assert whole.empty == any(one.empty for one in each), seed
        if whole.empty:
            continue
        if not any(v.name == "p" for v in whole.plant.variables):
            each = each[:1]  # nothing depends on it
        for figure in ("plant_states", "controlled_states", "controlled_transitions"):
            assert getattr(whole, figure) == sum(getattr(one, figure) for one in each), seed
        states = explore(whole).states
        index = next((n for n, v in enumerate(whole.plant.variables) if v.name == "p"), None)
        for one, value in zip(each, range(4), strict=False):
            here = {
                tuple(v for n, v in enumerate(state) if n != index): state
                for state in states
                if index is None or state[index] == value
            }
            alone = explore(one).states
            assert set(here) == set(alone), seed
            for guard, other in zip(whole.guards, one.guards, strict=True):
                for state in alone:
                    allowed = holds(whole.plant, guard.expr, here[state])
                    if allowed != holds(one.plant, other.expr, state):
                        # Where the plant cannot do the event, a guard means nothing.
                        assert not _possible(one, guard.event.key, state), (seed, state)
    assert seen == {True, False}


def _possible(supervisor: Supervisor, key: str, state: tuple[int, ...]) -> bool:
    graph = explore(lower(supervisor.plant.robot))
    number = graph.states.index(state)
    return any(
        t.source == number and graph.plant.events[t.event].key == key
        and graph.plant.events[t.event].controllable
        for t in graph.transitions
    )  # fmt: skip
