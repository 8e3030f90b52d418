"""Events as the page shows them: ranges of numbers as people write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from robosc import pipeline
from robosc.simulate.machines.event_by_event import SingleEvents

MODEL = """
robot R {{
    component Battery {{
        outgoing message battery with type: double
        behaviour {{
            variable charge: double = 0.0
            initial marked state on {{ on response from battery do charge := value }}
        }}
    }}
    component Light {{ incoming message shine with type: none }}
    requirement shine needs {condition}
}}
"""


@pytest.mark.parametrize(
    ("condition", "shown"),
    [
        ("Battery.charge < 0.3 or Battery.charge > 0.9", ["< 0.3", "0.3 … 0.9", "> 0.9"]),
        ("Battery.charge >= 0.35", ["< 0.35", ">= 0.35"]),
        (
            "Battery.charge > 0.2 and Battery.charge <= 0.5",
            ["<= 0.2", "0.2 … 0.5", "> 0.5", "not a number"],
        ),
        ("Battery.charge = 0.5", ["value != 0.5", "value = 0.5"]),
    ],
)
def test_classes_of_numbers(condition: str, shown: list[str], tmp_path: Path) -> None:
    (tmp_path / "r.rscd").write_text(MODEL.format(condition=condition), encoding="utf-8")
    machine = SingleEvents(pipeline.supervise(pipeline.load(tmp_path / "r.rscd").robot))
    texts = {c.short for c in machine.choices() if c.event.kind.word == "response"}
    assert texts == {f"battery.response({text})" for text in shown}
