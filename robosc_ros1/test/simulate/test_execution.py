"""The controller as it executes: edges, rate, settling, deadlines, on the virtual clock."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from emit.generated_code import supervisor_of
from simulate.players import MODEL, SEVERAL_TYPES, line_follower, play, sent, session

from robosc.simulate.faults import Failed, InvalidLine, Refused
from robosc.simulate.machines.state import make_controller
from robosc.simulate.script.session import Session
from robosc.simulate.values.event_data import complete
from robosc.supervisor import Supervisor
from robosc.synthesis.formatting import path_text


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return line_follower()


@pytest.fixture
def player(supervisor: Supervisor) -> Session:
    return session(supervisor, execute=True)


def test_what_becomes_allowed_is_sent_at_once(player: Session) -> None:
    assert sent(play(player, "distance 0.5")) == ["move"]
    assert sent(play(player, "distance free")) == []
    assert sent(play(player, "distance 0.1")) == ["stop", "grab"]
    assert player.machine.time == 0.0


def test_what_stays_allowed_is_repeated_at_the_rate(player: Session) -> None:
    done = play(player, "distance free", "wait 0.35")
    moves = [h.time for h in done.happenings if h.name == "move"]
    assert moves == pytest.approx([0.1, 0.2, 0.3])
    done = play(player, "set rate 4", "set timeout/distance 2", "distance free", "wait 1")
    moves = [h.time for h in done.happenings if h.name == "move"]
    assert moves == pytest.approx([0.25, 0.5, 0.75, 1.0])


def test_long_waits_do_not_drift(player: Session) -> None:
    done = play(
        player,
        "set timeout/distance 200",
        "distance free",
        "set_light_state.response",
        "wait 100",
    )
    moves = [h.time for h in done.happenings if h.name == "move"]
    assert len(moves) == pytest.approx(1000, abs=1)
    assert moves[-1] == pytest.approx(round(moves[-1], 1), abs=1e-6)


def test_a_request_without_answer_ends_at_its_deadline(player: Session) -> None:
    done = play(player, "wait 5.05")
    ends = [h for h in done.happenings if h.kind == "error"]
    assert [(h.name, h.time, h.detail) for h in ends] == [
        ("set_light_state", pytest.approx(5.0), "no answer in time")
    ]
    play(player, "set timeout/set_light_state 0.5", "wait 0.49", "expect LightBulb.switching")
    play(player, "wait 0.02", "expect LightBulb.unknown")


def test_goals_are_accepted_and_answered(player: Session) -> None:
    play(player, "distance 0.1", "expect grab.busy", "grab.feedback", "expect grab.busy")
    play(player, "wait 20", "expect grab.busy")  # accepted: no deadline
    play(player, "grab.error", "expect ObstacleGrabber.looking and !grab.busy")


def test_a_goal_is_cancelled_when_its_requirement_is_violated(player: Session) -> None:
    done = play(player, "distance 0.1", "distance free")
    assert ("cancel", "grab") in [(h.kind, h.name) for h in done.happenings]
    play(player, "expect grab.cancelling")
    with pytest.raises(Refused, match="grab is cancelling"):
        player.do("grab.feedback")
    play(player, "distance 0.1", "wait 1", "expect grab.cancelling")
    play(player, "grab.cancelled", "distance 0.1", "wait 1", "expect grab.busy")
    with pytest.raises(Refused, match="grab is busy"):
        player.do("grab.cancelled")


def test_a_goal_that_takes_too_long_is_cancelled_and_ends_as_its_server_says(
    player: Session,
) -> None:
    play(player, "set goal_timeout/grab 3", "distance 0.1", "wait 5", "expect grab.busy")
    done = player.do("grab.cancelled")
    assert [(h.kind, h.detail) for h in done.happenings if h.name == "grab"] == [
        ("error", "deadline exceeded")
    ]


def test_commands_are_not_typed(player: Session) -> None:
    with pytest.raises(InvalidLine, match="sent by the controller itself"):
        player.do("move")
    with pytest.raises(InvalidLine, match="goto is for single events"):
        player.do("goto Motor.moving")


def test_components_settle_before_commands() -> None:
    player = session(supervisor_of(SEVERAL_TYPES), execute=True)
    done = play(player, "level 3")
    assert [(h.kind, h.value) for h in done.happenings] == [("response", 3), ("tau", "quiet->loud")]


def test_a_mismatch_is_counted_and_may_stop_the_controller() -> None:
    supervisor = supervisor_of(SEVERAL_TYPES)
    player = session(supervisor, execute=True)
    done = play(player, "level 4", "expect mismatch", "expect Sensor.level = 0")
    with pytest.raises(Failed, match="no safe stop"):
        player.do("expect stopped")
    strict = session(supervisor, execute=True, parameters={"on_mismatch": "stop"})
    done = play(strict, "level 4")
    assert [h.outcome for h in done.happenings] == ["mismatch", "stopped"]
    play(strict, "expect stopped")
    assert {r.kind for c in strict.machine.commands() for r in c.reasons[:1]} == {"stopped"}
    with pytest.raises(Failed, match="there was a safe stop"):
        strict.do("expect enabled go")


def test_undo_is_as_if_it_had_not_been(player: Session, supervisor: Supervisor) -> None:
    play(player, "random 15 8")
    state, time, history = player.machine.state, player.machine.time, list(player.history)
    play(player, "distance 0.5", "wait 2.5", "distance 0.1", "undo 3")
    assert (player.machine.state, player.machine.time, player.history) == (state, time, history)
    untouched = session(supervisor, execute=True)
    play(untouched, "random 15 8")
    assert play(player, "wait 1").happenings == play(untouched, "wait 1").happenings


def test_a_random_run_is_saved_with_its_parameters(supervisor: Supervisor, tmp_path) -> None:
    player = session(supervisor, execute=True, parameters={"rate": 3, "order": "declared"})
    file = tmp_path / "run.sim"
    play(player, "random 40 2", f"save {file}")
    again = session(supervisor, execute=True)
    again.do(f"play {file}")
    assert again.machine.state == player.machine.state
    assert again.machine.time == pytest.approx(player.machine.time)


@pytest.mark.parametrize("execute", [False, True])
def test_why_a_goal_is_not_cancelled(execute: bool) -> None:
    """First no requirement is violated; then one is, but nobody says what follows on a cancel."""
    forgetful = MODEL.parents[1] / "line_follower_unhandled" / "line_follower_unhandled.rscd"
    text = forgetful.read_text().replace(
        "on response from grab goto idle",
        "on response from grab goto idle on error from grab goto idle",
    )
    player = session(supervisor_of(text, str(forgetful)), execute=execute)
    play(player, "distance 0.1", *([] if execute else ["grab"]))

    def reasons() -> list[tuple[str, str]]:
        (cancel,) = [c for c in player.machine.commands() if c.event.kind.word == "cancel"]
        return [(r.kind, r.text) for r in cancel.reasons]

    requirement = "requirement DistanceSensor.current = free disables grab"
    assert reasons() == [("requirement", f"this requirement holds: {requirement}")]
    play(player, "distance 0.5")
    ((kind, text),) = reasons()
    assert kind == "synthesis" and text.startswith("grab.cancel can never be allowed: after")


@pytest.mark.parametrize("event", ["grab", "set_light_state"])
def test_a_busy_command_is_refused_for_the_same_reasons_in_every_mode(
    supervisor: Supervisor, event: str
) -> None:
    def reasons(execute: bool) -> list[tuple[str, str]]:
        player = session(supervisor, execute=execute)
        orders = ["set_light_state", "distance 0.1", "stop", "grab"]
        play(player, *(["distance 0.1"] if execute else orders))
        (command,) = [
            c
            for c in player.machine.commands()
            if (c.event.name, c.event.kind.word) == (event, "request")
        ]
        return [(r.kind, r.text) for r in command.reasons]

    assert reasons(False)[0] == ("phase", "it is busy")
    assert "synchronisation" in dict(reasons(False))
    assert reasons(False) == reasons(True)


LANE = """
robot Lane {
    component Car[1..3] {
        incoming message go with identifier: "/car_{index}/go", type: none
        outgoing message there with identifier: "/car_{index}/there", type: none
        behaviour {
            initial marked state away { on request to go goto coming }
            state coming { on response from there goto away }
        }
    }
    component Gate {
        outgoing message open with identifier: "/open", type: boolean
        behaviour {
            variable wide: boolean = false
            on response from open do wide := value
            initial marked state shut { on response from open if value goto up }
            state up {
                on request to Car[1].go
                on request to Car[2].go
                on request to Car[3].go%s
                on response from open if !value goto shut
            }
        }
    }
}
"""


@pytest.mark.parametrize("guard", ["", " if wide"], ids=["one function for all", "methods"])
def test_only_components_that_block_are_named_in_every_mode(guard: str) -> None:
    lane = supervisor_of(LANE % guard)
    played, executed = session(lane), session(lane, execute=True)

    def reasons(player: Session) -> list[list[tuple[str, str]]]:
        return [[(r.kind, r.text) for r in c.reasons] for c in player.machine.commands()]

    shut = ("synchronisation", "blocked by Gate in shut")
    assert reasons(played) == [[shut]] * 3 == reasons(executed)
    play(executed, "open true", "open false")
    play(played, "open true", "Car[1].go", "Car[2].go", "Car[3].go", "open false")
    coming = [("synchronisation", f"blocked by Car[{i}] in coming") for i in (1, 2, 3)]
    assert reasons(played) == [[one, shut] for one in coming] == reasons(executed)


@pytest.mark.parametrize("side", [-3, 0, 7])
@pytest.mark.parametrize("tags", [[], [2], [0, 1]])
def test_values_are_converted_as_the_controller_converts_messages(
    side: int, tags: list[int]
) -> None:
    supervisor = supervisor_of(SEVERAL_TYPES)
    point = SimpleNamespace(x=2.5, side=side)
    controller = make_controller(supervisor)
    entry = next(i for i in controller.INPUTS if i.key == "Sensor.pose")
    event = next(e for e in supervisor.plant.events if e.key == entry.key)
    parts = {"position.x": 2.5, "position.side": side}
    parts |= {f"tags[{n}]": tag for n, tag in enumerate(tags)}
    given = complete(supervisor.plant.robot, event, parts, "pose")
    read = entry.read(controller, SimpleNamespace(position=point, tags=tags, label=""))
    assert {path_text(path): value for path, value in given.items()} == read


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("set rte 3", "did you mean ~rate"),
        ("set rate fast", "must be a number"),
        ("set rate", "write a parameter"),
        ("wait", "number of seconds"),
        ("wait -1", "number of seconds"),
        ("wait 0", "more than 0"),
        ("wait 1e9", "number of seconds"),
        ("wait 99999", "at most 3600"),
    ],
)
def test_wrong_lines(player: Session, line: str, message: str) -> None:
    history = list(player.history)
    with pytest.raises(InvalidLine) as told:
        player.do(line)
    assert message in str(told.value)
    assert player.history == history


REFUSED = """
robot Refused {
    component B {
        service q with expect: value.success, identifier: "/q", request: none, response: Answer
            links answers
        incoming message lamp with rate: once, type: none
        behaviour {
            initial marked state asking {
                on error from q if reason = refused and value.message = "hot" goto hot
                on error from q else goto other
            }
            marked state hot {}
            marked state other {}
        }
    }
    datatype object Answer { success: boolean message: string }
    interface answers use Ask from some_msgs
    requirement lamp needs B.hot
}
"""


@pytest.mark.parametrize(("message", "place"), [("hot", "hot"), ("cold", "other")])
def test_what_is_read_of_a_refused_answer_only(message: str, place: str) -> None:
    """The transition of the error reads a field that no transition of the response does."""
    player = session(supervisor_of(REFUSED), execute=True)
    play(player, f'q.response success: false, message: "{message}"', f"expect B.{place}")


BEYOND = """
robot Beyond {
    component Base {
        outgoing message level with type: integer
        incoming message gear with type: std_msgs/UInt8
        incoming message gears with type: std_msgs/UInt8MultiArray
        incoming message far with type: double
        incoming message rest with type: none
        behaviour {
            variable last: integer = 1
            initial marked state on_ { on response from level do last := value }
        }
    }
    prefer { gear, gears, far } over rest
    provide gear with { data: Base.last }
    provide gears with { data: [1, Base.last] }
    provide far with Base.last * 1e36
}
"""


def test_commands_beyond_their_fields_are_not_sent_and_hold_back_nothing() -> None:
    """As in nodes, where a message cannot be packed."""
    player = session(supervisor_of(BEYOND), execute=True)
    done = play(player, "level 255", "wait 0.15")
    assert {(h.name, h.outcome) for h in done.happenings} == {
        ("gear", "applied"), ("gears", "applied"), ("far", "applied")
    }  # fmt: skip
    done = play(player, "level 400")
    assert sent(done) == ["rest"]
    done = play(player, "wait 0.15")
    failed = {h.name: h.detail for h in done.happenings if h.outcome == "failed"}
    assert failed == {
        "gear": "400 does not fit uint8",
        "gears": "400 does not fit uint8",
        "far": "4e+38 does not fit float32",
    }
    assert {h.name for h in done.happenings if h.outcome == "applied"} == {"rest"}


REPORTING = """
robot Reporting {
    component Orders {
        outgoing action order with type: actionlib/Test
        behaviour {
            initial marked state free { on request from order goto busy_ }
            state busy_ { on response to order goto free }
        }
    }
    component Base {
        outgoing message level with type: integer
        incoming message rest with type: none
        behaviour {
            variable last: integer = 1
            initial marked state on_ { on response from level do last := value }
        }
    }
    requirement order.response needs Base.last = 0
    prefer order.feedback over rest
    provide order.feedback with { feedback: Base.last * 1000000000 }
    stop with nothing
}
"""


def test_answers_hold_back_what_they_are_preferred_to_if_they_fit() -> None:
    """They are looked at as what they are, a result or feedback, as in nodes."""
    player = session(supervisor_of(REPORTING), execute=True)
    assert sent(play(player, "wait 0.15")) == ["rest"]
    done = play(player, "order.request", "wait 0.25")
    assert {(h.kind, h.outcome) for h in done.happenings} == {("feedback", "applied")}
    commands = {c.event.kind.word: c for c in player.machine.commands()}
    assert commands["request"].waits_for == ("order.feedback",)
    done = play(player, "level 3", "wait 0.15")
    failed = {h.detail for h in done.happenings if h.outcome == "failed"}
    assert failed == {"3000000000 does not fit int32"}
    assert {h.name for h in done.happenings if h.outcome == "applied"} == {"rest"}
