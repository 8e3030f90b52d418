"""Controllers that are tested by the scripts of their packages, without ROS.

A script's expectations come from the plant; :mod:`robosc.simulate` follows it with a controller on
a virtual clock.
"""

from __future__ import annotations

from typing import Any

import pytest
from emit.judged_controllers import class_of

from robosc.simulate.faults import LineFault
from robosc.simulate.machines import execute
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor
from robosc.traces.scripts import choose, script

__all__ = ["scripts_of", "tells_apart"]


def scripts_of(supervisor: Supervisor) -> list[str]:
    """The scripts of the package of a supervised robot."""
    return [script(supervisor, run, "run") for run in choose(supervisor).runs]


def tells_apart(supervisor: Supervisor, scripts: list[str], source: str) -> list[str]:
    """What a script finds in a controller with this source; nothing: all scripts pass."""
    kind: Any = class_of(source)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(execute, "make_controller", lambda _: kind())
        for text in scripts:
            session = Session(machine_maker(supervisor, execute=True))
            for number, line in enumerate(text.splitlines(), 1):
                try:
                    session.do(line, numbers=False)
                except LineFault as fault:
                    return [f"line {number}: {fault}"]
                except Exception as error:  # of a mutant
                    return [f"line {number}: {type(error).__name__}: {error}"]
    return []
