"""``dataclass`` as Python has it, but the methods of frozen classes are made when first called.

Python compiles up to six functions for each frozen class. For the 200 that a check of a small model
loads, most of which it makes no object of, that was a quarter of its time.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import MISSING, FrozenInstanceError
from typing import TYPE_CHECKING, Any


def _dataclass(own: type | None = None, /, **options: bool) -> Any:
    if not options.pop("frozen", False):
        return dataclasses.dataclass(own, **options)
    shows, compares = options.pop("repr", True), options.pop("eq", True)

    def made(own: type) -> Any:
        own.__doc__ = own.__doc__ or own.__name__  # instead of one made of the signature
        cls: Any = dataclasses.dataclass(init=False, repr=False, eq=False, **options)(own)
        methods: dict[str, Any] = {"__setattr__": _refuse, "__delattr__": _refuse}
        methods["__init__"] = _late(cls, "__init__", _init)
        if options.get("slots"):  # for copies, which would set attributes
            methods |= {"__getstate__": _values, "__setstate__": _restore}
        if shows:
            methods["__repr__"] = _shown
        if compares:
            methods["__eq__"] = _late(cls, "__eq__", _equal)
            methods["__hash__"] = _late(cls, "__hash__", _hash)
        for name, method in methods.items():
            if own.__dict__.get(name) is None:  # its own ones stay
                setattr(cls, name, method)
        return cls

    return made if own is None else made(own)


def _refuse(self: object, name: str, *value: object) -> None:
    raise FrozenInstanceError(f"cannot change field {name!r}")


def _shown(self: Any) -> str:
    shown = (f"{f.name}={getattr(self, f.name)!r}" for f in dataclasses.fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(shown)})"


def _values(self: Any) -> list[object]:
    return [getattr(self, field.name) for field in dataclasses.fields(self)]


def _restore(self: Any, values: list[object]) -> None:
    for field, value in zip(dataclasses.fields(self), values, strict=True):
        object.__setattr__(self, field.name, value)


def _late(cls: Any, name: str, source: Callable[[Any], tuple[str, dict[str, Any]]]) -> Any:
    """Return a method that is compiled in its own place when it is called."""

    def method(*values: object, **named: object) -> object:
        text, known = source(cls)
        exec(text, known)
        setattr(cls, name, known[name])
        return known[name](*values, **named)

    return method


def _init(cls: Any) -> tuple[str, dict[str, Any]]:
    known: dict[str, Any] = {"_set": object.__setattr__, "_MISSING": MISSING}
    by_place, lines = ["self"], []
    by_name: list[str] = []
    for field in dataclasses.fields(cls):
        name, default = field.name, f"_{field.name}"
        parameter, value = name, name
        if field.default_factory is not MISSING:
            known[default] = field.default_factory
            parameter, value = f"{name}=_MISSING", f"{default}() if {name} is _MISSING else {name}"
        elif field.default is not MISSING:
            known[default] = field.default
            parameter = f"{name}={default}"
        if field.init:
            (by_name if field.kw_only else by_place).append(parameter)
        lines.append(f"    _set(self, {name!r}, {value if field.init else default})")
    if hasattr(cls, "__post_init__"):
        lines.append("    self.__post_init__()")
    parameters = ", ".join(by_place + ["*"] * bool(by_name) + by_name)
    return "\n".join([f"def __init__({parameters}):", *lines, "    return"]), known


def _equal(cls: Any) -> tuple[str, dict[str, Any]]:
    equal = f"{_compared(cls, 'self')} == {_compared(cls, 'other')}"
    same = "self.__class__ is other.__class__"
    return f"def __eq__(self, other): return {equal} if {same} else NotImplemented", {}


def _hash(cls: Any) -> tuple[str, dict[str, Any]]:
    return f"def __hash__(self): return hash({_compared(cls, 'self')})", {}


def _compared(cls: Any, of: str) -> str:
    return (
        f"({''.join(f'{of}.{field.name}, ' for field in dataclasses.fields(cls) if field.compare)})"
    )


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:
    dataclass = _dataclass
