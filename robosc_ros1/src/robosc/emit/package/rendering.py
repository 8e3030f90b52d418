"""Templates to text. The only module that knows Jinja."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from functools import cache
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from robosc import names, resources
from robosc.emit.controller.python_literals import literal
from robosc.emit.write.line_breaks import break_long_lines as break_python
from robosc.emit.write.text_breaks import break_comments, break_markdown, break_xml

_EMPTY = re.compile(r"(?<==)( ?)\(\n *\)")
"""A tuple none of whose rows a template has written."""


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(resources.templates_folder()),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # the output is source code, not markup
    )
    environment.filters["quoted"] = literal
    environment.filters["rostest_name"] = names.rostest_name
    return environment


def render(template: str, context: Any) -> str:
    """The text of :func:`instantiated`, its long lines broken as its language allows."""
    return _broken(template)(instantiated(template, context))


def instantiated(template: str, context: Any) -> str:
    """The template (its path below the templates' folder) with the values of a frozen dataclass.

    The fields of the context are the names that the template sees; one that is missing is an error.
    """
    fields = {f.name: getattr(context, f.name) for f in dataclasses.fields(context)}
    text: str = _environment().get_template(template).render(fields)
    return text


def _broken(template: str) -> Callable[[str], str]:
    """The function that breaks the long lines of what a template gives."""
    name = template.rpartition("/")[2].removesuffix(".jinja")
    if name.endswith(".py") or name == "script":
        return lambda text: break_python(_EMPTY.sub(r"\1()", text))
    if name.endswith(".md"):
        return break_markdown
    return break_xml if name.endswith((".xml", "launch", "rostest")) else break_comments
