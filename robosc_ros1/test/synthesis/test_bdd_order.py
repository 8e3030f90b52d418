"""The order of the variables brings together what belongs together."""

from __future__ import annotations

import random
from itertools import pairwise

from robosc.synthesis.bdd.order import order_items


def test_a_shuffled_chain_is_put_in_a_row() -> None:
    count = 60
    names = list(range(count))
    random.Random(3).shuffle(names)
    groups = [(names[i], names[i + 1]) for i in range(count - 1)]
    order = order_items(count, groups)
    assert sorted(order) == list(range(count))
    place = {item: n for n, item in enumerate(order)}
    assert all(abs(place[a] - place[b]) <= 2 for a, b in groups)


def test_two_shuffled_chains_do_not_interleave() -> None:
    items = list(range(40))
    random.Random(4).shuffle(items)
    chains = [items[:20], items[20:]]
    order = order_items(40, [pair for c in chains for pair in pairwise(c)])
    place = {item: n for n, item in enumerate(order)}
    spans = [sorted(place[item] for item in chain) for chain in chains]
    assert all(span[-1] - span[0] == 19 for span in spans)


def test_a_good_order_is_kept() -> None:
    assert order_items(10, [(i, i + 1) for i in range(9)]) in (
        list(range(10)),
        list(range(9, -1, -1)),
    )


def test_nothing_to_order() -> None:
    assert order_items(0, []) == []
    assert sorted(order_items(3, [(), (1,)])) == [0, 1, 2]


def test_groups_of_everything_do_not_part_what_belongs_together() -> None:
    """Each of 40 stations has a location and a phase; every command looks at all locations."""
    stations = 40
    pairs = [(2 * n, 2 * n + 1) for n in range(stations)]
    everywhere = [(*range(0, 2 * stations, 2), 2 * n + 1) for n in range(stations)]
    order = order_items(2 * stations, [*everywhere, *pairs])
    assert all(abs(order.index(a) - order.index(b)) == 1 for a, b in pairs)
