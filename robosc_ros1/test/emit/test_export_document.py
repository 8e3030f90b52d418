"""The JSON export: complete, as documented, and enough to rebuild the controlled system."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from quick import quick_first
from random_models import random_model
from ros_support import REPOSITORY, SOURCES
from synthesis.oracle import Oracle
from synthesis.subject import robot_of

from robosc.emit.export.export import exported
from robosc.errors import EmptySupervisorError
from robosc.plant.build import lower

BUFFER = """
robot Buffer {
    interface link use Thing from some_robot_msgs
    component Buffer {
        service fill with request: none, response: integer(1..2) links link
        incoming message take with type: none
        behaviour {
            variable n: integer(0..2)
            on response from fill do n := n + value
            on request to take if n > 0 do n := n - 1
            initial marked state only {}
            marked state other { transition if n = 0 goto only }
        }
    }
    requirement take needs Buffer.n != 2
    requirement never Buffer.n = 2 and Buffer.other
}
"""


def export(text: str) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(exported(lower(robot_of(text)), "json"))
    return document


def keys(document: Any) -> Iterator[str]:
    if isinstance(document, dict):
        for key, value in document.items():
            yield key
            yield from keys(value)
    elif isinstance(document, list):
        for value in document:
            yield from keys(value)


def test_document_of_a_robot() -> None:
    document = export(BUFFER)
    assert document["version"] == 1
    assert document["plant"]["variables"][1] == {
        "kind": "variable",
        "name": "Buffer.n",
        "values": [0, 1, 2],
        "initial": 0,
        "initials": [0],
        "marked": [0, 1, 2],
    }
    fill = next(e for e in document["plant"]["events"] if e["kind"] == "response")
    assert fill["parameters"] == [{"path": "", "values": [1, 2]}]
    assert fill["phase"] == {"name": "fill", "sources": ["busy"], "target": "idle"}
    assert fill["automata"] == [
        {
            "component": "Buffer",
            "blocking": False,
            "edges": [
                {
                    "source": place,
                    "guard": None,
                    "updates": [{"variable": "Buffer.n", "value": "Buffer.n + value"}],
                    "target": place,
                }
                for place in ("only", "other")
            ],
        }
    ]
    take = next(e for e in document["plant"]["events"] if e["name"] == "take")
    assert (take["requirement"], take["requirements"]) == ("Buffer.n != 2", [0])
    assert document["requirements"] == [
        "requirement take needs Buffer.n != 2",
        "requirement never Buffer.n = 2 and Buffer.other",
    ]
    guards = {g["event"]["name"]: g for g in document["supervisor"]["guards"]}
    assert guards["fill"]["event"] == {"kind": "request", "name": "fill", "value": None}
    assert guards["fill"]["status"] == "restricted"
    assert guards["take"]["guard"] == "Buffer.n != 2"


@pytest.mark.parametrize("seed", quick_first(range(20), 4))
def test_every_field_is_documented(seed: int) -> None:
    page = (Path(REPOSITORY) / "docs" / "export.md").read_text(encoding="utf-8")
    documented = {part for word in page.split("`")[1::2] for part in word.split(".")}
    document = export(random_model(random.Random(seed), 2))
    assert set(keys(document)) <= documented


@pytest.mark.slow
def test_sizes_are_those_of_the_oracle() -> None:
    for seed in range(20):
        text = random_model(random.Random(seed), 1)
        document, oracle = export(text), Oracle(robot_of(text))
        assert document["supervisor"]["empty"] == oracle.empty
        assert document["supervisor"]["plant_states"] == len(oracle.plant[0])
        assert len(document["plant"]["variables"]) == len(oracle.slots)
        assert len(document["plant"]["events"]) == len(oracle.events)


def test_supervisor_cannot_be_added_where_there_is_none() -> None:
    plant = lower(robot_of(BUFFER.replace("requirement never", "requirement always")))
    assert exported(plant, "cif")
    with pytest.raises(EmptySupervisorError):
        exported(plant, "cif", with_supervisor=True)


MIXED = """
robot Level {
    component Level {
        outgoing message level with type: double
        outgoing message probe with type: double
        incoming message fill with type: none
        incoming message drain with type: none
        behaviour {
            variable x: double
            variable y: double
            initial marked state s {
                on response from level do x := value
                on response from probe if value > 3.0 do x := y
            }
        }
    }
    requirement fill needs Level.x > 1 and Level.x != 2.0
    requirement drain needs Level.x < 1.0 or Level.x = 2
}
"""
"""Compares a number with constants that are equal and of two types."""


@pytest.mark.slow
def test_the_same_model_gives_the_same_text_in_every_process(tmp_path: Path) -> None:
    """The order of a set of texts changes from process to process."""
    model = tmp_path / "level.rscd"
    model.write_text(MIXED)
    program = (
        "from robosc.pipeline import export, load\n"
        f"robot = load({str(model)!r}).robot\n"
        "print(export(robot, 'cif'), export(robot, 'json'))"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ | {"PYTHONPATH": str(SOURCES), "PYTHONHASHSEED": seed},
            check=True,
            capture_output=True,
        ).stdout
        for seed in ("1", "2", "4")
    }
    assert len(texts) == 1
