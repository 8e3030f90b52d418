"""Definitions of ROS 1, as genmsg reads them (https://wiki.ros.org/msg), without genmsg.

That library is on no index of Python packages, so a Python that is not the one of ROS has none.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from robosc.expr.types import Value
from robosc.model.ros.interfaces import INTEGERS, PARTS, Definition, Folder

_BUILT_IN = frozenset({*INTEGERS, "bool", "float32", "float64", "string", "time", "duration"})
_CONSTANTS = _BUILT_IN - {"time", "duration"}
_NAME = re.compile(r"[A-Za-z]\w*")
_TYPE = re.compile(r"(?P<base>[A-Za-z]\w*(?:/[A-Za-z]\w*)?)(?P<array>(?:\[\d*\])?)")
_HEADER = "std_msgs/Header"


def parts(text: str, package: str, type_: str, folder: Folder) -> Iterator[Definition]:
    """Yield the parts of the text of ``package/folder/type_.folder``.

    Raises:
        ValueError: the text is faulty; says what is wrong in it.
    """
    names = PARTS[folder]
    texts = [text] if folder == "msg" else re.split(r"^---.*$", text, flags=re.MULTILINE)
    if (
        folder == "srv"
    ):  # a service without --- is a request; all that follows the first one answers
        texts = [texts[0], "\n".join(texts[1:])]
    if len(texts) != len(names):
        raise ValueError(f"has {len(texts)} parts instead of {len(names)}, separated by ---")
    for part, name in zip(texts, names, strict=True):
        fields: list[tuple[str, str]] = []
        constants: list[tuple[str, Value]] = []
        for line in part.split("\n"):
            code = line.partition("#")[0].strip()
            if "=" in code:
                constants.append(_constant(line, code))
            elif code:
                fields.append(_field(code, package))
        yield Definition.of(f"{package}/{type_}{name}", fields, constants)


def _field(code: str, package: str) -> tuple[str, str]:
    """The name and the type of the field that a line declares."""
    words = code.split()
    match = _TYPE.fullmatch(words[0])
    if len(words) != 2 or match is None or not _NAME.fullmatch(words[1]):
        raise ValueError(f"Invalid declaration: {code}")
    base = match["base"]
    if base == "Header":
        base = _HEADER
    elif base not in _BUILT_IN and "/" not in base:
        base = f"{package}/{base}"
    return words[1], base + match["array"]


def _constant(line: str, code: str) -> tuple[str, Value]:
    """The name and the value of the constant that a line declares.

    ``code`` is the line without its comment; that of a string has none.
    """
    type_, _, rest = (line.strip() if code.startswith("string") else code).partition(" ")
    name, _, text = (word.strip() for word in rest.partition("="))
    if type_ not in _CONSTANTS or not _NAME.fullmatch(name):
        raise ValueError(f"Invalid constant declaration: {code}")
    try:
        return name, _value(type_, text)
    except (SyntaxError, ValueError) as error:
        raise ValueError(f"Invalid constant value: {error}") from None


def _value(type_: str, text: str) -> Value:
    if type_ == "string":
        return text
    if type_ == "bool":
        return bool(ast.literal_eval(text))
    if type_ not in INTEGERS:
        return float(text)
    least, greatest = INTEGERS[type_]
    if not least <= int(text) <= greatest:
        raise ValueError(f"cannot coerce [{text}] to {type_} (out of bounds)")
    return int(text)
