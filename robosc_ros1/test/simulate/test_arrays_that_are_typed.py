"""Elements of an array or parts of an object that is typed as a whole."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, session

from robosc.simulate.faults import Failed, InvalidLine

MODEL = """
robot R {
    interface link use Report from some_msgs
    datatype object Report { position: array(double) place: Place }
    datatype object Place { x: double }
    component A {
        outgoing message joints with type: Report links link
        incoming message far with type: none
        incoming message near with type: Place links link
        behaviour {
            variable q: array(double)
            variable place: Place
            variable x: double
            variable y: double
            initial marked state s {
                on response from joints
                    do q := value.position, x := value.position[2], place := value.place,
                        y := value.place.x
            }
        }
    }
    requirement far needs A.x > 0.5 and A.q[1] > 0.5 and A.y > 1
    provide near with A.place
}
"""


@pytest.mark.parametrize("execute", [False, True])
def test_what_a_whole_holds_is_there(execute: bool) -> None:
    player = session(supervisor_of(MODEL), execute=execute)
    play(player, "joints position: [1.0, 2.0, 3.0], place.x: 4.0")
    play(player, "expect A.x = 3.0", "expect A.q[1] > 0.5", "expect A.y = 4.0")
    play(player, "joints position: [0.5], place.x: 0.0")
    play(player, "expect A.x = 3.0", "expect !defined(A.q[1])", "expect A.y = 0.0")


@pytest.mark.parametrize("execute", [False, True])
def test_what_is_drawn_is_one_value(execute: bool) -> None:
    player = session(supervisor_of(MODEL), execute=execute)
    for seed in range(20):
        play(player, f"random 1 {seed}")
        state = player.machine.state.variables
        if state["A.place"] is not None:
            assert state["A.place"].x == state["A.y"]


def test_a_part_is_what_the_whole_has_there() -> None:
    player = session(supervisor_of(MODEL))
    play(player, "joints position: [0, 0, 1.5], position[2]: 1.5, place.x: 0", "expect A.x = 1.5")
    for line in (
        "joints position: [1.0], position[2]: 3.0",
        "joints place.x: 1, position[2]: 1, position: []",
    ):
        with pytest.raises(
            InvalidLine, match=r"position\[2\] of joints.response is not what position has"
        ):
            player.do(line)


def test_what_a_whole_holds_is_not_asked_for_again() -> None:
    hints = [choice.hint for choice in session(supervisor_of(MODEL)).machine.choices()]
    assert "position: array(double), place: Place" in hints


ROUTE = """
robot R {
    interface link use Route from some_msgs
    datatype object Route { names: array(string) points: array(Point) }
    datatype object Point { levels: array(double) last: boolean }
    component A {
        incoming message drive with type: Route links link
        behaviour { variable level: double = 0.5 initial marked state s {} }
    }
    provide drive with { names: ["a"],
        points: [{ levels: [1, A.level] }, { levels: [0 / 0], last: true }] }
}
"""


def test_parts_of_arrays_that_are_sent_can_be_expected() -> None:
    player = session(supervisor_of(ROUTE))
    play(player, "drive", "expect data drive names[0]: a, points[0].levels[1]: 0.5")
    play(player, "expect data drive points[1].levels: [NaN]", 'expect data drive names: ["a"]')
    play(player, 'expect data drive points: [{"levels": [1, 0.5]}, {"last": true}]')
    for line, message in (
        ("points: [1]", "points was "),
        ("points: [1, 2]", "points was "),
        ("points: 3", "points was "),
        ('points: [{"levels": [1, 0.5], "last": true}, {"last": true}]', "points was "),
        ("points[0].levels[1]: 0.25", r"points\[0\].levels\[1\] was 0.5, not 0.25"),
        ("points[2].last: true", r"points\[2\].last was not sent; sent were names, points"),
        ("points.last: true", "points.last was not sent"),
    ):
        with pytest.raises(Failed, match=message):
            player.do(f"expect data drive {line}")


SIDES = """
robot R {
    interface link use Report from some_msgs
    datatype object Report { sides: array(Side) at: array(At) one: Side }
    datatype object At { side: Side x: double }
    datatype enum Side from integer to { value < 0 -> left value > 0 -> right default -> middle }
    component A {
        outgoing message report with type: Report links link
        outgoing message place with type: integer(0..3)
        incoming message go with type: none
        behaviour {
            variable n: integer(0..3)
            variable seen: array(Side)
            variable first: Side
            variable at: array(At)
            variable all: Report
            on response from place do n := value
            initial marked state s {
                on response from report
                    do seen := value.sides, first := value.sides[0], at := value.at, all := value
            }
        }
    }
    requirement go needs any(x = left for x in A.seen) and A.seen[A.n] = left
        and any(a.side = left for a in A.at) and A.all.one = left
}
"""


@pytest.mark.parametrize("execute", [False, True])
@pytest.mark.parametrize("left", ["-1", '"left"'])
def test_enums_within_a_whole_are_converted_where_they_are_read(execute: bool, left: str) -> None:
    """Like the generated controller, which keeps the message; a name gives a value for it."""
    player = session(supervisor_of(SIDES), execute=execute)
    one = left.strip('"')
    play(player, f'report sides: [{left}, 2], at: [{{"side": {left}}}], one: {one}')
    play(player, "expect A.first = left", "expect A.seen[1] = right", "expect enabled go")
    play(player, "expect any(a.side = left for a in A.at)", "expect A.all.one = left")
    assert player.machine.state.variables["A.seen"] == [-1, 2]
    play(player, "place 1", "expect disabled go", "expect A.seen[A.n] = right", "place 0")
    play(player, 'report sides: ["middle"], at: [], one: left', "expect disabled go")
    play(player, "expect A.first = middle", "expect all(x = middle for x in A.seen)")


@pytest.mark.parametrize("execute", [False, True])
def test_enums_within_a_whole_are_drawn(execute: bool) -> None:
    player = session(supervisor_of(SIDES), execute=execute)
    play(player, "random 50 1")
    assert {type(side) for side in player.machine.state.variables["A.seen"]} <= {int}


def test_constants_have_names_of_enums() -> None:
    text = (
        "robot F { constant modes: array(Side) = [left, right]"
        " datatype enum Side from integer to { value < 0 -> left default -> right }"
        " component A { outgoing message n with type: integer(0..1)"
        " incoming message go with type: none incoming message come with type: none"
        " behaviour { variable n: integer(0..1)"
        " initial marked state s { on response from n do n := value } } }"
        " requirement go needs modes[A.n] = left"
        " requirement come needs any(x = right for x in modes[0..A.n]) }"
    )
    player = session(supervisor_of(text))
    play(player, "n 0", "expect enabled go", "expect disabled come")
    play(player, "n 1", "expect disabled go", "expect enabled come")


OBJECTS = """
robot R {
    interface link use Route from some_msgs
    datatype object Route { points: array(Point) }
    datatype object Point { x: double tags: array(integer) }
    component A {
        outgoing message route with type: Route links link
        behaviour {
            variable first: Point
            variable tags: array(integer)
            initial marked state s {
                on response from route do first := value.points[0], tags := value.points[1].tags
            }
        }
    }
}
"""


@pytest.mark.parametrize("execute", [False, True])
def test_an_object_that_an_array_does_not_have_is_missing(execute: bool) -> None:
    player = session(supervisor_of(OBJECTS), execute=execute)
    play(player, "route points: []", "expect !defined(A.first)", "expect !defined(A.tags)")
    play(player, 'route points: [{"x": 1.5}]', "expect A.first.x = 1.5", "expect !defined(A.tags)")
    play(player, 'route points: [{"x": 2.5}, {"tags": [7]}]', "expect A.tags[0] = 7")
    play(player, "route", "expect A.first.x = 2.5", "route points[0].x: 0.5")
    play(player, "expect A.first.x = 0.5", "expect A.tags[0] = 7")
