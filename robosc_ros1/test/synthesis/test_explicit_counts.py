"""Exact sizes: families whose counts are known in closed form, and degenerate models."""

from __future__ import annotations

import math
from itertools import product

import families
import pytest
from synthesis.plants import guard_text, plant_of, supervisor_of

from robosc.errors import StateSpaceError
from robosc.synthesis import explore, synthesize
from robosc.synthesis.formatting import amount, contributors


def sizes(body: str) -> tuple[int, int, int]:
    found = supervisor_of(body)
    return found.plant_states, found.controlled_states, found.controlled_transitions


def walked(body: str) -> tuple[int, int, int]:
    """The same by walking state by state."""
    supervisor = supervisor_of(body)
    graph = explore(supervisor)
    return len(explore(supervisor.plant).states), len(graph.states), len(graph.transitions)


@pytest.mark.parametrize("n", [2, 3, 5, 7, 8])
def test_hands(n: int) -> None:
    plant, states, transitions = sizes(families.hands(n))
    assert (plant, states) == (4**n, 2**n * (2**n - 1))
    # The 3n outgoing messages are always possible. A hand starts where it and the next are idle and
    # its sensor is open: half of the sensors, a quarter of the hands.
    starts = n * 2 ** (n - 1) * 2 ** (n - 2)
    assert transitions == 3 * n * states + starts


def test_hands_at_the_published_sizes() -> None:
    assert sizes(families.hands(7))[1] == 16_256
    assert sizes(families.hands(8))[1] == 65_280


@pytest.mark.parametrize("n", [2, 4, 6])
def test_hands_with_services(n: int) -> None:
    plant, states, _ = sizes(families.services_hands(n))
    assert (plant, states) == (4**n, families.hands_states(n))


@pytest.mark.parametrize(("n", "k"), [(2, 1), (3, 2), (4, 3), (6, 2)])
def test_transfer_line(n: int, k: int) -> None:
    plant, states, _ = sizes(families.transfer_line(n, k))
    assert (plant, states) == (2**n * (k + 1) ** (n - 1), families.line_states(n, k))


@pytest.mark.parametrize(
    "text",
    [
        families.hands(3),
        families.services_hands(3),
        families.transfer_line(3, 2),
        families.action_robot(2),
    ],
    ids=["hands", "services", "line", "actions"],
)
def test_counts_are_those_of_a_walk(text: str) -> None:
    assert sizes(text) == walked(text)


DEGENERATE = {
    "nothing at all": ("", (1, 1, 0)),
    "a component without anything": ("component A {}", (1, 1, 0)),
    "messages without behaviour": (
        "component A { incoming message go with type: none outgoing message m with type: none }",
        (1, 1, 2),
    ),
    "one state": ("component A { behaviour { initial marked state only {} } }", (1, 1, 0)),
    "a variable of one value": (
        "component A { outgoing message m with type: integer(3..3)"
        " behaviour { variable x: integer(3..3) = 3"
        " initial marked state s { on response from m do x := value } } }"
        " component B { incoming message go with type: none }"
        " requirement go needs A.x = 3",
        (1, 1, 2),
    ),
    "a variable that never changes": (
        "component A { incoming message go with type: none"
        " behaviour { variable x: integer(-2..2) = 1 initial marked state s {} } }"
        " requirement go needs A.x = 1",
        (1, 1, 1),
    ),
    "an internal transition that changes nothing": (
        "component A { behaviour { initial marked state s { transition } } }",
        (1, 1, 1),
    ),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate(name: str) -> None:
    body, expected = DEGENERATE[name]
    assert sizes(body) == expected == walked(body)


def test_enum_of_64_values() -> None:
    rules = " ".join(f"value = {i} -> v{i}" for i in range(63))
    text = (
        f"datatype enum Big from integer to {{ {rules} default -> v63 }}"
        "component A { outgoing message m with type: Big outgoing message n with type: Big"
        " behaviour { variable x: Big variable y: Big initial marked state s {"
        " on response from m do x := value"
        " on response from n do y := value } } }"
        "component B { incoming message go with type: none }"
        "requirement go needs A.x != A.y"
    )
    assert sizes(text.replace("type: Big", "type: Big links link")) == (
        64 * 64,
        64 * 64,
        64 * 64 * 128 + 64 * 63,
    )


def test_many_constant_components() -> None:
    """40 constant components around three that move."""
    still = [
        f"component C{i} {{ behaviour {{ initial marked state a {{}} marked state b {{}} }} }}"
        for i in range(40)
    ]
    moving = [
        f"component D{i} {{ outgoing message m{i} with type: none behaviour {{"
        f" initial marked state a {{ on response from m{i} goto b }}"
        f" marked state b {{ on response from m{i} goto a }} }} }}"
        for i in range(3)
    ]
    parts = [*still[:15], moving[0], *still[15:30], moving[1], *still[30:], moving[2]]
    assert sizes("".join(parts)) == (8, 8, 24)


def test_guard_over_many_state_variables() -> None:
    count = 15
    sensors = "".join(
        f"component S{i} {{ outgoing message m{i} with type: boolean behaviour {{"
        f" variable x: boolean"
        f" initial marked state s {{ on response from m{i} do x := value }} }} }}"
        for i in range(count)
    )
    needs = " or ".join(f"(S{i}.x and !S{i + 1}.x)" for i in range(count - 1))
    text = f"{sensors} component B {{ incoming message go with type: none }}"
    falling = supervisor_of(f"{text} requirement go needs {needs}")
    # No true is followed by a false in the rising sequences alone.
    states = 2**count
    assert falling.controlled_states == states
    assert falling.controlled_transitions == states * 2 * count + states - (count + 1)


def test_event_with_many_automata() -> None:
    """Nine components with three states each listen to one message: 4^9 choices at once."""
    listeners = "".join(
        f"component L{i} {{ outgoing message up{i} with type: none behaviour {{"
        f" initial marked state a {{ on response from up{i} goto b on response from stop goto a }}"
        f" marked state b {{ on response from up{i} goto c on response from stop goto a }}"
        f" marked state c {{ on response from stop goto b }} }} }}"
        for i in range(9)
    )
    text = f"component E {{ outgoing message stop with type: none }} {listeners}"
    found = supervisor_of(text)
    assert found.controlled_states == 3**9
    assert found.controlled_transitions == 3**9 * 10


def test_automata_that_read_each_other() -> None:
    """All exchange their values round a ring at once: each reads what its neighbour had before."""
    count = 5
    ring = "".join(
        f"component P{i} {{ outgoing message set{i} with type: boolean behaviour {{"
        f" variable x: boolean initial marked state s {{"
        f" on response from set{i} do x := value"
        f" on response from turn if P{(i + 1) % count}.x do x := true"
        f" on response from turn if !P{(i + 1) % count}.x do x := false }} }} }}"
        for i in range(count)
    )
    text = f"component E {{ outgoing message turn with type: none }} {ring}"
    found = supervisor_of(text)
    graph = explore(found)
    assert len(graph.states) == found.controlled_states == 2**count
    turn = next(n for n, e in enumerate(found.plant.events) if e.name == "turn")
    for step in graph.transitions:
        if step.event == turn:
            before = [graph.states[step.source][2 * i + 1] for i in range(count)]
            after = [graph.states[step.target][2 * i + 1] for i in range(count)]
            assert after == before[1:] + before[:1]


def test_too_large_names_the_contributors() -> None:
    text = (
        "component A { outgoing message m with type: integer(0..999)"
        " outgoing message n with type: boolean behaviour {"
        " variable far: integer(0..999) variable near: boolean"
        " initial marked state s { on response from m do far := value"
        " on response from n do near := value } }"
        " incoming message go with type: none }"
        " requirement go needs A.far > 3 or A.near"
    )
    plant = plant_of(text)
    with pytest.raises(StateSpaceError, match=r"more than 1999 states.* A\.far \(1000 values\)"):
        synthesize(plant, "explicit", 1999)
    assert synthesize(plant, "explicit", 2000).controlled_states == 2000


def test_contributors_of_one_size_are_told_together() -> None:
    assert contributors([("a", 2), ("b", 10), ("c", 2)]) == "b (10 values), a and c (2 values each)"
    many = [(f"v{n}", 2) for n in range(20_000)]
    assert contributors(many) == "v0, v1 and 19998 others (2 values each)"
    assert contributors(("v", size) for size in range(2, 9)).startswith(
        "v (8 values), v (7 values)"
    )


def test_counts_with_thousands_of_digits_are_told() -> None:
    assert amount(2**15_000) == "about 10^4515"
    assert [amount(10**24), amount(10**12 - 1)] == ["about 10^24", "999999999999"]


def test_what_cannot_be_visited_is_refused() -> None:
    many = "".join(
        f"component S{i} {{ outgoing message m{i} with type: integer(0..99) behaviour {{"
        f" variable x: integer(0..99) initial marked state s {{ on response from m{i} do x := value"
        f" }} }} incoming message go{i} with type: none }}"
        f" requirement go{i} needs S{i}.x > S{(i + 1) % 12}.x "
        for i in range(12)
    )
    with pytest.raises(StateSpaceError, match=r"more than 1000 states"):
        synthesize(plant_of(many), "explicit", 1000)


def test_only_reached_states_count() -> None:
    """The product of services that components mirror is 8^n; 4^n are reached."""
    plant = plant_of(families.services_hands(6))
    assert synthesize(plant, "explicit", 4**6).controlled_states == families.hands_states(6)
    with pytest.raises(StateSpaceError):
        synthesize(plant, "explicit", 100)


def test_what_requirements_hold_together_is_counted_in_parts() -> None:
    """The plant has 20^8 states without its requirement; those with all apart are few."""
    walkers = "".join(
        f"component W{i} {{ incoming message go{i} with type: none behaviour {{"
        f" variable at: integer(0..19) = {i}"
        f" initial marked state s {{ on request to go{i} do at := at + 1 }} }} }}"
        for i in range(8)
    )
    order = " and ".join(f"W{i}.at < W{i + 1}.at and W{i + 1}.at - W{i}.at < 3" for i in range(7))
    found = supervisor_of(f"{walkers} requirement always {order}")
    assert found.plant_states == math.prod(20 - i for i in range(8))
    # Seven steps of one or two between neighbours, and the first one wherever there is room.
    gaps = [list(g) for g in product((1, 2), repeat=7)]
    assert found.controlled_states == sum(20 - sum(gap) for gap in gaps)


def test_range_left_by_an_uncontrollable_event_is_avoided() -> None:
    found = supervisor_of(families.transfer_line(3, 2))
    assert guard_text(found, "work0.request") == ("Buffer0.level <= 1", "restricted")
    assert guard_text(found, "work2.request") == ("Buffer1.level > 0", "as required")
