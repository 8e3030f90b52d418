"""A test that shows where temporary files go; test_side_by_side.py runs it."""

from __future__ import annotations

import tempfile


def test_it() -> None:
    print(f"\nfolder {tempfile.gettempdir()}")
