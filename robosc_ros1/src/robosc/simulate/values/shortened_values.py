"""Values that an event log has only in a short form, and the effects that it has instead."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, NoReturn

from robosc.runtime.core import model, recorder


class UnknownValue(Exception):
    """Something depends on a value that the log does not have whole."""


class ShortenedValue(str):
    """The short form of a variable's value. It can be shown, but nothing can be computed from it.

    Raises:
        UnknownValue: at every use but as a text of JSON.
    """

    def _refuse(self, *_: object) -> NoReturn:
        raise UnknownValue(str.__str__(self))

    __eq__ = __ne__ = __lt__ = __le__ = __gt__ = __ge__ = _refuse
    __iter__ = __len__ = __contains__ = __getitem__ = _refuse
    __add__ = __radd__ = __deepcopy__ = _refuse
    __hash__ = str.__hash__

    def __getattribute__(self, name: str) -> Any:
        if name.startswith("__"):
            return super().__getattribute__(name)
        raise UnknownValue(str.__str__(self))


def apply_effect(
    controller: model.Controller, effect: dict[str, Any], restored: Callable[[str, str, Any], Any]
) -> None:
    """Change a controller as an event did; ``restored`` returns a value of a group of
    these by name, as the controller has it.

    Raises:
        ValueError: the controller has no such thing, or it cannot have the value.
    """
    attributes = {place: name for name, place in recorder.attribute_names(controller).items()}
    short = effect.get("shortened", [])
    for group in ("components", "variables", "communications"):
        for name, told in effect.get(group, {}).items():
            attribute = attributes.get((group, name))
            if attribute is None:
                raise ValueError(f"the model has no {name}")
            if name in short:
                text = told if isinstance(told, str) else json.dumps(told, ensure_ascii=False)
                value: Any = ShortenedValue(text)
            else:
                value = restored(group, name, told)
            setattr(controller, attribute, value)
