"""Arrays that a model makes: in what is sent, in variables, and in conditions of commands."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from emit.generated_code import controller_class, supervisor_of
from emit.scripted_controllers import faults_of
from model.model_text import faults
from simulate.players import play, session

MODEL = """
datatype object Point { x: double y: double }
datatype object Pose { position: Point marks: array(double) }
datatype object Path { poses: array(Pose) near: array(boolean) ranges: array(double) }
datatype object Scan { ranges: array(double) count: integer points: array(Point) }
interface path use Path from example_msgs
interface scan use Scan from example_msgs
constant route: array(Point) = [{ x: i * 0.5, y: n } for i, n in [4, 5, 6] if n != 5]
component A {
    outgoing message scan with type: Scan links scan
    incoming message go with type: Path links path
    incoming message come with type: none
    behaviour {
        variable close: array(double)
        variable first_close: integer
        variable nearest: Point
        initial marked state on {
            on response from scan
                do close := [r * 2 for r in value.ranges if r < 1],
                    first_close := first(i for i, r in value.ranges if r < 1) else -1,
                    nearest := first(p for p in value.points if p.x >= value.ranges[value.count])
        }
    }
}
component Lamp[1..2] {
    outgoing message lit with identifier: "lit_{index}", type: boolean
    behaviour { variable on: boolean initial marked state s { on response from lit do on := value } }
}
provide go with {
    poses: [
        { position: p, marks: [i, p.x + A.first_close] } for i, p in route if p.y > A.first_close
    ],
    near: [l.on for l in Lamp],
    ranges: A.close
}
requirement go needs first(r for r in A.close if r > 0.5) < 1.5
requirement come needs length([r for i, r in A.close if i > 0]) > 1 or A.nearest.y > 3
"""
ROBOT = "robot R { %s }"


def scan(ranges: list[float], count: int = 0, points: tuple[float, ...] = ()) -> SimpleNamespace:
    return SimpleNamespace(
        ranges=ranges, count=count, points=[SimpleNamespace(x=x, y=2 * x) for x in points]
    )


def plain(data: object) -> object:
    if isinstance(data, SimpleNamespace):
        return vars(data)
    if isinstance(data, dict):
        return {name: plain(part) for name, part in data.items()}
    return [plain(part) for part in data] if isinstance(data, list) else data


@pytest.mark.parametrize(
    ("ranges", "expected"),
    [
        ([2.0, 0.25, 0.5], ([(0, 0.0, 4, 1.0), (2, 1.0, 6, 2.0)], [0.5, 1.0])),
        ([3.0] * 5 + [0.25], ([(2, 1.0, 6, 6.0)], [0.5])),
        ([], ([(0, 0.0, 4, -1.0), (2, 1.0, 6, 0.0)], [])),
    ],
)
def test_what_is_made_is_sent(
    ranges: list[float], expected: tuple[list[tuple[float, ...]], list[float]]
) -> None:
    supervisor = supervisor_of(ROBOT % MODEL)
    controller = controller_class(supervisor)[0]()
    controller.on_response_of_scan(vars(scan(ranges)))
    controller.on_response_of_lamp_2_lit(True)
    points, close = expected
    found = plain(controller.data_for_go())
    # The positions count what is in the array, not what is chosen of it.
    assert found == {
        "poses": [
            {"position": {"x": x, "y": y}, "marks": [1.0 if i == 2 else 0.0, mark]}
            for i, x, y, mark in points
        ],
        "near": [False, True],
        "ranges": close,
    }
    assert all(type(m) is float for pose in found["poses"] for m in pose["marks"])


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_commands_wait_for_what_is_made(engine: str) -> None:
    player = session(supervisor_of(ROBOT % MODEL, engine=engine), execute=True)
    play(
        player,
        "scan ranges: [2.0, 0.25, 0.5], count: 0",
        "expect enabled go",
        "expect disabled come",
        "scan ranges: [0.1, 0.2, 0.9], count: 0",
        "expect disabled go",
        "expect enabled come",
        "scan ranges: [0.1], count: 0",
        "expect disabled come",
    )


def test_the_test_of_the_package_makes_the_same() -> None:
    assert faults_of(supervisor_of(ROBOT % MODEL)) == []


def test_an_array_with_an_undefined_element_is_not_there() -> None:
    """So its variable stays as it was, and what would be sent is not."""
    text = MODEL.replace(
        "[r * 2 for r in value.ranges", "[value.ranges[i + 1] for i, r in value.ranges"
    )
    controller = controller_class(supervisor_of(ROBOT % text))[0]()
    controller.on_response_of_scan(vars(scan([0.5, 0.75, 3.0])))
    assert controller.a_close == [0.75, 3.0]
    controller.on_response_of_scan(vars(scan([2.0, 0.5])))
    assert controller.a_close == [0.75, 3.0] and controller.a_first_close == 1
    text = MODEL.replace("marks: [i,", "marks: [A.close[i],")
    controller = controller_class(supervisor_of(ROBOT % text))[0]()
    controller.on_response_of_scan(vars(scan([2.0, 0.25])))
    with pytest.raises(IndexError):
        controller.data_for_go()


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        ("{ poses: [{ position: p } for p in route] }", None),
        ("{ ranges: [i for i, p in route] }", None),
        ("{ near: [l.on for l in Lamp] }", None),
        ("{ ranges: [p for p in route] }", ("type-mismatch", "p")),
        ("{ ranges: [{ x: 1 } for p in route] }", ("type-mismatch", "{")),
        ("{ poses: [{ position: p, mark: 1 } for p in route] }", ("unknown-property", "mark")),
        ("{ poses: [p.x for p in A.close] }", ("unknown-member", "x")),
        ("{ poses: [{ position: p } for p, p in route] }", ("duplicate-name", "p")),
        ("{ ranges: [l.on for l in Lamp] }", ("type-mismatch", "l.on")),
        ("{ near: [l.on for l in Lamp if l.on] }",
         ("not-over-components", "[l.on for l in Lamp if l.on]")),
        ("{ ranges: A.close, near: [r < first(p for p in route) for r in A.close] }",
         ("type-mismatch", "first(p for p in route)")),
    ],
)  # fmt: skip
def test_what_is_made_fits_the_field(data: str, fault: tuple[str, str] | None) -> None:
    begin, end = MODEL.index("provide go with"), MODEL.index("requirement go")
    found = faults(f"{MODEL[:begin]}provide go with {data}\n{MODEL[end:]}")
    left_out = ("unused", "package", "unread", "undefined", "stale")
    assert [f for f in found if not f[0].startswith(left_out)] == ([] if fault is None else [fault])
