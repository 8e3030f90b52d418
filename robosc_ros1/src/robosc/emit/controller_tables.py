"""Tables and bounds of a generated controller, and what it imports."""

from __future__ import annotations

import re
from math import prod

from robosc.emit.literals import literal
from robosc.emit.views import ControllerContext
from robosc.ir.automaton import VariableKind
from robosc.language.functions import HELPERS
from robosc.model.entities import EventKind
from robosc.runtime.model import Parameter
from robosc.supervisor import Supervisor

__all__ = ["STEP_LIMIT", "bound_of_steps", "imports_of", "parameter_row"]

STEP_LIMIT = 10_000
"""No run to completion takes more steps, whatever the product of the components' states is."""


def _tables(context: ControllerContext) -> tuple[str, ...]:
    used = {
        "Command": context.tables["commands"],
        "Communication": context.tables["communications"],
        "Input": context.tables["inputs"],
        "Requirement": context.tables["requirements"],
        "After": context.tables["afters"],
        "Parameter": context.parameters,
        "Rows": context.copies,
        "Tau": context.tables["taus"],
    }
    return tuple(sorted(["Controller", *(name for name, entries in used.items() if entries)]))


def imports_of(context: ControllerContext) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What is used of each module of the runtime: all expressions are text in the context."""
    called = set(re.findall(r"(?<!\w)\w+(?=\()", repr(context).replace("\\n", " ")))
    modules = {
        "functions": [],
        "values": ["copied", "given", "in_range", "now", "only_field", "optional"],
    }
    for name, function in HELPERS.items():
        modules[function.__module__.rpartition(".")[2]].append(name)
    used = {
        module: [name for name in sorted(names) if name in called]
        for module, names in modules.items()
    }
    reactions = [i.reaction for i in context.inputs] + [c.reaction for c in context.commands]
    if "Mismatch" in called or any(reaction.busy for reaction in reactions):
        used["values"].insert(0, "Mismatch")
    used["model"] = list(_tables(context))
    return tuple((module, tuple(names)) for module, names in sorted(used.items()) if names)


def bound_of_steps(supervisor: Supervisor) -> int:
    """Internal transitions that can follow one another without coming back to a state.

    Synthesis knows the exact number unless the system is large or they have no end. Else: own
    steps change nothing but their components' states, so there are no more situations than
    combinations of those, nor than reachable states.
    """
    if supervisor.step_bound is not None:
        return max(1, supervisor.step_bound)
    plant = supervisor.plant
    variables = {p.variable for e in plant.events if e.kind is EventKind.TAU for p in e.automata}
    combinations = prod(
        variable.size
        for index, variable in enumerate(plant.variables)
        if index in variables and variable.kind is VariableKind.LOCATION
    )
    return max(1, min(combinations, supervisor.controlled_states or combinations, STEP_LIMIT))


def parameter_row(parameter: Parameter) -> str:
    """The entry of a parameter in the table, as arguments."""
    parts = [literal(parameter.name), literal(parameter.type), literal(parameter.default)]
    parts.append(literal(parameter.meaning))
    if parameter.choices:
        parts.append(f"choices={literal(tuple(parameter.choices))}")
    for name in ("minimum", "maximum"):
        bound = getattr(parameter, name)
        parts += [] if bound is None else [f"{name}={bound!r}"]
    return ", ".join([*parts, f"attribute={literal(parameter.attribute)}"])
