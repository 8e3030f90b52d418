"""``robosc export``: a model in the formats of other tools."""

from __future__ import annotations

import json
from math import prod
from typing import Literal, TypeAlias

from robosc import errors, limits
from robosc.emit.export import cif, dot, json_export
from robosc.plant.automaton import Plant
from robosc.supervisor import Supervisor
from robosc.synthesis import Graph, explore, synthesize

Format: TypeAlias = Literal["cif", "dot", "svg", "json"]


def exported(plant: Plant, format_: Format, with_supervisor: bool = False) -> str:
    """The text of a plant in a format; ``with_supervisor`` adds its guards to CIF.

    Raises:
        EmptySupervisorError: there is no supervisor to add.
        StateSpaceError: synthesis is needed, and the state space is too large.
        UsageError: graphviz is needed and not installed, or CIF has no place for a test of data.
    """
    match format_:
        case "cif" if with_supervisor:
            supervisor = synthesize(plant)
            if supervisor.empty:
                raise errors.EmptySupervisorError("the supervisor is empty; leave out --supervisor")
            return cif.cif_supervised(supervisor)
        case "cif":
            return cif.cif_plant(plant)
        case "json":
            document = json_export.export_document(synthesize(plant))
            return json.dumps(document, indent=2, ensure_ascii=False) + "\n"
    picture = dot.dot_text(plant.robot, _drawn(plant))
    return picture if format_ == "dot" else dot.svg_text(picture)


def picture(supervisor: Supervisor) -> str:
    """The picture of a robot and its controlled states in DOT."""
    return dot.dot_text(supervisor.plant.robot, _controlled(supervisor))


def _drawn(plant: Plant) -> Graph | None:
    """The controlled system, if it is small enough for a picture."""
    return _controlled(synthesize(plant)) if _is_small(plant) else None


def _is_small(plant: Plant) -> bool:
    return prod(variable.size for variable in plant.variables) <= limits.DRAWN_PRODUCT


def _controlled(supervisor: Supervisor) -> Graph | None:
    if supervisor.empty or not _is_small(supervisor.plant):
        return None
    try:
        return explore(supervisor, limits.DRAWN_STATES)
    except errors.StateSpaceError:
        return None
