"""``robosc report``: the evidence as HTML, Markdown or JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from robosc.emit.package.rendering import instantiated
from robosc.errors import UsageError

FORMATS = (".html", ".md", ".json")
_TEMPLATES = {".html": "evidence/report.html.jinja", ".md": "evidence/report.md.jinja"}


@dataclass(frozen=True)
class _View:
    """What the templates see."""

    e: Mapping[str, Any]


def format_of(suffix: str) -> str:
    """One of :data:`FORMATS`; Markdown without a suffix.

    Raises:
        UsageError: it is another one.
    """
    if suffix and suffix not in FORMATS:
        raise UsageError(f"a report is .html, .md or .json, not {suffix}")
    return suffix or ".md"


def rendered(document: Mapping[str, Any], suffix: str) -> str:
    """The document in a format."""
    if suffix == ".json":
        return json.dumps(document, indent=2, ensure_ascii=False) + "\n"
    return instantiated(_TEMPLATES[suffix], _View(document))
