"""Definitions of ROS 2: ``.msg``, ``.srv``, ``.action``, or ``.idl`` where there is only that.

Unlike in ROS 1, fields may have default values, and bounds; types of the
same package have no package name, and there is no ``Header``, ``time`` or ``duration``. Of IDL
(https://design.ros2.org/articles/idl_interface_definition.html), the subset that ROS 2's own tools
write is read.

Types are spelled as in ROS 1: ``float64``, ``string[3]``, ``geometry_msgs/Point[]``; a byte or a
char of ROS 2 is a ``uint8``.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import prod
from pathlib import Path

from robosc.expr.types import Value
from robosc.model.ros.interfaces import INTEGERS, PARTS, Default, Definition, Folder


def read(file: Path, package: str, type_: str, folder: Folder) -> tuple[Definition, ...]:
    """The parts of ``package/folder/type_``, from its ``.msg`` or the like, or its ``.idl``.

    Raises:
        ValueError: the file is faulty, with what is wrong where (in IDL of which name).
        OSError: it cannot be read.
    """
    text = file.read_text(encoding="utf-8", errors="replace")
    reader = _idl if file.suffix == ".idl" else texts
    return tuple(reader(text, package, type_, folder))


# --- .msg, .srv, .action -------------------------------------------------------------------------

_BUILT_IN = {
    **{f"{sign}int{bits}": f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    **{"bool": "bool", "byte": "uint8", "char": "uint8", "float32": "float32"},
    **{"float64": "float64", "string": "string", "wstring": "wstring"},
}
_LINE = re.compile(
    r"(?P<base>[A-Za-z]\w*(?:/[A-Za-z]\w*){0,2})(?P<longest>(?:<=\d+)?)"
    r"(?:\[(?P<length>\d*|<=\d+)\])?\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)"
)

_QUOTED = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'')
_ELEMENT = re.compile(rf"\s*(?P<text>{_QUOTED.pattern}|[^,\]]*?)\s*(?P<end>[,\]]|$)")
_FIELD_NAME = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
_CONSTANT_NAME = re.compile(r"[A-Z]([A-Z0-9_]?[A-Z0-9]+)*")
_STRINGS = ("string", "wstring")
_NO_MEMBER = "structure_needs_at_least_one_member"


def texts(text: str, package: str, type_: str, folder: Folder) -> Iterator[Definition]:
    """Yield the parts of the text of ``package/folder/type_.folder``.

    Raises:
        ValueError: the text is faulty; says what is wrong in which line.
    """
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
    fields: list[tuple[str, str, Default | None]] = []
    constants = []
    doubts: list[str] = []
    for number, line in lines:
        code = line.strip()
        if not code or code.startswith("#"):
            continue
        match = _LINE.fullmatch(code)
        if match is None:
            raise ValueError(f"line {number}: {code!r} is neither a field nor a constant")
        where = f"line {number}"
        is_constant = match["rest"].startswith("=")
        pattern = _CONSTANT_NAME if is_constant else _FIELD_NAME
        if not pattern.fullmatch(match["name"]):
            case = "upper" if is_constant else "lower"
            doubts.append(
                f"{where}: the name {match['name']} must be of {case} case, with single _"
            )
        if is_constant:
            value = _constant(match["base"], match["rest"][1:].strip(), where)
            constants.append((match["name"], value))
            doubts += _out_of_range(match["base"], value, where)
            continue
        base = match["base"]
        if "/" not in base:
            base = _BUILT_IN.get(base, f"{package}/{base}")
        else:  # recorders also name the folder: geometry_msgs/msg/Point
            base = f"{base.partition('/')[0]}/{base.rpartition('/')[2]}"
        default: Default | None = None
        if base in _BUILT_IN.values():
            read = _default if match["length"] is None else _default_of_array
            default = read(match["base"], match["rest"], where)
        for part in default if isinstance(default, tuple) else (default,):
            doubts += _out_of_range(match["base"], part, where)
        fields.append((match["name"], _spelled(base + match["longest"], match["length"]), default))
    return Definition.of(name, fields, constants, doubts)


def _out_of_range(base: str, value: Value | None, where: str) -> Iterator[str]:
    least, greatest = INTEGERS.get(_BUILT_IN.get(base, ""), (0, 0))
    if type(value) is int and not least <= value <= greatest:
        yield f"{where}: {value} is not from {least} to {greatest}"


def _default(base: str, text: str, where: str) -> Value | None:
    """The default of a field; None if there is none.

    Raises:
        ValueError: it is not of the type.
    """
    quoted = _QUOTED.match(text)
    if quoted is not None and _BUILT_IN.get(base) in _STRINGS:
        return _unquoted(quoted[0])
    text = text.partition("#")[0].strip()
    return _constant(base, text, where) if text else None


def _default_of_array(base: str, text: str, where: str) -> tuple[Value, ...] | None:
    """The default of an array, ``[1, 2]``; None if there is none.

    Raises:
        ValueError: an element is not of the type.
    """
    if not text.startswith("["):
        return None
    found: list[Value] = []
    element = _ELEMENT.match(text, 1)
    while element is not None and (element["text"] or element["end"] == ","):
        is_string = _BUILT_IN.get(base) in _STRINGS
        given = element["text"]
        found.append(_unquoted(given) if is_string else _constant(base, given, where))
        element = _ELEMENT.match(text, element.end()) if element["end"] == "," else None
    return tuple(found)


def _unquoted(text: str) -> str:
    """A string without its quotes; as in ROS 2, only a quote can be escaped."""
    if text[:1] in ("'", '"') and text[-1:] == text[0] and len(text) > 1:
        return text[1:-1].replace(f"\\{text[0]}", text[0])
    return text


def _constant(base: str, text: str, where: str) -> Value:
    """The value of a constant, which stands ``where``; as in ROS 2, a comment ends it even within
    quotes, and a number is decimal if it can be (``010`` is ten).

    Raises:
        ValueError: it is not of the type.
    """
    text = text.partition("#")[0].strip()
    if _BUILT_IN.get(base) in _STRINGS:
        return _unquoted(text)
    try:
        if base == "bool":
            return {"true": True, "1": True, "false": False, "0": False}[text.lower()]
        return float(text) if base.startswith("float") else _integer(text)
    except (KeyError, ValueError):
        raise ValueError(f"{where}: {text!r} is not of type {base}") from None


def _integer(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        return int(text, 0)


def _spelled(base: str, length: str | None) -> str:
    return base if length is None else f"{base}[{length}]"


# --- .idl ----------------------------------------------------------------------------------------

_NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"', re.DOTALL)
_ANNOTATION = re.compile(r"@\w+\s*(?:\([^()]*\))?")
_DEFAULT = re.compile(r"@default\s*\(\s*value\s*=\s*([^()]*?)\s*\)")
_STRUCT = re.compile(r"struct\s+(\w+)\s*\{([^{}]*)\}")
_ENUM = re.compile(r"enum\s+(\w+)\s*\{[^{}]*\}")
_TYPEDEF = re.compile(r"typedef\s+([^;]+?)\s+(\w+\s*(?:\[[^;]*)?);")
_DECLARATOR = re.compile(r"(\w+)\s*((?:\[\s*\w+\s*\]\s*)*)")
_CONSTANTS = re.compile(r"module\s+(\w+)_Constants\s*\{([^{}]*)\}")
_CONSTANT = re.compile(r"const\s+([^;=]+?)\s+(\w+)\s*=\s*([^;]+?)\s*;")
_SEQUENCE = re.compile(r"sequence\s*<\s*([\w:]+(?:\s*<\s*\d+\s*>)?)\s*(?:,\s*(\d+)\s*)?>")
_IDL_TYPES = {
    "boolean": "bool", "octet": "uint8", "char": "uint8", "wchar": "uint16", "float": "float32",
    "double": "float64", "string": "string", "wstring": "wstring", "short": "int16",
    "unsigned short": "uint16", "long": "int32", "unsigned long": "uint32", "long long": "int64",
    "unsigned long long": "uint64",
}  # fmt: skip


def _idl(text: str, package: str, type_: str, folder: Folder) -> Iterator[Definition]:
    structs = idl_structs(text, package)
    for part in PARTS[folder]:
        name = f"{type_}_{part}" if part else type_
        if name not in structs:
            raise ValueError(f"has no struct {name}")
        yield replace(structs[name], name=f"{package}/{type_}{part}")


def idl_structs(text: str, package: str) -> dict[str, Definition]:
    """All structs of a text, by their names without those of their modules.

    Raises:
        ValueError: the text is faulty; says what is wrong of which name.
    """
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
    members = _Members(text, package, defaults, strings)
    constants = {
        name: tuple(_idl_constants(body, strings)) for name, body in _CONSTANTS.findall(text)
    }
    return {
        name: Definition.of(f"{package}/{name}", members.of(body), constants.get(name, ()))
        for name, body in _STRUCT.findall(text)
    }


def _idl_constants(body: str, strings: Sequence[str]) -> Iterator[tuple[str, Value]]:
    for type_, name, text in _CONSTANT.findall(body):
        base = _idl_type(type_)
        yield name, _idl_value(base, text, strings, f"constant {name}")


def _idl_value(base: str, text: str, strings: Sequence[str], where: str) -> Value:
    if base in _STRINGS:
        return "".join(strings[int(number)] for number in re.findall(r'"(\d+)"', text))
    return _constant(base, text, where)


def _idl_elements(text: str) -> tuple[Value, ...] | None:
    """The default of an array, which ROS 2 writes as a tuple of Python within a string."""
    try:
        found = ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return None
    return found if isinstance(found, tuple) else None


class _Members:
    """The members of the structs of a text, whose aliases and sizes of arrays are resolved."""

    def __init__(
        self, text: str, package: str, defaults: Sequence[str], strings: Sequence[str]
    ) -> None:
        self._defaults = defaults
        self._strings = strings
        self._sizes = {name: size for _, name, size in _CONSTANT.findall(text)}
        self._named = dict.fromkeys(_ENUM.findall(text), "uint32")
        self._named |= {name: f"{package}/{name}" for name, _ in _STRUCT.findall(text)}
        self._aliases: dict[str, tuple[str, str | None]] = {}
        for base, declarator in _TYPEDEF.findall(text):
            name, length = self._declared(declarator)
            self._aliases[name] = self._spelled(" ".join(base.split()), length)

    def of(self, body: str) -> Iterator[tuple[str, str, Default | None]]:
        """Name, type and default of each member."""
        for statement in filter(None, map(str.strip, body.split(";"))):
            given = re.search(r"@(\d+)", statement)
            member = " ".join(re.sub(r"@\d+", " ", statement).split())
            # Commas also stand in sequence<…, …>, which ends before the names.
            head, bracket, tail = member.rpartition(">")
            words, *more = tail.split(",")
            type_, _, first = re.sub(r"\s+\[", "[", words).rstrip().rpartition(" ")
            for declarator in (first, *more):
                name, length = self._declared(declarator)
                # A struct of IDL needs a member; ROS 2 gives this one to an empty message.
                if name == _NO_MEMBER:
                    continue
                base, length = self._spelled(f"{head}{bracket}{type_}".strip(), length)
                default: Default | None = None
                if given is not None and "/" not in base:
                    text = self._defaults[int(given[1])]
                    where = f"the default of {name}"
                    if length is None:
                        default = _idl_value(base.partition("<")[0], text, self._strings, where)
                    else:
                        default = _idl_elements(
                            str(_idl_value("string", text, self._strings, where))
                        )
                yield name, _spelled(base, length), default

    def _declared(self, text: str) -> tuple[str, str | None]:
        """The name and the number of elements of a declarator such as ``a[3]``."""
        match = _DECLARATOR.fullmatch(text.strip())
        if match is None:
            raise ValueError(f"{text.strip()!r} is no name of a member")
        sizes = re.findall(r"\w+", match[2])
        return match[1], str(prod(self._size(size) for size in sizes)) if sizes else None

    def _size(self, text: str) -> int:
        try:
            return int(self._sizes.get(text, text))
        except ValueError:
            raise ValueError(f"the size of an array, {text!r}, is not known") from None

    def _spelled(self, type_: str, length: str | None) -> tuple[str, str | None]:
        """The type of the elements, and their number: None if it is a single one, else as texts of
        messages have it, ``<=3`` and, for any, nothing."""
        if match := _SEQUENCE.fullmatch(type_):
            return self._spelled(match[1], None)[0], f"<={match[2]}" if match[2] else ""
        if type_ in self._aliases:
            base, own = self._aliases[type_]
            return base, length if own is None else own
        scope = type_.rpartition("::")[2]
        base = re.sub(r"\s*<.*", "", type_)
        if base in _IDL_TYPES or "::" in type_ or scope not in self._named:
            return _idl_type(type_), length
        return self._named[scope], length


def _idl_type(text: str) -> str:
    base, _, longest = (part.strip() for part in " ".join(text.split()).partition("<"))
    if base in _IDL_TYPES:
        return _IDL_TYPES[base] + (f"<={longest.rstrip('> ')}" if longest else "")
    if re.fullmatch(r"u?int(8|16|32|64)", base):
        return base
    scopes = base.strip(":").split("::")
    if len(scopes) < 2:
        raise ValueError(f"the type {text!r} is not known")
    return f"{scopes[0]}/{scopes[-1]}"
