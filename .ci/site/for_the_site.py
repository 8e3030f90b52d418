"""What the pages have for GitHub and for the tests, and a site cannot show."""

from __future__ import annotations

import re
from typing import Any

_FENCE = re.compile(r"^(```\w+) .*$", re.MULTILINE)
"""What stands behind a language is for the tests."""

_OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./[^)]*\)")
"""Links to other files of the repository, which are no part of the site."""


def on_page_markdown(markdown: str, **_: Any) -> str:
    return _OUTSIDE.sub(r"\1", _FENCE.sub(r"\1", markdown))
