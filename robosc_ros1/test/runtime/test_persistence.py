"""Persistent variables are kept whole: over kills, full disks, other models and torn files."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from ros_support import await_condition
from runtime.lamp_robot import PlayedPort
from runtime.schemas import validate
from runtime.test_reports import Heard

from robosc.runtime.core import persistence
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.persistence import Keeper, kept_values, start
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import Reporter
from robosc.simulate.event_log import read_log
from robosc.simulate.replay import Follower

MODEL = """robot Tour {
    datatype enum Mood from integer to { value = 1 -> glad default -> calm }
    component Tour {
        outgoing message arrived with type: integer
        behaviour {
            persistent variable next: integer(0..9) = 4
            persistent variable asked: boolean
            persistent variable mood: Mood
            initial marked state on {
                on response from arrived if next < 9
                    do next := next + 1, asked := true, mood := Mood(value)
            }
        }
    }
}"""
NEW = {"Tour.next": 4, "Tour.asked": False, "Tour.mood": "calm"}
LATER = {"Tour.next": 7, "Tour.asked": True, "Tour.mood": "glad"}
SUPERVISOR = supervisor_of(MODEL)
CLASS = controller_class(SUPERVISOR)[0]


def keeper(path: Path, forget: bool = False) -> tuple[Keeper, Any]:
    controller = CLASS()
    controller.configure({"persistent_file": str(path), "forget": forget})
    return Keeper(controller, "/tour", lambda level, text: None), controller


def begun(path: Path, forget: bool = False) -> tuple[dict[str, Any], list[str]]:
    """What a node begins with, and its faults."""
    one, controller = keeper(path, forget)
    one.close(5.0)
    assert kept_values(controller) == one.began_with
    return one.began_with, one.all_faults()


def test_values_outlast_the_node(tmp_path: Path) -> None:
    file = tmp_path / "deep" / "tour.json"
    one, controller = keeper(file)
    assert one.began_with == NEW
    assert "No such file" in one.faults[0]
    assert start(controller, LATER) == []
    one.look()
    one.close(5.0)
    assert begun(file) == (LATER, [])
    assert begun(file, forget=True) == (NEW, [])
    assert begun(file) == (NEW, [])
    assert [p.name for p in file.parent.iterdir()] == ["tour.json"]


@pytest.mark.parametrize(
    ("values", "expected", "fault"),
    [
        ({**LATER, "Tour.next": 10}, {**LATER, "Tour.next": 4}, "Tour.next"),
        ({**LATER, "Tour.next": True}, {**LATER, "Tour.next": 4}, "Tour.next"),
        ({**LATER, "Tour.asked": 1}, {**LATER, "Tour.asked": False}, "Tour.asked"),
        ({**LATER, "Tour.mood": "sad"}, {**LATER, "Tour.mood": "calm"}, "Tour.mood"),
        ({**LATER, "Tour.mood": []}, {**LATER, "Tour.mood": "calm"}, "Tour.mood"),
        ({"Tour.next": 3, "Tour.old": 1}, {**NEW, "Tour.next": 3}, "Tour.asked, Tour.mood"),
    ],
)
def test_what_is_outside_the_type_begins_anew(
    tmp_path: Path, values: dict[str, Any], expected: dict[str, Any], fault: str
) -> None:
    file = tmp_path / "tour.json"
    persistence.write(file, "Tour", values)
    found, faults = begun(file)
    assert found == expected
    assert f"no value for {fault}," in faults[0]
    assert begun(file) == (expected, [])


def test_the_file_of_another_model_counts_as_not_there(tmp_path: Path) -> None:
    file = tmp_path / "tour.json"
    persistence.write(file, "Walk", LATER)
    found, faults = begun(file)
    assert found == NEW
    assert "of another model, Walk" in faults[0]


def test_no_torn_file_is_taken(tmp_path: Path) -> None:
    """Cut anywhere, or with any character another one, it is torn; it never has other values."""
    file = tmp_path / "tour.json"
    persistence.write(file, "Tour", LATER)
    text = file.read_text()
    rng = random.Random(1)
    torn = [text[:n] for n in range(len(text) - 2)]
    torn += [text[:n] + rng.choice("0a}\0") + text[n + 1 :] for n in range(len(text) - 1)]
    torn += ["[" * 100_000, "{}", "null", '{"robot":1,"values":[],"check":0}', "\xff"]
    for found in torn:
        file.write_text(found, encoding="latin-1")
        try:
            values = persistence.read(file, "Tour")
        except ValueError:
            continue
        assert values == LATER, found  # "version" is no part of what counts


def test_what_is_no_file_is_neither_read_nor_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path):
        found, faults = begun(path)
        assert found == NEW
        assert len(faults) == 2
        assert "are not kept" in faults[1]
    assert pipe.is_fifo()


def test_what_could_not_be_written_is_written_once_it_can(tmp_path: Path) -> None:
    path = tmp_path / "state.json"
    path.mkdir()
    kept, _ = keeper(path)
    await_condition(lambda: "not kept" in str(kept.all_faults()), "the fault")
    path.rmdir()
    await_condition(lambda: path.is_file() and "not kept" not in str(kept.all_faults()), "the file")
    assert persistence.read(path, "Tour") == NEW
    kept.close(5.0)


WRITER = """
import sys
from pathlib import Path
from robosc.runtime.core.persistence import write
file = Path(sys.argv[1])
n = int(sys.argv[2])
print("ready", flush=True)
while True:
    n += 1
    write(file, "Tour", {"Tour.next": n, "Tour.copy": [n] * 200})
"""


def test_killed_at_random_while_writing_no_value_is_torn(tmp_path: Path) -> None:
    """120 times: what is there afterwards is what one write has written, and no older one."""
    file = tmp_path / "tour.json"
    rng = random.Random(56)
    latest = 0
    persistence.write(file, "Tour", {"Tour.next": 0, "Tour.copy": [0] * 200})
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    for _ in range(120):
        command = [sys.executable, "-S", "-c", WRITER, str(file), str(latest)]
        writer = subprocess.Popen(command, stdout=subprocess.PIPE, env=environment)
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"ready\n"
        until = time.monotonic() + rng.uniform(0.0, 0.01)
        values = {"Tour.next": latest}
        while values["Tour.next"] == latest or time.monotonic() < until:
            assert writer.poll() is None
            values = persistence.read(file, "Tour")  # also while it is replaced
            assert values["Tour.copy"] == [values["Tour.next"]] * 200
        writer.send_signal(signal.SIGKILL)
        writer.wait()
        writer.stdout.close()
        values = persistence.read(file, "Tour")
        assert values["Tour.copy"] == [values["Tour.next"]] * 200
        assert values["Tour.next"] >= latest
        latest = values["Tour.next"]


def engine_of(path: Path, log: Path) -> tuple[Engine[Any], Reporter, Heard]:
    controller = CLASS()
    controller.configure({"persistent_file": str(path), "forget": False})
    settings = Settings(event_log=str(log))
    engine = controller_engine(controller, PlayedPort(), settings)
    heard = Heard()
    return engine, Reporter(engine, heard, {}), heard


def test_a_node_goes_on_where_the_last_one_ended(tmp_path: Path) -> None:
    """Its log says where it began, so that it can be followed."""
    file = tmp_path / "tour.json"
    for run in range(3):
        log = tmp_path / f"log{run}.jsonl"
        engine, reporter, heard = engine_of(file, log)
        reporter.start()
        thread = threading.Thread(target=engine.run)
        thread.start()
        for _ in range(2):
            engine.post("Tour.arrived", "response", type("Int16", (), {"data": 1})())
        heard.wait(lambda heard=heard: any(s["number"] >= 2 for s in heard.states))
        engine.close()
        thread.join(5.0)
        reporter.close(5.0)
        assert heard.states[-1]["variables"]["Tour.next"] == min(9, 6 + 2 * run)
        assert bool(heard.states[-1]["faults"]) == (run == 0)  # there was no file at first
        first, *_ = [json.loads(line) for line in log.read_text().splitlines()]
        validate(first, "event")
        assert first["start"]["Tour.next"] == 4 + 2 * run
        follower = Follower(SUPERVISOR)
        for entry in read_log(str(log)):
            follower.take(entry)
        assert follower.controller is not None and not follower.departures
        assert follower.controller.variables() == heard.states[-1]["variables"]


def test_at_most_ten_writes_a_second_and_the_last_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[tuple[float, int]] = []

    def counted(path: Path, robot: str, values: dict[str, Any]) -> None:
        written.append((time.monotonic(), values["Tour.next"]))

    monkeypatch.setattr(persistence, "write", counted)
    one, controller = keeper(tmp_path / "tour.json")
    n = 0
    while len(written) < 5:
        n += 1
        start(controller, {**LATER, "Tour.next": n % 10})
        one.look()
    start(controller, {**LATER, "Tour.next": 3})
    one.look()
    one.close(5.0)
    *before, last = written
    assert last[1] == 3
    assert all(b[0] - a[0] >= persistence.PERIOD for a, b in pairwise(before))
