"""The plant of small robots: what each event does in each state, worked out by hand."""

from __future__ import annotations

import pytest

from robosc.errors import render_all
from robosc.expr.tree import FALSE
from robosc.language.events import EventKind
from robosc.model.resolve import load
from robosc.plant.automaton import Event, Plant, VariableKind
from robosc.plant.build import lower
from robosc.plant.model_text import to_dsl
from robosc.plant.step import Verdict, outcome, valuations
from robosc.source import Source


def plant(text: str) -> Plant:
    robot, diagnostics = load(Source("robot.rscd", "robot R {" + text + "}"))
    assert robot is not None, render_all(diagnostics)
    return lower(robot)


def event(system: Plant, kind: str, name: str, index: int = 0) -> Event:
    (found,) = (
        e for e in system.events if (e.kind, e.name, e.index) == (EventKind(kind), name, index)
    )
    return found


def step(system: Plant, kind: str, name: str, state: dict[str, object], *values, index: int = 0):
    """The state after an event as {state variable name: value}, or the verdict."""
    before = list(system.initial)
    for variable, value in state.items():
        (position,) = (i for i, a in enumerate(system.variables) if a.name == variable)
        before[position] = system.variables[position].values.index(value)
    after = outcome(system, event(system, kind, name, index), values, tuple(before))
    if isinstance(after, Verdict):
        return after
    return {a.name: a.values[i] for a, i in zip(system.variables, after, strict=True)}


SERVICE_AND_ACTION = """
    interface s use SetBool from std_srvs
    interface a use Test from actionlib
    component C {
        service call with request: none, response: none links s
        action act with request: none, response: none, feedback: none links a
        incoming message go with type: none
        outgoing message done with type: none
    }
"""


def test_each_communication_has_its_events_in_model_order():
    system = plant(SERVICE_AND_ACTION)
    assert [(e.name, e.kind.word, e.controllable) for e in system.events] == [
        ("call", "request", True),
        ("call", "response", False),
        ("call", "error", False),
        ("act", "request", True),
        ("act", "response", False),
        ("act", "feedback", False),
        ("act", "error", False),
        ("act", "cancel", True),
        ("act", "cancelled", False),
        ("go", "request", True),
        ("done", "response", False),
    ]


@pytest.mark.parametrize(
    ("kind", "before", "after"),
    [
        ("request", "idle", "busy"),
        ("response", "busy", "idle"),
        ("feedback", "busy", "busy"),
        ("error", "busy", "idle"),
        ("cancel", "busy", "cancelling"),
        ("cancelled", "cancelling", "idle"),
        ("response", "cancelling", "idle"),
        ("error", "cancelling", "idle"),
    ],
)
def test_an_action_goes_through_its_phases(kind, before, after):
    system = plant(SERVICE_AND_ACTION)
    other = "busy" if before == "idle" else "idle"
    assert step(system, kind, "act", {"C.act": before})["C.act"] == after
    assert step(system, kind, "act", {"C.act": other}) is Verdict.IMPOSSIBLE


def test_messages_are_always_possible():
    system = plant(SERVICE_AND_ACTION)
    assert step(system, "request", "go", {}) == step(system, "response", "done", {})


SYNCHRONISED = """
    component Sender {
        incoming message go with type: none
        outgoing message seen with type: none
        behaviour {
            initial marked state a { on request to go goto b on response from seen goto b }
            state b { on response from seen goto a }
        }
    }
    component Witness {
        behaviour {
            initial marked state yes { on request to go on response from seen goto no }
            state no { transition goto yes }
        }
    }
"""


def test_a_request_is_synchronised_with_all_that_mention_it():
    system = plant(SYNCHRONISED)
    assert step(system, "request", "go", {})["Sender"] == "b"
    assert step(system, "request", "go", {"Witness": "no"}) is Verdict.IMPOSSIBLE
    assert step(system, "request", "go", {"Sender": "b"}) is Verdict.IMPOSSIBLE


def test_what_the_robot_sends_is_blocked_by_nobody():
    system = plant(SYNCHRONISED)
    assert step(system, "response", "seen", {}) == {"Sender": "b", "Witness": "no"}
    assert step(system, "response", "seen", {"Sender": "b", "Witness": "no"}) == {
        "Sender": "a",
        "Witness": "no",
    }


def test_a_tau_is_possible_in_its_own_state_only():
    system = plant(SYNCHRONISED)
    assert step(system, "tau", "Witness", {}, index=1) is Verdict.IMPOSSIBLE
    assert step(system, "tau", "Witness", {"Witness": "no"}, index=1)["Witness"] == "yes"


VARIABLES = """
    component Counter {
        incoming message up with type: none
        outgoing message tick with type: none
        outgoing message level with type: integer(0..9)
        behaviour {
            variable count: integer(0..3)
            variable last: integer(0..3) = 3
            variable heard: integer = 7
            on request to up do count := count + 1, last := count
            on response from tick do count := last - 1
            on response from level do last := value, heard := value
            initial marked state on_ { on response from tick do count := count }
            marked state off {}
            transition if count = 3 goto off
        }
    }
    requirement up needs Counter.last < 4
"""


def test_assignments_see_the_values_before_the_event():
    system = plant(VARIABLES)
    after = step(system, "request", "up", {"Counter.count": 1})
    assert (after["Counter.count"], after["Counter.last"]) == (2, 1)


def test_leaving_a_range_is_told_from_being_impossible():
    system = plant(VARIABLES)
    assert step(system, "request", "up", {"Counter.count": 3}) is Verdict.OUT_OF_RANGE
    low = {"Counter": "off", "Counter.last": 0}
    assert step(system, "response", "tick", low) is Verdict.OUT_OF_RANGE


def test_the_state_level_wins_over_the_automaton_level():
    system = plant(VARIABLES)
    assert step(system, "response", "tick", {"Counter.count": 2})["Counter.count"] == 2
    assert step(system, "response", "tick", {"Counter": "off"})["Counter.count"] == 2


def test_an_automaton_level_tau_exists_in_every_state():
    system = plant(VARIABLES)
    for location in ("on_", "off"):
        ready = {"Counter": location, "Counter.count": 3}
        assert step(system, "tau", "Counter", ready, index=1)["Counter"] == "off"
        early = {"Counter": location, "Counter.count": 2}
        assert step(system, "tau", "Counter", early, index=1) is Verdict.IMPOSSIBLE


def test_data_that_nothing_decides_on_is_no_state_variable():
    system = plant(VARIABLES)
    assert (VariableKind.DATA, "Counter.heard") not in system.variable_index
    (edge, *_) = event(system, "response", "level").automata[0].edges
    assert "heard" in [a.variable for a in edge.assignments]
    assert "Counter.heard" not in [system.variables[v].name for v, _ in edge.updates]


def test_an_event_branches_over_the_values_that_are_taken():
    system = plant(VARIABLES)
    level = event(system, "response", "level")
    assert [v for (v,) in valuations(level)] == list(range(10))
    assert step(system, "response", "level", {}, 2)["Counter.last"] == 2
    assert step(system, "response", "level", {}, 4) is Verdict.OUT_OF_RANGE
    assert event(system, "response", "tick").parameters == ()


ARRAY = """
    interface i use Int32MultiArray from std_msgs
    datatype object Levels { data: array(integer(0..2)) }
    component C {
        outgoing message levels with type: Levels links i
        incoming message go with type: none
        behaviour {
            variable seen: integer(0..2) = 1
            variable big: boolean
            initial marked state quiet {
                on response from levels do seen := value.data[1], big := value.data[0] > 1 goto heard
            }
            marked state heard {
                on response from levels if value.data[0] = 0 goto quiet
            }
        }
    }
    requirement go needs C.seen = 1 and !C.big
"""


def test_an_array_may_be_too_short():
    system = plant(ARRAY)
    levels = event(system, "response", "levels")
    assert [p.path for p in levels.parameters] == [("data", 1), ("data", 0)]
    assert [p.values for p in levels.parameters] == [(0, 1, 2, None)] * 2
    assert step(system, "response", "levels", {}, None, 2) == {
        "C": "heard",
        "C.seen": 1,
        "C.big": True,
    }
    heard = {"C": "heard"}
    assert step(system, "response", "levels", heard, None, 0)["C"] == "quiet"
    assert step(system, "response", "levels", heard, None, None)["C"] == "heard"


def test_a_cancel_is_for_violated_requirements_only():
    system = plant(
        SERVICE_AND_ACTION
        + """
        component D { behaviour { variable p: boolean variable q: boolean initial marked state s {} } }
        requirement act needs D.p
        requirement D.q disables act
        """
    )
    robot = system.robot
    assert to_dsl(event(system, "request", "act").requirement, robot) == "D.p and !D.q"
    assert to_dsl(event(system, "cancel", "act").requirement, robot) == "!D.p or D.q"
    assert event(system, "cancel", "act").requirements == (0, 1)
    assert event(system, "request", "go").requirement is None


def test_a_cancel_without_requirements_is_never_allowed():
    system = plant(SERVICE_AND_ACTION)
    assert event(system, "cancel", "act").requirement == FALSE


def test_state_requirements_are_invariants():
    system = plant(
        """
        component D { behaviour { variable p: boolean initial marked state s {} } }
        requirement never D.p
        requirement always !D.p or D.s
        """
    )
    assert [(to_dsl(e, system.robot), i) for e, i in system.invariants] == [
        ("!D.p", 0),
        ("!D.p or D.s", 1),
    ]
