"""Tests of which test_what_a_run_shows.py and test_side_by_side.py look at what is shown."""

from __future__ import annotations

import tempfile

import pytest


def test_that_passes() -> None:
    print(f"\nfolder {tempfile.gettempdir()}")


@pytest.mark.parametrize("case", range(3))
def test_that_is_left_out(case: int) -> None:
    pytest.skip("there is no such thing (./dev setup installs it)")
