"""A transition system as the document that ``explore --json`` prints."""

from __future__ import annotations

from typing import Any

from robosc.synthesis import documents
from robosc.synthesis.documents import step_document
from robosc.synthesis.explore import Graph
from robosc.synthesis.system import make_step


def explore_document(graph: Graph) -> dict[str, Any]:
    """What ``explore --json`` prints, made in one piece: without its parts, and without its cache."""
    plant = graph.plant
    return {
        "version": 1,
        "robot": plant.robot.name,
        **documents._initial(graph),
        "states": [
            documents._state(plant, number, state) for number, state in enumerate(graph.states)
        ],
        "transitions": [
            {
                "source": t.source,
                "event": step_document(
                    make_step(
                        plant,
                        plant.events[t.event],
                        t.values,
                        graph.states[t.source],
                        graph.states[t.target],
                    )
                ),
                "controllable": plant.events[t.event].controllable,
                "target": t.target,
            }
            for t in graph.transitions
        ],
    }  # fmt: skip
