"""The events of CIF: those of the plant, each with each of its values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from robosc import errors, limits, names
from robosc.emit.export.cif_names import CifScope
from robosc.plant import automaton, partial_evaluation, step
from robosc.synthesis.event_parameters import weight


@dataclass(frozen=True, slots=True)
class CifEvent:
    """An event with one value: an event of its own in CIF."""

    event: automaton.Event
    values: partial_evaluation.PartValues
    name: str


def cif_events(plant: automaton.Plant, scope: CifScope) -> Iterator[CifEvent]:
    """Each event with each of its values.

    Raises:
        StateSpaceError: they are too many to be written down.
    """
    for event in plant.events:
        if weight(event) > limits.CIF_VALUES:
            name = f"{event.name}.{event.kind.word}"
            raise errors.StateSpaceError(
                f"CIF needs an event for each value, and {name} has more than"
                f" {limits.CIF_VALUES:,}: convert the received value by an enum,"
                " or export as JSON"
            )
        event_name = _event_name(event)
        parameters = (event.whole or event).parameters
        words = [scope.value_names(event_name, p) for p in parameters]
        for values in step.valuations(event):
            known = list(zip(parameters, values, words, strict=True))
            parts = [event_name, *(own[p.values.index(value)] for p, value, own in known)]
            name = scope.fresh("_".join(parts))
            yield CifEvent(event, {p.path: value for p, value, _ in known}, name)


def _event_name(event: automaton.Event) -> str:
    prefix = "c" if event.controllable else "u"
    name = names.without_index(event.name).replace(".", "_")
    number = event.index if event.kind.of_component else ""
    return f"{prefix}_{name}_{event.kind.word}{number}"
