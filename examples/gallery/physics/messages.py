"""Messages of either ROS, made of dictionaries."""

from __future__ import annotations

from typing import Any

__all__ = ["fill"]


def fill(message: Any, fields: dict[str, Any]) -> Any:
    """Return the message with fields set, nested ones from nested dictionaries."""
    for name, value in fields.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)
    return message
