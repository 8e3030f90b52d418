"""Numbers without bounds and strings that decide about commands: the finite view in synthesis."""

from __future__ import annotations

import json

import pytest
from plants import explanation_of, guard_text, plant_of, supervisor_of
from synthesis.explored import explore_document

from robosc.emit.export.export import exported
from robosc.report import supervisor_text
from robosc.synthesis import explore
from robosc.synthesis.documents import synthesize_document
from robosc.synthesis.formatting import trace_text

BATTERY = """
component Battery {
    outgoing message battery with type: double
    behaviour {
        variable charge: double = 1.0
        initial marked state ok { on response from battery do charge := value }
    }
}
component Base {
    incoming message drive with type: none
    incoming message halt with type: none
}
"""

ENGINES = pytest.mark.parametrize("engine", ["explicit", "bdd"])


@ENGINES
def test_a_number_is_known_by_what_it_is_compared_with(engine: str) -> None:
    supervisor = supervisor_of(
        BATTERY
        + """
        requirement drive needs Battery.charge > 0.2
        requirement halt needs Battery.charge <= 0.1
        """,
        engine,
    )
    assert supervisor.controlled_states == 3
    assert guard_text(supervisor, "drive.request") == ("Battery.charge > 0.2", "as required")
    assert guard_text(supervisor, "halt.request") == ("Battery.charge <= 0.1", "as required")


@ENGINES
def test_the_class_between_two_constants_has_nan_in_it(engine: str) -> None:
    graph = explore(
        supervisor_of(BATTERY + "requirement { drive, halt } needs Battery.charge > 0.2", engine)
    )
    variables = [state["variables"] for state in explore_document(graph)["states"]]
    assert variables == [
        {"Battery.charge": "Battery.charge > 0.2"},
        {"Battery.charge": "!(Battery.charge > 0.2)"},
    ]
    values = {t["event"]["value"] for t in explore_document(graph)["transitions"]}
    assert values == {"value > 0.2", "!(value > 0.2)", None}


@ENGINES
def test_an_enum_as_a_function_and_comparisons_share_their_classes(engine: str) -> None:
    supervisor = supervisor_of(
        """
        datatype enum Level from double to { value > 0.5 -> high value < 0.2 -> low default -> some }
        component Battery {
            outgoing message battery with type: double
            behaviour {
                variable charge: double = 1.0
                variable level: Level = high
                initial marked state ok {
                    on response from battery do charge := value, level := Level(value)
                }
            }
        }
        component Base {
            incoming message drive with type: none
            incoming message halt with type: none
        }
        requirement drive needs Battery.level = high and Battery.charge > 0.5
        requirement halt needs Level(Battery.charge) = low and Battery.charge > 0.3
        """,
        engine,
    )
    assert supervisor.plant.view.free == {}
    assert supervisor.controlled_states == 4  # 0.3 lies between the limits of the enum
    assert guard_text(supervisor, "drive.request")[0] in (
        "Battery.level = high", "Battery.charge > 0.5", "Battery.level = high and Battery.charge > 0.5"
    )  # fmt: skip
    assert guard_text(supervisor, "halt.request") == ("false", "never")


DRAINING = """
component Battery {
    outgoing message battery with type: double
    service charge_up with request: none, response: none links link
    behaviour {
        variable charge: double = 1.0
        initial marked state ok {
            on response from battery do charge := value
        }
    }
}
component Gate {
    incoming message enter with type: none
    behaviour {
        initial marked state outside {
            on request to enter goto inside
        }
        state inside {
            on response from battery if value < 0.25 goto outside
        }
    }
}
requirement never Gate.inside and Battery.charge >= 0.5 and Battery.charge < 0.75
"""


@ENGINES
def test_guards_and_traces_speak_of_classes(engine: str) -> None:
    supervisor = supervisor_of(DRAINING, engine)
    text, status = guard_text(supervisor, "enter.request")
    assert (text, status) == ("false", "never")
    trace = trace_text(explanation_of(supervisor, "enter.request").trace)
    assert trace == "enter.request, battery.response(value >= 0.5 and value < 0.75)"


@ENGINES
@pytest.mark.parametrize(
    ("type_", "condition", "guard"),
    [
        ("double", "value > 0.5", "!(Sensor.seen > 0.5)"),
        ("double", "value <= 0.5", "!(Sensor.seen <= 0.5)"),
        ("double", "!(value > 0.5)", "Sensor.seen > 0.5"),
        ("double", "value != 0.5", "Sensor.seen = 0.5"),
        ("integer", "value > 5", "Sensor.seen <= 5"),
        ("integer", "value < 3 or value = 7", "Sensor.seen >= 3 and Sensor.seen != 7"),
        ("string", 'value = "a" or value = "b"', 'Sensor.seen != "a" and Sensor.seen != "b"'),
    ],
)
def test_guards_of_synthesis_are_told_in_comparisons(
    type_: str, condition: str, guard: str, engine: str
) -> None:
    """Synthesis finds out where one must not go, as nothing asks for it directly."""
    compared = condition.replace("value", "Sensor.seen")
    supervisor = supervisor_of(
        f"""
        component Sensor {{
            outgoing message sensor with type: {type_}
            behaviour {{
                variable seen: {type_}
                initial marked state s {{
                    on response from sensor if Base.here do seen := value
                }}
            }}
        }}
        component Base {{
            incoming message go with type: none
            behaviour {{
                initial marked state here {{ on request to go goto there }}
                state there {{ transition goto here }}
            }}
        }}
        requirement never Base.there and ({compared})
        """,
        engine,
    )
    assert guard_text(supervisor, "go.request") == (guard, "restricted")


@ENGINES
def test_transitions_that_are_taken_together_store_the_same_number(engine: str) -> None:
    supervisor = supervisor_of(
        """
        component Sensor {
            outgoing message sensor with type: double
            incoming message go with type: none
            behaviour {
                variable x: double
                variable y: double
                on response from sensor do y := value
                initial marked state s { on response from sensor do x := value }
            }
        }
        requirement go needs Sensor.x > 0.5 and Sensor.y > 0.5
        """,
        engine,
    )
    assert supervisor.controlled_states == 2


COUNTING = """
component Counter {
    incoming message up with type: none
    incoming message clear with type: none
    behaviour {
        variable n: integer
        initial marked state s {
            on request to up do n := n + 1
            on request to clear do n := 0
        }
    }
}
"""


@ENGINES
def test_a_command_is_allowed_only_if_all_that_may_come_of_it_is_good(engine: str) -> None:
    supervisor = supervisor_of(COUNTING + "requirement never Counter.n > 5", engine)
    assert guard_text(supervisor, "up.request") == ("false", "never")
    trace = trace_text(explanation_of(supervisor, "up.request").trace)
    assert trace == "up.request(Counter.n + 1 > 5)"
    assert supervisor.controlled_states == 1


@ENGINES
def test_what_a_command_computes_may_come_to_anything(engine: str) -> None:
    supervisor = supervisor_of(COUNTING + "requirement clear needs Counter.n > 5", engine)
    assert guard_text(supervisor, "up.request") == ("true", "as required")
    assert supervisor.controlled_states == 2
    transitions = explore_document(explore(supervisor))["transitions"]
    assert len(transitions) == supervisor.controlled_transitions == 5


@ENGINES
def test_two_numbers_that_are_compared_have_one_order(engine: str) -> None:
    """What excludes each other in the data does so in the plant, however it is written."""
    supervisor = supervisor_of(
        """
        component Arm {
            outgoing message left with type: double
            outgoing message right with type: double
            incoming message close with type: none
            incoming message open with type: none
            behaviour {
                variable x: double
                variable y: double
                initial marked state s {
                    on response from left if value > y do x := value
                    on response from left if value <= y do x := y
                    on response from right do y := value
                }
            }
        }
        requirement close needs Arm.x > Arm.y
        requirement open needs Arm.y >= Arm.x
        requirement never Arm.x > Arm.y and Arm.x < Arm.y
        """,
        engine,
    )
    assert {d.code for d in supervisor.diagnostics} == {"requirement-always-true"}
    assert supervisor.controlled_states == 4  # less, equal, greater, not a number


def test_what_is_taken_as_free_is_told() -> None:
    supervisor = supervisor_of(
        COUNTING + BATTERY + "requirement clear needs Counter.n > 5"
        " and Battery.charge > 0.2 requirement up needs Counter.n < 7 and"
        " Battery.charge < Battery.charge * 2"
    )
    document, text = synthesize_document(supervisor), supervisor_text(supervisor)
    reasons = document["free_reasons"]
    assert document["free_tests"] == list(reasons)
    assert reasons == {
        "Battery.charge < Battery.charge * 2": "it is computed",
        "Counter.n + 1": "it is computed",
    }
    assert "    Counter.n + 1: it is computed\n" in text


KEPT = """
    parameter limit: double = 1.0
    interface links use Place from nowhere_msgs
    datatype object Place {{ x: double levels: array(double) }}
    datatype enum Odd from double to {{ value * 2 > 1 -> odd default -> even }}
    component S {{
        outgoing message place with type: Place links links
        incoming message go with type: none
        behaviour {{
            variable x: double
            variable y: double
            variable n: integer
            variable far: boolean
            variable here: Place
            variable levels: array(double)
            initial marked state s {{ on response from place do {action} }}
        }}
    }}
    requirement go needs {condition}
"""


@pytest.mark.parametrize(
    ("action", "condition", "free", "reason"),
    [
        ("x := value.x", "S.x > S.y", "S.x > S.y", "it reads more than one number or string"),
        ("x := value.x", "S.x > limit", "S.x > limit", "it reads a parameter"),
        ("levels := value.levels", "S.levels[S.n] > 0", "S.levels[S.n] > 0",
         "it reads a computed or negative index"),
        ("levels := value.levels[1..2]", "S.levels[0] > 0", "S.levels[0] > 0", "it reads a part of an array"),
        ("levels := value.levels", "any(l > 0 for l in S.levels)", "any(l > 0 for l in S.levels)",
         "it goes through the elements of an array"),
        ("x := value.x", "abs(S.x) > 1", "abs(S.x) > 1", "it calls abs(…)"),
        ("far := S.x > value.x", "S.far", "S.x > value.x", "it reads a received value and a variable"),
        ("x := value.x", "Odd(S.x) = odd", "Odd(S.x) = odd",
         "the rules of the enum do not only compare with constants"),
        ("x := levels[0]", "S.x > 1", "S.levels[0]",
         "it is a part of a variable, and is assigned to another variable"),
        ("levels := here.levels", "S.levels[0] > 1", "S.levels[0] > 1",
         "it is assigned a part of a variable that may be missing"),
    ],
)  # fmt: skip
def test_each_free_test_has_its_reason(action: str, condition: str, free: str, reason: str) -> None:
    plant = plant_of(KEPT.format(action=action, condition=condition))
    assert plant.view.free == {free: reason}


@pytest.mark.parametrize(
    ("action", "condition"),
    [
        ("levels := value.levels", "S.levels[0] > 1 and !(S.levels[1] <= 2)"),
        ("far := here.x > 1, here := value", "S.far and S.here.x > 2"),
        ("far := levels[0] > 1 or here.x > 2, here := value", "!S.far"),
    ],
)
def test_parts_of_variables_are_exact(action: str, condition: str) -> None:
    assert plant_of(KEPT.format(action=action, condition=condition)).view.free == {}


def test_nothing_is_free_where_constants_decide() -> None:
    supervisor = supervisor_of(BATTERY + "requirement drive needs Battery.charge > 0.2")
    assert synthesize_document(supervisor)["free_tests"] == []
    assert "free" not in supervisor_text(supervisor)


def test_cif_has_classes_as_enumerations() -> None:
    plant = plant_of(BATTERY + "requirement drive needs Battery.charge > 0.2")
    lines = exported(plant, "cif").splitlines()
    assert "// not_above_0_2: !(Battery.charge > 0.2), above_0_2: Battery.charge > 0.2" in lines
    assert (
        "requirement invariant c_drive_request needs"
        " Battery.charge = Battery_charge_class_above_0_2;"
    ) in lines


def test_json_names_classes_by_what_they_have_in_common() -> None:
    plant = plant_of(BATTERY + "requirement drive needs Battery.charge > 0.2")
    document = json.loads(exported(plant, "json"))["plant"]
    labels = ["!(Battery.charge > 0.2)", "Battery.charge > 0.2"]
    (battery,) = [v for v in document["variables"] if v["name"] == "Battery.charge"]
    assert (battery["values"], battery["initial"]) == (labels, labels[1])


@ENGINES
def test_functions_are_tests_and_enums_whose_rules_compare_are_none(engine: str) -> None:
    supervisor = supervisor_of(
        BATTERY
        + """
        datatype enum Charge from double to { value > 0.5 -> full value > 0.2 -> half default -> low }
        requirement drive needs Charge(Battery.charge) = full or isnan(Battery.charge)
        requirement halt needs Charge(Battery.charge) = low and !isnan(Battery.charge)
        """,
        engine,
    )
    assert synthesize_document(supervisor)["free_tests"] == ["isnan(Battery.charge)"]
    assert supervisor.controlled_states == 6
    assert {guard.status for guard in supervisor.guards} == {"as required"}


@ENGINES
@pytest.mark.parametrize("source", ["integer", "double"])
def test_a_conversion_of_a_number_with_a_range_is_of_its_exact_value(
    source: str, engine: str
) -> None:
    """The enum compares an unbounded number, but what is converted here has few values."""
    supervisor = supervisor_of(
        f"""
        datatype enum Level from {source} to {{ value > 1 -> high default -> low }}
        component Lift {{
            incoming message up with type: none
            incoming message hold with type: none
            behaviour {{
                variable floor: integer(-1..2) = -1
                initial marked state on_ {{ on request to up do floor := floor + 1 }}
            }}
        }}
        requirement hold needs Level(Lift.floor) = high
        """,
        engine,
    )
    assert (supervisor.controlled_states, supervisor.controlled_transitions) == (4, 4)
    states = explore_document(explore(supervisor))["states"]
    assert [s["variables"] for s in states] == [{"Lift.floor": n} for n in (-1, 0, 1, 2)]


TWO_READERS = """
datatype object Reading {{ low: double high: double level: double }}
{parameter}
component Limits {{
    outgoing message reading with type: Reading links link
    behaviour {{
        variable low: double = 1.0
        variable high: double = 0.0
        on response from reading do low := value.low, high := value.high
        initial marked state s {{}}
    }}
}}
component Gauge {{
    incoming message go with type: none
    behaviour {{
        variable level: double
        on response from reading do level := value.level
        initial marked state off {{ on request to go goto seen }}
        marked state seen {{}}
    }}
}}
requirement never Gauge.seen and {condition}
"""


@ENGINES
@pytest.mark.parametrize(
    "condition",
    [
        "Gauge.level < Limits.high and Gauge.level > Limits.low",
        "Limits.high > Gauge.level and Limits.low < Gauge.level",
        "Gauge.level > p and Gauge.level < Limits.high and Gauge.level != Limits.low",
        "Gauge.level = Limits.high + 1 and Gauge.level > Limits.high",
    ],
)
def test_tests_of_one_variable_change_independently(condition: str, engine: str) -> None:
    parameter = "parameter p: double = 0.5" if "p " in condition else ""
    supervisor = supervisor_of(TWO_READERS.format(parameter=parameter, condition=condition), engine)
    assert guard_text(supervisor, "go.request") == ("false", "never")
    assert "compare" not in supervisor_text(supervisor)


def test_a_variable_that_is_assigned_to_itself_keeps_what_is_known_of_it() -> None:
    plant = plant_of(
        """
        datatype object Place { n: integer }
        component C {
            outgoing message same with type: none
            outgoing message place with type: Place links link
            incoming message go with type: none
            behaviour {
                variable v: Place
                variable w: Place
                initial marked state s {
                    on response from same do v := v
                    on response from place do w := value
                    on request to go do v := w
                }
            }
        }
        requirement go needs C.v.n < 3
        requirement never C.v.n > 5 and C.w.n > 5
        """
    )
    (same,) = (event for event in plant.events if event.name == "same")
    (go,) = (event for event in plant.events if event.name == "go")
    assert same.parameters == go.parameters == ()


DOCK = """
component Base {
    action dock with request: none, response: Outcome, feedback: none links dock
    behaviour {
        initial marked state away performs dock then goto docked {
            on error from dock if CONDITION goto lost
            REST
        }
        marked state docked {}
        marked state lost {}
    }
}
datatype object Outcome { code: integer tries: integer text: string }
interface dock use Dock from some_dock_msgs
"""


@ENGINES
@pytest.mark.parametrize("rest", ["", "retry 1 times else goto lost", "on error from dock else"])
@pytest.mark.parametrize(
    ("condition", "is_free"),
    [
        ("value.code in { 901, 902 }", False),
        ('value.text = "blocked" or value.code > 3 and !(value.tries < 2)', False),
        ("value.code + 1 > 902", True),
        ("value.code > value.tries", True),
    ],
)
def test_what_a_result_that_may_be_missing_does_not_decide_is_for_the_rest(
    condition: str, is_free: bool, rest: str, engine: str
) -> None:
    """Of each error exactly one of both happens, also of one that brought nothing."""
    text = DOCK.replace("CONDITION", condition).replace("REST", rest)
    supervisor = supervisor_of(text, engine)
    assert guard_text(supervisor, "dock.request") == ("true", "as required")
    assert bool(synthesize_document(supervisor)["free_tests"]) is is_free
