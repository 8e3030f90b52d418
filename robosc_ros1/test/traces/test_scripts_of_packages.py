"""The scripts of a package's test: the controller passes them, and faulty controllers do not."""

from __future__ import annotations

import io
from typing import Any

import pytest
from emit.generated_code import controller_source
from emit.judged_controllers import class_of
from emit.mutants import mutants
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.simulate.faults import LineFault
from robosc.simulate.machines import execute
from robosc.simulate.script.run import follow_script
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor
from robosc.traces.scripts import choose, script

PLAYED = ("courier", "door", "drone", "kobuki", "navigation")


def supervisor_of(name: str) -> Supervisor:
    return pipeline.synthesize(pipeline.load(EXAMPLES / name / f"{name}.rscd").robot)


def texts_of(supervisor: Supervisor) -> list[str]:
    return [script(supervisor, run, "run") for run in choose(supervisor).runs]


@pytest.mark.parametrize("name", PLAYED)
def test_the_generated_controller_passes(name: str) -> None:
    """Expectations are those of the plant, so this compares the two."""
    supervisor = supervisor_of(name)
    for text in texts_of(supervisor):
        out, messages = io.StringIO(), io.StringIO()
        session = Session(machine_maker(supervisor, execute=True))
        done = follow_script(session, text.splitlines(), "run", out, messages, False)
        assert (done.exit_code, messages.getvalue()) == (0, "")


def test_the_same_runs_are_chosen_again() -> None:
    supervisor = supervisor_of("navigation")
    assert texts_of(supervisor) == texts_of(supervisor_of("navigation"))


def test_planted_faults_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    supervisor = supervisor_of("door")
    texts = texts_of(supervisor)
    make = machine_maker(supervisor, execute=True)

    def passes(source: str) -> bool:
        faulty: Any = class_of(source)
        monkeypatch.setattr(execute, "make_controller", lambda _: faulty())
        try:
            for text in texts:
                session = Session(make)
                for line in text.splitlines():
                    session.do(line, numbers=False)
        except LineFault:
            return False
        return True

    source = controller_source(supervisor, "door.rscd")
    assert passes(source)
    missed = [(m.before, m.after) for m in mutants(source) if passes(m.source)]
    # The requirement keeps the door from being turned between the two limits.
    assert missed == [("if self.sensor_last <= 0.01:  # door.rscd:29", "0.062")]
