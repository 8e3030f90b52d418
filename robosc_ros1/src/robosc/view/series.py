"""How the states, the numbers of variables and those in data went over a recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from robosc.runtime.core.model import Controller
from robosc.runtime.core.places import places
from robosc.simulate.event_log import LogEntry

Json = Any


class Collector:
    """Series by name: a component's states, a variable, or an event with the path of a number.

    Of states and variables, places (from 1) where they change; of data, all places. ``owners`` are
    the components of communications.
    """

    def __init__(self, owners: Mapping[str, str]) -> None:
        self._owners = owners
        self._found: dict[str, tuple[str | None, list[int], list[Any]]] = {}

    def take(self, place: int, entry: LogEntry, controller: Controller | None) -> None:
        """An event, and the state after it; None where it is not known."""
        if controller is not None:
            self._change(place, places(controller.components()))
            self._change(place, dict(_numbers(controller.variables(), "")))
        if entry.outcome == "applied" and entry.name in self._owners:
            for path, value in _numbers(entry.value, " "):
                self._series(f"{entry.text}{path}", self._owners[entry.name], place, value)

    def documents(self) -> list[Json]:
        """``component`` is set for data: the one whose communication carries them."""
        return [
            {"name": name, "component": component, "places": places, "values": values}
            for name, (component, places, values) in self._found.items()
        ]

    def _change(self, place: int, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            found = self._found.get(name)
            if found is None or found[2][-1] != value:
                self._series(name, None, place, value)

    def _series(self, name: str, component: str | None, place: int, value: Any) -> None:
        _, places, values = self._found.setdefault(name, (component, [], []))
        places.append(place)
        values.append(value)


def _numbers(value: Any, before: str) -> Iterator[tuple[str, int | float]]:
    """The numbers of a value that JSON has, with their paths; lists are too many."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            for path, number in _numbers(part, before):
                yield f"{before}{name}{path}", number
    elif isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300:
        yield "", value
