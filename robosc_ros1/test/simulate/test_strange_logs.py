"""Event logs that are JSON, but have other values than a node writes: they are refused with the line,
or leave the model; nothing ends with a traceback."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from quick import quick_first
from ros_support import Completed
from simulate.players import session
from simulate.test_replay import lines_of, run_of, write

from robosc.errors import RoboscError
from robosc.simulate.replay import replay
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.recorded import Recording

MODEL = """
robot Stay {
    parameter limit: double = 1.0
    parameter fast: boolean = true
    component Sensor {
        outgoing message level with identifier: "/level", type: integer(0..3)
        outgoing message word with identifier: "/word", type: string
        outgoing message far with identifier: "/far", type: double, timeout: 1 s
        behaviour {
            persistent variable next: integer(0..9) = 0
            variable last: string
            variable dist: double
            initial marked state a {
                on response from level if value > 1 do next := value goto b
                on response from word do last := value
                on response from far do dist := value
            }
            marked state b {
                on response from level goto a
                after 500 ms goto a
                transition if dist > 3.0 goto a
            }
        }
    }
    component Motor { incoming message move with identifier: "/move", type: double }
    requirement move needs Sensor.a and Sensor.dist < limit and fast
    provide move with Sensor.dist
}
"""
BESIDE: tuple[dict[str, Any], ...] = (
    {"parameters": {"limit": 2.0, "fast": False}, "start": {"Sensor.next": 3}},
    {
        "shortened": True,
        "effect": {
            "components": {"Sensor": "b"}, "variables": {"Sensor.last": "x", "Sensor.dist": 0.5},
            "communications": {"far.fresh": True}, "shortened": ["Sensor.last"],
        },
    },
    {"seen": True, "blocked_by": [{"kind": "requirement", "text": "x"}]},
    {"reordered": True, "effect": {"components": {"Sensor": "a"}}},
    {"detail": "stop command", "reason": "failed"},
)  # fmt: skip
"""What nodes write beside events."""
OTHERS: tuple[Any, ...] = (
    None, True, 0, -1, 10**30, 0.5, "", "x", "applied", "NaN", [], [1, None], {}, {"": None},
    {"Sensor.next": 12}, [[[]]],
)  # fmt: skip


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(MODEL, "stay.rscd")


@pytest.fixture(scope="module")
def log(supervisor: Supervisor) -> list[str]:
    return lines_of(run_of(session(supervisor, execute=True), "random 40 11"))


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield path
    inner: Any = value.items() if isinstance(value, dict) else ()
    for key, part in enumerate(value) if isinstance(value, list) else inner:
        yield from places(part, (*path, key))


def with_other(document: Any, path: tuple[Any, ...], other: Any) -> Any:
    if not path:
        return other
    part = document
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = other
    return document


@pytest.mark.parametrize("seed", quick_first(range(16), 4))
def test_any_value_in_place_of_another(
    supervisor: Supervisor, log: list[str], tmp_path: Path, seed: int
) -> None:
    rng = random.Random(seed)
    for number in range(25):
        place = rng.randrange(min(12, len(log)))
        document = json.loads(log[place])
        for more in BESIDE:
            if rng.random() < 0.3:
                document.update(json.loads(json.dumps(more)))
        document = with_other(document, rng.choice(list(places(document))), rng.choice(OTHERS))
        path = tmp_path / f"{number}.log"
        path.write_text("\n".join([*log[:place], json.dumps(document), *log[place + 1 :]]) + "\n")
        for follow in (lambda p: replay(supervisor, p), lambda p: looked_at(supervisor, p)):
            try:
                follow(str(path))
            except RoboscError as error:
                assert str(path) in str(error)


def looked_at(supervisor: Supervisor, path: str) -> None:
    recording = Recording(supervisor, path, Hub())
    recording.overview({})
    recording.search({"text": "a"})
    recording.moment({"at": 1})
    list(recording.states())


@pytest.mark.parametrize(
    ("beside", "reason"),
    [
        ({"start": 1}, "this is not an event of a log, version 1"),
        ({"parameters": []}, "this is not an event of a log, version 1"),
        ({"effect": {"components": None}}, "this is not an event of a log, version 1"),
        ({"effect": {"shortened": 1}}, "this is not an event of a log, version 1"),
        ({"parameters": {"limit": []}}, "the parameter limit cannot be []: it carries a double"),
        (
            {"start": {"Sensor.next": 12}},
            "the start of Sensor.next cannot be 12: it is not of its type",
        ),
    ],
)
def test_what_is_told_at_the_beginning(
    robosc: Callable[..., Completed], log: list[str], tmp_path: Path, beside: Any, reason: str
) -> None:
    (tmp_path / "stay.rscd").write_text(MODEL)
    first = json.dumps({**json.loads(log[0]), **beside})
    path = write(tmp_path / "events.log", [first, *log[1:]])
    done = robosc("replay", str(tmp_path / "stay.rscd"), path)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"{path}:1: {reason}" in done.stderr


def test_a_number_that_json_lacks_is_a_parameter_all_the_same(
    supervisor: Supervisor, log: list[str], tmp_path: Path
) -> None:
    first = {**json.loads(log[0]), "parameters": {"limit": "Infinity"}}
    path = write(tmp_path / "events.log", [json.dumps(first), *log[1:2]])
    assert replay(supervisor, path).runs == 1
