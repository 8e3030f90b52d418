"""All that the oracle and robosc can be asked about one robot, compared."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from synthesis.explored import explore_document
from synthesis.oracle import Event, Oracle

from robosc import pipeline
from robosc.errors import has_errors
from robosc.model.entities import Robot
from robosc.supervisor import Supervisor
from robosc.synthesis import explore
from robosc.synthesis.documents import synthesize_document
from robosc.synthesis.verify.verification import verify

Document = dict[str, Any]

__all__ = ["ENGINES", "differences"]

ENGINES = ("explicit", "bdd")


def differences(robot: Robot, oracle: Oracle, engine: str = "explicit") -> list[str]:
    """Every difference between robosc and the oracle, as a sentence."""
    return [*_plant(robot, oracle), *_control(robot, oracle, engine)]


def _plant(robot: Robot, oracle: Oracle) -> Iterator[str]:
    declared = {
        variable.key
        for component in robot.components
        if component.behaviour is not None
        for variable in component.behaviour.variables
        if variable.in_state
    }
    if declared != oracle.synthesis_variables:
        yield f"synthesis variables {declared}, oracle {oracle.synthesis_variables}"
    ours = explore_document(pipeline.explore(robot, plant=True))
    yield from _graphs("plant", ours, oracle.document(plant=True), oracle)


def _control(robot: Robot, oracle: Oracle, engine: str) -> Iterator[str]:
    supervisor = pipeline.synthesize(robot, engine)
    document = synthesize_document(supervisor)
    states, transitions = oracle.controlled
    figures = {
        "plant_states": len(oracle.plant[0]),
        "controlled_states": len(states),
        "controlled_transitions": len(transitions),
    }
    for name, figure in figures.items():
        if document[name] != figure:
            yield f"{name} {document[name]}, oracle {figure}"
    if supervisor.empty != oracle.empty:
        yield f"empty {supervisor.empty}, oracle {oracle.empty}"
    if not supervisor.empty and not oracle.empty:
        ours = explore_document(explore(supervisor))
        yield from _graphs("controlled", ours, oracle.document(), oracle)
    yield from _guards(supervisor, oracle)
    if not oracle.empty:
        yield from _properties(supervisor, oracle)
        yield from (f"error: {d.message}" for d in supervisor.diagnostics if has_errors([d]))
    report = verify(supervisor)
    yield from (f"verify: {c.name}: {c.detail}" for c in report.checks if not c.holds)


def _properties(supervisor: Supervisor, oracle: Oracle) -> Iterator[str]:
    expected = oracle.properties()
    if not expected.pop("acyclic"):
        del expected["confluence"]  # not a question where internal transitions may go round
    told = dict(supervisor.properties)
    for name, holds in expected.items():
        if told.get(name) != holds:
            yield f"{name} {told.get(name)}, oracle {holds}"


def _guards(supervisor: Supervisor, oracle: Oracle) -> Iterator[str]:
    """The guards evaluated in every controlled state, and the statuses."""
    told = [Event(g.event.kind, g.event.key, g.event.index) for g in supervisor.guards]
    expected = [event for event in oracle.events if event.controllable]
    if told != expected:
        yield f"guards of {told}, oracle {expected}"
        return
    states, _ = oracle.controlled
    for event, guard in zip(told, supervisor.guards, strict=True):
        if guard.status != oracle.status(event):
            yield f"{event}: status {guard.status}, oracle {oracle.status(event)}"
        for state in states:
            if event in oracle.possible(state):
                ours = oracle.holds(guard.expr, state)
                if ours != (event in oracle.enabled(state)):
                    yield f"{event}: guard {ours} in {state}"


def _graphs(what: str, ours: Document, theirs: Document, oracle: Oracle) -> Iterator[str]:
    """Two transition systems: the same states and steps, and the documented order of them."""
    for part in (_states, _steps):
        mine, other = part(ours), part(theirs)
        for key in mine - other:
            yield f"{what}: only robosc has {key}"
        for key in other - mine:
            yield f"{what}: only the oracle has {key}"
    if [s["id"] for s in ours["states"]] != list(range(len(ours["states"]))):
        yield f"{what}: states are not numbered in order"
    if len(mine) != len(ours["transitions"]):
        yield f"{what}: a step is told twice"
    yield from (f"{what}: {text}" for text in _order(ours, oracle))


def _order(document: Document, oracle: Oracle) -> Iterator[str]:
    """States breadth-first from the initial ones, the steps of each in model order."""
    events = [(e.kind.word, oracle.name(e), e.index or None) for e in oracle.events]
    place = {event: i for i, event in enumerate(events)}
    order = []
    seen = dict.fromkeys(document.get("initials", [document["initial"]]))
    for t in document["transitions"]:
        event = t["event"]
        order.append((t["source"], place[event["kind"], event["name"], event.get("index")]))
        seen.setdefault(t["target"])
    if order != sorted(order):
        yield "the steps are not in model order"
    if document["states"] and list(seen) != list(range(len(document["states"]))):
        yield "the states are not numbered breadth-first"
    decided = {(e.kind.word, oracle.name(e)) for e in oracle.events if e.controllable}
    for t in document["transitions"]:
        if t["controllable"] != ((t["event"]["kind"], t["event"]["name"]) in decided):
            yield f"controllable is wrong in {t}"


def _states(document: Document) -> set[Any]:
    found = {_frozen({k: v for k, v in s.items() if k != "id"}) for s in document["states"]}
    if document["states"]:
        found.add(("initial", _frozen(_state(document, document["initial"]))))
    return found


def _state(document: Document, number: int) -> Document:
    return {k: v for k, v in document["states"][number].items() if k != "id"}


def _steps(document: Document) -> set[Any]:
    states = [_frozen(_state(document, number)) for number in range(len(document["states"]))]
    return {
        (states[t["source"]], _frozen(t["event"]), states[t["target"]])
        for t in document["transitions"]
    }


def _frozen(value: Any) -> str:
    """A document as something that can be in a set; 1, 1.0 and true stay three things."""
    return json.dumps(value, sort_keys=True)
