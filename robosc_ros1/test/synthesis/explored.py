"""A transition system as the document that ``explore --json`` prints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from robosc.plant.automaton import Plant
from robosc.plant.step import valuations
from robosc.supervisor import Step
from robosc.synthesis import documents
from robosc.synthesis.controlled_system import make_step
from robosc.synthesis.documents import step_document
from robosc.synthesis.explore import Graph


def explore_document(graph: Graph) -> dict[str, Any]:
    """What ``explore --json`` prints, but with every value of each event."""
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


def spelled_out(plant: Plant, document: dict[str, Any]) -> dict[str, Any]:
    """The printed document with every value of each event: the parts left out take all values."""
    lists = [list(_spelled_out(plant, t)) for t in document["transitions"]]
    return {**document, "transitions": [t for several in lists for t in several]}


def _spelled_out(plant: Plant, transition: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if "any" not in transition:
        yield transition
        return
    told = transition["event"]
    (event,) = (e for e in plant.events if documents.event_document(e).items() <= told.items())
    left = {key: part for key, part in transition.items() if key not in ("any", "values")}
    found = [step_document(Step(event, values)) for values in valuations(event)]
    known = told["value"] or {}
    some = [one for one in found if known.items() <= one["value"].items()]
    assert len(some) == transition["values"]
    assert all(one["value"].keys() == {*known, *transition["any"]} for one in some)
    yield from ({**left, "event": one} for one in some)
