"""The judge of a package's own test: it is content with the controller, and with no faulty one.

The controller runs here as it is generated, on a port that plays the robot; the judge gets its
events and states as the node would publish them. So many faults can be planted in little time.
"""

from __future__ import annotations

import importlib
import random
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.judged_controllers import Robot, judged, judging_modules
from emit.mutants import mutants
from ros_support import EXAMPLES

pytestmark = pytest.mark.slow

MODEL = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"


@pytest.fixture(scope="module")
def source() -> str:
    return controller_source(supervisor_of(MODEL.read_text(encoding="utf-8")))


@pytest.fixture(scope="module")
def judging(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The module ``judge`` as it lies in the package."""
    supervisor = supervisor_of(MODEL.read_text(encoding="utf-8"))
    with judging_modules(tmp_path_factory.mktemp("package_test"), supervisor) as judge:
        yield judge


@pytest.mark.parametrize("seed", range(5))
def test_it_is_content_with_the_controller(judging: Any, source: str, seed: int) -> None:
    judge = judged(judging, source, seed)
    assert judge.faults == []
    assert [
        row for row in importlib.import_module("run_report").coverage(judge) if not row[2]
    ] == []


def test_another_package_is_judged_meanwhile(judging: Any, source: str, tmp_path: Path) -> None:
    other = supervisor_of("robot Other { component A { outgoing message a with type: boolean } }")
    with judging_modules(tmp_path, other) as beside:
        assert judged(beside, controller_source(other), rounds=5).faults == []
    assert judged(judging, source, rounds=5).faults == []


def test_it_finds_faults(judging: Any, source: str) -> None:
    """A few; ``mutation_run.py`` plants all."""
    tried = list(mutants(source))[::6]
    assert {mutant.kind for mutant in tried} == {"guard", "data", "rule", "update"}
    missed = [mutant for mutant in tried if not judged(judging, mutant.source).faults]
    assert [(mutant.method, mutant.after) for mutant in missed] == []


def test_the_guide_tells_what_was_not_reached(judging: Any, source: str) -> None:
    judge = judged(judging, source)
    unseen = judge.guide.unseen(judge.shadow)
    assert [text for text in unseen if text.startswith("request of set_light_state")] == []
    # While it grabs, the motor never runs.
    text = "cancel of grab: requirement grab needs DistanceSensor.sensing and Motor.stopped"
    assert any(line.startswith(text) for line in unseen)


def test_transitions_have_the_same_names_in_tables_and_faults(tmp_path: Path) -> None:
    supervisor = supervisor_of("""
        robot Other {
            component Flame {
                outgoing message wind with type: boolean
                behaviour {
                    initial marked state sparking {
                        on response from wind goto burning
                        after 2 s goto burning
                    }
                    state burning { transition goto sparking }
                }
            }
        }
    """)
    names = ["internal transition 1 of Flame", "after 1 of Flame"]
    with judging_modules(tmp_path, supervisor) as judging:
        judge = judged(judging, controller_source(supervisor), rounds=5)
        rows = [name for _, name, _ in importlib.import_module("run_report").coverage(judge)]
        assert [name for name in rows if name.endswith(" of Flame")] == names
        wanted = [text for text, _ in judge.guide.cases.wanted(judge.shadow)]
        assert [text for text in wanted if text.endswith(" of Flame")] == names
        wrong = importlib.import_module("reference_model").Wrong
        for take, name in zip((judge.shadow.step, judge.shadow.wait_over), names, strict=True):
            with pytest.raises(wrong, match=f"^{name}"):
                take("Flame", 1, "burning->burning")


def faster(data: dict[str, Any]) -> dict[str, Any]:
    return {**data, "linear": {"x": 7.5}} if "linear" in data else data


def dark(data: dict[str, Any]) -> dict[str, Any]:
    return {**data, "state": not data["state"]} if "state" in data else data


@pytest.mark.parametrize(
    ("spoilt", "complaint"),
    [
        (faster, "timed out waiting for the messages on /vel to match the events"),
        (
            dark,
            "timed out waiting for the requests of LightBulb.set_light_state to match the events",
        ),
    ],
)
def test_what_arrives_must_be_what_the_events_say(
    judging: Any, source: str, spoilt: Callable[[Any], Any], complaint: str
) -> None:
    # With this seed the light is not switched in turns, which would fit one request later, too.
    assert judged(judging, source, seed=2, spoilt=spoilt).faults == [complaint]


def test_requests_may_arrive_some_time_before_their_events(
    judging: Any, source: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a loaded machine the controller asks again and again before its events come."""
    monkeypatch.setattr(judging, "TIMEOUT", 30.0)
    judge = judged(judging, source)
    key = "LightBulb.set_light_state"
    reported = importlib.import_module("reported_requests").ReportedRequest
    some = list(judge.robot.requests[key])
    judge.robot.requests[key].extend([some[-1]] * 3)

    def tell() -> None:
        with judge._changed:
            for _ in range(3):
                request = reported(key, {"state": some[-1].state}, judge.shadow)
                request.arrived = True
                judge.asked[key].append(request)
            judge._changed.notify_all()

    teller = threading.Timer(0.1, tell)
    teller.start()
    judge.compare_messages()
    teller.join()
    assert judge.faults == []


def test_a_byte_of_rclpy_carries_a_number(judging: Any) -> None:
    message = SimpleNamespace(one=b"\x04", two=[b"\x01", b"\xff"])
    carries = importlib.import_module("arrivals").carries
    assert carries(message, {"one": 4, "two": [1, 255]})
    assert not carries(message, {"one": 5})
    assert not carries(message, {"one": 260})


FRAMES = """
robot R {
    interface frame use Frame from can_msgs
    datatype object Frame { data: array(integer) }
    component Can {
        outgoing message frame with type: Frame links frame
        behaviour {
            variable seen: boolean
            initial marked state s { on response from frame do seen := value.data[0] = 7 }
        }
    }
}
"""


def test_arrays_of_bytes_of_a_fixed_length_are_filled(tmp_path: Path) -> None:
    """About half of the numbers that are tried do not fit into a byte."""

    class Frame:
        def __init__(self) -> None:
            self.data = bytes(64)

    def as_it_arrives(message: Frame) -> Frame:
        message.data = bytes(message.data)
        return message

    with judging_modules(tmp_path, supervisor_of(FRAMES)):
        values = importlib.import_module("random_messages").Values(random.Random(1))
        values.as_it_arrives = as_it_arrives
        values.array_of = lambda owner, name: (64, 64, None)
        frames = [values.message(Frame, "Can.frame", "response").data for _ in range(50)]
    assert {len(frame) for frame in frames} == {64}
    assert {6, 7, 8} <= {frame[0] for frame in frames}


SIGNS = """
robot R {{
    interface link use Signs from nowhere_msgs
    datatype object Signs {{ signs: array(Sign) }}
    datatype enum Sign from {source} to {{ value = {one} -> clear default -> blocked }}
    component Reader {{
        outgoing message read with type: Signs links link
        incoming message go with type: none
        behaviour {{
            variable first: Sign
            variable way: boolean
            initial marked state s {{
                on response from read
                    do first := value.signs[0], way := any(x = clear for x in value.signs)
            }}
        }}
    }}
    requirement go needs Reader.first = clear and Reader.way
}}
"""


@pytest.mark.parametrize(
    ("source", "one", "kind"),
    [("boolean", "true", bool), ("integer(-1..2)", "1", int), ("string", '"up"', str)],
)
def test_arrays_of_enums_have_what_the_enum_converts_from(
    source: str, one: str, kind: type, tmp_path: Path
) -> None:
    with judging_modules(tmp_path, supervisor_of(SIGNS.format(source=source, one=one))) as judging:
        robot = Robot(judging, 1, lambda data: data)
        messages = [robot.message("Reader.read", "response") for _ in range(50)]
    assert {type(sign) for message in messages for sign in message.signs} == {kind}


WAITING = """
robot R {
    interface set use SetLevel from some_interfaces
    datatype object Level { level: integer }
    component Count {
        outgoing message items with type: integer
        behaviour {
            variable n: integer
            on response from items do n := value
            initial marked state s {}
        }
    }
    component Lamp {
        service set with request: Level, response: boolean links set
        behaviour {
            variable times: integer
            initial marked state resting { on request to set do times := times + 1 goto working }
            state working { on response, error from set goto resting }
        }
    }
    provide set with { level: Count.n + 10 * Lamp.times }
}
"""


def test_a_request_that_waits_for_its_server_arrives_with_the_data_of_that_moment(
    tmp_path: Path,
) -> None:
    with judging_modules(tmp_path, supervisor_of(WAITING)) as judging:
        requests = importlib.import_module("reported_requests")
        state = judging.ReferenceModel(judging.PLANT)
        asked: dict[str, list[Any]] = {"Lamp.set": []}

        def follow(kind: str, key: str, value: Any = None) -> None:
            state.happen(kind, key, None if value is None else judging.Told(value))
            requests.look_at_latest(asked, state)

        def fitting() -> set[int]:
            return {n for n in range(40) if asked["Lamp.set"][0].fits(SimpleNamespace(level=n))}

        asked["Lamp.set"].append(requests.ReportedRequest("Lamp.set", {"level": 0}, state))
        follow("request", "Lamp.set")
        assert fitting() == {0}  # what the request itself changed counts for the next one
        follow("response", "Count.items", 3)
        assert fitting() == {0, 3}
        follow("error", "Lamp.set")
        follow("response", "Count.items", 5)
        assert fitting() == {0, 3}
        sent = [SimpleNamespace(level=3)]
        assert requests.are_told(sent, asked["Lamp.set"], range(1))
        asked["Lamp.set"].append(requests.ReportedRequest("Lamp.set", {"level": 15}, state))
        follow("request", "Lamp.set")
        asked["Lamp.set"][-1].arrived = True
        follow("response", "Count.items", 6)
        assert requests.are_told([*sent, SimpleNamespace(level=15)], asked["Lamp.set"], range(1))
        wrong = [SimpleNamespace(level=16), SimpleNamespace(level=16)]
        assert not requests.are_told(wrong, asked["Lamp.set"], range(1))
