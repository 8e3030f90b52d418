"""``start next: 3``: a run begins with a value that was kept."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from synthesis.subject import oracle_of

from robosc.errors import EmptySupervisorError, UsageError
from robosc.pipeline import supervised
from robosc.simulate.faults import InvalidLine
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker, started

BODY = """
    component Base {
        incoming message drive with type: integer
        outgoing message START with type: boolean
    }
    component Tour {
        outgoing message arrived with type: none
        behaviour {
            PERSISTENT variable next: integer(0..3) = 0
            initial marked state on {
                on response from arrived if next < 3 do next := next + 1
            }
        }
    }
    provide drive with Tour.next
    requirement drive needs Tour.next < 3
    stop with nothing
"""


def model(persistent: str = "persistent", name: str = "begin", more: str = "") -> str:
    body = BODY.replace("PERSISTENT", persistent).replace("START", name)
    return f"robot Tours {{ {body} {more} }}"


@pytest.mark.parametrize("execute", [False, True])
def test_lines_start_with_values(execute: bool) -> None:
    session = Session(machine_maker(supervisor_of(model()), execute=execute))
    session.do("expect Tour.next = 0")
    session.do("start Tour.next: 2")
    session.do("expect Tour.next = 2")
    session.do("expect enabled drive")
    session.do("arrived")
    session.do("expect disabled drive")
    session.do("restart")
    session.do("expect Tour.next = 2")
    assert "start Tour.next: 2\n" in session.script()
    session.do("start next: 3")
    session.do("expect disabled drive")
    for wrong in ("start next: 4", "start next: true", "start lap: 1", "start 3", "start"):
        with pytest.raises(InvalidLine):
            session.do(wrong)
        session.do("expect Tour.next = 3")
    with pytest.raises(InvalidLine, match="cannot start with true:"):
        session.do("start next: true")


def test_without_persistent_variables_it_is_a_name_as_any() -> None:
    session = Session(machine_maker(supervisor_of(model("", "start")), execute=False))
    session.do("start true")
    with pytest.raises(InvalidLine, match="is no persistent variable"):
        machine_maker(supervisor_of(model("")), execute=False)({}, {"next": 1})


def test_a_recording_may_begin_with_values() -> None:
    supervisor = started(supervisor_of(model()), ["next=3"])
    assert supervisor.plant.initial[supervisor.plant.variable_index[NEXT]] == 3
    with pytest.raises(UsageError, match="integer"):
        started(supervisor, ["next=7"])


NEXT = next(key for key in supervisor_of(model()).plant.variable_index if key[1] == "Tour.next")


def test_a_start_that_cannot_be_controlled_is_told() -> None:
    """Tour.next never becomes 0 by itself: only the node may begin with it."""
    never = "requirement never Tour.next = 0"
    begins = model(more=never).replace("integer(0..3) = 0", "integer(0..3) = 1")
    with pytest.raises(EmptySupervisorError) as error:
        supervised(oracle_of(begins).robot, None)
    assert "if Tour.next <= 0 at the start" in str(error.value.diagnostics)
    supervised(oracle_of(begins.replace("persistent", "")).robot, None)
