"""What a name means is decided by the type that its place needs."""

from __future__ import annotations

import random

import pytest
from model_text import behaviour_of, faults, resolve

from robosc.expr.tree import Binary, Literal, PhaseRef, StateRef, Unary, VariableRef
from robosc.expr.types import BooleanType, EnumType
from robosc.model.names.occurrences import SymbolKind
from robosc.model.resolve import load, read
from robosc.model.ros.definitions import MessageDefinitions
from robosc.source import Source

# A gear whose state, variables and enum values share their names as far as the language allows.
GEAR = """
component Gear {
    outgoing message lever with type: Speed
    outgoing message oil with type: boolean
    behaviour {
        variable speed: Speed
        variable warm: boolean
        %s
        initial marked state slow { %s }
        marked state fast { transition goto slow }
    }
}
component Motor { incoming message move with type: none }
datatype enum Speed from integer to { value > 3 -> fast default -> slow }
datatype enum Danger from integer to { value > 3 -> fast default -> low }
"""


def gear(transition: str, variables: str = "", rest: str = "") -> str:
    return GEAR % (variables, transition) + rest


def guard_of(transition: str, variables: str = "") -> object:
    robot = resolve(gear(transition, variables))
    return behaviour_of(robot, "Gear").states[0].taus[0].guard


def test_an_assigned_enum_variable_takes_the_enum_value_not_the_state() -> None:
    robot = resolve(gear("on response from oil do speed := fast goto fast"))
    value = behaviour_of(robot, "Gear").states[0].transitions[0].assignments[0].value
    assert isinstance(value, Literal) and value.value == "fast"
    assert isinstance(value.type, EnumType) and value.type.name == "Speed"


def test_a_condition_takes_the_state_not_the_enum_value() -> None:
    assert guard_of("transition if fast goto fast") == StateRef("Gear", "fast")


@pytest.mark.parametrize("comparison", ["speed = fast", "fast = speed"])
def test_the_other_side_of_a_comparison_decides(comparison: str) -> None:
    guard = guard_of(f"transition if {comparison} goto fast")
    assert isinstance(guard, Binary)
    sides = {type(guard.left), type(guard.right)}
    assert sides == {VariableRef, Literal}


def test_a_boolean_compared_with_a_name_takes_the_state() -> None:
    guard = guard_of("transition if warm = slow goto fast")
    assert isinstance(guard, Binary) and guard.right == StateRef("Gear", "slow")


def test_two_states_are_compared_before_two_constants() -> None:
    guard = guard_of("transition if slow != fast goto fast")
    assert isinstance(guard, Binary)
    assert (guard.left, guard.right) == (StateRef("Gear", "slow"), StateRef("Gear", "fast"))


def test_a_variable_may_be_called_like_a_state_of_another_type() -> None:
    guard = guard_of("transition if slow and slow > 3 goto fast", "variable slow: integer(0..9)")
    assert isinstance(guard, Binary) and guard.left == StateRef("Gear", "slow")


def test_a_variable_and_a_value_of_its_own_enum_are_ambiguous() -> None:
    text = gear("transition if speed = fast goto fast", "variable fast: Speed")
    assert faults(text) == [("ambiguous-name", "fast")]
    assert resolve(text.replace("speed = fast", "speed = Speed.fast"))
    assert resolve(text.replace("speed = fast", "speed = Gear.fast"))


def test_two_constants_of_two_enums_need_the_enum() -> None:
    rest = "requirement move needs {} = fast"
    go = "transition goto fast"
    assert faults(gear(go, rest=rest.format("fast"))) == [("ambiguous-name", "fast")]
    robot = resolve(gear(go, rest=rest.format("Danger.fast")))
    condition = robot.requirements[0].condition
    assert isinstance(condition, Binary) and condition.right.type == condition.left.type


def test_an_enum_value_is_no_condition() -> None:
    text = gear("", rest="requirement move needs fast")
    assert ("type-mismatch", "fast") in faults(text)


def test_bare_states_are_known_in_their_own_component_only() -> None:
    text = gear(
        "", rest="component Other { behaviour { initial marked state s { transition if slow } } }"
    )
    assert ("type-mismatch", "slow") in faults(text)


def test_the_escape_makes_value_a_name() -> None:
    robot = resolve(
        """
        component Gear {
            outgoing message lever with type: boolean
            behaviour {
                variable ^value: boolean
                initial marked state idle { on response from lever if ^value do ^value := value }
            }
        }
        """
    )
    transition = behaviour_of(robot, "Gear").states[0].transitions[0]
    assert transition.guard == VariableRef("Gear", "value", transition.guard.type)  # type: ignore[union-attr]
    assert transition.assignments[0].variable == "value"


def test_keywords_of_python_and_of_the_language_are_names() -> None:
    resolve(
        """
        component class {
            incoming message lambda with identifier: "/a", type: none
            outgoing message message with identifier: "/b", type: boolean
            behaviour {
                variable from: boolean
                initial marked state state { on response from message do from := value goto def }
                marked state def { on request to lambda goto state }
            }
        }
        requirement lambda needs class.from and class.state
        """
    )


def test_an_own_communication_is_meant_before_one_of_another_component() -> None:
    # Two local components cannot share a name; that is an error of its own, told once.
    text = """
    component A {
        incoming message go with type: none
        behaviour { initial marked state s { on request to go } }
    }
    component B {
        incoming message go with type: none
        behaviour { initial marked state s { on request to go } }
    }
    requirement go needs A.s
    """
    assert faults(text) == [("duplicate-name", "go")]


def test_a_communication_of_another_component_is_known_by_its_bare_name() -> None:
    robot = resolve(
        """
        component B { behaviour { initial marked state s { on response from seen } } }
        component A { outgoing message seen with type: none }
        """
    )
    assert behaviour_of(robot, "B").states[0].transitions[0].communication == "A.seen"


ARM = """
component Arm {
    service grab with request: none, response: none links grab
    outgoing message lever with type: none
    behaviour { initial marked state idle { %s } }
}
interface grab use Empty from std_srvs
"""


@pytest.mark.parametrize("name", ["grab", "Arm.grab"])
def test_the_phase_of_a_service_is_a_condition(name: str) -> None:
    robot = resolve(ARM % f"transition if {name}.busy transition if {name}.idle")
    busy, idle = (t.guard for t in behaviour_of(robot, "Arm").states[0].taus)
    assert busy == PhaseRef("Arm.grab", "busy")
    assert idle == Unary("!", PhaseRef("Arm.grab", "busy"), BooleanType())


@pytest.mark.parametrize("condition", ["lever.busy", "grab.gone", "Arm.lever.idle"])
def test_only_services_and_actions_are_busy_or_idle(condition: str) -> None:
    codes = {code for code, _ in faults(ARM % f"transition if {condition}")}
    assert codes & {"unknown-name", "unknown-member"}


def test_phases_that_a_communication_does_not_have() -> None:
    text = ARM % "transition if grab.cancelling goto idle"
    _, found = load(Source("model.rscd", f"robot T {{ {text} }}"))
    assert ("'grab' is never cancelling", "it is idle or busy") in [
        (d.message, d.hint) for d in found
    ]


@pytest.mark.parametrize(
    ("condition", "told"),
    [
        ("oil.fresh", "'oil' is neither fresh nor silent: it has no timeout"),
        ("Gear.oil.silent", "'oil' is neither fresh nor silent: it has no timeout"),
        ("oil.data", "'oil' is a communication; conditions are about variables and states"),
        ("move.fresh", "'move' is a communication; conditions are about variables and states"),
    ],
)
def test_what_is_no_condition_of_a_communication_is_explained(condition: str, told: str) -> None:
    text = gear("on response from oil goto fast", rest=f"requirement move needs {condition}")
    _, diagnostics = load(Source("model.rscd", f"robot Test {{\n{text}\n}}\n"))
    assert [(d.span.text, d.message) for d in diagnostics if d.code == "unknown-name"] == [
        (condition, told)
    ]


WAY = """
robot Test {
    constant near: integer = 3
    datatype enum Way from integer to { value < near -> near value < 5 -> far default -> wide }
    component C {
        outgoing message m with type: Way
        incoming message go with type: none
        behaviour { variable way: Way initial marked state s { on response from m do way := value } }
    }
    requirement go needs %s
}
"""


@pytest.mark.parametrize("seed", range(10))
def test_editors_tell_enum_values_from_a_constant_of_the_same_name(seed: int) -> None:
    """Also after names for which the constant was a candidate and was not chosen."""
    terms = {
        "C.way = near": ["near"], "C.way != near": ["near"], "far = C.way": ["far"],
        "C.way in { near, far }": ["near", "far"], "near > 2": [], "C.s": [],
    }  # fmt: skip
    chosen = random.Random(seed).choices(list(terms), k=20)
    text = WAY % " or ".join(chosen)
    found = read(Source("model.rscd", text), (), MessageDefinitions())
    assert found.robot is not None and found.contents is not None
    values = [
        o.span.text
        for o in found.contents.scope.names.index.occurrences
        if o.symbol.kind is SymbolKind.VALUE and o.span.start > text.index("requirement")
    ]
    assert values == [value for term in chosen for value in terms[term]]
