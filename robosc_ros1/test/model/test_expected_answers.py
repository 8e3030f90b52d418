"""``expect:`` and ``within:``: which answers are a success, and how long a goal may take."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from model.model_text import faults, resolve
from runtime.lamp_robot import PlayedPort
from simulate.players import play, session

from robosc.emit.package.config import declared_communications, declared_parameters
from robosc.language.events import EventKind
from robosc.model.resolve import load
from robosc.plant.automaton import Plant, PlantState, VariableKind
from robosc.plant.step import Verdict, outcome, valuations
from robosc.runtime.core.calls import Failure
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import Settings, declared, read
from robosc.simulate.faults import Refused
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis.verify.verification import verify

ROBOT = """
robot Hand {
    interface grip use Grip from some_msgs
    interface store use Store from some_msgs
    datatype object Grip { held: boolean, force: array(double) }
    datatype object Stored { success: boolean, message: string }
    parameter least: double = 2.0
    component Hand {
        action grip with expect: value.held and value.force[0] > least, within: 20 s,
            request: none, response: Grip, feedback: none links grip
        service store with timeout: 1 s, expect: value.success,
            request: none, response: Stored links store
        behaviour {
            variable full: boolean
            variable holds: boolean
            variable weak: boolean
            on response from grip do holds := value.held
            on error from grip do weak := value.held
            on error from store do full := value.message = "full"
            initial marked state open {}
        }
    }
    requirement grip needs !Hand.weak and !Hand.holds
    requirement store needs Hand.holds and !Hand.full
}
""".replace(", force", " force").replace(", message", " message")


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(ROBOT)


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_a_response_is_as_expected(engine: str) -> None:
    found = supervisor_of(ROBOT, engine=engine)
    assert found.controlled_states == 6
    assert verify(found).verified


def test_other_answers_are_no_response_in_the_plant(supervisor: Supervisor) -> None:
    plant = supervisor.plant
    variable = plant.variable_index[VariableKind.PHASE, "Hand.grip"]
    (event,) = (e for e in plant.events if e.identity[:2] == (EventKind.RESPONSE, "Hand.grip"))
    held = [parameter.path for parameter in event.parameters].index(("held",))
    possible = {
        (phase, values[held])
        for phase in range(3)
        for values in valuations(event)
        if outcome(plant, event, values, _with(plant, variable, phase)) is not Verdict.IMPOSSIBLE
    }
    assert possible == {(1, True), (2, True)}


def _with(plant: Plant, variable: int, value: int) -> PlantState:
    return tuple(value if n == variable else v for n, v in enumerate(plant.initial))


class Played:
    """The generated controller, executed; ``told`` are the events of one communication."""

    def __init__(self, supervisor: Supervisor) -> None:
        self.port = PlayedPort()
        self.controller = controller_class(supervisor)[0]()
        self.engine = controller_engine(self.controller, self.port, Settings())
        self.engine.begin()
        self.engine.cycle()

    def answer(self, key: str, kind: str, message: Any) -> list[tuple[str, Any, str | None]]:
        self.engine.report(key, self.port.tokens[key], kind, message)
        self.engine.recorder.take()
        self.engine.cycle()
        events = self.engine.recorder.take()
        return [(e.kind, e.value, e.detail) for e in events if e.kind in ("response", "error")]


GOOD = SimpleNamespace(held=True, force=[3.0])
REFUSED = "refused: the answer is not as expected"


@pytest.mark.parametrize(
    "message",
    [SimpleNamespace(held=True, force=[2.0]), SimpleNamespace(held=True, force=[])],
    ids=["too weak", "undefined"],
)
def test_another_answer_is_an_error_with_that_answer(supervisor: Supervisor, message: Any) -> None:
    played = Played(supervisor)
    ((kind, value, detail),) = played.answer("Hand.grip", "response", message)
    assert (kind, value, detail) == ("error", {"held": True}, REFUSED)
    assert (played.controller.hand_weak, played.controller.hand_holds) == (True, False)
    assert played.engine.recorder.counters["errors"] == 1


def test_an_error_of_a_service_has_the_answer_only_if_that_was_refused(
    supervisor: Supervisor,
) -> None:
    played = Played(supervisor)
    ((kind, *_),) = played.answer("Hand.grip", "response", GOOD)
    assert kind == "response"
    ((_, value, _),) = played.answer("Hand.store", "error", "it is broken")
    assert (value["message"], played.controller.hand_full) == (None, False)
    played = Played(supervisor)
    played.answer("Hand.grip", "response", GOOD)
    full = SimpleNamespace(success=False, message="full")
    ((kind, value, _),) = played.answer("Hand.store", "response", full)
    told = (kind, value["message"], played.controller.hand_full)
    assert told == ("error", "full", True)


@pytest.mark.parametrize("execute", [False, True])
def test_simulated_answers(supervisor: Supervisor, execute: bool) -> None:
    player = session(supervisor, execute=execute)
    if not execute:
        play(player, "grip.request")
    play(player, "expect grip.busy")
    weak = "held: true, force[0]: 1.5"
    if execute:
        play(player, f"grip.response {weak}", "expect grip.idle and !Hand.holds")
    else:
        with pytest.raises(Refused):
            play(player, f"grip.response {weak}")
        play(player, "grip.response held: true, force[0]: 2.5", "expect grip.idle and Hand.holds")


def test_an_aborted_goal_is_an_error_whatever_its_result(supervisor: Supervisor) -> None:
    ((kind, _, detail),) = Played(supervisor).answer("Hand.grip", "error", Failure("aborted", GOOD))
    assert (kind, detail) == ("error", "aborted")


def test_the_time_that_a_goal_may_take_is_a_default(supervisor: Supervisor) -> None:
    communications = declared_communications(supervisor.plant.robot)
    settings, _ = read(communications, {})
    assert settings.goal_timeout_of("Hand.grip") == 20.0
    settings, _ = read(communications, {"goal_timeout/grip": 0})
    assert settings.goal_timeout_of("Hand.grip") is None


def test_a_parameter_may_say_how_long_a_goal_may_take() -> None:
    text = ROBOT.replace("within: 20 s", "within: most")
    robot = supervisor_of(text.replace("component", "parameter most: duration = 3 s component", 1))
    robot = robot.plant.robot
    communications = declared_communications(robot)
    assert "goal_timeout/grip" not in {p.name for p in declared(communications)}
    settings, _ = read(communications, {"most": 7.0}, declared_parameters(robot))
    assert settings.goal_timeout_of("Hand.grip") == 7.0


HEAD = "interface l use L from p component A {"
DATA = "} datatype object D { a: double }"


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("service s with expect: A.open, request: none, response: D links l",
         [("unknown-name", "A")]),
        ("service s with expect: value, request: none, response: none links l",
         [("value-not-allowed", "value")]),
        ("service s with expect: value.a, request: none, response: D links l",
         [("type-mismatch", "value.a")]),
        ("service s with expect: value.b = 1, request: none, response: D links l",
         [("unknown-member", "b")]),
        ("action s with within: 0 s, request: none, response: D, feedback: none links l",
         [("out-of-range", "0 s")]),
        ("action s with within: 1, request: none, response: D, feedback: none links l",
         [("syntax", "1")]),
        ("service s with within: 1 s, request: none, response: D links l", [("syntax", "within")]),
        ("outgoing message s with expect: value > 1, type: double", [("syntax", "expect")]),
        ("action s with within: 1 s, within: 2 s, request: none, response: D, feedback: none"
         " links l", [("syntax", "within")]),
        ("service s with request: none, response: D links l behaviour { variable v: double"
         " on error from s do v := value.a initial marked state o {} }",
         [("value-not-allowed", "value")]),
    ],
)  # fmt: skip
def test_what_is_wrong_with_them(line: str, found: list[tuple[str, str]]) -> None:
    told = faults(HEAD + line + DATA)
    assert [entry for entry in told if entry[0] != "package-not-found"] == found


def test_a_response_without_a_value_is_told() -> None:
    action = "action go with request: none, response: none, feedback: D links l"
    assumed = f"robot R {{ {HEAD} {action} {DATA} assume go needs value.a > 1.0 }}"
    expected = (
        f"robot R {{ {HEAD} {action.replace('with', 'with expect: value.a > 1.0,')} {DATA} }}"
    )
    for text in (assumed, expected):
        _, diagnostics = load(Source("model.rscd", text))
        (told,) = (d.message for d in diagnostics if d.code == "value-not-allowed")
        assert told == "the response of go carries no value"


def test_attributes_stand_in_any_order() -> None:
    orders = (
        'within: 2 s, expect: value.a > 1, identifier: "/x", timeout: 1 s',
        'timeout: 1 s, identifier: "/x", expect: value.a > 1, within: 2 s',
    )
    types = "request: none, response: D, feedback: none links l"
    robots = [resolve(f"{HEAD} action s with {order}, {types} {DATA}") for order in orders]
    first, second = (robot.communications["A.s"] for robot in robots)
    assert first == second


@pytest.mark.parametrize(
    ("attribute", "transitions", "told"),
    [
        ("", "on response from store goto full on error from store goto open", True),
        ("", "on response from store do n := 1 goto open on error from store goto open", True),
        ("expect: value.success, ", "on response from store goto full on error from store goto open", False),
        ("", "on response from store if value.success goto full on response from store else goto open"
             " on error from store goto open", False),
        ("", "on response, error from store goto open", False),  # it makes no difference
        ("", "on response from store goto full", False),  # synthesis tells that
    ],
)  # fmt: skip
def test_an_answer_that_says_no_is_read(attribute: str, transitions: str, told: bool) -> None:
    text = f"""
    interface store use Store from some_msgs
    datatype object Stored {{ success: boolean }}
    component Hand {{
        service store with {attribute}request: none, response: Stored links store
        behaviour {{
            variable n: integer(0..1)
            initial marked state open {{ on request to store goto storing }}
            state storing {{ {transitions} }}
            marked state full {{}}
        }}
    }}
    """
    found = [(code, shown) for code, shown in faults(text) if code == "refusal-unread"]
    assert found == [("refusal-unread", "store")] * told
