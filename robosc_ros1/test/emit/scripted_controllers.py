"""Controllers that are tested by the scripts of their packages, without ROS.

A script's expectations come from the plant; :mod:`robosc.simulate` follows it with a controller, or
with a supervisor between a robot and another controller, on a virtual clock.
"""

from __future__ import annotations

import ast
from typing import Any

import pytest
from emit.generated_code import controller_source

from robosc.plant.automaton import Plant
from robosc.runtime.core.model import Controller
from robosc.runtime.core.places import stands_in
from robosc.simulate.faults import LineFault
from robosc.simulate.machines import execute
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor
from robosc.traces.scripts import choose, script

__all__ = ["class_of", "faults_of", "scripts_of", "tells_apart"]


def class_of(
    source: str, called: set[str] | None = None, plant: Plant | None = None
) -> type[Controller]:
    """The class in the source of a controller; its methods put their names into ``called``. With a
    ``plant``, it reads given values in place of messages."""
    namespace: dict[str, Any] = {"__name__": "controller", "_called": called}
    tree = ast.parse(source.replace("from ._runtime.", "from robosc.runtime."))
    for node in ast.walk(tree) if called is not None else ():
        if isinstance(node, ast.FunctionDef):
            node.body[:0] = ast.parse(f"_called.add({node.name!r})").body
    exec(compile(tree, "controller.py", "exec"), namespace)
    classes = [c for c in namespace.values() if isinstance(c, type)]
    (found,) = (c for c in classes if c.__base__ is Controller)
    if plant is not None:
        own = found()
        execute.read_given(own, plant)
        for name in ("COMMUNICATIONS", "INPUTS", "COMMANDS"):
            setattr(found, name, getattr(own, name))
    return found


def scripts_of(supervisor: Supervisor) -> list[str]:
    """The scripts of the package of a supervised robot."""
    return [script(supervisor, run, "run") for run in choose(supervisor).runs]


def tells_apart(supervisor: Supervisor, scripts: list[str], source: str) -> list[str]:
    """What a script finds in a controller with this source; nothing: all scripts pass."""
    kind: Any = class_of(source)
    phases = {*supervisor.plant.robot.display_names.values()}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(execute, "controller_class", lambda _: kind)
        for text in scripts:
            session = Session(machine_maker(supervisor, execute=True))
            for number, line in enumerate(text.splitlines(), 1):
                try:
                    session.do(line, numbers=False)
                    # As the player in the package, which reads them in the node's ~state.
                    machine = session.machine
                    heres = [".".join(item) for item in machine.state.components.items()]
                    delays = machine.clocks.keys() - phases
                    assert all(any(stands_in(h, delay) for h in heres) for delay in delays)
                except LineFault as fault:
                    return [f"line {number}: {fault}"]
                except Exception as error:  # of a mutant
                    return [f"line {number}: {type(error).__name__}: {error}"]
    return []


def faults_of(supervisor: Supervisor, right: str = "", wrong: str = "") -> list[str]:
    """What the scripts of a package find in its controller, in which the text ``right`` is replaced
    by the ``wrong`` one."""
    source = controller_source(supervisor)
    assert right in source, source
    return tells_apart(supervisor, scripts_of(supervisor), source.replace(right, wrong))
