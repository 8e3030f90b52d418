"""How many random models the differential tests try."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--models",
        type=int,
        default=None,
        help="number of random models in the differential tests (default: a minute's worth)",
    )
    parser.addoption("--first-model", type=int, default=0, help="seed of the first of them")
