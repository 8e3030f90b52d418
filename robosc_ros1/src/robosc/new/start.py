"""From what runs or was recorded to the text of a model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from robosc.errors import UsageError, counted
from robosc.language.attributes import TRANSFORM_TYPE
from robosc.model.ros import interfaces
from robosc.model.ros.definitions import MessageDefinitions
from robosc.names import ros_name_fault
from robosc.new import from_bag, from_ros1, from_ros2, skeleton
from robosc.new.declared_types import parts
from robosc.new.survey import Offer, RosGraph, Spacing, Survey, survey
from robosc.view.node import which_ros

_LINK = Offer("/tf", "/".join(TRANSFORM_TYPE), "")
_LISTENING = 3.0
"""Seconds in which it is measured how often messages come."""


def running(name: str, environment: Mapping[str, str]) -> str:
    """Return a model of the nodes that run; what it has is counted on standard output.

    Raises:
        UsageError: no robot is running, or no ROS.
    """
    listen = {"1": from_ros1.listen, "2": from_ros2.listen}[which_ros(environment)]
    graph, pauses = listen(_LISTENING)
    nothing = "no node of a robot is running: start the robot first"
    return _model(name, graph, pauses, "what runs", nothing)


def recorded(name: str, bag: Path) -> str:
    """Return a model of what was recorded; what it has is counted on standard output.

    Raises:
        UsageError: the bag cannot be read, or has nothing of a robot.
    """
    seen = from_bag.read(bag)
    said = "".join(f"; {note}" for note in seen.notes)
    nothing = f"{bag} has no topic of a robot{said}"
    return _model(
        name, seen.graph, seen.pauses, f"the recording {bag}", nothing, seen.definitions, seen.notes
    )


def _model(
    name: str,
    graph: RosGraph,
    pauses: Mapping[str, Spacing],
    origin: str,
    nothing: str,
    recorded: Mapping[str, interfaces.Definition] | None = None,
    notes: Sequence[str] = (),
) -> str:
    seen = survey(graph)
    if seen == Survey((), (), (), (), chains=seen.chains):
        raise UsageError(nothing)
    print(
        f"{counted(len(seen.outgoing), 'topic')} from the robot, {len(seen.incoming)} to it,"
        f" {counted(len(seen.services), 'service')}, {counted(len(seen.actions), 'action')}"
        + (f", {counted(len(seen.chains), 'transform')}" if seen.chains else "")
    )
    for note in notes:
        print(note)
    definitions = MessageDefinitions.for_model(Path(f"{name}.rscd"))
    seen, misnamed = _named(seen)
    here, absent = _defined(seen, definitions, recorded or {})
    if absent:
        print(
            f"left out, since their types are not defined here: {', '.join(o.name for o in absent)}"
        )
    if misnamed:
        names = ", ".join(map(repr, misnamed))
        print(f"left out, since ROS 1 or ROS 2 does not allow their names: {names}")
    return skeleton.from_survey(name, here, pauses, origin, absent, recorded, notes, misnamed)


def _named(survey: Survey) -> tuple[Survey, list[str]]:
    """What a model can name, and the names that it cannot: recorders of others write any text."""
    misnamed: list[str] = []

    def allowed(offers: Iterable[Offer]) -> tuple[Offer, ...]:
        faults = [(offer, ros_name_fault(offer.name)) for offer in offers]
        misnamed.extend(offer.name for offer, fault in faults if fault is not None)
        return tuple(offer for offer, fault in faults if fault is None)

    here = replace(
        survey, outgoing=allowed(survey.outgoing), incoming=allowed(survey.incoming),
        services=allowed(survey.services), actions=allowed(survey.actions),
    )  # fmt: skip
    return here, misnamed


def _defined(
    survey: Survey, definitions: MessageDefinitions, recorded: Mapping[str, interfaces.Definition]
) -> tuple[Survey, list[Offer]]:
    """What a model can name or declare, and what has a type without a definition."""
    absent: list[Offer] = []
    declared: set[str] = set()

    def known(offers: Iterable[Offer], folder: interfaces.Folder) -> tuple[Offer, ...]:
        there: list[Offer] = []
        for offer in offers:
            package, _, type_ = offer.type.partition("/")
            found = definitions.interface(package, type_, folder)
            if not isinstance(found, interfaces.Missing):
                there.append(offer)
            elif found.reason == "package" and any(parts(offer.type, folder, recorded)):
                declared.add(offer.type)
                there.append(offer)
            else:
                absent.append(offer)
        return tuple(there)

    here = Survey(
        known(survey.outgoing, "msg"), known(survey.incoming, "msg"),
        known(survey.services, "srv"), known(survey.actions, "action"), frozenset(declared),
        survey.chains if any(known([_LINK], "msg")) else (),
    )  # fmt: skip
    return here, absent
