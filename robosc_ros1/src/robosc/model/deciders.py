"""Who decides when an event occurs, given by the words that documents and logs have for it."""

from __future__ import annotations

from robosc.language.events import EventKind
from robosc.model.entities import Robot


def decides(robot: Robot, word: str, name: str) -> bool:
    """Whether the controller decides when an event occurs.

    ``name`` is the name, as shown to users, of its communication, or that of its component.
    """
    keys = {shown: key for key, shown in robot.display_names.items()}
    communication = robot.communications.get(keys.get(name, ""))
    if communication is None:
        return word == EventKind.TAU.word
    kind = communication.sort.named(word)
    return kind is not None and kind.controllable
