"""What conflicts: all of it suffices, and nothing of it can be left out."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from quick import quick_first
from random_models import random_model
from synthesis.oracle import Oracle
from synthesis.oracle_events import Occurrence, OracleState
from synthesis.oracle_values import Impossible
from synthesis.plants import plant_of, supervisor_of
from synthesis.subject import robot_of

from robosc import limits
from robosc.language.events import EventKind
from robosc.model.entities import Robot
from robosc.plant.build import lower
from robosc.supervisor import Explanation, Supervisor
from robosc.synthesis import synthesize
from robosc.synthesis.documents import synthesize_document
from robosc.synthesis.explain.smallest_conflict import smallest_conflict

CIRCLE = """
    component A {
        incoming message go with type: none
        incoming message back with type: none
        behaviour {
            initial state home { on request to go goto away }
            marked state away { on request to back goto home }
        }
    }
    component B {
        incoming message run with type: none
        behaviour {
            initial marked state idle { on request to run goto running }
            marked state running {}
        }
    }
    requirement back needs B.running
    requirement go needs B.running
    requirement run needs B.idle
    requirement run needs A.away
"""
DOOR = """
    component Door {
        incoming message open with type: none
        incoming message lock with type: none
        outgoing message slam with type: none
        behaviour {
            initial marked state shut {
                on request to open goto ajar
                on request to lock goto locked
            }
            marked state ajar { on response from slam goto shut }
            marked state locked {}
        }
    }
    component Arm {
        service grip with request: none, response: none links link
        behaviour {
            initial marked state idle { on request to grip goto busy }
            state busy { on response from grip goto held }
            marked state held { on request to grip goto busy }
        }
    }
    requirement lock needs Arm.held
    requirement possible Door.locked from Door.shut
    requirement open needs Door.shut
    requirement never Door.ajar and Arm.held
"""


def texts(found: Explanation) -> list[str]:
    assert found.conflict is not None
    return [text for text, _ in found.conflict]


def explained(supervisor: Supervisor, name: str) -> Explanation:
    return next(e for e in supervisor.explanations if e.event and e.event.name == name)


def test_requirements_that_wait_for_each_other() -> None:
    supervisor = supervisor_of(CIRCLE)
    assert supervisor.empty
    (why,) = supervisor.explanations
    assert texts(why) == ["requirement go needs B.running", "requirement run needs A.away"]
    assert [note.message for note in why.diagnostic.notes][-2:] == [
        "2 things conflict, and no fewer of them do: 'requirement go needs B.running'",
        "and 'requirement run needs A.away'",
    ]
    assert [d.notes for d in supervisor.diagnostics] == [why.diagnostic.notes]
    document = synthesize_document(supervisor)
    (conflict,) = [explanation["conflict"] for explanation in document["explanations"]]
    assert [part["text"] for part in conflict] == texts(why)


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_goals_and_errors_take_part(engine: str) -> None:
    (why,) = synthesize(plant_of(DOOR), engine).explanations
    assert texts(why) == [
        "requirement lock needs Arm.held",
        "requirement possible Door.locked from Door.shut",
        "grip may fail",
    ]


@pytest.mark.parametrize(
    "mended",
    [
        DOOR.replace("requirement lock needs Arm.held", ""),
        DOOR.replace("requirement possible Door.locked from Door.shut", ""),
        DOOR.replace("goto held }", "goto held on error from grip goto idle }"),
    ],
)
def test_mending_any_of_it_gives_a_controller(mended: str) -> None:
    assert not supervisor_of(mended).empty


def test_of_a_command_that_never_happens() -> None:
    text = """
        component Light {
            outgoing message on with type: boolean
            behaviour {
                initial marked state off { on response from on if value goto lit }
                marked state lit { on response from on if !value goto off }
            }
        }
        component Door {
            incoming message open with type: none
            incoming message wave with type: none
            behaviour {
                initial marked state shut { on request to open goto opened }
                marked state opened { on request to wave }
            }
        }
        requirement wave needs Light.off
        requirement never Door.opened and Light.lit
        requirement open needs Light.off
    """
    why = explained(supervisor_of(text), "open")
    assert texts(why) == ["requirement never Door.opened and Light.lit"]
    # The trace tells of that requirement already.
    assert len(why.diagnostic.notes) == 1
    assert texts(explained(supervisor_of(text), "wave")) == texts(why)


COPIES = """
    component Light {
        outgoing message on with type: boolean
        behaviour {
            initial marked state off { on response from on if value goto lit }
            marked state lit { on response from on if !value goto off }
        }
    }
    component Station[1..3] {
        incoming message go with type: none
        behaviour {
            initial marked state s { on request to go goto t }
            marked state t { on request to go goto s }
        }
    }
    requirement never Station[2].t and Light.lit
    requirement Station[3].go needs Station[2].t
    requirement Station[1].go needs Station[3].t
"""


def test_what_is_told_of_a_copy_is_about_that_copy() -> None:
    """All copies of a command stand at one place of the model."""
    supervisor = supervisor_of(COPIES)
    first = texts(explained(supervisor, "Station[2].go"))
    assert first == ["requirement never Station[2].t and Light.lit"]
    second = texts(explained(supervisor, "Station[3].go"))
    assert second == [*first, "requirement Station[3].go needs Station[2].t"]
    (told,) = (d for d in supervisor.diagnostics if d.code == "never-allowed")
    assert told.message.startswith("Station[2].go")
    assert [note.message for note in told.notes] == ["this is where it goes wrong"]


def test_an_error_may_be_the_only_way_on() -> None:
    """It is no part of the conflict: without it there would be no controller either."""
    text = """
        component Arm {
            service grip with request: none, response: none links link
            incoming message wave with type: none
            behaviour {
                initial state idle { on request to grip goto busy }
                state busy { on response from grip goto idle on error from grip goto done }
                marked state done { on request to wave goto idle }
            }
        }
        requirement grip needs Arm.done
    """
    (why,) = supervisor_of(text).explanations
    assert texts(why) == ["requirement grip needs Arm.done"]


SILENT = """
    component Sensor {
        outgoing message seen with timeout: 1 s, type: boolean
        incoming message go with type: none
        behaviour {
            initial marked state standing { on request to go goto moving }
            marked state moving {}
        }
    }
    requirement never Sensor.moving and seen.silent
    requirement go needs Sensor.standing
"""
UNHANDLED = """
    component Arm {
        service grip with request: none, response: boolean links link
        behaviour {
            initial marked state idle { on request to grip goto busy }
            state busy {
                on response from grip if value goto idle
                on error from grip goto idle
            }
        }
    }
"""
CANCELLED = """
    component Runner {
        outgoing action run with request: none, response: none, feedback: none links link
        behaviour {
            initial marked state free { on request from run goto running }
            state running { on response to run goto free }
        }
    }
    requirement never run.ending
"""


@pytest.mark.parametrize(
    ("text", "conflict"),
    [
        (SILENT, ["requirement never Sensor.moving and seen.silent", "seen may fall silent"]),
        (UNHANDLED, ["response from grip is not handled everywhere"]),
        (CANCELLED, ["requirement never run.ending", "run may be cancelled"]),
    ],
    ids=["silent", "unhandled", "cancelled"],
)
@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_what_the_robot_may_do_takes_part(text: str, conflict: list[str], engine: str) -> None:
    (why,) = synthesize(plant_of(text), engine).explanations
    assert texts(why) == conflict


def test_large_data_are_not_solved_again() -> None:
    text = """
        component A {
            outgoing message m with type: integer(0..5000)
            behaviour {
                variable x: integer(0..5000)
                initial marked state s { on response from m do x := value }
            }
        }
        requirement never A.x = 77
    """
    (why,) = synthesize(plant_of(text), "auto").explanations
    assert why.conflict is None


def test_a_large_search_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "CONFLICT_WORK", 10)
    (why,) = supervisor_of(CIRCLE).explanations
    assert why.conflict is None
    assert synthesize_document(supervisor_of(CIRCLE))["explanations"][0]["conflict"] is None


@pytest.mark.parametrize("seed", range(30))
def test_of_any_conflicts_a_smallest_one_is_found(seed: int) -> None:
    """A family of conflicts decides: a set fails if it contains one of them."""
    chosen = random.Random(seed)
    number = chosen.randint(1, 12)
    family = [frozenset(chosen.sample(range(number), chosen.randint(1, number))) for _ in range(3)]
    asked = []

    def fails(kept: frozenset[int]) -> bool:
        asked.append(kept)
        return any(conflict <= kept for conflict in family)

    found = frozenset(smallest_conflict(range(number), fails))
    assert fails(found)
    assert not any(fails(found - {one}) for one in found)
    # Far fewer questions than there are subsets.
    assert len(asked) <= 2 * (len(found) + 1) * (number.bit_length() + 2)


class Without(Oracle):
    """The reading of the tests without some of what the robot may do, by its text."""

    def __init__(self, robot: Robot, left_out: str) -> None:
        super().__init__(robot)
        self._left_out = left_out

    def step(self, state: OracleState, occurrence: Occurrence) -> OracleState:
        event = occurrence.event
        name = self.robot.display_names.get(event.key, "")
        told = {
            EventKind.ERROR: f"{name} may fail",
            EventKind.TIMEOUT: f"{name} may fall silent",
            EventKind.RECALL: f"{name} may be cancelled",
            EventKind.RESPONSE: f"response from {name} is not handled everywhere",
            EventKind.CANCELLED: f"cancelled from {name} is not handled everywhere",
        }
        if told.get(event.kind) == self._left_out and not (
            "handled" in self._left_out
            and any(
                self._taken(component, state, occurrence) for component in self.concerned(event)
            )
        ):
            raise Impossible
        return super().step(state, occurrence)


def rules_out(robot: Robot, conflict: list[str], found: Explanation, left_out: str = "") -> bool:
    """Whether the reading of the tests, too, finds no controller, or no such command, of what
    conflicts without one part of it."""
    kept = [text for text in conflict if text != left_out]
    fewer = replace(
        robot,
        requirements=tuple(r for r in robot.requirements if r.text in kept),
        goals=tuple(g for g in robot.goals if g.text in kept),
    )
    states, steps = Without(fewer, left_out).controlled
    if found.event is None:
        return not states
    key = found.event.key
    requests = (step.occurrence.event for step in steps)
    return not any((event.kind.value, event.key) == ("request", key) for event in requests)


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
@pytest.mark.parametrize("first", quick_first(range(0, 60, 15), 1))
def test_conflicts_of_random_models(first: int, engine: str) -> None:
    """What the robot may do is there, but for the part of the conflict that is left out."""
    looked_at = 0
    for seed in range(first, first + 15):
        robot = robot_of(random_model(random.Random(seed), 2, served=bool(seed % 2)))
        for found in synthesize(lower(robot), engine).explanations:
            if found.conflict is None:
                continue
            conflict = texts(found)
            looked_at += bool(conflict)
            assert rules_out(robot, conflict, found)
            for one in conflict:
                assert not rules_out(robot, conflict, found, one), (seed, one)
    assert looked_at


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_goals_that_only_together_cannot_be_met(engine: str) -> None:
    text = """
        component Switch {
            incoming message left with type: none
            incoming message right with type: none
            behaviour {
                initial marked state middle {
                    on request to left goto at_left
                    on request to right goto at_right
                }
                marked state at_left {}
                marked state at_right {}
            }
        }
        requirement possible Switch.at_left
        requirement possible Switch.at_right
    """
    (why,) = synthesize(plant_of(text), engine).explanations
    assert [note.message for note in why.diagnostic.notes] == [
        "this is where it goes wrong",
        "2 goals cannot remain possible together; without any one of them the others can:"
        " 'requirement possible Switch.at_left'",
        "and 'requirement possible Switch.at_right'",
    ]
    for goal in ("at_left", "at_right"):
        alone = text.replace(f"requirement possible Switch.{goal}", "")
        assert not synthesize(plant_of(alone), engine).empty


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_assumptions_take_part(engine: str) -> None:
    """What is assumed away is the only way back to where a command is allowed."""
    text = """
        component Lamp {
            outgoing message lit with type: boolean
            incoming message leave with type: none
            behaviour {
                initial state dark { on response from lit if value goto bright }
                state bright { on request to leave goto gone }
                marked state gone {}
            }
        }
        requirement leave needs Lamp.bright
        assume never Lamp.gone
        assume lit needs !value
    """
    (why,) = synthesize(plant_of(text), engine).explanations
    assert texts(why) == ["assume lit needs !value"]
    assert not synthesize(plant_of(text.replace("assume lit needs !value", "")), engine).empty
