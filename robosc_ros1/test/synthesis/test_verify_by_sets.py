"""Verification set by set tells the same as state by state, of right and of wrong supervisors."""

from __future__ import annotations

import gc
import random
import weakref
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import pytest
import steep_families
from random_models import random_model
from synthesis.plants import supervisor_of
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.errors import StateSpaceError
from robosc.expr.tree import FALSE, TRUE
from robosc.report import verify_text
from robosc.supervisor import Supervisor
from robosc.synthesis.bdd import manager
from robosc.synthesis.verify import symbolic
from robosc.synthesis.verify.verification import verify
from robosc.synthesis.verify.verify_report import VerifyReport, verify_document

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")


def told(report: VerifyReport) -> object:
    """All but traces, and which of several faults is told; behind an unsafe step nothing counts."""
    safe = all(check.holds for check in report.checks if check.name == "safe")
    sizes = (report.states, report.transitions) if safe else None
    return [(check.name, check.holds) for check in report.checks], sizes


def wrong(supervisor: Supervisor) -> Iterator[Supervisor]:
    """The same with one guard too weak, too strong, and with wrong sizes."""
    for number, guard in enumerate(supervisor.guards):
        for expr in (TRUE, FALSE, guard.required):
            guards = list(supervisor.guards)
            guards[number] = replace(guard, expr=expr)
            yield replace(supervisor, guards=tuple(guards))
    yield replace(supervisor, guards=supervisor.guards[1:])
    yield replace(supervisor, plant_states=supervisor.plant_states + 1)
    yield replace(supervisor, controlled_states=supervisor.controlled_states + 1)
    yield replace(supervisor, controlled_transitions=supervisor.controlled_transitions + 1)


@pytest.mark.slow
def test_random_supervisors() -> None:
    found = failing = 0
    for seed in range(6):
        robot = robot_of(random_model(random.Random(seed), 1 + seed % 2))
        right = pipeline.synthesize(robot, "explicit")
        for supervisor in (right, *wrong(right)):
            report = verify(supervisor, limit=0)
            assert report.method == "symbolic"
            assert told(report) == told(verify(supervisor)), seed
            found += 1
            failing += not report.verified
        assert verify(right, limit=0).verified, seed
    assert 0 < failing < found


def test_what_is_too_large_to_visit_each_state() -> None:
    supervisor = supervisor_of(steep_families.chain(30), "bdd")
    report = verify(supervisor)
    assert report.verified
    assert report.states == 2**30
    assert "set" in verify_text(report).splitlines()[1]
    assert verify_document(report, str)["method"] == "symbolic"


def stop_for_all(n: int) -> str:
    """A stop to which n components react, each in its own states: 3^n combinations."""
    parts = [
        f"""component M{i} {{
            incoming message go{i} with type: none
            outgoing message end{i} with type: none
            behaviour {{
                initial marked state rests {{
                    on request to go{i} goto works
                    on response from stop if value goto halted
                }}
                state works {{
                    on response from end{i} goto rests
                    on response from stop if value goto halted
                }}
                state halted {{ on response from stop if !value goto rests }}
            }}
        }}
        requirement go{i} needs !Stop.on
        """
        for i in range(n)
    ]
    stop = """component Stop {
        outgoing message stop with type: boolean
        behaviour {
            variable on: boolean
            initial marked state s { on response from stop do on := value }
        }
    }"""
    return " ".join([stop, *parts])


def test_an_event_of_many_components_needs_no_table_of_all() -> None:
    report = verify(supervisor_of(stop_for_all(21), "bdd"))
    assert report.verified
    assert report.method == "symbolic"
    assert report.states == 2**21 + 1  # halted all at once, or none


def test_a_sum_of_many_variables_needs_no_table_of_all() -> None:
    report = verify(supervisor_of(steep_families.budget(13, 20), "bdd"))
    assert report.verified
    assert report.method == "symbolic"


def test_what_reads_too_many_values_is_refused() -> None:
    with pytest.raises(StateSpaceError, match=r"values of Gauge0\.level, Gauge1\.level"):
        verify(supervisor_of(steep_families.gauges(1100), "bdd"))


def test_very_many_transitions_are_taken_by_sets() -> None:
    supervisor = supervisor_of(steep_families.restless(18))
    assert supervisor.plant_states < 2**20 < 2**22 < supervisor.controlled_transitions
    assert verify(supervisor).method == "symbolic"


def test_small_systems_are_visited_state_by_state() -> None:
    assert verify(supervisor_of(steep_families.crew(4))).method == "explicit"


def test_diagrams_of_synthesis_are_gone_before_there_are_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Both together took 390 MB for missions 12 8, and each 260."""
    alive: weakref.WeakSet[manager.Manager] = weakref.WeakSet()
    beside = []
    make = manager.Manager.__init__

    def made(self: manager.Manager, *size: int) -> None:
        beside.append(len(alive))
        make(self, *size)
        alive.add(self)

    monkeypatch.setattr(manager.Manager, "__init__", made)
    robot = robot_of(random_model(random.Random(1), 2))
    gc.disable()
    try:
        assert verify(pipeline.synthesize(robot, "bdd"), limit=0).verified
    finally:
        gc.enable()
    assert beside == [0, 0]


@pytest.mark.slow
def test_the_other_direction_of_the_order_proves_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each direction alone, and in turn where a try takes more nodes than it may."""
    monkeypatch.setattr(symbolic, "_MANY_NODES", 1)
    monkeypatch.setattr(manager, "_AMPLE_NODES", 0)
    for seed in range(2):
        right = pipeline.synthesize(robot_of(random_model(random.Random(7_300 + seed))))
        for judged in (right, *islice(wrong(right), 3)):
            forth, back = (
                symbolic._Proof(judged, None, reverse, 2**60).found() for reverse in (False, True)
            )
            assert forth == back
            assert symbolic.search_by_sets(judged) == forth
