"""Variable ordering: variables that an event reads and writes should be close to each other.

The heuristic is FORCE (Aloul, Markov & Sakallah, "FORCE: a fast and easy-to-implement variable-
ordering heuristic", GLSVLSI 2003): every item moves to the centre of gravity of its groups, until
the total span of the groups stops shrinking. It is started from the given order and from the
reverse Cuthill-McKee order, and the better result is taken.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from itertools import combinations, pairwise

from robosc.plant.automaton import Plant
from robosc.synthesis.bdd.rounds import early_last
from robosc.synthesis.bdd.sources import LeafSource, touched_together

_ROUNDS = 60
_PATIENCE = 5
_LARGEST_CLIQUE = 12


def ordered(plant: Plant, together: bool = False) -> Sequence[LeafSource]:
    """Return the state variables of a plant and the parameters of its events in a good order.

    ``together``: the variables of a component stand side by side. Others that only requirements
    relate to them do not come between them, where what the plant reaches has far more nodes.
    """
    parameters = [
        (e, p) for e, event in enumerate(plant.events) for p in range(len(event.parameters))
    ]
    items: list[LeafSource] = [*range(len(plant.variables)), *parameters]
    order = order_items(len(items), touched_together(plant, items))
    found = [items[number] for number in order]
    return early_last(plant, _by_component(plant, found) if together else found)


def _by_component(plant: Plant, order: Sequence[LeafSource]) -> Sequence[LeafSource]:
    """Return an order of components, by the mean place of their variables, in which each has its
    own in the given order."""
    robot = plant.robot
    owners = {variable.key: variable.component for variable in robot.variables.values()}
    owners |= {one.key: one.component for one in robot.communications.values()}

    def component(item: LeafSource) -> object:
        if not isinstance(item, int):
            return item
        name = plant.variables[item].name
        return owners.get(name, name)

    members: dict[object, list[tuple[int, LeafSource]]] = {}
    for place, item in enumerate(order):
        members.setdefault(component(item), []).append((place, item))
    groups = sorted(
        members.values(), key=lambda group: sum(place for place, _ in group) / len(group)
    )
    return [item for group in groups for _, item in group]


def order_items(count: int, groups: Iterable[Iterable[int]]) -> list[int]:
    """Return the numbers 0 to ``count`` - 1 in an order in which the groups have a small span."""
    distinct = dict.fromkeys(tuple(sorted(set(group))) for group in groups)
    kept = [group for group in distinct if len(group) > 1]
    starts = [list(range(count)), _cuthill_mckee(count, kept)]
    return min((_force(start, kept) for start in starts), key=lambda order: _span(order, kept))


def _cuthill_mckee(count: int, groups: Sequence[tuple[int, ...]]) -> list[int]:
    near: list[set[int]] = [set() for _ in range(count)]
    for group in groups:
        pairs = combinations(group, 2) if len(group) <= _LARGEST_CLIQUE else pairwise(group)
        for a, b in pairs:
            near[a].add(b)
            near[b].add(a)
    found: dict[int, int] = {}
    for item in range(count):
        if item not in found:
            found |= _distances(near, _outermost(near, item))
    return [*found][::-1]


def _outermost(near: Sequence[set[int]], item: int) -> int:
    """Return an item far from the others that are connected with it."""
    last = 0
    while True:
        distances = _distances(near, item)
        most = max(distances.values())
        if most <= last:
            return item
        last = most
        item = min((n for n, d in distances.items() if d == most), key=lambda n: len(near[n]))


def _distances(near: Sequence[set[int]], start: int) -> dict[int, int]:
    """Return the distances from an item breadth first, those with fewer neighbours first."""
    found = {start: 0}
    queue = deque([start])
    while queue:
        item = queue.popleft()
        for other in sorted(near[item], key=lambda n: (len(near[n]), n)):
            if other not in found:
                found[other] = found[item] + 1
                queue.append(other)
    return found


def _force(order: list[int], groups: Sequence[tuple[int, ...]]) -> list[int]:
    member_of: list[list[int]] = [[] for _ in order]
    for number, group in enumerate(groups):
        for item in group:
            member_of[item].append(number)
    best, least, waited = order, _span(order, groups), 0
    weights = [_weight(group) for group in groups]
    for _ in range(_ROUNDS):
        place = _places(order)
        centres = [sum(place[item] for item in group) / len(group) for group in groups]
        pull = [
            sum(weights[g] * centres[g] for g in member_of[item])
            / sum(weights[g] for g in member_of[item])
            if member_of[item]
            else float(place[item])
            for item in range(len(order))
        ]
        order = sorted(order, key=lambda item: (pull[item], place[item]))
        span = _span(order, groups)
        waited = 0 if span < least else waited + 1
        if span < least:
            best, least = order, span
        elif waited >= _PATIENCE:
            break
    return best


def _places(order: Sequence[int]) -> list[int]:
    place = [0] * len(order)
    for position, item in enumerate(order):
        place[item] = position
    return place


def _span(order: Sequence[int], groups: Sequence[tuple[int, ...]]) -> float:
    """Return the weighted sum of the groups' spans in an order."""
    place = _places(order)
    return sum(
        _weight(group) * (max(place[item] for item in group) - min(place[item] for item in group))
        for group in groups
    )


def _weight(group: tuple[int, ...]) -> float:
    """Return the weight of a group: large ones span everything in any order, so count little."""
    return 1 / len(group) ** 2
