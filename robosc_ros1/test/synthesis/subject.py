"""One robot, told by the oracle and by robosc: documents, counts and statuses to be compared."""

from __future__ import annotations

from functools import cached_property, lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

from synthesis.explored import explore_document
from synthesis.oracle import Oracle

from robosc import pipeline
from robosc.errors import EmptySupervisorError, ModelError, render_all
from robosc.model.entities import Robot
from robosc.supervisor import Supervisor
from robosc.synthesis.documents import synthesize_document

Document = dict[str, Any]

__all__ = ["SUBJECTS", "Engine", "Reference", "Subject", "oracle_of", "robot_of", "steps"]


class Subject(Protocol):
    """What both can tell. ``explore`` gives a document without states if nothing is left."""

    def __init__(self, text: str) -> None: ...
    def explore(self, plant: bool) -> Document: ...
    def counts(self) -> tuple[int, int, int]: ...
    def statuses(self) -> dict[str, str]: ...


def robot_of(text: str) -> Robot:
    """The resolved robot of a model text; errors fail the test as a user would read them."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.rscd"
        path.write_text(text)
        try:
            return pipeline.load(path).robot
        except ModelError as error:
            raise AssertionError(f"{text}\n{render_all(error.diagnostics)}") from error


@lru_cache(maxsize=128)
def oracle_of(text: str) -> Oracle:
    """The oracle of a model; its states are found once, however many engines are compared with it."""
    return Oracle(robot_of(text))


class Reference:
    """The oracle."""

    def __init__(self, text: str) -> None:
        self.oracle = Oracle(robot_of(text))

    def explore(self, plant: bool) -> Document:
        return self.oracle.document(plant)

    def counts(self) -> tuple[int, int, int]:
        states, transitions = self.oracle.controlled
        return len(self.oracle.plant[0]), len(states), len(transitions)

    def statuses(self) -> dict[str, str]:
        oracle = self.oracle
        return {
            f"{oracle.name(event)}.{event.kind.word}{event.index or ''}": oracle.status(event)
            for event in oracle.events
            if event.controllable
        }


class Engine:
    """robosc, through the same functions as its commands."""

    engine = "explicit"

    def __init__(self, text: str) -> None:
        self.robot = robot_of(text)

    @cached_property
    def supervisor(self) -> Supervisor:
        return pipeline.synthesize(self.robot, self.engine)

    def explore(self, plant: bool) -> Document:
        try:
            return explore_document(pipeline.explore(self.robot, plant=plant))
        except EmptySupervisorError:
            return {"states": [], "transitions": []}

    def counts(self) -> tuple[int, int, int]:
        document = synthesize_document(self.supervisor)
        names = ("plant_states", "controlled_states", "controlled_transitions")
        plant, states, transitions = (document[name] for name in names)
        return plant, states, transitions

    def statuses(self) -> dict[str, str]:
        return {
            _event_name(guard["event"]): guard["status"]
            for guard in synthesize_document(self.supervisor)["guards"]
        }


class Symbolic(Engine):
    """The same by the symbolic engine, where it is installed."""

    engine = "bdd"


SUBJECTS: list[type[Subject]] = [Reference, Engine]


def steps(document: Document) -> list[str]:
    """The transitions in words, sorted: ``one 0 idle --up.request--> one 1 idle``."""
    states = {state["id"]: _state_text(state) for state in document["states"]}
    return sorted(
        f"{states[t['source']]} --{_event_text(t['event'])}--> {states[t['target']]}".strip()
        for t in document["transitions"]
    )


def _state_text(state: Document) -> str:
    parts = ("components", "variables", "communications")
    return " ".join(_plain(value) for part in parts for value in state[part].values())


def _event_name(event: Document) -> str:
    return f"{event['name']}.{event['kind']}{event.get('index', '')}"


def _event_text(event: Document) -> str:
    value = event["value"]
    if value is None:
        return _event_name(event)
    if isinstance(value, dict):
        value = ", ".join(f"{path}={_plain(part)}" for path, part in value.items())
    return f"{_event_name(event)}({_plain(value)})"


def _plain(value: object) -> str:
    if value is None:
        return "null"
    return str(value).lower() if isinstance(value, bool) else str(value)
