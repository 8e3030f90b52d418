"""The types that the topics of a model should have in a recording."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from robosc.errors import UsageError
from robosc.language.events import Kind
from robosc.model.entities import Communication

_NUMBERS = frozenset(
    {"Float32", "Float64", *(f"{u}Int{bits}" for u in ("", "U") for bits in (8, 16, 32, 64))}
)
"""The messages of std_msgs that are a number: whichever was recorded, it can be read."""


def types_of(communication: Communication, ros_1: bool) -> Mapping[str, str]:
    """By the parts of a communication's name (of a message ``""``), as ``rosbags`` has them."""
    package, name = communication.binding.package, communication.binding.type
    if communication.kind is Kind.SERVICE:
        return {"/_service_event": f"{package}/srv/msg/{name}_Event"}
    if communication.kind is not Kind.ACTION:
        return {"": f"{package}/msg/{name}"}
    if not ros_1:
        feedback = f"{package}/action/msg/{name}_FeedbackMessage"
        return {"/_action/status": "action_msgs/msg/GoalStatusArray", "/_action/feedback": feedback}
    parts = {f"/{part.lower()}": f"{package}/msg/{name}Action{part}"
             for part in ("Goal", "Feedback", "Result")}  # fmt: skip
    return {
        **parts,
        "/cancel": "actionlib_msgs/msg/GoalID",
        "/status": "actionlib_msgs/msg/GoalStatusArray",
    }


def demand_type(path: Path, name: str, part: str, recorded: Collection[str], expected: str) -> None:
    """Raises UsageError if a topic, a part of what has the name, has messages that are not of the
    type that the model expects."""
    if all(_sort(type_) == _sort(expected) for type_ in recorded):
        return
    found = " and ".join(_in_ros(type_) for type_ in recorded)
    remedy = (
        "keep only those (for instance with 'rosbag filter')"
        if expected in recorded
        else "correct the model"
    )
    raise UsageError(
        f"{path}: {name}{part} has messages of {found}, but the model expects"
        f" {_in_ros(expected)}: {remedy}, or give the name that is meant: --remap {name}:=/OTHER"
    )


def _sort(type_: str) -> str:
    package, _, name = type_.partition("/msg/")
    return "a number" if package == "std_msgs" and name in _NUMBERS else type_


def _in_ros(type_: str) -> str:
    return type_.replace("/msg/", "/")
