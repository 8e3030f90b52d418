"""Scripts have nothing that messages cannot hold, and expect nothing that nodes cannot send."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from emit.generated_code import supervisor_of
from emit.golden_packages import GOLDEN
from emit.scripted_controllers import scripts_of
from ros_support import REPOSITORY

from robosc import pipeline
from robosc.model.ros.definitions import MessageDefinitions
from robosc.simulate.faults import InvalidLine
from robosc.simulate.values.message_fields import KnownFields
from robosc.traces.scripts import Traces, choose, script

EVERYTHING = REPOSITORY / "robosc_ros1" / "test" / "ros2" / "models" / "everything.rscd"
INTERFACES = EVERYTHING.parents[1] / "interfaces"


def texts_of(traces: Traces) -> str:
    return "\n".join(script(traces.coverage.steps.supervisor, run, "run") for run in traces.runs)


def chosen(text: str) -> Traces:
    """The runs for a model of whose messages none is found."""
    supervisor = supervisor_of(text)
    definitions = MessageDefinitions(ros_version="1")
    return choose(supervisor, KnownFields(supervisor.plant.robot, definitions))


def test_bounds_of_ros_2_are_kept() -> None:
    """The bounds as they stand in the message: string<=8, string<=4[<=3], bool[<=4], uint8."""
    where = {"ROS_PACKAGE_PATH": str(INTERFACES)}
    definitions = MessageDefinitions.for_model(EVERYTHING, where, ros_version="2")
    supervisor = pipeline.synthesize(pipeline.load(EVERYTHING).robot)
    known = KnownFields(supervisor.plant.robot, definitions)
    text = texts_of(choose(supervisor, known))
    assert not known.unknown
    heard = re.findall("^heard.response (.*)$", text, re.MULTILINE)
    assert heard
    for line in heard:
        parts = dict(re.findall(r'([\w.\[\]]+): ("[^"]*"|[^,]+)', line))
        assert len(parts["short_name"]) <= 8 + 2
        assert len(parts["tags[1]"]) <= 4 + 2
        assert 0 <= int(parts["raw"]) < 256


FAST = """
robot Fast {
    interface small use Small from own_msgs
    component Count {
        outgoing message level with type: integer(0..4)
        behaviour {
            variable items: integer(0..4) = 0
            initial marked state open { on response from level do items := value }
        }
    }
    component Gear {
        incoming message gear with type: integer links small
        incoming message lamp with type: boolean
    }
    requirement gear needs Count.items >= 1
    requirement lamp needs Count.items = 4
    provide gear with Count.items * 40
    provide lamp with true
}
"""


PACKAGE = """<package format="2"><name>own_msgs</name><version>1.0.0</version>
<description>-</description><maintainer email="a@b.c">-</maintainer><license>-</license>
<buildtool_depend>catkin</buildtool_depend></package>"""


def test_a_command_beyond_its_field_holds_back_nothing_and_is_not_expected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "own_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text(PACKAGE, encoding="utf-8")
    (package / "msg" / "Small.msg").write_text("int8 data\n", encoding="utf-8")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    model = tmp_path / "fast.rscd"
    model.write_text(FAST, encoding="utf-8")
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    definitions = MessageDefinitions.for_model(model, ros_version="1")
    traces = choose(supervisor, KnownFields(supervisor.plant.robot, definitions))
    assert not traces.coverage.steps.fields.unknown
    text = texts_of(traces)
    numbers = {int(n) for n in re.findall("^expect data gear.request data: (.*)$", text, re.M)}
    assert numbers
    assert numbers <= {40, 80, 120}
    after = text.split("level.response 4\n")[1]
    assert after.startswith("expect sent lamp.request\n")


REPORTING = """
robot Reporting {
    component Orders {
        outgoing action order with type: actionlib/Test
        behaviour {
            variable told: boolean
            initial marked state free { on request from order goto busy_ }
            state busy_ {
                on feedback to order do told := !told
                on response to order goto free
            }
        }
    }
    component Base {
        outgoing message done with type: boolean
        incoming message rest with type: none
        behaviour {
            variable over: boolean
            initial marked state on_ { on response from done do over := value }
        }
    }
    requirement order.response needs Base.over
    prefer order.feedback over rest
    provide order.feedback with { feedback: 7 }
    stop with nothing
}
"""


def test_answers_hold_back_what_they_are_preferred_to() -> None:
    supervisor = supervisor_of(REPORTING)
    definitions = MessageDefinitions(ros_version="1")
    text = texts_of(choose(supervisor, KnownFields(supervisor.plant.robot, definitions)))
    repeated = set(re.findall("^wait 1\nexpect sent (.*)$", text, re.M))
    assert repeated == {"order.feedback", "rest.request"}


@pytest.mark.parametrize(("number", "arrives"), [(0.1, 0.10000000149), (-3e38, -3e38)])
def test_a_number_beyond_32_bits_does_not_fit(number: float, arrives: float) -> None:
    """It is no infinity, which another number could be."""
    model = """
        robot Far {
            component Base { incoming message far with type: double }
            provide far with 1.0
            stop with nothing
        }
    """
    supervisor = supervisor_of(model)
    known = KnownFields(supervisor.plant.robot, MessageDefinitions(ros_version="1"))
    event = next(e for e in supervisor.plant.events if e.name == "far")
    assert known.narrow(event, {"data": number}) == {"data": pytest.approx(arrives, rel=1e-7)}
    for beyond in (4e38, -1e300):
        with pytest.raises(InvalidLine, match="does not fit float32"):
            known.narrow(event, {"data": beyond})


ARM = """
robot Arm {
    interface reach use Reach from gauntlet_interfaces
    datatype object Goal { height: integer }
    datatype object Outcome { quality: integer }
    component Runner {
        outgoing message wanted with type: boolean
        action run with identifier: "/run", request: Goal, response: Outcome, feedback: double
            links reach
        behaviour {
            variable progress: double
            variable quality: integer = 7
            variable want: boolean
            initial marked state resting {
                on response from wanted do want := value
                on request to run goto running
            }
            state running {
                on feedback from run do progress := value
                on response from run goto resting
                on error from run if reason = failed do quality := value.quality goto resting
                on error from run if reason != failed goto resting
            }
        }
    }
    requirement run needs Runner.want
    provide run with { height: 1 }
}
"""


def test_only_goals_that_are_rejected_have_no_result() -> None:
    """And none is rejected after its server has told how far it is."""
    rejected, is_told = [], False
    for line in texts_of(chosen(ARM)).splitlines():
        word, _, rest = line.partition(" ")
        if word == "run.error":
            rejected += [is_told] if "rejected" in rest else []
            assert ("quality" in rest) is ("rejected" not in rest)
        is_told = word == "run.feedback" or (is_told and word not in ("run.error", "run.response"))
    assert rejected
    assert not any(rejected)


def test_commands_take_turns() -> None:
    """The lamp is allowed only while a mission ends, which the node answers at once; where it has
    answered before, it is the lamp's turn."""
    supervisor = pipeline.synthesize(pipeline.load(GOLDEN / "models" / "missions.rscd").robot)
    assert any("expect sent lamp.request" in text for text in scripts_of(supervisor))


def test_definitions_that_are_not_found_are_told() -> None:
    traces = chosen(ARM)
    assert traces.coverage.steps.fields.unknown == {"gauntlet_interfaces/Reach"}
