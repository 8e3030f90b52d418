"""Sums of products on decision diagrams: exact, irredundant, and within a budget."""

from __future__ import annotations

import random
from itertools import product

import pytest

from robosc.synthesis.guards.sum_of_products import Diagrams, Product, TooLarge

SIZES = (2, 3, 2, 4)
EVERY = list(product(*(range(size) for size in SIZES)))


def held(products: tuple[Product, ...], which: int) -> set[tuple[int, ...]]:
    """What the products hold: 0 with the needed values, 1 with all that may be added."""
    return {
        values
        for values in EVERY
        for one in products
        if all(pair[which] >> value & 1 for pair, value in zip(one, values, strict=True))
    }


@pytest.mark.parametrize("seed", range(40))
def test_products_hold_the_lower_set_and_stay_in_the_upper(seed: int) -> None:
    rng = random.Random(seed)
    lower = {values for values in EVERY if rng.random() < 0.4}
    upper = lower | {values for values in EVERY if rng.random() < 0.3}
    diagrams = Diagrams(SIZES)
    products = diagrams.products(diagrams.of_rows(lower), diagrams.of_rows(upper))
    assert lower <= held(products, 0)
    assert held(products, 1) <= upper
    for number in range(len(products)):
        assert not lower <= held(products[:number] + products[number + 1 :], 0)


def test_equal_sets_are_one_number() -> None:
    diagrams = Diagrams(SIZES)
    some = set(EVERY[::2])
    rest = set(EVERY) - some
    assert diagrams.complement(diagrams.of_rows(some)) == diagrams.of_rows(rest)


def test_a_sum_that_takes_too_long_is_given_up() -> None:
    diagrams = Diagrams(SIZES, most_steps=3)
    odd = {values for values in EVERY if sum(values) % 2}
    with pytest.raises(TooLarge, match="too long"):
        diagrams.products(diagrams.of_rows(odd), diagrams.of_rows(odd))


def test_sets_that_are_combined_count_as_steps() -> None:
    """They took most of the time of a guard that was given up in the end."""
    rows = random.Random(1).sample(list(product(range(5), repeat=4)), 200)
    many = Diagrams([5] * 4, most_steps=2_000)
    assert many.complement(many.of_rows(rows))
    few = Diagrams([5] * 4, most_steps=100)
    with pytest.raises(TooLarge):
        few.complement(few.of_rows(rows))
