"""Definitions of ROS 2: ``.msg``, ``.srv``, ``.action``, or ``.idl`` where there is only that.

Unlike in ROS 1, fields may have default values, and bounds, which are ignored here; types of the
same package have no package name, and there is no ``Header``, ``time`` or ``duration``. Of IDL
(https://design.ros2.org/articles/idl_interface_definition.html), the subset that ROS 2's own tools
write is read.

Types are spelled as in ROS 1: ``float64``, ``string[3]``, ``geometry_msgs/Point[]``; a byte or a
char of ROS 2 is a ``uint8``.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from robosc.expr.types import Value
from robosc.model.ros.interfaces import PARTS, Definition, Folder


def read(package: Path, name: str, type_: str, folder: Folder) -> tuple[Definition, ...] | None:
    """The parts of ``msg/type_.msg`` or the like in the package ``name``; None if it is not there.

    Raises:
        ValueError: the file is faulty, with what is wrong where (in IDL of which name).
        OSError: it cannot be read.
    """
    file = package / folder / f"{type_}.{folder}"
    if file.is_file():
        text = file.read_text(encoding="utf-8", errors="replace")
        return tuple(_texts(text, name, type_, folder))
    idl = file.with_suffix(".idl")
    if idl.is_file():
        text = idl.read_text(encoding="utf-8", errors="replace")
        return tuple(_idl(text, name, type_, folder))
    return None


# --- .msg, .srv, .action -------------------------------------------------------------------------

_BUILT_IN = {
    **{f"{sign}int{bits}": f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    **{"bool": "bool", "byte": "uint8", "char": "uint8", "float32": "float32"},
    **{"float64": "float64", "string": "string", "wstring": "string"},
}
_LINE = re.compile(
    r"(?P<base>[A-Za-z]\w*(?:/[A-Za-z]\w*)?)(?:<=\d+)?"
    r"(?:\[(?P<length>\d*|<=\d+)\])?\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)"
)

_QUOTED = re.compile(r'"[^"]*"|\'[^\']*\'')


def _texts(text: str, package: str, type_: str, folder: Folder) -> Iterator[Definition]:
    texts: list[list[tuple[int, str]]] = [[]]
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("---"):
            texts.append([])
        else:
            texts[-1].append((number, line))
    if len(texts) != len(PARTS[folder]):
        raise ValueError(f"has {len(texts)} parts instead of {len(PARTS[folder])}")
    for lines, part in zip(texts, PARTS[folder], strict=True):
        yield _part(lines, package, f"{package}/{type_}{part}")


def _part(lines: list[tuple[int, str]], package: str, name: str) -> Definition:
    fields: list[tuple[str, str, Value | None]] = []
    constants = []
    for number, line in lines:
        code = line.strip()
        if not code or code.startswith("#"):
            continue
        match = _LINE.fullmatch(code)
        if match is None:
            raise ValueError(f"line {number}: {code!r} is neither a field nor a constant")
        if match["rest"].startswith("="):
            text = match["rest"][1:].strip()
            constants.append((match["name"], _constant(match["base"], text, f"line {number}")))
            continue
        base = match["base"]
        if "/" not in base:
            base = _BUILT_IN.get(base, f"{package}/{base}")
        single = base in _BUILT_IN.values() and match["length"] is None
        default = _default(match["base"], match["rest"], f"line {number}") if single else None
        fields.append((match["name"], _spelled(base, match["length"]), default))
    return Definition.of(name, fields, constants)


def _default(base: str, text: str, where: str) -> Value | None:
    """The default of a field; None if there is none.

    Raises:
        ValueError: it is not of the type.
    """
    quoted = _QUOTED.match(text)
    if quoted is not None and _BUILT_IN.get(base) == "string":
        return quoted[0][1:-1]
    text = text.partition("#")[0].strip()
    return _constant(base, text, where) if text else None


def _constant(base: str, text: str, where: str) -> Value:
    """The value of a constant, which stands ``where``; as in ROS 2, a comment ends it even within
    quotes.

    Raises:
        ValueError: it is not of the type.
    """
    text = text.partition("#")[0].strip()
    if _BUILT_IN.get(base) == "string":
        return text[1:-1] if text[:1] in ("'", '"') and text[-1:] == text[0] else text
    try:
        if base == "bool":
            return {"true": True, "1": True, "false": False, "0": False}[text.lower()]
        return float(text) if base.startswith("float") else int(text, 0)
    except (KeyError, ValueError):
        raise ValueError(f"{where}: {text!r} is not of type {base}") from None


def _spelled(base: str, length: str | None) -> str:
    if length is None:
        return base
    return f"{base}[]" if length.startswith("<") else f"{base}[{length}]"


# --- .idl ----------------------------------------------------------------------------------------

_NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"', re.DOTALL)
_ANNOTATION = re.compile(r"@\w+\s*(?:\([^()]*\))?")
_DEFAULT = re.compile(r"@default\s*\(\s*value\s*=\s*([^()]*?)\s*\)")
_STRUCT = re.compile(r"struct\s+(\w+)\s*\{([^{}]*)\}")
_TYPEDEF = re.compile(r"typedef\s+([^;]+?)\s+(\w+)\s*\[\s*(\d+)\s*\]\s*;")
# ROS 2 declares an alias for a struct before an array of it.
_ALIAS = re.compile(r"typedef\s+([^;\[\]]+?)\s+(\w+)\s*;")
_CONSTANTS = re.compile(r"module\s+(\w+)_Constants\s*\{([^{}]*)\}")
_CONSTANT = re.compile(r"const\s+([^;=]+?)\s+(\w+)\s*=\s*([^;]+?)\s*;")
_SEQUENCE = re.compile(r"sequence\s*<\s*([\w:]+(?:\s*<\s*\d+\s*>)?)\s*(?:,\s*\d+\s*)?>")
_IDL_TYPES = {
    "boolean": "bool", "octet": "uint8", "char": "uint8", "wchar": "uint16", "float": "float32",
    "double": "float64", "string": "string", "wstring": "string", "short": "int16",
    "unsigned short": "uint16", "long": "int32", "unsigned long": "uint32", "long long": "int64",
    "unsigned long long": "uint64",
}  # fmt: skip


def _idl(text: str, package: str, type_: str, folder: Folder) -> Iterator[Definition]:
    strings: list[str] = []

    def put_aside(match: re.Match[str]) -> str:
        """Replace a string by its number, since it may contain what looks like a declaration."""
        if not match[0].startswith('"'):
            return " "
        strings.append(ast.literal_eval(match[0]))
        return f'"{len(strings) - 1}"'

    defaults: list[str] = []

    def numbered(match: re.Match[str]) -> str:
        """Replace the default of a member by its number; all other annotations say nothing here."""
        default = _DEFAULT.fullmatch(match[0])
        if default is None:
            return " "
        defaults.append(default[1])
        return f" @{len(defaults) - 1} "

    text = _ANNOTATION.sub(numbered, _NOISE.sub(put_aside, text))
    aliases = {name: base for base, name in _ALIAS.findall(text)}
    typedefs = _TYPEDEF.findall(text)
    arrays = {name: (aliases.get(base, base), length) for base, name, length in typedefs}
    structs = dict(_STRUCT.findall(text))
    constants = {
        name: tuple(_idl_constants(body, strings)) for name, body in _CONSTANTS.findall(text)
    }

    def default_of(base: str, number: int, member: str) -> Value:
        return _idl_value(base, defaults[number], strings, f"the default of {member}")

    for part in PARTS[folder]:
        name = f"{type_}_{part}" if part else type_
        if name not in structs:
            raise ValueError(f"has no struct {name}")
        members = [m.strip() for m in structs[name].split(";") if m.strip()]
        fields = _members(members, arrays, default_of)
        yield Definition.of(f"{package}/{type_}{part}", fields, constants.get(name, ()))


def _idl_constants(body: str, strings: Sequence[str]) -> Iterator[tuple[str, Value]]:
    for type_, name, text in _CONSTANT.findall(body):
        base = _idl_type(type_)
        yield name, _idl_value(base, text, strings, f"constant {name}")


def _idl_value(base: str, text: str, strings: Sequence[str], where: str) -> Value:
    if base == "string":
        return "".join(strings[int(number)] for number in re.findall(r'"(\d+)"', text))
    return _constant(base, text, where)


def _members(
    members: list[str],
    arrays: dict[str, tuple[str, str]],
    default_of: Callable[[str, int, str], Value],
) -> Iterator[tuple[str, str, Value | None]]:
    """Yield name, type and default of each member; ``default_of`` takes type, number and name."""
    for member in members:
        given = re.search(r"@(\d+)", member)
        type_, _, name = " ".join(re.sub(r"@\d+", " ", member).split()).rpartition(" ")
        # A struct of IDL needs a member; ROS 2 gives this one to an empty message.
        if name == "structure_needs_at_least_one_member":
            continue
        if type_ in arrays:
            base, length = arrays[type_]
            yield name, f"{_idl_type(base)}[{length}]", None
        elif match := _SEQUENCE.fullmatch(type_):
            yield name, f"{_idl_type(match[1])}[]", None
        else:
            base = _idl_type(type_)
            default = (
                None if given is None or "/" in base else default_of(base, int(given[1]), name)
            )
            yield name, base, default


def _idl_type(text: str) -> str:
    base = re.sub(r"\s*<.*", "", " ".join(text.split()))
    if base in _IDL_TYPES:
        return _IDL_TYPES[base]
    if re.fullmatch(r"u?int(8|16|32|64)", base):
        return base
    scopes = base.strip(":").split("::")
    if len(scopes) < 2:
        raise ValueError(f"the type {text!r} is not known")
    return f"{scopes[0]}/{scopes[-1]}"
