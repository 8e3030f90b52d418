"""Several of a kind are written out before names are resolved."""

from __future__ import annotations

from itertools import product

import pytest

from robosc.errors import render_all
from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, StateRef
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.names import Copy
from robosc.plant.build import lower
from robosc.source import Source

STATION = """
    component Station[1..3] {
        outgoing message call with identifier: "/station_{index}/call", type: none
        incoming message go with type: none
        behaviour {
            variable number: integer(0..9) = index
            initial marked state idle {
                on response from call do number := index * 2 goto waiting
                transition if Station[index % 3 + 1].waiting and number > 0
            }
            state waiting {
                on request to go goto idle
            }
        }
    }
"""


def resolved(text: str) -> Robot:
    robot, diagnostics = load(
        Source("model.rscd", f"robot R {{ {text} }}"), definitions=MessageDefinitions()
    )
    assert robot is not None, render_all(diagnostics)
    told = {d.code for d in diagnostics}
    assert told <= {"unused-variable", "stale-event"}, render_all(diagnostics)
    return robot


def needs(condition: str) -> dict[int, bool]:
    """A requirement on each way in which three stations may wait: bit i is station i + 1."""
    robot = resolved(f"{STATION} requirement Station[1].go needs {condition}")
    (requirement,) = robot.requirements
    found = {}
    for bits in product((False, True), repeat=3):
        waiting = {f"Station[{n}]": bit for n, bit in enumerate(bits, 1)}

        def lookup(leaf: object, waiting: dict[str, bool] = waiting) -> bool:
            assert isinstance(leaf, StateRef)
            return waiting[leaf.component] == (leaf.state == "waiting")

        found[sum(bit << n for n, bit in enumerate(bits))] = bool(
            evaluate(requirement.condition, lookup)
        )
    return found


def test_each_copy_has_its_index_in_names_strings_and_values() -> None:
    robot = resolved(STATION)
    assert [c.name for c in robot.components] == ["Station[1]", "Station[2]", "Station[3]"]
    assert {c.key: c.identifier for c in robot.communications.values()} == {
        "Station[1].call": "/station_1/call", "Station[1].go": "station_1/go",
        "Station[2].call": "/station_2/call", "Station[2].go": "station_2/go",
        "Station[3].call": "/station_3/call", "Station[3].go": "station_3/go",
    }  # fmt: skip
    starts = [c.behaviour.variables[0].initial for c in robot.components if c.states]
    assert starts == [1, 2, 3]


def test_copies_mean_what_components_written_one_by_one_mean() -> None:
    by_hand = "".join(
        STATION.replace("Station[1..3]", f"Station{n}")
        .replace("Station[index % 3 + 1]", f"Station{n % 3 + 1}")
        .replace("{index}", str(n))
        .replace("index", str(n))
        .replace("message call", f"message call{n}")
        .replace("from call", f"from call{n}")
        .replace("message go with", f'message go{n} with identifier: "station_{n}/go",')
        .replace("to go", f"to go{n}")
        for n in (1, 2, 3)
    )
    one, other = lower(resolved(STATION)), lower(resolved(by_hand))
    assert [(v.kind, v.values, v.initial) for v in one.variables] == [
        (v.kind, v.values, v.initial) for v in other.variables
    ]
    assert [(e.kind, len(e.automata)) for e in one.events] == [
        (e.kind, len(e.automata)) for e in other.events
    ]


def test_for_repeats_statements_and_conditions_in_it() -> None:
    robot = resolved(
        STATION
        + """
        for i in 1..3 {
            condition other = Station[i % 3 + 1].waiting
            requirement Station[i].go needs other
            for j in 1..2 { requirement Station[j].go needs Station[i].waiting }
        }
        """
    )
    named = [r for r in robot.requirements if "other" in r.text]
    assert [(r.communications, r.text[-7:]) for r in named] == [
        (("Station[1].go",), "(i = 1)"),
        (("Station[2].go",), "(i = 2)"),
        (("Station[3].go",), "(i = 3)"),
    ]
    conditions = [r.condition for r in named]
    assert [c.component for c in conditions if isinstance(c, StateRef)] == [
        "Station[2]", "Station[3]", "Station[1]",
    ]  # fmt: skip
    assert len(robot.requirements) == 9


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("any(s.waiting for s in Station)", lambda n: n > 0),
        ("all(s.waiting for s in Station)", lambda n: n == 3),
        ("count(s.waiting for s in Station) < 2", lambda n: n < 2),
        ("count(s.waiting for s in Station) <= 2", lambda n: n <= 2),
        ("count(s.waiting for s in Station) = 2", lambda n: n == 2),
        ("count(s.waiting for s in Station) != 1", lambda n: n != 1),
        ("count(s.waiting for s in Station) >= 1", lambda n: n >= 1),
        ("2 < count(s.waiting for s in Station)", lambda n: n > 2),
        ("2 >= count(s.waiting for s in Station)", lambda n: n <= 2),
        ("count(s.waiting for s in Station) >= 0", lambda n: True),
        ("count(s.waiting for s in Station) > 3", lambda n: False),
    ],
)
def test_conditions_over_all_components(condition: str, holds: object) -> None:
    assert callable(holds)
    for bits, value in needs(f"{condition} and (Station[1].idle or Station[1].waiting)").items():
        assert value == holds(bits.bit_count()), f"{condition} with {bits:03b}"


def test_conditions_over_some_components() -> None:
    slice_ = needs("any(s.waiting for s in Station[2..3])")
    assert slice_ == {bits: bits & 0b110 != 0 for bits in range(8)}
    filtered = needs("all(s.waiting for s in Station if !Station[1].waiting)")
    assert filtered == {bits: bits in (0b111,) or bits & 1 != 0 for bits in range(8)}


@pytest.mark.parametrize("first", [-2, -1, 0])
@pytest.mark.parametrize(("low", "high"), [(0, 0), (0, 1), (1, 1), (0, 2)])
def test_a_bound_of_some_components_may_be_zero(first: int, low: int, high: int) -> None:
    """The bounds of a part of a family are numbers like all others: 0 is none that is left out."""
    robot = resolved(
        f"""
        component Gate[{first}..{first + 2}] {{
            outgoing message call with type: none
            incoming message go with type: none
            behaviour {{
                initial marked state shut {{ on response from call goto ajar }}
                marked state ajar {{ on request to go goto shut }}
            }}
        }}
        requirement Gate[{first}].go needs any(g.ajar for g in Gate[{first + low}..{first + high}])
        """
    )
    (requirement,) = robot.requirements
    read = {leaf.component for leaf in walk(requirement.condition) if isinstance(leaf, StateRef)}
    assert read == {f"Gate[{n}]" for n in range(first + low, first + high + 1)}


SCANNERS = """
    datatype object Scan { r: array(double) }
    interface scans use Scan from some_robot_msgs
    constant MOST: integer = 1
    component Laser[1..2] {
        outgoing message scan with type: Scan links scans
        incoming message go with type: none
        behaviour {
            variable r: array(double)
            variable level: integer(0..3)
            initial marked state s {
                on response from scan do r := value.r
                on request to go do level := 1
            }
        }
    }
"""


def of_scanners(condition: str) -> Expr:
    robot, found = load(
        Source("model.rscd", f"robot R {{ {SCANNERS} requirement always {condition} }}"),
        definitions=MessageDefinitions(),
    )
    assert robot is not None, render_all(found)
    return robot.requirements[0].condition


@pytest.mark.parametrize(
    ("condition", "first", "second", "holds"),
    [
        ("any(x.r[0] < 1 for x in Laser)", (), (0.5,), True),
        ("any(x.r[0] < 1 for x in Laser)", (0.5,), (), True),
        ("any(x.r[0] < 1 for x in Laser)", (2.0,), (), False),
        ("!any(x.r[0] < 1 for x in Laser)", (), (2.0,), True),
        ("!any(x.r[0] < 1 for x in Laser)", (), (0.5,), False),
        ("all(x.r[0] < 1 for x in Laser)", (0.5,), (), True),
        ("all(x.r[0] < 1 for x in Laser)", (), (2.0,), False),
        ("all(x.r[0] < 1 for x in Laser if x.r[1] < 1)", (2.0,), (0.5, 0.5), True),
        ("count(x.r[0] < 1 for x in Laser) >= 1", (), (0.5,), True),
        ("count(x.r[0] < 1 for x in Laser) >= 2", (), (0.5,), False),
        ("count(x.r[0] < 1 for x in Laser) > MOST", (0.5,), (0.5,), True),
        ("count(x.r[0] < 1 for x in Laser) > MOST", (0.5,), (), False),
    ],
)
def test_what_is_undefined_does_not_count(
    condition: str, first: tuple[float, ...], second: tuple[float, ...], holds: bool
) -> None:
    """As in an array: whichever component it is about."""
    data = {"Laser[1]": first, "Laser[2]": second}
    found = of_scanners(condition)
    assert evaluate(found, lambda leaf: data[leaf.component]) is holds  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("condition", "levels", "holds"),
    [
        ("sum(x.level for x in Laser) = 3", (1, 2), True),
        ("min(x.level for x in Laser) = 1", (1, 2), True),
        ("sum(max(2 for other in Laser) for x in Laser) = 4", (0, 0), True),
        ("max(x.level for x in Laser[2..2]) = 2", (3, 2), True),
        ("sum(x.level for x in Laser[2..1]) = 0", (3, 2), True),
        ("all(x.level > 2 for x in Laser[2..1])", (1, 1), True),
        ("count(x.level > 2 for x in Laser[2..1]) = 0", (1, 1), True),
    ],
)
def test_numbers_of_some_or_no_components(
    condition: str, levels: tuple[int, int], holds: bool
) -> None:
    level = dict(zip(("Laser[1]", "Laser[2]"), levels, strict=True))
    found = of_scanners(condition)
    assert evaluate(found, lambda leaf: level[leaf.component]) is holds  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "condition", ["min(x.r[0] for x in Laser) < 1", "sum(x.r[0] for x in Laser) < 1"]
)
def test_a_number_that_may_be_undefined_is_refused(condition: str) -> None:
    _, found = load(
        Source("model.rscd", f"robot R {{ {SCANNERS} requirement always {condition} }}"),
        definitions=MessageDefinitions(),
    )
    assert "not-over-components" in [d.code for d in found]


def test_a_count_of_many_is_written_out_in_few_terms() -> None:
    many = (
        STATION.replace("1..3", "1..200")
        .replace("index % 3 + 1", "index % 200 + 1")
        .replace("integer(0..9)", "integer(0..400)")
    )
    robot = resolved(
        f"{many} requirement Station[1].go needs count(s.waiting for s in Station) < 2"
    )
    assert len(robot.components) == 200


def test_a_fault_in_a_body_is_told_once() -> None:
    _, found = load(
        Source("model.rscd", f"robot R {{ {STATION.replace('goto waiting', 'goto wating')} }}"),
        definitions=MessageDefinitions(),
    )
    assert [(d.code, d.span.text) for d in found] == [("unknown-state", "wating")]


@pytest.mark.parametrize(
    "transition",
    ["on response from index goto idle", "on request to go do index := 1 goto idle"],
)
def test_the_index_is_no_name_of_anything(transition: str) -> None:
    text = STATION.replace("on request to go goto idle", transition)
    robot, diagnostics = load(
        Source("model.rscd", f"robot R {{ {text} }}"), definitions=MessageDefinitions()
    )
    assert robot is None
    assert {d.code for d in diagnostics} <= {
        "unknown-communication",
        "unknown-name",
        "not-assignable",
    }


@pytest.mark.parametrize("statement", ["requirement Station[1].go needs true", ""])
def test_ranges_in_each_other_that_make_too_many_statements_are_told_once(statement: str) -> None:
    body = statement
    for name in "kji":
        body = f"for {name} in 1..1000 {{ {body} }}"
    _, found = load(
        Source("model.rscd", f"robot R {{ {STATION} {body} }}"), definitions=MessageDefinitions()
    )
    errors = [d for d in found if d.code == "bad-index"]
    assert [d.message for d in errors] == ["this makes more than 100,000 statements"]
    assert errors[0].span.start == errors[0].span.source.text.index("1..1000")


def test_copies_know_what_they_are_copies_of() -> None:
    robot = resolved(
        f"{STATION} component Bell {{ incoming message ring with type: none }}"
        " for i in 1..2 { requirement Station[i].go needs Station[i].waiting"
        " requirement ring needs Station[i].idle }"
        " for i in 3..3 { requirement Station[i].go needs Station[i].waiting }"
        " requirement ring needs Station[1].idle"
    )
    assert [c.copy for c in robot.components] == [*(Copy("Station", n) for n in (1, 2, 3)), None]
    repeated = [requirement.repeated for requirement in robot.requirements]
    assert [r and r.values for r in repeated] == [
        *((("i", n),) for n in (1, 1, 2, 2, 3)),
        None,
    ]
    assert len({r.block for r in repeated[:4] if r is not None}) == 1
    assert repeated[3] is not None and repeated[4] is not None
    assert repeated[3].block != repeated[4].block


def test_frames_of_transforms_have_the_index() -> None:
    text = """component Arm[1..2] {
        outgoing transform hand with from: "base{index}", to: "arm{index}/hand", timeout: 1 s
    }"""
    robot, diagnostics = load(Source("model.rscd", f"robot R {{ {text} }}"))
    assert robot is not None, render_all(diagnostics)
    found = [c.frames for c in robot.communications.values()]
    assert found == [("base1", "arm1/hand"), ("base2", "arm2/hand")]
