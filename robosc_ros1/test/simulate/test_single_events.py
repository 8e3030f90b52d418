"""Single events of the supervised system: exactly what explore lists."""

from __future__ import annotations

import random
import re

import pytest
from emit.generated_code import supervisor_of
from hypothesis import given, settings
from hypothesis import strategies as st
from random_models import random_model
from simulate.players import SEVERAL_TYPES, line_follower, play, session

from robosc.plant.automaton import VariableKind
from robosc.simulate.faults import Failed, InvalidLine, Refused
from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.simulate.values.event_data import parameter_values
from robosc.supervisor import Supervisor
from robosc.synthesis import explore


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return line_follower()


@pytest.fixture
def player(supervisor: Supervisor) -> Session:
    return session(supervisor)


@pytest.mark.slow
@settings(max_examples=40)
@given(seed=st.integers(0, 10**6))
def test_a_random_walk_stays_within_the_explored_transitions(seed: int) -> None:
    supervisor = supervisor_of(random_model(random.Random(seed), 1 + seed % 3))
    graph = explore(supervisor)
    if supervisor.empty:
        return
    steps = {(graph.states[t.source], t.event, t.values, graph.states[t.target])
             for t in graph.transitions}  # fmt: skip
    machine = SingleEvents(supervisor)
    rng = random.Random(seed)
    outgoing = {state: {e for s, e, _, _ in steps if s == state} for state in graph.states}
    for _ in range(30):
        before = machine.plant_state
        able = {n for n, e in enumerate(supervisor.plant.events) if machine.can(e, None)}
        assert able == outgoing[before]
        drawn = machine.draw(rng)
        if drawn is None:
            assert not outgoing[before]
            break
        event, value = drawn
        machine.fire(event, value)
        number = next(n for n, e in enumerate(supervisor.plant.events) if e is event)
        assert (before, number, parameter_values(event, value), machine.plant_state) in steps


@pytest.mark.slow
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6))
def test_commands_are_enabled_where_they_can_be_fired(seed: int) -> None:
    supervisor = supervisor_of(random_model(random.Random(seed), 1 + seed % 3))
    if supervisor.empty:
        return
    player = session(supervisor)
    for number in range(10):
        for command in player.machine.commands():
            assert command.enabled is player.machine.can(command.event, None)
        player.do(f"random 1 {number}")


def test_undo_goes_back_step_by_step(player: Session) -> None:
    states = [player.machine.state]
    for number in range(20):
        player.do(f"random 1 {number}")
        states.append(player.machine.state)
    for state in reversed(states):
        assert player.machine.state == state
        if player.history:
            player.do("undo")
    with pytest.raises(Refused, match="there are no steps to undo"):
        player.do("undo")


def test_the_same_seed_takes_the_same_steps(supervisor: Supervisor) -> None:
    histories = []
    for seed in (4, 4, 5):
        player = session(supervisor)
        player.do(f"random 50 {seed}")
        histories.append(player.history)
    assert histories[0] == histories[1] != histories[2]


def test_goto_takes_a_shortest_way(player: Session) -> None:
    done = play(player, "goto ObstacleGrabber.grabbing")
    names = [f"{h.name}.{h.kind}" for h in done.happenings]
    assert names == ["distance.response", "stop.request", "grab.request"]
    assert play(player, "goto ObstacleGrabber.grabbing").text == "it holds already"


@pytest.mark.slow
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6))
def test_no_way_is_shorter(seed: int) -> None:
    """To each state of each component, the events are as many as the graph of explore needs."""
    supervisor = supervisor_of(random_model(random.Random(seed), 1 + seed % 3))
    if supervisor.empty:
        return
    graph = explore(supervisor)
    depth = {0: 0}
    for transition in graph.transitions:  # from states in order of their depth
        depth.setdefault(transition.target, depth[transition.source] + 1)
    variables = [
        (n, a) for n, a in enumerate(supervisor.plant.variables) if a.kind is VariableKind.LOCATION
    ]
    for number, variable in variables:
        for index, name in enumerate(variable.values):
            there = [depth[n] for n, s in enumerate(graph.states) if s[number] == index]
            player = session(supervisor)
            if there:
                assert len(player.do(f"goto {variable.name}.{name}").happenings) == min(there)
            else:
                with pytest.raises(Refused, match="no path leads"):
                    player.do(f"goto {variable.name}.{name}")


def test_goto_where_no_way_leads(player: Session) -> None:
    with pytest.raises(Refused, match="no path leads"):
        player.do("goto Motor.moving and ObstacleGrabber.grabbing and Motor.stopped")
    with pytest.raises(InvalidLine, match="not to data"):
        player.do("goto LineDetector.current_correction > 3")


def test_a_bare_name_means_the_message_rather_than_its_silence(player: Session) -> None:
    play(player, "distance free", "expect distance.fresh", "expect enabled distance.timeout")
    play(player, "distance 0.1", "distance.t", "expect distance.silent")


def test_what_forbids_a_command_is_told_with_its_line(player: Session) -> None:
    with pytest.raises(Refused) as told:
        player.do("move")
    assert re.search(r"move needs DistanceSensor.current = free \(line_follower.rscd:\d+\)",
                     str(told.value))  # fmt: skip


def test_a_whole_run_is_saved_and_played_again(player: Session, tmp_path, supervisor) -> None:
    file = tmp_path / "run.sim"
    play(player, "correction -2.5", "random 40 3", f"save {file}")
    assert "expect Motor." in file.read_text()
    again = session(supervisor)
    again.do(f"play {file}")
    assert again.machine.state == player.machine.state
    assert again.history == player.history


def test_a_saved_text_has_any_character(tmp_path) -> None:
    supervisor = supervisor_of(
        "robot R { component A { outgoing message note with type: string behaviour {"
        " variable text: string initial marked state s { on response from note do text := value }"
        ' } } component B { incoming message go with type: none } requirement go needs A.text = "x"'
        " }"
    )
    player = session(supervisor)
    player.fire(player.event("note"), "a\u2028b\x0cc\x85d\ne")
    play(player, f"save {tmp_path / 'run.sim'}")
    again = session(supervisor)
    again.do(f"play {tmp_path / 'run.sim'}")
    assert again.machine.state == player.machine.state


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("play /dev/zero", "no script has more than 64 MB"),
        ("distnce free", "did you mean 'distance"),
        ("distance", "needs a value: free or obstructed"),
        ("distance fre", "is free or obstructed, or a double"),
        ("distance true", "is free or obstructed, or a double"),
        ("no_line 4", "carries no value"),
        ("correction far", "is a double, not far"),
        ("m)(", "cannot read"),
        ("expct Motor.moving", "did you mean 'expect'"),
        ("goto", "a condition is missing"),
        ("goto Motor.flying", "no variable or state 'flying'"),
        ("goto Moter.moving", "did you mean 'Motor'"),
        ("goto moving", "did you mean 'Motor.moving'"),
        ("goto Motor.moving and 3", "'and' needs a boolean"),
        ("goto 3", "needs a boolean"),
        ("goto (Motor.moving", "is not a condition"),
        ("goto Motor.moving } component x {", "is not a condition"),
        ("goto DistanceSensor.current = close", "has no value 'close'"),
        ("goto DistanceSensor.current = 3", "the other side of '=' needs a number"),
        ("random", "how many steps"),
        ("random 99999999", "at most"),
        ("undo x", "how many steps"),
        ("wait 3", "needs --execute"),
        ("set rate 3", "use --execute"),
        ("99", "there is no number 99"),
        ("why", "there is no command"),
        ("why lift", "there is no command 'lift'"),
        ("save /nowhere/at/all", "cannot write"),
        ("save a\0b", "cannot write"),
        ("play /nowhere/at/all", "cannot read"),
        ("expect enabled", "write an event"),
        ("expect sent distance", "is not sent by a controller"),
        ("expect data move", "write what is sent"),
        ("expect data grab.cancel x: 1", "was not sent"),
        ("grab.cancel x: 1, x: 2", "given twice"),
        ("grab.request(", "cannot read"),
        ("\x1b[A", "cannot read"),
        ("ä", "cannot read"),
    ],
)
def test_a_line_that_means_nothing_says_why(player: Session, line: str, message: str) -> None:
    before = player.machine.state
    with pytest.raises((InvalidLine, Failed)) as told:
        player.do(line)
    assert message in str(told.value)
    assert player.machine.state == before


_WORDS = [
    "goto", "expect", "enabled", "sent", "data", "random", "undo", "why", "set", "distance", "free",
    "move", "grab.error", "Motor.moving", "LineDetector.no_line", "and", "true", "3", "-1e9",
    "x[0]", "!", "(", ")", "=", ",", "*", ":", '"',
]  # fmt: skip


@settings(max_examples=300)
@given(
    line=st.text(max_size=30)
    | st.builds(
        " ".join,
        st.lists(
            st.sampled_from(_WORDS),
            max_size=6,
        ),
    )
)
def test_no_line_at_all_breaks_a_session(line: str, shared: Session) -> None:
    try:
        shared.do(line)
    except (InvalidLine, Refused, Failed) as fault:
        assert str(fault)


@pytest.fixture(scope="module")
def shared(supervisor: Supervisor) -> Session:
    return session(supervisor)


@pytest.fixture
def typed() -> Session:
    return session(supervisor_of(SEVERAL_TYPES))


def test_objects_are_written_part_by_part(typed: Session) -> None:
    play(typed, "pose position.x: 1.5, position.side: -3, tags[0]: 1", "expect Sensor.side = left")
    play(typed, "expect Sensor.x = 1.5 and Sensor.tag = 1", "go", "expect data go 3")
    play(typed, "pose(position.side = right)", "expect Sensor.tag = 1 and Sensor.x = 0.0")
    play(typed, "expect disabled go")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("pose", "position.side of pose.response needs a value"),
        ("pose 3", "write its parts"),
        ("pose position.y: 3, position.side: left", "has no part 'position.y'"),
        ("pose position.side: left, tags: 3", "tags"),
        ("pose position.side: left, tags[0]: 1.5", "is an integer(0..2), not 1.5"),
        ("pose position.side: 1.5", "left, right or middle"),
    ],
)
def test_wrong_parts_are_told(typed: Session, line: str, message: str) -> None:
    if "tags: 3" in line:
        typed.do(line)  # an array that nothing reads as a whole is simply there
        return
    with pytest.raises(InvalidLine) as told:
        typed.do(line)
    assert message in str(told.value)


def test_a_value_outside_its_range_cannot_come(typed: Session) -> None:
    with pytest.raises(Refused, match="outside its range"):
        typed.do("level 4")


def test_own_steps_are_events_too(typed: Session) -> None:
    done = play(typed, "level 3", "expect enabled Sensor.tau1", "Sensor.tau1")
    assert done.happenings[0].value == "quiet->loud"
    play(typed, "expect Sensor.loud", "expect disabled Sensor.tau1")


ARRAYS = """
datatype object Point { x: double y: double }
datatype object Cloud { ranges: array(double) points: array(Point) }
interface cloud use Cloud from example_msgs
component Eye {
    incoming message go with type: double
    outgoing message cloud with type: Cloud links cloud
    behaviour {
        variable near: boolean
        variable most: double
        initial marked state on_ {
            on response from cloud do
                near := any(r < 0.5 for r in value.ranges),
                most := max(p.x for p in value.points if p.y > 0)
        }
    }
}
requirement go needs !Eye.near
provide go with Eye.most
"""


@pytest.fixture
def seeing() -> Session:
    return session(supervisor_of(f"robot Seeing {{ {ARRAYS} }}"))


def test_arrays_are_written_as_in_json(seeing: Session) -> None:
    play(seeing, "cloud ranges: [2, 0.25], points: []", "expect Eye.near", "expect disabled go")
    play(seeing, 'cloud ranges: [2.5], points: [{"x": 1.5, "y": 1}, {"x": 9, "y": 0}]', "go")
    play(seeing, "expect data go 1.5", "cloud", "expect !Eye.near and Eye.most = 1.5", "random 20")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("cloud ranges: 3", "ranges of cloud.response is an array(double), not 3"),
        ("cloud ranges: [true]", "is a double, not true"),
        ('cloud points: [{"x": "far"}]', "is a double, not far"),
        ("cloud ranges: [1, 2", "cannot read"),
        (
            'cloud points: [{"x": 1, "z": 2}]',
            "an element of points of cloud.response has no part 'z'",
        ),
        ("cloud [1, 2]", "cloud.response carries an object Cloud: write its parts"),
    ],
)
def test_wrong_arrays_are_told(seeing: Session, line: str, message: str) -> None:
    with pytest.raises(InvalidLine) as told:
        seeing.do(line)
    assert message in str(told.value)


RANGE_AND_LIMIT = """\
robot R {
    component Laser {
        outgoing message scan with timeout: 1 s, type: double
        behaviour {
            variable front: double
            initial marked state on { on response from scan do front := value }
        }
    }
    component Motor { incoming message move with type: none }
    parameter near: double = 0.4
    requirement move needs scan.fresh and Laser.front > near
}
"""


LIMITED = """
robot Limited {
    component Motor { incoming message move with type: double }
    requirement move needs value <= 0.5
}
"""


@pytest.mark.parametrize("execute", [False, True])
def test_why_tells_for_which_data_a_command_is_allowed(execute: bool) -> None:
    """A plant has an event for each kind of data; "never" is true of one of them alone."""
    supervisor = supervisor_of(LIMITED, supervises=True)
    told = play(Session(machine_maker(supervisor, execute=execute), {}), "why move").text
    parts = re.split(r"(?=move.request[(])", told)
    said = {part.split(")")[0]: "as required" in part for part in parts if "allowed where" in part}
    assert said == {"move.request(value <= 0.5": True, "move.request(!(value <= 0.5": False}, told


def test_why_tells_the_part_that_fails_with_its_values() -> None:
    player = session(supervisor_of(RANGE_AND_LIMIT))

    def because() -> list[str]:
        (command,) = player.machine.commands()
        return [told for reason in command.reasons for told in reason.because]

    front = "Laser.front > near is false (Laser.front is {}, near is 0.4)".format
    assert because() == ["scan.fresh is false", front("0")]
    play(player, "scan 0.3875")
    assert because() == [front("0.3875")]
    told = play(player, "why move").text
    assert front("0.3875") in told
    play(player, "scan 0.5")
    assert because() == []
