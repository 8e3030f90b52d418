"""Loading what the generator wrote without building a package."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from robosc.emit.controller.assembly import controller_context
from robosc.emit.controller.template_data import ControllerContext
from robosc.emit.package.rendering import render
from robosc.model.resolve import load
from robosc.plant.build import lower
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize

__all__ = ["controller_class", "controller_source", "supervisor_of"]


@lru_cache(64)
def supervisor_of(
    text: str, name: str = "model.rscd", engine: str = "auto", *, supervises: bool = False
) -> Supervisor:
    """The supervisor of a model without errors, computed once for the tests of a file;
    ``supervises``: it guards another controller."""
    robot, diagnostics = load(Source(name, text), supervises=supervises)
    assert robot is not None, diagnostics
    return synthesize(lower(robot), engine)


def controller_source(supervisor: Supervisor, name: str = "model.rscd") -> str:
    return render("common/node/controller.py.jinja", controller_context(supervisor, name))


def controller_class(supervisor: Supervisor) -> tuple[Any, ControllerContext]:
    """The class of ``controller.py``, with the runtime of the checkout, and what it was made of."""
    context = controller_context(supervisor, "model.rscd")
    source = controller_source(supervisor).replace("from ._runtime.", "from robosc.runtime.")
    namespace: dict[str, Any] = {"__name__": "controller"}
    exec(compile(source, str(Path("controller.py")), "exec"), namespace)
    return namespace[context.class_name], context
