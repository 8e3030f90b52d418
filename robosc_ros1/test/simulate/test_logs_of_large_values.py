"""Logs in which large values have short forms: they are small, and replay follows them."""

from __future__ import annotations

import json
import random
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from runtime.lamp_robot import PlayedPort
from runtime.schemas import validate
from simulate.test_replay import write

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import dump, event_document
from robosc.simulate.machines.state import make_controller
from robosc.simulate.replay import replay
from robosc.supervisor import Supervisor

MODEL = """robot Large {
    interface look use Look from nowhere_msgs
    datatype object Look { ranges: array(double) label: string points: array(Point) }
    datatype object Point { x: double y: double }
    component Front {
        outgoing message scan with timeout: 500 ms, type: Look links look
        outgoing message tick with type: integer(0..3)
        incoming message pass with type: Look links look
        incoming message move with type: double
        incoming message halt with type: string
        behaviour {
            variable blocked: boolean = true
            variable third: double
            variable label: string
            variable last: Look
            variable ticks: integer(0..3)
            on response from scan do
                blocked := any(r < 0.5 for r in value.ranges), third := value.ranges[2],
                label := value.label, last := value
            initial marked state near {
                on response from tick if any(r > 3.0 for r in last.ranges) do ticks := value goto away
            }
            marked state away {
                on response from tick if value = 0 goto near
                transition if all(p.x < 0.5 for p in last.points) goto gone
            }
            marked state gone { on response from tick goto near }
        }
    }
    requirement move needs !Front.blocked and scan.fresh
    requirement pass needs any(r > 3.5 for r in Front.last.ranges) and Front.away
    requirement halt needs Front.label != "go"
    provide move with Front.third
    provide pass with Front.last
    provide halt with Front.label
}
"""


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(MODEL)


def message(chance: random.Random, size: int) -> Any:
    some = chance.sample([0.2, 1.0, 3.2, 4.0, float("nan")], 2)
    return SimpleNamespace(
        ranges=[chance.choice(some) for _ in range(size)],
        label=chance.choice(["go", "stop " * size]),
        points=[SimpleNamespace(x=chance.choice([0.1, 0.4, 0.9]), y=1.0) for _ in range(size // 3)],
    )


def run(supervisor: Supervisor, seed: int, size: int, **settings: Any) -> list[str]:
    """The event log of a random run with arrays of about this size."""
    chance = random.Random(seed)
    port = PlayedPort()
    parameters = Settings(timeout={"Front.scan": 0.5}, **settings)
    engine = controller_engine(
        make_controller(supervisor), port, parameters, steady=lambda: port.time
    )
    engine.begin()
    for _ in range(100):
        port.time += chance.choice([0.0, 0.05, 0.1, 0.6])
        engine.cycle()
        if chance.random() < 0.5:
            engine.post("Front.scan", "response", message(chance, chance.choice([4, size])))
        else:
            engine.post("Front.tick", "response", SimpleNamespace(data=chance.randint(0, 3)))
        engine.cycle()
    entries = engine.recorder.take()
    assert {"scan", "tick", "move", "pass", "halt"} <= {entry.name for entry in entries}
    return [dump(event_document(entry)) for entry in entries]


@pytest.mark.parametrize("seed", range(8))
def test_replay_follows_short_forms(supervisor: Supervisor, tmp_path: Path, seed: int) -> None:
    lines = run(supervisor, seed, 300)
    assert max(map(len, lines)) < 6000
    for line in lines:
        validate(json.loads(line), "event")
    found = replay(supervisor, write(tmp_path / "events.log", lines))
    assert (found.departures, found.missing) == ((), ())
    assert 0 < found.unchecked < len(lines)


def test_values_are_whole_if_the_parameter_says_so(supervisor: Supervisor, tmp_path: Path) -> None:
    lines = run(supervisor, 1, 300, whole_values=True)
    assert "shortened" not in "".join(lines)
    found = replay(supervisor, write(tmp_path / "events.log", lines))
    assert (found.departures, found.missing, found.unchecked) == ((), (), 0)


def test_a_command_that_its_requirement_forbids_is_still_found(
    supervisor: Supervisor, tmp_path: Path
) -> None:
    documents = [json.loads(line) for line in run(supervisor, 3, 300)]
    blocked = next(
        d for d in documents
        if d.get("shortened") and d["event"]["name"] == "scan" and not d["effect"]["variables"]["Front.blocked"]
    )  # fmt: skip
    blocked["effect"]["variables"]["Front.blocked"] = True
    found = replay(supervisor, write(tmp_path / "events.log", list(map(dump, documents))))
    (departure,) = found.departures
    assert departure.event.startswith("move.request")
    assert "Front.blocked" in departure.reason


@pytest.mark.parametrize(
    "effect",
    [
        {"variables": {"Front.nothing": 1}},
        {"variables": {"Front.ticks": 9}},
        {"variables": {"Front.third": "far"}},
        {"components": {"Nobody": "near"}},
    ],
)
def test_an_effect_that_cannot_be(supervisor: Supervisor, tmp_path: Path, effect: Any) -> None:
    documents = [json.loads(line) for line in run(supervisor, 3, 300)]
    scan = next(d for d in documents if d.get("shortened") and d["event"]["name"] == "scan")
    scan["effect"] = effect
    found = replay(supervisor, write(tmp_path / "events.log", list(map(dump, documents))))
    (departure,) = found.departures
    assert departure.number == scan["number"]
    assert departure.reason.startswith("its effect cannot be")
