"""A robot that calls with data of every primitive type, and a model whose controller gives them back.

Both depend on the version of ROS only in the types that one of them lacks, or has otherwise.
"""

from __future__ import annotations

from typing import Any

from primitives import Primitives, definition

__all__ = ["call", "files", "model"]

PARTS = "Primitives"


def fields(primitives: Primitives) -> str:
    """Each primitive type as a field, in an array, in a message, and in an array of messages."""
    return definition(primitives) + f"std_msgs/Header header\n{PARTS} nested\n{PARTS}[] several\n"


def files(primitives: Primitives) -> dict[str, str]:
    """The definitions, by their places in a package."""
    part = fields(primitives)
    return {
        f"msg/{PARTS}.msg": definition(primitives),
        "srv/Reflect.srv": f"{part}---\n{part}",
        "action/Shine.action": f"{part}---\n{part}---\n{part}",
    }


def call(primitives: Primitives, succeeds: bool = True) -> dict[str, Any]:
    """Data of a call; a goal that shall not succeed has no true ``one_bool``."""
    flat: dict[str, Any] = {}
    for name, values in primitives.items():
        flat |= {f"one_{name}": values[2], f"many_{name}": values, f"three_{name}": values[::-1]}
    other = {name: [] if name.startswith("many_") else value for name, value in flat.items()}
    return flat | {"one_bool": succeeds, "nested": flat, "several": [other, flat, other]}


def model(primitives: Primitives) -> str:
    """Give back what came with a call; a goal gets it as feedback, and then as its result."""
    types = {}
    for name, values in primitives.items():
        plain = {bool: "boolean", int: "integer", float: "double", str: "string"}[type(values[0])]
        types |= {f"one_{name}": plain, f"many_{name}": f"array({plain})"}
        types |= {f"three_{name}": f"array({plain})"}
    part = f"robosc_testing/{PARTS}"
    types |= {"header": "std_msgs/Header", "nested": part, "several": f"array({part})"}
    variables = "\n".join(f"variable {name}: {type_}" for name, type_ in types.items())
    kept = ", ".join(f"{name} := value.{name}" for name in types)
    given = "{ " + ", ".join(f"{name}: Mirror.{name}" for name in types) + " }"
    return f"""
robot Reflector {{
    component Mirror {{
        outgoing service reflect with type: robosc_testing/Reflect
        outgoing action shine with type: robosc_testing/Shine
        behaviour {{
            {variables}
            initial marked state free {{
                on request from reflect do {kept} goto called
                on request from shine if value.one_bool do {kept} goto sent
                on request from shine if !value.one_bool do {kept} goto failing
            }}
            state called {{ on response to reflect goto free }}
            state sent {{
                on feedback to shine goto told
                on cancel from shine goto failing
            }}
            state told {{
                on response to shine goto free
                on cancel from shine goto failing
            }}
            state failing {{ on error to shine goto free }}
        }}
    }}
    provide reflect with {given}
    provide shine with {given}
    provide shine.feedback with {given}
    provide shine.error with {given}
}}
"""
