"""Which events set lasting conditions back (docs/semantics.md, "Time")."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from robosc.expr import traversal, tree, undefined_data
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata, entities
from robosc.plant.logic import conjunction, simplified
from robosc.plant.preconditions import EventCase, Owner, after_event, cases_of, cases_of_step


@dataclass(frozen=True)
class Reset:
    """That an event may change what a lasting condition is about: it does not set the condition
    back where ``kept``, over the state before the event, holds."""

    lasting: automata.Lasting
    kept: tree.Expr


def resets(robot: entities.Robot) -> Iterator[tuple[tuple[EventKind, str, int], Reset]]:
    """Yield what each event, by its identity in the plant, may set back."""
    if not robot.lasting:
        return
    conditions = {one.name: one.condition for one in robot.lasting}
    wanted = [(one, _spread(one.condition, conditions)) for one in robot.lasting]
    for identity, cases in _events(robot):
        for lasting, condition in wanted:
            # Its own event happens only where its condition holds, and changes nothing in that.
            after = condition if identity[1] == lasting.name else after_event(condition, cases)
            if after != condition:
                yield identity, Reset(lasting, simplified(undefined_data.known_condition(after)))


def _spread(condition: tree.Expr, conditions: Mapping[str, tree.Expr]) -> tree.Expr:
    """A condition in which others that must last are also as they are after an event at once."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        if isinstance(node, tree.StateRef) and node.component in conditions:
            return conjunction([node, _spread(conditions[node.component], conditions)])
        return node

    return traversal.rewritten(condition, leaf)


def _events(
    robot: entities.Robot,
) -> Iterator[tuple[tuple[EventKind, str, int], Mapping[Owner, Sequence[EventCase]]]]:
    for communication in robot.communications.values():
        for sort in communication.sort.events_of(communication.timeout is not None):
            cases = cases_of(robot, communication, sort.kind)
            yield (sort.kind, communication.key, 0), cases
    for component in robot.components:
        for place, transition in component.behaviour.placed:
            if transition.event.of_component:
                identity = transition.event, component.name, transition.index
                yield identity, cases_of_step(robot, component, place, transition)
