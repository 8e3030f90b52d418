"""The CIF text means the same as the model: run by a small CIF reader, held against the oracle."""

from __future__ import annotations

import random
import re
from collections import deque
from pathlib import Path
from typing import Any

import pytest
from data_models import data_model
from emit.cif_reader import read_cif
from emit.cif_system import Specification, State
from random_models import random_model
from synthesis.oracle import Occurrence, Oracle, OracleState
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.emit.export.cif import cif_plant, cif_supervised
from robosc.errors import UsageError
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.plant.build import lower
from robosc.source import Source
from robosc.synthesis import explore
from robosc.synthesis.event_parameters import weight

CELL = """
robot Cell {
    interface link use Thing from some_robot_msgs
    datatype enum Level from double to { value > 2 -> high default -> low }
    component Tank {
        outgoing message level with type: Level
        service fill with request: none, response: integer(-1..1) links link
        behaviour {
            variable now: Level = high
            variable depth: integer(-2..2)
            initial marked state open {
                on response from level do now := value
                on request to fill
                on response from fill if value != 0 do depth := depth - value
                on error from fill do depth := depth * depth
                transition if depth / 2 > 0.5 goto end
            }
            marked state end { transition goto open }
        }
    }
    requirement fill needs Tank.now = low => Tank.depth - 1 < 1
    requirement never Tank.end and Tank.depth = 1
}
"""


def event_name(oracle: Oracle, occurrence: Occurrence) -> str:
    """What an occurrence is called in CIF, as the export's documentation has it."""
    event = occurrence.event
    prefix = "c" if event.controllable else "u"
    name = oracle.name(event).replace(".", "_")
    if event.kind.of_component:
        return f"{prefix}_{name}_{event.kind.word}{event.index}"
    return "_".join([prefix, name, event.kind.word, *(_word(v) for _, v in occurrence.values)])


def _word(value: Any) -> str:
    if value is None:
        return "missing"
    if isinstance(value, bool):
        return str(value).lower()
    return f"m{-value}" if isinstance(value, int) and value < 0 else str(value)


def compare(
    oracle: Oracle,
    steps: dict[OracleState, dict[str, OracleState]],
    graph: dict[State, dict[str, State]],
    specification: Specification,
) -> None:
    """Walk both systems together: the same events in each pair of states, one to one."""
    assert len(steps) == len(graph)
    if not steps:
        return
    pairs = {oracle.initial: specification.initial}
    queue = deque(pairs)
    while queue:
        state = queue.popleft()
        theirs = graph[pairs[state]]
        assert set(steps[state]) == set(theirs), state
        assert oracle.marked(state) == specification.is_marked(pairs[state])
        for event, target in steps[state].items():
            if target not in pairs:
                pairs[target] = theirs[event]
                queue.append(target)
            assert pairs[target] == theirs[event], (state, event)
    assert len(set(pairs.values())) == len(steps)


def graph_of(oracle: Oracle, plant: bool) -> dict[OracleState, dict[str, OracleState]]:
    states, transitions = oracle.plant if plant else oracle.controlled
    found: dict[OracleState, dict[str, OracleState]] = {state: {} for state in states}
    for transition in transitions:
        name = event_name(oracle, transition.occurrence)
        found[transition.source][name] = transition.target
    return found


def check(robot: Robot) -> None:
    oracle = Oracle(robot)
    plant = read_cif(cif_plant(lower(robot)))
    compare(oracle, graph_of(oracle, plant=True), plant.graph(), plant)
    compare(oracle, graph_of(oracle, plant=False), plant.synthesized(), plant)
    supervisor = pipeline.synthesize(robot)
    if not supervisor.empty:
        supervised = read_cif(cif_supervised(supervisor))
        expected = graph_of(oracle, plant=False)
        compare(oracle, expected, supervised.graph(supervised=True), supervised)


def test_hand_made_robot() -> None:
    check(robot_of(CELL))


@pytest.mark.parametrize(
    "condition",
    [
        "(A.x / A.y else 3.0) < 2.0",
        "(A.x % A.y else 1) = 1 or A.near",
        "A.x / A.y < 1.0 else A.near",
        "A.near else A.x > 1",
        "(A.near else true) and !(A.x > A.y else false)",
    ],
)
def test_else_is_written_out(condition: str) -> None:
    """CIF has nothing undefined; what comes to no number is known value by value."""
    check(
        robot_of(f"""
        robot Else {{
            component A {{
                outgoing message m with type: integer(0..2)
                outgoing message n with type: integer(0..2)
                incoming message go with type: none
                behaviour {{
                    variable x: integer(0..2)
                    variable y: integer(0..2)
                    variable near: boolean
                    initial marked state s {{
                        on response from m do x := value, near := {condition}
                        on response from n if {condition} do y := value
                    }}
                }}
            }}
            requirement go needs {condition}
        }}""")
    )


DATA = """
component Battery {
    outgoing message battery with type: double
    outgoing message name with type: string
    incoming message drive with type: none
    incoming message halt with type: none
    behaviour {
        variable charge: double = 1.0
        variable last: double
        variable label: string = "a"
        variable n: integer
        initial marked state ok {
            on response from battery if value > 0.3 do charge := value, last := charge
            on response from battery if !(value > 0.3) goto low
            on response from name do label := value
        }
        marked state low {
            on request to drive do n := n + 1 goto ok
            on response from battery do charge := 0.9
        }
    }
}
requirement drive needs Battery.charge > 0.2 and Battery.charge <= 0.8 or Battery.label = "b"
requirement halt needs Battery.charge < Battery.last and Battery.n < 3
requirement never Battery.low and Battery.charge = 0.25
"""


def check_data(text: str) -> None:
    """The export has as many states and transitions as the controlled system."""
    supervisor = pipeline.synthesize(robot_of(text))
    if supervisor.empty:
        return
    graph = explore(supervisor)
    found = read_cif(cif_supervised(supervisor)).graph(supervised=True)
    assert len(found) == len(graph.states)
    assert sum(map(len, found.values())) == len(graph.transitions)
    synthesized = read_cif(cif_plant(supervisor.plant)).synthesized()
    assert len(synthesized) == len(graph.states)


def test_data_become_enumerations() -> None:
    check_data(f"robot R {{ {DATA} }}")
    text = cif_plant(lower(robot_of(f"robot R {{ {DATA} }}")))
    assert 'is_b: Battery.label = "b"' in text


ENUM = """
datatype enum Band from double to { value > 2.0 -> high default -> low }
component Tank {
    outgoing message level with type: double
    outgoing message name with type: string
    incoming message drain with type: none
    behaviour {
        variable depth: double
        variable label: string
        initial marked state s {
            on response from level do depth := value
            on response from name if value != "" do label := value
        }
    }
}
requirement drain needs high = Band(Tank.depth) or Tank.label = "" and Band(Tank.depth) = low
"""


def test_an_enum_of_no_variable_is_compared_by_classes() -> None:
    check_data(f"robot R {{ {ENUM} }}")
    text = cif_plant(lower(robot_of(f"robot R {{ {ENUM} }}")))
    assert "enum Band" not in text
    assert "u_name_response_is_empty" in text


NEVER_THERE = {
    "what is not expected": (
        "service lock with expect: value.success, request: none, response: Done links lock",
        "on request to lock goto busy",
        "on response from lock do done := value.success goto idle on error from lock goto idle",
    ),
    "data that a component blocks": (
        "incoming message lock with type: boolean outgoing message told with type: boolean",
        "on request to lock if value goto busy",
        "on response from told do done := value goto idle",
    ),
}
LOCK = """
robot Lock {{
    datatype object Done {{ success: boolean }}
    interface lock use Trigger from std_srvs
    component Door {{
        {communications}
        behaviour {{
            variable done: boolean
            initial marked state idle {{ {asks} }}
            state busy {{ {ends} }}
        }}
    }}
    component Lamp {{
        incoming message shine with type: none
        behaviour {{ initial marked state dark {{ on request to {{ shine, lock }} }} }}
    }}
    requirement shine needs Door.done
}}
"""


@pytest.mark.parametrize("case", NEVER_THERE)
def test_values_with_which_an_event_never_happens(case: str) -> None:
    """An event of which an automaton has no edge at all would be possible always."""
    communications, asks, ends = NEVER_THERE[case]
    text = LOCK.format(communications=communications, asks=asks, ends=ends)
    robot, _ = load(Source("lock.rscd", text), supervises=True)
    assert robot is not None
    found = read_cif(cif_plant(lower(robot))).graph()
    graph = pipeline.explore(robot, plant=True)
    assert len(found) == len(graph.states)
    assert sum(map(len, found.values())) == len(graph.transitions)


def test_names_have_no_letters_but_those_of_cif() -> None:
    text = ENUM.replace('!= ""', '!= "café ☕"').replace('= ""', '= "naïve"')
    check_data(f"robot R {{ {text} }}")
    code = re.sub("//.*", "", cif_plant(lower(robot_of(f"robot R {{ {text} }}"))))
    assert code.isascii()


RANDOM = [(seed, "") for seed in range(6)] + [(seed, "parameter") for seed in range(1, 4)]
RANDOM += [(0, "enum"), (1, "enum"), (2, "enum"), (0, "failure")]


@pytest.mark.parametrize(("seed", "extra"), RANDOM)
def test_random_data_become_enumerations(seed: int, extra: str) -> None:
    rng = random.Random(seed)
    while True:
        text = data_model(rng, seed % 2 == 1, extra)
        plant = lower(robot_of(text))
        tests = [v.test.name for v in plant.variables if v.test is not None]
        across = any("Sensor" in name and "Base" in name for name in tests)
        if not across and all(weight(event) < 60 for event in plant.events):
            check_data(text)
            return


PARAMETERS = """
robot R {
    parameter careful: boolean = true
    parameter limit: double = 0.5
    parameter gear: integer(1..3) = 2
    component Parameters {
        outgoing message battery with type: double
        incoming message drive with type: none
        incoming message halt with type: none
        behaviour {
            variable charge: double = 1.0
            variable chosen: integer(1..3) = 1
            initial marked state ok {
                on response from battery do charge := value
                on request to halt do chosen := gear goto ok
            }
        }
    }
    requirement drive needs (careful => Parameters.charge > limit) and limit > 0.2
    requirement halt needs Parameters.chosen != gear
}
"""


def test_parameters_are_variables_with_any_value_at_the_start() -> None:
    check_data(PARAMETERS)
    text = cif_plant(lower(robot_of(PARAMETERS)))
    assert "plant automaton Parameters_:" in text
    assert "  disc bool careful in {true, false};" in text
    assert "  disc int[1..3] gear in {2, 1, 3};" in text


def test_data_that_cif_has_no_place_for() -> None:
    two = """robot R {{
        component A {{ outgoing message m with type: double
            behaviour {{ variable x: double initial marked state s {{ on response from m do x := value }} }} }}
        component B {{ outgoing message k with type: double incoming message go with type: none
            behaviour {{ variable y: double initial marked state s {{ on response from k do y := value }} }} }}
        {more}
    }}"""
    more = "requirement go needs A.x < B.y"
    reason = "data of A and B are compared with each other"
    with pytest.raises(UsageError, match=re.escape(reason)):
        cif_plant(lower(robot_of(two.format(more=more))))


def test_names_that_are_words_of_cif() -> None:
    check(
        robot_of(
            "robot R { component C { incoming message go with type: none behaviour {"
            " initial marked state alphabet { on request to go goto edge }"
            " marked state edge { on request to go goto alphabet } } } }"
        )
    )


def test_names_inside_an_automaton_hide_none_outside() -> None:
    text = cif_plant(
        lower(
            robot_of(
                "robot R { component C { incoming message go with type: none behaviour {"
                " initial marked state c_go_request { on request to go goto C }"
                " state C { on request to go goto c_go_request } } } }"
            )
        )
    )
    assert "location c_go_request_:" in text
    assert "location C_:" in text
    assert "edge c_go_request goto C_;" in text


@pytest.mark.slow
@pytest.mark.parametrize("chunk", range(4))
def test_random_robots(chunk: int) -> None:
    for seed in range(500 + 25 * chunk, 500 + 25 * (chunk + 1)):
        kinds = {"served": seed % 3 == 0, "assumes": seed % 2 == 0}
        lines = random_model(random.Random(seed), 1 + seed % 2, **kinds).split("\n")
        # CIF has no such requirements.
        text = "\n".join(line for line in lines if "requirement possible" not in line)
        try:
            check(robot_of(text))
        except Exception as error:
            raise AssertionError(f"seed {seed}\n{text}") from error


@pytest.mark.parametrize(
    "assumed",
    ["count needs C.n + value <= 2", "count needs C.n + value <= 3", "count needs value > 2", ""],
)
def test_what_is_assumed_away_leaves_no_range(assumed: str) -> None:
    """A request was forbidden wherever a response could leave the range without the assumption."""
    assumption = f"assume {assumed}" if assumed else ""
    check(
        robot_of(
            f"""robot R {{
                interface link use Work from some_package
                component C {{
                    service count with request: none, response: integer(0..2) links link
                    behaviour {{
                        variable n: integer(0..2)
                        initial marked state idle {{ on request to count goto asking }}
                        state asking {{
                            on response from count do n := n + value goto idle
                            on error from count do n := 0 goto idle
                        }}
                    }}
                }}
                {assumption}
            }}"""
        )
    )


ERRANDS = """
    interface link use Work from some_package
    component Errand {
        outgoing action errand with request: none, response: none, feedback: boolean links link
        outgoing message low with type: boolean
        behaviour {
            initial marked state free { on request from errand goto busy }
            state busy {
                on response from low if value goto failed
                on response to errand goto free
            }
            state failed performs errand.error then goto free
        }
    }
    component Witness {
        behaviour {
            initial marked state one { on response from low if !value goto two }
            state two performs errand.error then goto one { on response from low goto one }
        }
    }
    provide errand.feedback with Errand.busy
"""


@pytest.mark.parametrize("command", ["errand", "errand.response", "errand.feedback"])
def test_requirements_on_answers_restrict_those_that_they_name(command: str) -> None:
    check(robot_of(f"robot Test {{ {ERRANDS} requirement {command} needs Witness.one }}"))


def test_text_of_a_specification() -> None:
    """What it looks like; integers from below 0 are kept from 0 upwards."""
    expected = Path(__file__).with_name("cell.cif").read_text()
    assert cif_plant(lower(robot_of(CELL))) == expected
