"""The scripts of a package's test: the controller passes them, and faulty controllers do not."""

from __future__ import annotations

import io

import pytest
from emit.generated_code import controller_source
from emit.mutants import mutants
from emit.scripted_controllers import scripts_of, tells_apart
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.simulate.script.run import follow_script
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor

PLAYED = ("courier", "door", "drone", "kobuki", "navigation", "order", "two_robots")


def supervisor_of(name: str) -> Supervisor:
    return pipeline.synthesize(pipeline.load(EXAMPLES / name / f"{name}.rscd").robot)


@pytest.mark.parametrize("name", PLAYED)
def test_the_generated_controller_passes(name: str) -> None:
    """Expectations are those of the plant, so this compares the two."""
    supervisor = supervisor_of(name)
    for text in scripts_of(supervisor):
        out, messages = io.StringIO(), io.StringIO()
        session = Session(machine_maker(supervisor, execute=True))
        done = follow_script(session, text.splitlines(), "run", out, messages, False)
        assert (done.exit_code, messages.getvalue()) == (0, "")


def test_the_same_runs_are_chosen_again() -> None:
    supervisor = supervisor_of("navigation")
    assert scripts_of(supervisor) == scripts_of(supervisor_of("navigation"))


def test_planted_faults_are_found() -> None:
    supervisor = supervisor_of("door")
    scripts = scripts_of(supervisor)
    source = controller_source(supervisor, "door.rscd")
    assert tells_apart(supervisor, scripts, source) == []
    missed = [
        (m.before, m.after)
        for m in mutants(source)
        if not tells_apart(supervisor, scripts, m.source)
    ]
    # The requirement keeps the door from being turned between the two limits.
    assert missed == [("if self.sensor_last <= 0.01:  # door.rscd:29", "0.062")]
