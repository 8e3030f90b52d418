"""Traces where looking for them is bounded: by the events that concern them, or none."""

from __future__ import annotations

import random

import families
import pytest
from quick import quick_first
from random_models import random_model
from synthesis.plants import plant_of, replay

from robosc.language.events import EventKind
from robosc.plant.step import Verdict
from robosc.supervisor import Supervisor
from robosc.synthesis.bdd.cones import Cones
from robosc.synthesis.bdd.relaxed import Relaxation
from robosc.synthesis.bdd.search import SymbolicSystem
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine
from robosc.synthesis.bdd.synthesize import synthesize_bdd
from robosc.synthesis.explain.starts import UNTRACED
from robosc.synthesis.result import Sizes, Solved

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")

SMALL = 2**25


def bounded(whole: Supervisor, most_nodes: int, most_work: int) -> Supervisor:
    """Return a supervisor with the explanations that a bounded search finds."""
    system = SymbolicSystem(
        SymbolicEngine(whole.plant, memory=SMALL).solve(), whole.guards, most_nodes, most_work
    )
    sizes = Sizes(whole.plant_states, whole.controlled_states, whole.controlled_transitions)
    return Solved(system, "bdd", 0.0, sizes, whole.guards).explained()


@pytest.mark.parametrize("seeds", quick_first([range(15), range(15, 60)], 1))
def test_without_traces_the_same_is_told(seeds: range) -> None:
    """Each diagnostic has its place and code; what begins in some state says that it does."""
    untraced = 0
    for seed in seeds:
        whole = synthesize_bdd(
            plant_of(random_model(random.Random(seed), 1 + seed % 3)), None, SMALL
        ).explained()
        found = bounded(whole, 0, 0)
        told = [(d.code, d.span, d.severity) for d in found.diagnostics]
        assert told == [(d.code, d.span, d.severity) for d in whole.diagnostics]
        assert [e.event for e in found.explanations] == [e.event for e in whole.explanations]
        for explanation in found.explanations:
            assert explanation.traced != (UNTRACED in explanation.reason)
            assert explanation.traced or not explanation.trace
            untraced += not explanation.traced
    assert untraced > len(seeds) / 12


def test_a_reason_without_trace_tells_where_it_begins() -> None:
    whole = synthesize_bdd(plant_of(families.transfer_line(2, 2)), None, SMALL).explained()
    reasons = [e.reason for e in bounded(whole, 0, 0).explanations]
    assert reasons
    assert all(UNTRACED in reason and ": where " in reason for reason in reasons)
    assert not any(" true" in reason for reason in reasons)


@pytest.mark.parametrize("family", ["transfer_line", "philosophers"])
def test_paths_through_cones_can_be_replayed(family: str) -> None:
    """With nothing left for a search breadth first, all traces go through cones."""
    sizes = {"transfer_line": (4, 3), "philosophers": (6,)}
    whole = synthesize_bdd(
        plant_of(getattr(families, family)(*sizes[family])), None, SMALL
    ).explained()
    found = bounded(whole, 0, 10**9)
    assert found.explanations
    for explanation in found.explanations:
        assert explanation.traced
        assert isinstance(replay(found.plant, explanation.trace), Verdict | tuple)


def test_what_stands_apart_is_in_no_trace() -> None:
    """The first machines of a line explain themselves, however long the line is."""
    lengths = set()
    for length in (3, 12):
        whole = synthesize_bdd(plant_of(families.transfer_line(length, 2)), None, 2**28).explained()
        found = bounded(whole, 0, 100_000)
        first = next(e for e in found.explanations if e.trace)
        lengths.add(len(first.trace))
    assert len(lengths) == 1


def test_what_a_trace_does_not_need_stands_still() -> None:
    """A machine of a line needs what those before it achieve, and nothing else."""
    plant = plant_of(families.transfer_line(6, 2))
    solution = SymbolicEngine(plant, memory=SMALL).solve()
    engine = solution.engine
    cones = Cones(solution, synthesize_bdd(plant, memory=SMALL).guards)
    relaxation = Relaxation(engine, {e.number: cones.moves(e.number) for e in engine.events})
    for machine in range(6):
        (last,) = (
            event
            for event in engine.events
            if plant.events[event.number].name == f"work{machine}"
            and plant.events[event.number].kind is EventKind.REQUEST
        )
        needed = {
            (plant.events[n].name, plant.events[n].kind)
            for n in relaxation.events(solution.states & last.possible)
        }
        assert needed == {
            (f"work{before}", kind)
            for before in range(machine)
            for kind in (EventKind.REQUEST, EventKind.RESPONSE)
        }
