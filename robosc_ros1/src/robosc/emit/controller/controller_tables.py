"""Tables and bounds of a generated controller, and what it imports."""

from __future__ import annotations

import ast
from math import prod

from robosc import limits
from robosc.emit.controller.python_literals import literal
from robosc.language.events import EventKind
from robosc.language.functions import HELPERS
from robosc.runtime.core.model import Parameter
from robosc.supervisor import Supervisor


def _helpers(module: str) -> set[str]:
    return {n for n, function in HELPERS.items() if function.__module__.endswith(f".{module}")}


_OF_RUNTIME = {
    "core.functions": _helpers("functions"),
    "core.model": {
        "After", "Command", "Communication", "Controller", "Input", "Parameter", "Requirement",
        "Tau",
    },
    "core.values": {
        "BrokenAssumption", "Mismatch", "copied", "given", "in_range", "now", "only_field",
        "optional", "record", *_helpers("values"),
    },
}  # fmt: skip
"""What a controller may import, by module of the runtime."""


def imports_of(source: str) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The names that the source of a controller uses of the runtime, by module."""
    used = {node.id for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Name)}
    found = {module: used & names for module, names in _OF_RUNTIME.items()}
    return tuple((module, tuple(sorted(names))) for module, names in found.items() if names)


def bound_of_steps(supervisor: Supervisor) -> int:
    """Internal transitions that can follow one another without coming back to a state.

    Synthesis knows the exact number unless the system is large or they have no end. Else there are
    no more situations than combinations of what they change, nor than reachable states.
    """
    if supervisor.step_bound is not None:
        return max(1, supervisor.step_bound)
    plant = supervisor.plant
    written = {v for e in plant.events if e.kind is EventKind.TAU for v in e.writes}
    combinations = prod(plant.sizes(written))
    return max(1, min(combinations, supervisor.controlled_states or combinations, limits.STEPS))


def parameter_row(parameter: Parameter) -> str:
    """The entry of a parameter in the table, as arguments."""
    parts = [literal(parameter.name), literal(parameter.type), literal(parameter.default)]
    parts.append(literal(parameter.meaning))
    if parameter.choices:
        parts.append(f"choices={literal(tuple(parameter.choices))}")
    if parameter.shape is not None:
        parts.append(f"shape={literal(parameter.shape)}")
    for name in ("minimum", "maximum"):
        bound = getattr(parameter, name)
        parts += [] if bound is None else [f"{name}={bound!r}"]
    parts += ["required=True"] if parameter.required else []
    return ", ".join([*parts, f"attribute={literal(parameter.attribute)}"])
