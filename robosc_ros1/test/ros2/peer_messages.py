"""Messages and quality of service for a peer: of the JSON in its orders, and back."""

from __future__ import annotations

import importlib
import re
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)


def load(name: str) -> Any:
    package, kind, type_ = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), type_)


def fill(message: Any, data: dict[str, Any]) -> Any:
    for name, value in data.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            kind = message.get_fields_and_field_types()[name]
            package, _, type_ = re.sub(r"sequence<|[>,[].*", "", kind).partition("/")
            setattr(message, name, [fill(load(f"{package}/msg/{type_}")(), v) for v in value])
        elif isinstance(getattr(message, name), float):
            setattr(message, name, float(value))
        elif isinstance(getattr(message, name), bytes):
            setattr(message, name, bytes([value]))
        elif message.get_fields_and_field_types()[name].startswith(("sequence<octet", "octet[")):
            setattr(message, name, [bytes([part]) for part in value])
        else:
            setattr(message, name, value)
    return message


def plain(value: Any) -> Any:
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bool | int | float | str):
        return value
    if hasattr(value, "tolist"):  # of numpy, or an array
        return value.tolist()
    if isinstance(value, bytes):
        return list(value) if len(value) != 1 else value[0]
    return [plain(part) for part in value]


def profile(
    reliability: str = "reliable", durability: str = "volatile", depth: int = 1000,
    deadline: float = 0.0, liveliness: str = "automatic", lease: float = 0.0,
) -> Any:  # fmt: skip
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy[reliability.upper()],
        durability=DurabilityPolicy[durability.upper()],
        deadline=Duration(seconds=deadline),
        liveliness=LivelinessPolicy[liveliness.upper()],
        liveliness_lease_duration=Duration(seconds=lease),
    )
