"""The stages joined: text → model → plant → supervisor → files.

Each function takes what a command or a program has (a path, options) and gives frozen values; none
prints. Stages are imported where they are used, because a command needs few of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from robosc.errors import (
    Diagnostic,
    EmptySupervisorError,
    ModelError,
    RoboscError,
    StateSpaceError,
    UsageError,
    has_errors,
)

if TYPE_CHECKING:
    from robosc.model.entities import Robot
    from robosc.supervisor import Supervisor
    from robosc.synthesis.dense import Progress
    from robosc.synthesis.explore import Graph
    from robosc.synthesis.verify import VerifyReport

__all__ = [
    "Checked", "Loaded", "Options", "check", "explore", "load", "synthesize", "verify",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Options:
    """How a model is read: further folders with libraries, and whether a message definition that is
    not installed is an error."""

    library_path: tuple[Path, ...] = ()
    strict: bool = False


@dataclass(frozen=True, slots=True)
class Loaded:
    """A robot without errors, and the warnings."""

    robot: Robot
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Checked:
    """All that is to be said about a file. ``failure`` is why it cannot become a controller.

    ``incomplete`` says what was left out, because the state space is too large.
    """

    diagnostics: tuple[Diagnostic, ...]
    failure: RoboscError | None = None
    incomplete: str | None = None

    @property
    def exit_code(self) -> int:
        return 0 if self.failure is None else self.failure.exit_code


def load(path: str | Path, options: Options = Options()) -> Loaded:
    """The robot in a model file.

    Raises:
        UsageError: the file cannot be read, or holds a library.
        ModelError: the model has errors.
    """
    robot, diagnostics = _read(path, options)
    if robot is None:
        if has_errors(diagnostics):
            raise ModelError(diagnostics)
        raise UsageError(f"{path} holds a library; this needs a robot")
    return Loaded(robot, diagnostics)


def check(path: str | Path, options: Options = Options()) -> Checked:
    """Everything that is to be said about a robot or a library, synthesis included.

    Raises UsageError if the file cannot be read; whatever is wrong with the model is in the result.
    """
    robot, diagnostics = _read(path, options)
    if robot is None:
        failure = ModelError(diagnostics) if has_errors(diagnostics) else None
        return Checked(diagnostics, failure)
    try:
        supervisor = synthesize(robot)
    except StateSpaceError as error:
        return Checked(diagnostics, incomplete=f"{path}: checked without synthesis: {error}")
    diagnostics += supervisor_diagnostics(supervisor)
    empty = EmptySupervisorError(empty_message(supervisor)) if supervisor.empty else None
    return Checked(diagnostics, empty)


def synthesize(
    robot: Robot,
    engine: str = "auto",
    max_states: int | None = None,
    progress: Progress | None = None,
) -> Supervisor:
    """The supervisor of a robot; it may be empty.

    ``progress`` is told now and then what is being computed, how far it is, and the most it can be.

    Raises:
        StateSpaceError: too large for the engine and the limit.
    """
    from robosc.ir.lower import lower
    from robosc.synthesis import DEFAULT_MAX_STATES
    from robosc.synthesis import synthesize as compute

    return compute(lower(robot), engine, max_states or DEFAULT_MAX_STATES, progress)


def explore(robot: Robot, *, plant: bool = False, limit: int = 100_000) -> Graph:
    """The controlled transition system, or with ``plant`` the uncontrolled one.

    Raises:
        EmptySupervisorError: there is no controlled system.
        StateSpaceError: it has more than ``limit`` states.
    """
    from robosc.ir.lower import lower
    from robosc.synthesis import explore as walk

    if plant:
        return walk(lower(robot), limit)
    supervisor = synthesize(robot)
    if supervisor.empty:
        raise EmptySupervisorError(empty_message(supervisor))
    return walk(supervisor, limit)


def verify(robot: Robot) -> VerifyReport:
    """Proves the supervisor of a robot by independent means, state by state."""
    from robosc.synthesis.verify import verify as prove

    return prove(synthesize(robot))


def supervisor_diagnostics(supervisor: Supervisor) -> tuple[Diagnostic, ...]:
    """What synthesis found, as diagnostics: explanations and warnings."""
    return (*supervisor.diagnostics, *(e.diagnostic for e in supervisor.explanations))


def empty_message(supervisor: Supervisor) -> str:
    """Why there is no controller, in a sentence."""
    reasons = [e.reason for e in supervisor.explanations if e.event is None]
    head = f"no controller can keep the requirements of {supervisor.plant.robot.name}"
    return f"{head}: {reasons[0]}" if reasons else head


def _read(path: str | Path, options: Options) -> tuple[Robot | None, tuple[Diagnostic, ...]]:
    from robosc.model.resolve import load as resolve

    library_path = [str(folder) for folder in options.library_path]
    return resolve(str(path), library_path, strict=options.strict)
