"""Exact sizes, guards and reasons of systems that no array could hold."""

from __future__ import annotations

import families
import pytest
import steep_families
from synthesis.plants import explanation_of, guard_text, plant_of, replay, supervisor_of

from robosc.plant.step import Verdict
from robosc.synthesis.bdd.synthesize import synthesize_bdd

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")


def test_sixty_hands() -> None:
    found = synthesize_bdd(plant_of(families.hands(60))).supervisor
    states = families.hands_states(60)
    assert states > 10**36
    assert (found.plant_states, found.controlled_states) == (4**60, states)
    # 180 outgoing messages are always possible; a start needs its sensor and two of the hands.
    assert found.controlled_transitions == 180 * states + 60 * 2**59 * 2**58
    assert guard_text(found, "start0.request") == ("Sensor0.open and Hand1.idle", "as required")


def test_priorities_are_not_counted_through() -> None:
    """Where the highest waiting station goes first, single events would count up to 2^40."""
    found = synthesize_bdd(plant_of(steep_families.priorities(40))).supervisor
    assert found.plant_states == found.controlled_states == 2 * 3**40


def test_forty_hands_with_services() -> None:
    found = synthesize_bdd(plant_of(families.services_hands(40))).supervisor
    assert (found.plant_states, found.controlled_states) == (4**40, families.hands_states(40))


@pytest.mark.parametrize(("n", "k"), [(2, 1), (3, 2), (6, 40), (16, 3)])
def test_transfer_line(n: int, k: int) -> None:
    found = synthesize_bdd(plant_of(families.transfer_line(n, k))).supervisor
    assert found.plant_states == 2**n * (k + 1) ** (n - 1)
    assert found.controlled_states == families.line_states(n, k)
    assert guard_text(found, f"work{n - 2}.request")[1] == "restricted"


def test_the_reason_in_a_long_line_is_the_overflow() -> None:
    n, k = 16, 3
    plant = plant_of(families.transfer_line(n, k))
    found = synthesize_bdd(plant).explained()
    for i in (0, 7, 14):
        reason = explanation_of(found, f"work{i}.request")
        assert f"Buffer{i}.level leaves its range 0..{k}" in reason.reason
        assert replay(plant, reason.trace) is Verdict.OUT_OF_RANGE
        # Each of k + 1 parts takes two steps in each machine up to here.
        assert len(reason.trace) == 2 * (k + 1) * (i + 1)


@pytest.mark.slow
def test_a_guard_over_all_others() -> None:
    """All but one philosopher wait: 3^24 combinations of what the guard of the last one reads."""
    found = synthesize_bdd(plant_of(families.philosophers(25))).supervisor
    text, status = guard_text(found, "first0.request")
    assert status == "restricted"
    assert text.startswith("!Phil24.eating and (")
    assert sorted(text.removeprefix("!Phil24.eating and (").rstrip(")").split(" or ")) == sorted(
        f"Phil{i}.thinking" for i in range(1, 25)
    )


@pytest.mark.parametrize("n", [3, 5, 8])
def test_small_tables_still(n: int) -> None:
    symbolic = supervisor_of(families.philosophers(n), "bdd")
    explicit = supervisor_of(families.philosophers(n), "explicit")
    assert symbolic.guards == explicit.guards
    assert symbolic.controlled_transitions == explicit.controlled_transitions


def test_product_beyond_64_bits() -> None:
    """Seventy switches and nothing else: more states than an index of 64 bits could number."""
    needs = " and ".join(f"S{i}.x" for i in range(70))
    found = supervisor_of(
        f"{families.switches(70)} component B {{ incoming message go with type: none }}"
        f" requirement go needs {needs}",
        "auto",
    )
    assert found.engine == "bdd"
    assert found.controlled_states == 2**70
    assert found.controlled_transitions == 2**70 * 140 + 1


@pytest.mark.slow
def test_gauges_are_compared_by_bits() -> None:
    """Two thousand five hundred values each, whose pairs nobody could look at."""
    found = supervisor_of(steep_families.gauges(2500), "bdd")
    assert found.controlled_states == 2500**2
    close = sum(min(2499, x + 10) - max(0, x - 10) + 1 for x in range(2500))
    assert found.controlled_transitions == 2500**2 * 5000 + close


def test_wide_variables_copied_and_compared() -> None:
    """A thousand values each: relations, not one disjunct per value."""
    found = supervisor_of(
        "component A { outgoing message m with type: integer(0..999)"
        " outgoing message copy with type: none behaviour {"
        " variable x: integer(0..999) variable y: integer(0..999)"
        " initial marked state s { on response from m do x := value"
        " on response from copy do y := x } } incoming message go with type: none }"
        " requirement go needs A.x < A.y",
        "bdd",
    )
    assert found.controlled_states == 1000 * 1000
    assert found.controlled_transitions == 1000 * 1000 * 1001 + 1000 * 999 // 2


def test_automata_that_read_each_other() -> None:
    """All take over their neighbour's value at once: each reads what was there before."""
    count = 6
    ring = "".join(
        f"component P{i} {{ outgoing message set{i} with type: boolean behaviour {{"
        f" variable x: boolean initial marked state s {{"
        f" on response from set{i} do x := value"
        f" on response from turn do x := P{(i + 1) % count}.x }} }} }}"
        for i in range(count)
    )
    text = f"component E {{ outgoing message turn with type: none }} {ring}"
    needs = " or ".join(f"P{i}.x" for i in range(count))
    text += (
        " component W { incoming message go with type: none behaviour {"
        " initial marked state a { on request to go goto b }"
        " state b { on response from turn goto a } } }"
        f" requirement go needs {needs}"
    )
    symbolic, explicit = supervisor_of(text, "bdd"), supervisor_of(text, "explicit")
    assert symbolic.controlled_states == explicit.controlled_states == 2 * 2**count
    assert symbolic.controlled_transitions == explicit.controlled_transitions
    assert symbolic.guards == explicit.guards


@pytest.mark.slow
def test_a_guard_reads_more_variables_than_a_sum_of_products_may() -> None:
    """No two of a pair may be on when the second of two messages comes, which nobody prevents."""
    pairs = range(101)
    switch = """
        component {0} {{
            incoming message on_{0} with type: none
            incoming message off_{0} with type: none
            behaviour {{
                initial marked state off {{ on request to on_{0} goto lit }}
                marked state lit {{ on request to off_{0} goto off }}
            }}
        }}
    """
    both = " or ".join(f"A{i}.lit and B{i}.lit" for i in pairs)
    text = f"""
        {"".join(switch.format(f"{side}{i}") for i in pairs for side in "AB")}
        component Press {{
            incoming message go with type: none
            outgoing message near with type: none
            outgoing message down with type: none
            outgoing message up with type: none
            behaviour {{
                initial marked state open {{ on request to go goto closing }}
                state closing {{ on response from near goto near_ }}
                state near_ {{ on response from down goto closed }}
                state closed {{ on response from up goto open }}
            }}
        }}
        requirement never Press.closed and ({both})
    """
    guard, status = guard_text(synthesize_bdd(plant_of(text)).supervisor, "go.request")
    assert status == "restricted"
    assert sorted(guard.split(" and ")) == sorted(f"(A{i}.off or B{i}.off)" for i in pairs)
