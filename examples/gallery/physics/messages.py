"""Messages of either ROS, made of dictionaries."""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["fill", "interface"]


def fill(message: Any, fields: dict[str, Any]) -> Any:
    """Return the message with fields set, nested ones from nested dictionaries."""
    for name, value in fields.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)
    return message


def interface(type_: str, kind: str) -> Any:
    """Return the class of ``package/Name`` in ROS 2, a ``msg`` or an ``action``."""
    package, name = type_.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), name)
