"""Which of many cases ``./dev test --quick`` takes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

__all__ = ["quick_first"]


def quick_first(cases: Iterable[Any], number: int) -> list[Any]:
    """Return cases for ``parametrize``, those after the first few marked as slow."""
    return [
        case
        if place < number
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow)
        for place, case in enumerate(cases)
    ]
