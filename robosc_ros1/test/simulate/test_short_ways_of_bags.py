"""Messages of a recording that come alone are judged in a short way: it says what the engine says,
to which every message goes where the values of events are to be shown."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from quick import quick_first

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from simulate.recorded_runs import START, BagWriter, Run
from simulate.test_judged_bags import KINDS, LAWLESS, MODEL, TOLERANCE, definitions, robot
from simulate.test_transforms_in_bags import SPEEDS
from simulate.test_transforms_in_bags import SUPERVISOR as DOCKING
from simulate.test_transforms_in_bags import Run as DockingRun

from robosc.simulate.bags import bag_run
from robosc.simulate.bags.bag_run import BagRun
from robosc.simulate.bags.judgement import judge
from robosc.simulate.bags.judgement_report import judgement_document
from robosc.supervisor import Supervisor

NUMBERS = (0.0, 0.5, 1.0, 1.5, -1.0, math.nan, math.inf)


class _Counted(BagRun):
    alone = 0

    def entries(self, progress: Any) -> Any:
        yield from super().entries(progress)
        _Counted.alone += self.unrecorded


def judged_alike(supervisor: Supervisor, path: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """The messages that took the short way, of a bag that is judged in both ways."""
    _Counted.alone = 0
    monkeypatch.setattr(bag_run, "BagRun", _Counted)
    short = judgement_document(judge(supervisor, path, (), lambda *_: None))
    alone = _Counted.alone
    monkeypatch.setattr(bag_run, "BagRun", partial(_Counted, described=True))
    long = judgement_document(judge(supervisor, path, (), lambda *_: None))
    assert short == long
    assert _Counted.alone == alone  # none of the second time
    return alone


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("lawless", LAWLESS)
def test_runs_of_a_controller(
    tmp_path: Path, kind: str, lawless: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    supervisor = supervisor_of(MODEL.read_text(), str(MODEL))
    options: dict[str, Any] = {"lawless": lawless, "seed": 5, "jitter": 0.5 * TOLERANCE}
    run = Run(supervisor, tmp_path / f"run.{kind}", robot(), definitions(kind), **options)
    recorded = run.play(20.0)
    assert judged_alike(supervisor, recorded.path, monkeypatch) > 0


@pytest.mark.parametrize("seed", range(6))
def test_transforms(tmp_path: Path, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A link may be late, and commands come between those that are passed on later."""
    rng = random.Random(seed)
    docking = DockingRun(tmp_path / f"run.{KINDS[seed % 3]}")
    time = 0.0
    for _ in range(120):
        time += rng.choice([0.01, 0.02, 0.05, 0.3])
        match rng.randrange(4):
            case 0:
                docking.place(time, time)
            case 1:
                docking.tell(time, "odom", "base_link")
            case _:
                docking.move(time, rng.choice(sorted(SPEEDS)))
    docking.bag.close()
    judged_alike(DOCKING, docking.bag.path, monkeypatch)


SENSORS: dict[str, tuple[str, str, str, Callable[[random.Random, float], dict[str, Any]]]] = {
    # topic: type, what the model says of it, what it does, and the data of a message
    "scan": (
        "sensor_msgs/LaserScan",
        "variable ahead: double",
        "do ahead := min(r for r in value.ranges[-2..2]) else 0.0",
        lambda rng, time: {
            "header": stamp(rng, time),
            "ranges": floats([rng.choice(NUMBERS) for _ in range(rng.randrange(8))]),
            "intensities": floats([1.0] * rng.randrange(3)),
        },
    ),
    "point": (
        "geometry_msgs/PointStamped",
        "variable ahead: double",
        "do ahead := value.point.y",
        lambda rng, time: {
            "header": stamp(rng, time),
            "point": {"y": rng.choice(NUMBERS)},
        },
    ),
    "level": (
        "integer(0..2)",
        "variable ahead: integer(0..2)",
        "if value != 1 do ahead := value",
        lambda rng, time: {"data": rng.choice([0, 0, 1, 2, 2, 3])},
    ),
    "word": (
        "string",
        "variable ahead: boolean",
        'do ahead := value = "é"',
        lambda rng, time: {"data": rng.choice(["", "a", "é"])},
    ),
    "cells": (
        "sensor_msgs/BatteryState",
        "variable ahead: double",
        "if value.present do ahead := value.cell_voltage[1] else 0.5",
        lambda rng, time: {
            "header": stamp(rng, time),
            "present": rng.random() < 0.7,
            "cell_voltage": floats([rng.choice(NUMBERS)] * rng.randrange(4)),
            "location": rng.choice(["", "back", "frönt"]),
        },
    ),
}
RECORDED = {
    "integer(0..2)": "std_msgs/msg/Int64",
    "string": "std_msgs/msg/String",
    "double": "std_msgs/msg/Float64",
    "none": "std_msgs/msg/Empty",
}
CONDITIONS = {
    "scan": "ahead > 0.4",
    "point": "ahead <= 1.0",
    "level": "ahead != 2",
    "word": "ahead",
    "cells": "ahead < 1.2",
}


def floats(values: list[float]) -> Any:
    import numpy

    return numpy.array(values, dtype=numpy.float32)


def stamp(rng: random.Random, time: float) -> dict[str, Any]:
    made = time - rng.choice([0.0, 0.01, 0.01, 0.3])
    return {"stamp": {"sec": int(made), "nanosec": int(made % 1 * 1e9)}}


def random_rig(rng: random.Random) -> tuple[str, list[str]]:
    """A model, and its sensors. Their messages may have timeouts, may share a variable, begin
    delays and internal transitions."""
    names = rng.sample(sorted(SENSORS), rng.randint(1, 4))
    parts, conditions = [], []
    for name in names:
        type_, variable, effect, _ = SENSORS[name]
        owner = name.capitalize()
        more = ""
        if rng.random() < 0.6:
            more = f", timeout: {rng.choice([80, 150, 400])} ms"
            conditions.append(f"{name}.fresh")
        if name in ("scan", "point") and rng.random() < 0.2:
            more += ", max_age: 200 ms"
        states = f"initial marked state on {{ on response from {name} {effect} }}"
        if rng.random() < 0.5:
            states = (
                f"initial marked state on {{ on response from {name} {effect} goto off }}\n"
                f"marked state off {{ {rng.choice(['after 100 ms', 'transition'])} goto on\n"
                f"on response from {name} {effect} }}"
            )
        parts.append(
            f"component {owner} {{ outgoing message {name} with identifier: \"/{name}\","
            f" type: {type_}{more}\nbehaviour {{ {variable}\n{states} }} }}"
        )  # fmt: skip
        conditions.append(f"{owner}.{CONDITIONS[name]}")
    one = names[0]
    if rng.random() < 0.4:  # another one listens to the same topic
        parts.append(
            f'component Twin {{ outgoing message again with identifier: "/{one}",'
            f" type: {SENSORS[one][0]} }}"
        )
    if rng.random() < 0.5:  # its order among others matters
        reset = rng.choice(names)
        parts.append(
            f"component Mode {{ behaviour {{ initial marked state idle {{"
            f" on response from {one} goto busy }}\nmarked state busy {{ on response from {reset}"
            f" {'' if reset == one else 'goto idle'} }} }} }}"
        )
        conditions.append("Mode.idle")
    needed = " and ".join(rng.sample(conditions, rng.randint(1, len(conditions))))
    parts.append(
        'component Motor { incoming message move with identifier: "/move", type: none\n'
        'incoming message turn with identifier: "/turn", type: double }'
    )
    parts.append(
        f"requirement move needs {needed}\nrequirement {rng.choice(conditions)} disables turn"
    )
    if rng.random() < 0.4:
        parts.append(f"requirement never ({conditions[-1]} and {conditions[0]})")
    return "robot Rig {\n" + "\n".join(parts) + "\n}\n", names


def random_bag(rng: random.Random, path: Path, names: list[str]) -> Path:
    """Messages of the sensors and commands, some at one time, some after a silence."""
    bag = BagWriter(path, {})
    time = START
    for _ in range(150):
        time += rng.choice([0.0, 0.001, 0.01, 0.01, 0.02, 0.05, 0.08, 0.15, 0.5])
        topic = rng.choice([*names, *names, "move", "turn"])
        if topic == "move":
            bag.write("/move", RECORDED["none"], time, {})
        elif topic == "turn":
            bag.write("/turn", RECORDED["double"], time, {"data": rng.choice(NUMBERS[:5])})
        else:
            type_, _, _, make = SENSORS[topic]
            written = RECORDED.get(type_, type_.replace("/", "/msg/"))
            bag.write(f"/{topic}", written, time, make(rng, time))
    bag.close()
    return bag.path


@pytest.mark.parametrize("seed", quick_first(range(60), 12))
def test_random_models_and_bags(tmp_path: Path, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(seed)
    model, names = random_rig(rng)
    path = random_bag(rng, tmp_path / f"run.{KINDS[seed % 3]}", names)
    judged_alike(supervisor_of(model, "rig.rscd"), path, monkeypatch)
