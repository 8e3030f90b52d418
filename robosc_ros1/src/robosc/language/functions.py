"""The table of functions: how each is written, typed, evaluated and printed.

A function is an operation like an operator of :mod:`robosc.language.operators`, written as a call.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from robosc.language.operators import BINARY, PYTHON_ATOM, Operand, Operator, Result, Text
from robosc.runtime.core import functions as runtime
from robosc.runtime.core.values import widen

_ATOM = 9


def _no_function(value: Any) -> Any:
    raise AssertionError("every enum has its own function")


def _function(
    spelling: str,
    arguments: tuple[Operand, ...],
    result: Result,
    scalar: Callable[..., Any],
    *,
    python: str = "",
    variadic: bool = False,
    written: Text | None = None,
) -> Operator:
    """Return a function as an operator."""
    name = python or scalar.__name__
    return Operator(
        spelling,
        _ATOM,
        arguments[0],
        result,
        scalar,
        python=Text(f"{name}({{*}})", PYTHON_ATOM),
        arguments=arguments,
        variadic=variadic,
        written=written,
    )


_NUMBER, _INTEGER = Operand.NUMBER, Operand.INTEGER

_COMPUTED: Mapping[str, Operator] = {
    f.spelling: f
    for f in (
        _function("abs", (_NUMBER,), Result.NUMBER, abs),
        _function("min", (_NUMBER, _NUMBER), Result.NUMBER, runtime.least, variadic=True),
        _function("max", (_NUMBER, _NUMBER), Result.NUMBER, runtime.greatest, variadic=True),
        _function("sqrt", (_NUMBER,), Result.DOUBLE, runtime.square_root),
        _function("hypot", (_NUMBER, _NUMBER), Result.DOUBLE, runtime.hypotenuse),
        _function("sin", (_NUMBER,), Result.DOUBLE, runtime.sine),
        _function("cos", (_NUMBER,), Result.DOUBLE, runtime.cosine),
        _function("atan2", (_NUMBER, _NUMBER), Result.DOUBLE, runtime.arc_tangent),
        _function("floor", (_NUMBER,), Result.INTEGER, runtime.rounded_down),
        _function("ceil", (_NUMBER,), Result.INTEGER, runtime.rounded_up),
        _function("round", (_NUMBER,), Result.INTEGER, runtime.rounded),
        _function("isnan", (_NUMBER,), Result.BOOLEAN, runtime.is_not_a_number),
        _function("isinf", (_NUMBER,), Result.BOOLEAN, runtime.is_infinite),
        _function("has", (_INTEGER, _INTEGER), Result.BOOLEAN, runtime.has_bits),
        _function("string", (Operand.BASIC,), Result.STRING, runtime.as_text),
        _function("length", (Operand.ARRAY,), Result.INTEGER, len),
    )
}

FUNCTIONS: Mapping[str, Operator] = {
    **_COMPUTED,
    "defined": _function("defined", (Operand.ANY,), Result.BOOLEAN, runtime.is_so),
}
"""The functions by spelling; type checking replaces ``defined`` by PRESENCE."""

_SCAN = ("ranges", "angle_min", "angle_increment")
GEOMETRY: Mapping[str, tuple[int, int, tuple[str, ...], str]] = {
    "yaw": (1, 0, tuple("xyzw"), "a quaternion"),
    "distance": (2, 0, tuple("xyz"), "a point"),
    "sector": (1, 2, _SCAN, "a laser scan"),
}
"""Functions of objects: how many objects and numbers they take, the fields of the objects, and what
these are in words.

Names are resolved to what they are made of (:mod:`robosc.model.typing.function_calls`).
"""

_PARTS = (
    _function(
        "element", (Operand.ARRAY, _INTEGER), Result.ELEMENT, runtime.element,
        written=Text("{0:9}[{1:0}]", _ATOM),
    ),
    _function(
        "section", (Operand.ARRAY, _INTEGER, _INTEGER), Result.ARRAY, runtime.section,
        written=Text("{0:9}[{1:0}..{2:0}]", _ATOM),
    ),
    _function("sector", (Operand.ARRAY, *[_NUMBER] * 4), Result.ARRAY, runtime.sector),
)  # fmt: skip

CALLS: Mapping[str, Operator] = {**_COMPUTED, **{part.spelling: part for part in _PARTS}}
"""The operations with arguments that are evaluated: functions, array elements and array slices."""

CONVERSION = Operator(
    "convert", _ATOM, Operand.BASIC, Result.ENUM, _no_function, Text("{*}", PYTHON_ATOM)
)
"""The conversion of a value to an enum; the function and its name depend on the enum."""

PART = Operator(
    "part", _ATOM, Operand.BASIC, Result.ELEMENT, _no_function, Text("{*}", PYTHON_ATOM)
)
"""A part of an object or an array, given by a path."""

MADE = Operator("made", _ATOM, Operand.ANY, Result.ELEMENT, _no_function, Text("{*}", PYTHON_ATOM))
"""An object or an array made of values; the function depends on its names."""

PRESENCE = Operator(
    "holds", _ATOM, Operand.BASIC, Result.BOOLEAN, runtime.is_so,
    python=Text("is_so(lambda: {0:0})", PYTHON_ATOM),
)  # fmt: skip
"""Whether a condition is defined and true, or whether data are defined (``defined(…)``)."""

AGGREGATES: Mapping[str, Operator] = {
    a.spelling: a
    for a in (
        _function("any", (Operand.BOOLEAN,), Result.BOOLEAN, any),
        _function("all", (Operand.BOOLEAN,), Result.BOOLEAN, all),
        _function("count", (Operand.BOOLEAN,), Result.INTEGER, runtime.number_of),
        _function("sum", (_NUMBER,), Result.NUMBER, runtime.total),
        _function("min", (_NUMBER,), Result.NUMBER, runtime.least_of),
        _function("max", (_NUMBER,), Result.NUMBER, runtime.greatest_of),
        _function("first", (Operand.ANY,), Result.ELEMENT, runtime.first_of),
        replace(
            _function("[", (Operand.ANY,), Result.ARRAY, list, written=Text("[{0:0}]", _ATOM)),
            python=Text("{*}", PYTHON_ATOM),
        ),
    )
}
"""The aggregates: functions of the list of an expression's values for the elements of an array.

``[`` makes an array of them; it is undefined if one of them is.
"""

HELPERS: Mapping[str, Callable[..., Any]] = {
    **{
        function.__name__: function
        for function in (
            widen,
            runtime.defined,
            runtime.where,
            runtime.spread,
            runtime.is_so,
            runtime.otherwise,
        )
    },
    **{
        operation.scalar.__name__: operation.scalar
        for operation in (*BINARY.values(), *CALLS.values(), *AGGREGATES.values())
        if operation.python.level == PYTHON_ATOM
        and operation.scalar.__module__.startswith("robosc.")
    },
}
"""The functions of the runtime that generated Python expressions may call, by name."""
