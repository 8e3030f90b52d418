"""Whether two solutions of the symbolic engine are one controlled system."""

from __future__ import annotations

from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution

__all__ = ["assert_same"]


def assert_same(usual: SymbolicSolution, other: SymbolicSolution) -> None:
    assert other.restricted == usual.restricted
    assert other.plant_states == usual.plant_states
    assert other.controlled_states == usual.controlled_states
    for one, same in zip(usual.engine.events, other.engine.events, strict=True):
        if usual.engine.plant.events[one.number].controllable:
            counted = usual.engine.encoding.count(usual.enabled(one))
            assert other.engine.encoding.count(other.enabled(same)) == counted
        else:
            assert other.occurrences(same) == usual.occurrences(one)
