"""Families from the literature: engines agree, and the proof by sets of states holds."""

from __future__ import annotations

import published_families
import pytest
from synthesis.plants import supervisor_of

from robosc.synthesis.verify.verification import verify

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")

SMALL = [(family, sizes[0]) for family, sizes in published_families.SIZES.items()]
LARGE = [
    (family, size) for family, sizes in published_families.SIZES.items() for size in sizes[3:4]
]


def text_of(family: str, size: tuple[int, ...]) -> str:
    text: str = getattr(published_families, family)(*size)
    return text


@pytest.mark.parametrize(("family", "size"), SMALL)
def test_engines_agree(family: str, size: tuple[int, ...]) -> None:
    text = text_of(family, size)
    explicit, symbolic = supervisor_of(text, "explicit"), supervisor_of(text, "bdd")
    for name in ("plant_states", "controlled_states", "controlled_transitions"):
        assert getattr(explicit, name) == getattr(symbolic, name), name
    assert verify(explicit).verified
    assert verify(symbolic, limit=0).verified


@pytest.mark.slow
@pytest.mark.parametrize(("family", "size"), LARGE)
def test_large_ones_are_proven(family: str, size: tuple[int, ...]) -> None:
    supervisor = supervisor_of(text_of(family, size), "bdd")
    assert not supervisor.empty
    assert verify(supervisor, limit=0).verified
