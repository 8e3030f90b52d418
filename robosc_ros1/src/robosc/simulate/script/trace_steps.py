"""Reads an event as traces and explanations write it: ``battery.response(charge > 0.2)``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robosc.plant import automaton, step
from robosc.simulate.faults import Refused
from robosc.simulate.machines.machine import Machine, label
from robosc.simulate.values.drawn_values import completed
from robosc.simulate.values.event_data import Given, by_path
from robosc.synthesis.formatting import event_text, part_text


def fired_by(machine: Machine, text: str) -> tuple[automaton.Event, Given] | None:
    """What a step of a trace lets happen; None if this is none, or time passes (``--execute``).

    A class gives the number or string that represents it, a test the outcome that is written.
    """
    if machine.time is not None:
        return None
    name, _, path = text.partition(": ")
    for choice in machine.choices():
        event, typed = choice.event, f"{label(choice.event)} ({path})"
        if not event.kind.of_component or event.name != name or choice.given is None:
            continue
        if text == event_text(event) or choice.text == typed:
            return event, choice.given
    found = step_written(machine.plant, text)
    if found is None and any(event_text(e) == text for e in machine.plant.events):
        raise Refused(f"{text} cannot happen now")
    if found is None:
        return None
    event, values = found
    return event, completed(machine.plant.robot, event, by_path(event, values), label(event))


def step_written(plant: automaton.Plant, text: str) -> tuple[automaton.Event, step.Values] | None:
    """The event with the values that read so in a trace; None if there is none."""
    for event in plant.events:
        head = f"{event_text(event)}("
        if event.parameters and text.startswith(head) and text.endswith(")"):
            for values in _values(event.parameters, text[len(head) : -1]):
                if step.is_consistent(values, step.missing_together(event)):
                    return event, values
    return None


def _values(parameters: Sequence[automaton.EventParameter], text: str) -> Iterator[step.Values]:
    """All readings of a text as values of parameters, in order, with commas between."""
    first, *rest = parameters
    for value in first.values:
        part = part_text(first, value)
        if not rest:
            if text == part:
                yield (value,)
        elif text.startswith(f"{part}, "):
            yield from ((value, *others) for others in _values(rest, text[len(part) + 2 :]))
