"""Every primitive type of ROS with its extreme values, for the border between it and the language."""

from __future__ import annotations

__all__ = [
    "CHECK",
    "PRIMITIVES_OF_ROS1",
    "PRIMITIVES_OF_ROS2",
    "STORED",
    "Primitives",
    "definition",
]

Primitives = dict[str, list[bool | int | float | str]]

PRIMITIVES: Primitives = {
    "bool": [True, False, True],
    "float32": [0.5, -1.25, 3.0],
    "float64": [0.1, -1e300, 5e-324],
    **{f"int{n}": [-(2 ** (n - 1)), 0, 2 ** (n - 1) - 1] for n in (8, 16, 32, 64)},
    **{f"uint{n}": [0, 1, 2**n - 1] for n in (8, 16, 32, 64)},
    "string": ["", "größer 漢字", "a b"],
}
"""Type to three values. ``byte`` and ``char`` differ between the versions of ROS."""

# A byte of ROS 1 is an int8, a char an uint8; both are uint8 in ROS 2.
PRIMITIVES_OF_ROS1 = {**PRIMITIVES, "byte": [-128, 0, 127], "char": [0, 65, 255]}
PRIMITIVES_OF_ROS2 = {
    **PRIMITIVES, "byte": [0, 1, 255], "char": [0, 65, 255], "wstring": PRIMITIVES["string"],
}  # fmt: skip


def definition(primitives: Primitives) -> str:
    """A message with a field, an array and a fixed array of each type."""
    lines = (f"{t} one_{t}\n{t}[] many_{t}\n{t}[3] three_{t}\n" for t in primitives)
    return "".join(lines)


CHECK = """
import json
data = {}
for name, values in PRIMITIVES.items():
    data["one_" + name] = values[2]
    data["many_" + name] = values
    data["three_" + name] = values
message = there_and_back(data)
for name, expected in data.items():
    found = getattr(message, name)
    if isinstance(expected, list):
        found = list(found)
        assert [type(v) for v in found] == [type(v) for v in expected], (name, found)
    else:
        assert type(found) is type(expected), (name, found)
    assert found == expected, (name, found)
    json.dumps(found)
"""
"""Sends data of the language and takes them in again; what comes is equal, and plain Python."""

STORED = """
kept = copied(message)
assert str(there_and_back(copied(kept))) == str(message)
parts = {name: copied(getattr(kept, name)) for name in data}
assert str(there_and_back(parts)) == str(message)
for name in data:
    if not name.startswith("one_"):
        parts[name] = list(getattr(kept, name)[0:3])
assert str(there_and_back(parts)) == str(message)
"""
"""Sends again what came, as a whole, part by part, and with arrays of which sections were taken."""
