"""Copies in ``controller.py``: one function of ``i`` for all that are alike but for their index.

A component with indexes is several components to all other stages, and each statement of a ``for``
several statements. Here those whose code differs in nothing but the index become one function
again. What differs otherwise (a guard that synthesis restricts for one of them) stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from robosc.emit.controller.folding import Index, Run, in_function, runs
from robosc.emit.controller.guard_methods import with_guard_texts
from robosc.emit.controller.naming import PythonNames
from robosc.emit.controller.python import Attributes
from robosc.emit.controller.template_data import (
    CallView,
    ControllerContext,
    CopiedRows,
    CopiesView,
    CopyView,
)
from robosc.emit.package.rendering import instantiated
from robosc.model.entities import Requirement, Robot
from robosc.names import snake_case
from robosc.source import Span

_TABLES = tuple(f.name for f in fields(CopyView))
_METHODS = ("requirements", "inputs", "commands", "taus", "afters")

_Owner = tuple[str, int]
"""What an entry of a table belongs to: an indexed component, or the number of a ``for``, and the
index."""


@dataclass(frozen=True)
class _Entry:
    view: Any
    owner: _Owner | None


_Entries = list[_Entry]


@dataclass(frozen=True)
class _Folded:
    """A run of copies, what they are called together, and the list of their rows."""

    name: str
    copies: str
    run: Run


def with_copies(
    context: ControllerContext, robot: Robot, attributes: Attributes, names: PythonNames
) -> ControllerContext:
    """The context with its tables, and with a function for each run of copies that are alike."""
    methods = [f"requirement_{n}" for n, _ in enumerate(context.requirements, 1)]
    owners = dict(_owners(context, robot, attributes))
    tables = {
        table: [_Entry(*pair) for pair in zip(getattr(context, table), owners[table], strict=True)]
        for table in _TABLES
    }
    folded: list[_Folded] = []
    if methods == [requirement.method for requirement in context.requirements]:
        for name, copies in _copies(tables).items():
            for run in runs(sorted(copies.items())):
                rows = names.take(f"{_word(name).upper()}_ROWS")
                found = {t: _replaced(e, name, run, rows) for t, e in tables.items()}
                if all(entries is not None for entries in found.values()):
                    tables = {t: e for t, e in found.items() if e is not None}
                    folded.append(_Folded(name, rows, run))
    left = {e.view.method for e in tables["requirements"] if not isinstance(e.view, CopiedRows)}
    return _with_functions(context, tables, folded, left, names)


def _with_functions(
    context: ControllerContext,
    tables: Mapping[str, _Entries],
    folded: Sequence[_Folded],
    methods: set[str],
    names: PythonNames,
) -> ControllerContext:
    """The context of these tables; ``methods`` are those of requirements that are left."""

    def spelled(call: CallView) -> str:
        """A requirement that has no method of its own is found in the table."""
        number: int | Index = call.requirement
        if isinstance(number, int) and context.requirements[number].method in methods:
            return f"self.{context.requirements[number].method}({call.given})"
        given = ", ".join(filter(None, ["self", call.given]))
        return f"self.REQUIREMENTS[{number}].holds({given})"

    views = {table: tuple(e.view for e in entries) for table, entries in tables.items()}
    alone: dict[str, Any] = {
        t: tuple(v for v in views[t] if not isinstance(v, CopiedRows)) for t in _METHODS
    }
    alone["commands"] = with_guard_texts(alone["commands"], spelled)
    functions = []
    for one in folded:
        pattern = one.run.pattern
        pattern = replace(pattern, commands=with_guard_texts(pattern.commands, spelled))
        body, constants = in_function(instantiated("common/node/copies.jinja", pattern))
        functions.append(
            CopiesView(
                title=_title(pattern, one.name),
                function=names.take(f"rows_of_{_word(one.name)}"),
                copies=one.copies,
                first=one.run.first,
                last=one.run.last,
                names=constants,
                body=body,
                has_attributes=bool(pattern.components or pattern.phases),
            )
        )
    return replace(context, copies=tuple(functions), tables=views, **alone)


def _word(name: str) -> str:
    return snake_case(name.replace(" ", "_"))


def _title(pattern: CopyView, name: str) -> str:
    if pattern.requirements:
        return f"what is required for each i ({pattern.requirements[0].place})"
    where = f" ({pattern.components[0].place})" if pattern.components else ""
    return f"{name}[i]{where}"


def _owners(
    context: ControllerContext, robot: Robot, attributes: Attributes
) -> Iterator[tuple[str, list[_Owner | None]]]:
    """By table, what each of its entries belongs to."""
    owners = {c.name: (c.copy.family, c.copy.index) for c in robot.components if c.copy is not None}
    component = {key: c.component for key, c in robot.communications.items()}
    yield "components", [owners.get(c.name) for c in context.components]
    yield "phases", [owners.get(component[key]) for key, _ in attributes.phases]
    yield "locations", [owners.get(name) for name, _ in context.locations]
    yield "variables", [owners.get(robot.variables[key].component) for key, _ in context.variables]
    yield "communications", [owners.get(name) for name in component.values()]
    yield "inputs", [owners.get(component[i.key]) for i in context.inputs]
    yield "commands", [owners.get(component[c.key]) for c in context.commands]
    yield "taus", [owners.get(tau.component) for tau in context.taus]
    yield "afters", [owners.get(after.component) for after in context.afters]
    yield "requirements", list(_statements(robot.requirements))


def _statements(requirements: Sequence[Requirement]) -> Iterator[_Owner | None]:
    """The ``for`` of each requirement that is in only one, and the value of its variable."""
    numbers: dict[Span, int] = {}
    for requirement in requirements:
        repeated = requirement.repeated
        if repeated is None or len(repeated.values) > 1:
            yield None
        else:
            number = numbers.setdefault(repeated.block, len(numbers) + 1)
            yield f"requirements {number}", repeated.values[0][1]


def _copies(tables: Mapping[str, _Entries]) -> dict[str, dict[int, CopyView]]:
    """By name and index, all that belongs to a copy."""
    parts: dict[str, dict[int, dict[str, list[Any]]]] = {}
    for table, entries in tables.items():
        for entry in entries:
            if entry.owner is not None:
                name, index = entry.owner
                copy = parts.setdefault(name, {}).setdefault(index, {})
                copy.setdefault(table, []).append(entry.view)
    return {
        name: {
            index: CopyView(**{table: tuple(views) for table, views in copy.items()})
            for index, copy in copies.items()
        }
        for name, copies in parts.items()
    }


def _replaced(entries: _Entries, name: str, run: Run, rows: str) -> _Entries | None:
    """The entries with one in place of those of a run; None: they do not stand together."""
    at = [
        n
        for n, entry in enumerate(entries)
        if entry.owner and entry.owner[0] == name and run.first <= entry.owner[1] <= run.last
    ]
    if not at:
        return entries
    together = entries[at[0] : at[-1] + 1]
    indexes = [entry.owner[1] if entry.owner else 0 for entry in together]
    if len(together) != len(at) or indexes != sorted(indexes):
        return None
    return [*entries[: at[0]], _Entry(CopiedRows(rows), None), *entries[at[-1] + 1 :]]
