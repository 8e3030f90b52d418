"""Expressions as sets of states: the same values as the reference evaluation, state by state."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from itertools import product

import pytest
from random_models import random_model
from synthesis.plants import plant_of

from robosc.expr.evaluation import Undefined, evaluate
from robosc.expr.tree import Expr, Leaf, PhaseRef, StateRef, ValueRef, VariableRef
from robosc.expr.types import Value
from robosc.language.functions import CALLS
from robosc.language.operators import BINARY, UNARY
from robosc.plant.automaton import Event, Plant, PlantState, VariableKind
from robosc.plant.step import Values, valuations
from robosc.synthesis.bdd.encoding import Encoding

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")

pytestmark = pytest.mark.slow

SMALL = 2**25


def states_of(plant: Plant) -> Iterator[PlantState]:
    yield from product(*(range(variable.size) for variable in plant.variables))


def value_in(
    plant: Plant, expr: Expr, state: PlantState, event: Event | None, values: Values
) -> Value | None:
    def look(leaf: Leaf) -> Value | None:
        match leaf:
            case VariableRef(component=component, variable=name):
                variable = plant.variable_index[VariableKind.DATA, f"{component}.{name}"]
                return plant.variables[variable].values[state[variable]]
            case StateRef(component=component, state=name):
                variable = plant.variable_index[VariableKind.LOCATION, component]
                return plant.variables[variable].values[state[variable]] == name
            case PhaseRef(communication=key):
                return state[plant.variable_index[VariableKind.PHASE, key]] == 1
            case ValueRef(path=path):
                assert event is not None
                paths = [parameter.path for parameter in event.parameters]
                return values[paths.index(path)]

    try:
        return evaluate(expr, look)
    except Undefined:
        return None


def expressions(plant: Plant) -> Iterator[tuple[Expr, int | None]]:
    for number, event in enumerate(plant.events):
        if event.requirement is not None:
            yield event.requirement, None
        for automaton in event.automata:
            for edge in automaton.edges:
                if edge.guard is not None:
                    yield edge.guard, number
                for _, expr in edge.updates:
                    yield expr, number
    for condition, _ in plant.invariants:
        yield condition, None


def check(plant: Plant) -> int:
    """How many values were compared."""
    encoding = Encoding(plant, SMALL)
    false = encoding.manager.false
    compared = 0
    for expr, number in expressions(plant):
        partition = encoding.partition(expr, number)
        event = None if number is None else plant.events[number]
        for values in [()] if event is None else valuations(event):
            chosen = encoding.manager.true
            for n, value in enumerate(values):
                assert number is not None and event is not None
                index = list(event.parameters[n].values).index(value)
                chosen = chosen & encoding.value((number, n), index)
            for state in states_of(plant):
                here = encoding.state(state) & chosen
                found = [value for value, states in partition if here & states != false]
                expected = value_in(plant, expr, state, event, values)
                assert [repr(value) for value in found] == [repr(expected)], (expr, state, values)
                compared += 1
    return compared


def test_random_expressions() -> None:
    total = sum(check(plant_of(random_model(random.Random(seed), 1))) for seed in range(150))
    assert total > 10_000


def test_linear_comparisons_by_bits() -> None:
    """Constants beyond the ranges, multiples and differences, of variables and of what comes in."""
    assert check(
        plant_of(
            "component A { outgoing message m with type: integer(-3..4)"
            " outgoing message n with type: integer(5..5) behaviour {"
            " variable x: integer(-3..4) variable y: integer(2..8) variable z: integer(5..5)"
            " initial marked state s {"
            " on response from m if 3 * value - x < y + -7 do x := value"
            " on response from m if value = z - x and value * -2 != x do y := 3"
            " on response from n if value >= y and z <= x + value do y := 4 } } }"
            " requirement never A.x - 2 * A.y > 100 or A.x - 2 * A.y = -15"
            " requirement always A.x * 5 <= A.y - -40 or A.z - A.y >= A.x"
        )
    )


OPERATIONS = [
    *(f"A.p {o} A.q" for o in ("and", "or", "=>", "=", "!=")),
    *(f"A.x {o} A.y" for o in ("=", "!=", "<", "<=", ">", ">=")),
    *(f"A.x {o} A.y = 1" for o in ("+", "-", "*", "/", "%")),
    "!A.p",
    "-A.x > 1",
    *(f"{f}(A.x) = 1" for f in ("abs", "sqrt", "sin", "cos", "floor", "ceil", "round")),
    *(f"{f}(A.x, A.y) > 0" for f in ("min", "max", "hypot", "atan2")),
    "isnan(sqrt(A.x))",
    "isinf(1 / A.x)",
    "has(A.x, A.y)",
    'string(A.x) = "2"',
    "(A.x / A.y else 1.0) > 0.5",
]


@pytest.mark.parametrize("operation", OPERATIONS)
def test_every_operation_on_its_own(operation: str) -> None:
    assert check(
        plant_of(
            "component A { incoming message go with type: none"
            " outgoing message m with type: integer(-2..2)"
            " behaviour { variable x: integer(-2..2) variable y: integer(-2..2)"
            " variable p: boolean variable q: boolean initial marked state s {"
            " on response from m do x := value, p := value > 0, y := x, q := p } } }"
            f" requirement go needs {operation}"
        )
    )


def test_every_operation_of_the_tables_is_among_them() -> None:
    named = {word for text in OPERATIONS for word in re.findall(r"[a-z]\w+|[^\w\s().\"]+", text)}
    of_data = {"length", "element", "section", "sector"}
    assert {*UNARY, *BINARY, *CALLS} - of_data <= named


def test_division_signed_zeros_and_what_is_no_number() -> None:
    """0/0 differs from itself, and 1/-0.0 from 1/0.0, whatever the order in which values come."""
    assert check(
        plant_of(
            "component A { outgoing message m with type: integer(-2..2)"
            " outgoing message n with type: integer(-2..2) behaviour {"
            " variable x: integer(-2..2) variable y: integer(-2..2) variable b: boolean"
            " initial marked state s {"
            " on response from m if 1 / (0.0 * value) < x / y do x := value"
            " on response from n do y := value, b := x / y = x / y } } }"
            " requirement never A.b and A.x / A.y != A.x / A.y"
            " requirement always 1 / (A.x * 0.0) <= 1 / (A.y * 0.0) or A.b"
        )
    )


def test_conditions_that_differ_in_the_sign_of_a_zero_alone() -> None:
    """Where a condition holds is remembered, but not for the other one."""
    plant = plant_of(
        "component A { outgoing message m with type: integer(0..2) behaviour {"
        " variable x: integer(0..2) initial marked state s { on response from m do x := value } }"
        " incoming message up with type: none incoming message down with type: none }"
        " requirement up needs A.x / 0.0 > 1 requirement down needs A.x / -0.0 > 1"
    )
    encoding = Encoding(plant, SMALL)
    up, down = (event.requirement for event in plant.events if event.controllable)
    assert up is not None and down is not None and up != down
    assert encoding.count(encoding.holds(up)) == 2
    assert encoding.count(encoding.holds(down)) == 0


def test_equal_conditions_are_put_together_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each copy of a component has the same requirement: it is looked at for the first alone."""
    plant = plant_of(
        'component S[1..6] { incoming message go with identifier: "/go{index}", type: none'
        ' outgoing message m with identifier: "/m{index}", type: boolean behaviour {'
        " variable b: boolean initial marked state s { on response from m do b := value } } }"
        " for i in 1..6 { requirement S[i].go needs count(s.b for s in S) < 3 }"
    )
    wanted = [e.requirement for e in plant.events if e.requirement is not None]
    assert len(wanted) == 6
    asked = []
    put_together = Encoding.partition
    monkeypatch.setattr(
        Encoding, "partition", lambda *given: asked.append(given) or put_together(*given)
    )
    encoding = Encoding(plant, SMALL)
    assert len({encoding.count(encoding.holds(condition)) for condition in wanted}) == 1
    assert len(asked) == 1


def test_missing_elements() -> None:
    assert check(
        plant_of(
            "datatype object L { items: array(integer(0..2)) flags: array(boolean) }"
            " component A { outgoing message m with type: L links link behaviour {"
            " variable x: integer(0..2) variable b: boolean initial marked state s {"
            " on response from m if value.items[0] > x or b do x := value.items[1],"
            " b := value.flags[0] and x > 0 } } incoming message go with type: none }"
            " requirement go needs A.b and A.x > 1"
        )
    )
