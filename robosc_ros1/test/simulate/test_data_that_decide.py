"""Playing a robot whose decisions compare numbers: classes in single events, exact data when run."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, sent, session

from robosc.supervisor import Supervisor

MODEL = """
robot R {
    component Battery {
        outgoing message battery with type: double
        behaviour {
            variable charge: double = 1.0
            variable last: double
            initial marked state ok {
                on response from battery do charge := value, last := charge
            }
        }
    }
    component Base {
        incoming message drive with type: double
        incoming message step with type: none
        behaviour {
            variable n: integer
            initial marked state s { on request to step do n := n + 1 }
        }
    }
    requirement drive needs Battery.charge > 0.2 and Battery.charge < Battery.last
    requirement step needs Base.n < 2
    provide drive with Battery.charge
}
"""


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(MODEL)


def test_classes_and_tests_are_the_choices_of_single_events(supervisor: Supervisor) -> None:
    player = session(supervisor)
    assert [choice.text for choice in player.machine.choices()] == [
        "battery.response(!(value > 0.2), value < Battery.charge)",
        "battery.response(!(value > 0.2), !(value < Battery.charge))",
        "battery.response(value > 0.2, value < Battery.charge)",
        "battery.response(value > 0.2, !(value < Battery.charge))",
        "step.request(Base.n + 1 < 2)",
        "step.request(Base.n + 1 >= 2)",
    ]


def test_what_is_typed_decides_about_tests(supervisor: Supervisor) -> None:
    player = session(supervisor)
    play(player, "battery 0.5")
    drive = next(c for c in player.machine.commands() if c.event.name == "drive")
    assert drive.enabled
    assert list((drive.data or {}).values()) == [0.5]
    play(player, "battery 0.6")
    assert not next(c for c in player.machine.commands() if c.event.name == "drive").enabled
    assert player.machine.state.variables["Battery.charge"] == 0.6


def test_a_chosen_outcome_decides_whatever_the_data_are(supervisor: Supervisor) -> None:
    player = session(supervisor)
    play(player, "6")
    step = next(c for c in player.machine.commands() if c.event.name == "step")
    assert [reason.kind for reason in step.reasons] == ["requirement"]


def test_running_keeps_numbers_exactly(supervisor: Supervisor) -> None:
    player = session(supervisor, execute=True)
    assert sent(play(player, "battery 0.25")) == ["drive"]
    assert sent(play(player, "battery 0.2500000001")) == []
    assert sent(play(player, "battery 0.2")) == []
    assert player.machine.state.variables == {
        "Battery.charge": 0.2,
        "Battery.last": 0.2500000001,
        "Base.n": 1,
    }
