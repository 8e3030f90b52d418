"""From one state to the next, only what reads something that has changed is computed anew."""

from __future__ import annotations

import random
from typing import Any

import pytest
import steep_families
from data_models import data_model
from random_models import random_model
from synthesis.plants import supervisor_of

from robosc.runtime.core.values import Undefined
from robosc.traces.coverage import Case, Coverage
from robosc.traces.deciding_atoms import DecidedCondition
from robosc.traces.exact_steps import ExactStep, Results, State, Steps
from robosc.traces.samples import Samples
from robosc.traces.search import InputGraph

MODELS = {
    **{f"random-{n}": random_model(random.Random(n), 1 + n % 3) for n in range(12)},
    **{f"data-{n}": data_model(random.Random(n)) for n in range(6)},
    "swaps": steep_families.battery_swaps(1),
    "tools": steep_families.two_tools_each(2),
    "long": "component A { outgoing message m with type: integer(0..9) incoming message go with"
    " type: none behaviour { variable n: integer(0..9) on response from m do n := value"
    " initial marked state s {} } } requirement go needs "
    + " and ".join(f"(A.n != {n} or go_on)" for n in range(10))
    + " component B { outgoing message on with type: boolean behaviour { variable may: boolean"
    " on response from on do may := value initial marked state s {} } } condition go_on = B.may",
}


def reached(graph: InputGraph, most: int) -> list[State]:
    """States that inputs lead to, in an order in which each differs from the last in much."""
    graph.expand(graph.start)
    for node in list(graph._nodes.values())[:10]:
        graph.expand(node)
    states = [node.state for node in graph._nodes.values()]
    random.Random(1).shuffle(states)
    return states[:most]


@pytest.mark.parametrize("name", MODELS)
def test_results_are_those_that_are_computed_anew(name: str) -> None:
    supervisor = supervisor_of(MODELS[name])
    steps = Steps(supervisor)
    coverage = Coverage(steps)
    samples = Samples(steps.robot, [s.event for s in steps.steps], steps.fields)
    graph = InputGraph(steps, coverage, samples, coverage.cases.keys())
    for state in reached(graph, 30):
        again = Steps(supervisor)
        fresh = Coverage(again)
        anew = InputGraph(again, fresh, samples, fresh.cases.keys())
        assert [*graph._components(state)] == [*anew._components(state)]
        assert [*graph._obstacles(state)] == [*anew._obstacles(state)]
        assert coverage.of_state(state) == fresh.of_state(state)
        assert list(coverage.atoms(state)) == list(fresh.atoms(state))
        ways = [
            [(s.number, after) for s, _, after in each.settled(dict(state))]
            for each in (steps, again)
        ]
        assert ways[0] == ways[1]
        assert coverage.of_settled(dict(state)) == fresh.of_settled(dict(state))
        assert [s.number for s in again.commands if again.enabled(s, dict(state))] == [
            s.number
            for s, is_so in zip(steps.commands, steps._enabled(state), strict=True)
            if is_so
        ]


def test_an_input_of_one_of_many_concerns_a_few(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("oxidd")
    steps = Steps(supervisor_of(steep_families.chain(40), "bdd"))
    coverage = Coverage(steps)
    judged: list[int] = []
    of_command = Coverage.of_command

    def counted(self: Coverage, step: ExactStep, *rest: Any) -> set[Case]:
        judged.append(step.number)
        return of_command(self, step, *rest)

    monkeypatch.setattr(Coverage, "of_command", counted)
    (first,) = [s for s in steps.commands if steps.enabled(s, steps.initial)]
    coverage.of_state(steps.initial)
    assert len(judged) == 40
    judged.clear()
    after = first.after(steps.initial)
    assert after is not None
    coverage.of_state(after)
    assert 0 < len(judged) <= 3


def test_what_an_input_leaves_as_it_was_is_sent_without_being_judged_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = (
        "component Wheel[1..9] { incoming message turn with type: double provide turn with 0.5 }"
    )
    steps = Steps(supervisor_of(model))
    coverage = Coverage(steps)
    judged: list[str] = []

    def counted(of: type, name: str) -> None:
        method = getattr(of, name)

        def instead(self: Any, *rest: Any) -> Any:
            judged.append(name)
            return method(self, *rest)

        monkeypatch.setattr(of, name, instead)

    counted(Coverage, "of_command")
    counted(Steps, "demand_fitting")
    coverage.of_settled(steps.initial)
    assert sorted(judged) == 9 * ["demand_fitting"] + 9 * ["of_command"]
    judged.clear()
    coverage.of_settled(dict(steps.initial))
    assert judged == []


def test_what_stands_in_the_way_of_commands_is_judged_where_an_input_concerns_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = (
        "component Wheel[1..9] { incoming message turn with type: none"
        " outgoing message free with type: boolean outgoing message warm with type: boolean"
        " behaviour { variable is_free: boolean variable is_warm: boolean"
        " on response from free do is_free := value on response from warm do is_warm := value"
        " initial marked state s {} }"
        " requirement turn needs is_free requirement turn needs is_warm }"
    )
    steps = Steps(supervisor_of(model, "bdd"))
    coverage = Coverage(steps)
    samples = Samples(steps.robot, [s.event for s in steps.steps], steps.fields)
    graph = InputGraph(steps, coverage, samples, coverage.cases.keys())
    judged: list[DecidedCondition] = []
    possible = DecidedCondition.possible

    def counted(self: DecidedCondition, *rest: Any) -> Any:
        judged.append(self)
        return possible(self, *rest)

    monkeypatch.setattr(DecidedCondition, "possible", counted)
    changed = {**graph.start.state, "Wheel[3].is_warm": not graph.start.state["Wheel[3].is_warm"]}
    assert [*graph._obstacles(changed)] != [*graph.start.kinds[3]]
    assert len(judged) == 2
    assert [*graph._components(changed)] != [*graph.start.kinds[2]]


def test_what_is_undefined_is_tried_again() -> None:
    def needs(state: State) -> int:
        if state["a"] is None:
            raise Undefined
        return int(state["a"])

    results = Results([(needs, ["a"]), (lambda state: state["b"], ["b"])])
    assert results({"a": 1, "b": 2}) == [1, 2]
    with pytest.raises(Undefined):
        results({"a": None, "b": 3})
    assert results({"a": 1, "b": 3}) == [1, 3]


def test_only_readers_of_what_has_changed() -> None:
    calls: list[str] = []
    results = Results([(lambda s, k=k: calls.append(k), [k]) for k in "abc"])  # type: ignore[misc]
    state = dict.fromkeys("abc", 0)
    results(state)
    calls.clear()
    results({**state, "b": 1})
    assert calls == ["b"]


def test_the_way_to_where_a_run_was_has_a_beginning() -> None:
    """A run may be where the search has not been; from there, the search may come back to it."""
    steps = Steps(supervisor_of(MODELS["long"]))
    coverage = Coverage(steps)
    samples = Samples(steps.robot, [s.event for s in steps.steps], steps.fields)
    first, graph = (InputGraph(steps, coverage, samples, coverage.cases.keys()) for _ in range(2))
    first.expand(first.start)
    graph.node(list(first._nodes.values())[1].state)
    for node in list(graph._nodes.values())[1:]:
        graph.expand(node)
        for near in [edge[1] for edge in node.edges.values()]:
            graph.expand(near)
    for node in graph._nodes.values():
        passed = [node.number]
        while node.came is not None:
            node = node.came[0]
            assert node.number not in passed
            passed.append(node.number)
