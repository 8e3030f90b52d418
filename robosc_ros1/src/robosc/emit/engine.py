"""Templates to text. The only module that knows Jinja."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from robosc.resources import templates_folder

__all__ = ["render", "verbatim"]


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(templates_folder()),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # the output is source code, not markup
    )


def render(template: str, context: Any) -> str:
    """The template (its path below the templates' folder) filled from a frozen dataclass.

    The fields of the context are the names that the template sees; one that is missing is an error.
    """
    fields = {f.name: getattr(context, f.name) for f in dataclasses.fields(context)}
    text: str = _environment().get_template(template).render(fields)
    return text


def verbatim(name: str) -> str:
    """A file of the templates' folder that is the same in every package."""
    return (templates_folder() / name).read_text(encoding="utf-8")
