"""The parts of each communication's data that a model reads or sends."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Set
from dataclasses import replace
from itertools import chain
from typing import TypeAlias

from robosc.expr import traversal, tree, types
from robosc.language.events import Direction
from robosc.model import entities

Path: TypeAlias = tuple[str, ...]
"""Names of members from the whole message on; an array's elements have the path of the array."""


_RECEIVED: tuple[Direction, ...] = ("response", "feedback")


class Usage:
    """The paths of each communication's data that components and requirements read and provide
    statements send."""

    def __init__(self, robot: entities.Robot) -> None:
        self._paths: dict[tuple[str, Direction], set[Path]] = {}
        commands = robot.commands

        def sent(key: str) -> tuple[str, Direction]:
            command = commands.get(key)
            if command is None:
                return key, "request"
            return command.communication.key, command.direction

        sorts = {key: c.sort for key, c in robot.communications.items()}
        for provide in robot.provides:
            asked = (path for expr in provide.expressions for path in _read(expr))
            self._add(*sent(provide.communication), (*_sent(provide.data), *asked))
        for requirement in robot.requirements:
            for key in requirement.communications if requirement.on_data else ():
                self._add(*sent(key), _read(requirement.condition))
        for assumption in robot.assumptions:
            if assumption.communication is not None:
                for direction in _RECEIVED:
                    self._add(assumption.communication, direction, _read(assumption.condition))
        for component in robot.components:
            for communication in component.communications:
                for direction in communication.sort.received:
                    converted = _converted(getattr(communication, direction))
                    self._add(communication.key, direction, converted)
                if communication.expect is not None:
                    self._add(communication.key, "response", _read(communication.expect))
        for _, transition in robot.transitions:
            sort = sorts.get(transition.communication)
            event = None if sort is None else sort.event(transition.event)
            if event is not None and event.brings is not None:
                paths = (path for expr in transition.expressions for path in _read(expr))
                self._add(transition.communication, event.brings, paths)

    def _add(self, key: str, direction: Direction, paths: Iterable[Path]) -> None:
        self._paths.setdefault((key, direction), set()).update(paths)

    def uses(self, key: str, direction: Direction, path: Path) -> bool:
        """Whether a part is read or sent, itself, within a larger part, or a part of it."""
        return any(
            path[: len(used)] == used[: len(path)] for used in self._paths.get((key, direction), ())
        )

    def part(self, key: str, direction: Direction, type_: types.Type) -> types.Type:
        """The communication's type without the members that nothing reads or sends."""
        return _kept(type_, self._paths.get((key, direction), set()))


def _kept(type_: types.Type, used: Set[Path]) -> types.Type:
    if () in used:
        return type_
    match type_:
        case types.ArrayType(element=element):
            return replace(type_, element=_kept(element, used))
        case types.ObjectType(properties=properties):
            inner = {name: {p[1:] for p in used if p[0] == name} for name, _ in properties}
            kept = tuple(
                (name, _kept(type_, inner[name])) for name, type_ in properties if inner[name]
            )
            return replace(type_, properties=kept)
    return type_


def _read(expr: tree.Expr) -> tuple[Path, ...]:
    """The paths that an expression reads."""
    elements: dict[str, tuple[Path, ...]] = {}
    """By the variables of enclosing aggregates: the paths of the arrays that they range over."""

    def leaf(node: tree.Literal | tree.Leaf) -> tuple[Path, ...]:
        match node:
            case tree.ValueRef(path=path):
                return (_names(path),)
            case tree.ElementRef(variable=variable, path=path):
                return tuple((*array, *_names(path)) for array in elements.get(variable, ()))
        return ()

    def strict(node: tree.Operation, operands: tuple[tuple[Path, ...], ...]) -> tuple[Path, ...]:
        read = tuple(chain.from_iterable(operands))
        if isinstance(node, tree.Convert):
            return tuple((*path, *inner) for inner in _converted(node.type) for path in read)
        return read

    def through_array(
        node: tree.Aggregate,
        arrays: tuple[Path, ...],
        visit: Callable[[tree.Expr], tuple[Path, ...]],
    ) -> tuple[Path, ...]:
        elements[node.variable] = arrays
        parts = (node.element, node.condition)
        found = tuple(path for part in parts if part is not None for path in visit(part))
        # An array of which only the length counts is read, too.
        return found + tuple(a for a in arrays if not any(p[: len(a)] == a for p in found))

    return traversal.fold(expr, leaf, strict, bound=through_array)


def _names(path: tuple[str | int, ...]) -> Path:
    return tuple(step for step in path if isinstance(step, str))


def _converted(type_: types.Type) -> Iterator[Path]:
    """The paths that the rules of enums read, wherever in a type the enums are."""
    for path, part in types.innermost(type_):
        if isinstance(part, types.EnumType):
            read = (_read(tree.condition_of(rule)) for rule in part.rules)
            yield from ((*path, *inner) for inner in chain(*read, _converted(part.source)))


def _sent(data: entities.Data) -> Iterator[Path]:
    match data:
        case entities.DataObject(fields=fields):
            for name, inner in fields:
                yield from ((name, *path) for path in _sent(inner))
        case entities.DataArray(elements=elements):
            for inner in elements:
                yield from _sent(inner)
        case tree.Aggregate(element=tree.Made() as inner) if data.makes_array:
            yield from _sent(inner)
        case tree.Made(names=names, operands=parts) if names:
            for name, part in zip(names, parts, strict=True):
                yield from ((name, *path) for path in _sent(part))
        case _:
            yield ()
