"""The stages joined: text → model → plant → supervisor → files.

Each function takes what a command or a program has (a path, options) and gives frozen values; none
prints. Stages are imported where they are used, because a command needs few of them.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from robosc import errors, limits, names

if TYPE_CHECKING:
    from robosc.emit.export.export import Format
    from robosc.emit.package.package import Mode, Package
    from robosc.emit.write.writer import Written
    from robosc.model.entities import Robot
    from robosc.progress import Progress
    from robosc.source import Source
    from robosc.supervisor import Supervisor
    from robosc.synthesis.explore import Graph
    from robosc.synthesis.verify.verify_report import VerifyReport

Target: TypeAlias = Literal["ros1", "ros2"]


@dataclass(frozen=True, slots=True)
class ModelText:
    """A model as a text; ``path`` is the file that it counts as: diagnostics name it, and around
    it libraries, definitions of messages and options of the generator are searched for."""

    text: str
    path: str | Path = "model.rscd"


Model: TypeAlias = str | Path | ModelText
"""A model file, or the text of one."""


@dataclass(frozen=True, slots=True)
class Options:
    """How a model is read: further folders with libraries, and whether a message definition that is
    not installed is an error; ``supervises``: another controller sends the commands. ``progress``
    is called with what synthesis does, how far it is, and the most it can be. ``explaining``:
    the processor seconds for explanations (None: as many as synthesis takes, at least 1, at most
    10). ``solved`` is called with the supervisor before it is explained."""

    library_path: tuple[Path, ...] = ()
    strict: bool = False
    supervises: bool = False
    progress: Progress | None = None
    explaining: float | None = None
    solved: Callable[[Supervisor], None] | None = None


@dataclass(frozen=True, slots=True)
class Output:
    """What to generate, and where to. ``package`` None: the configuration's or the robot's name.

    ``folder`` gets the package as a folder of its own (None: the configuration's, or the current
    one); with ``force`` files that robosc did not write are replaced. ``config`` is a file with
    options; None takes those beside the model.
    """

    target: Target = "ros1"
    folder: Path | None = None
    package: str | None = None
    force: bool = False
    config: Path | None = None
    mode: Mode = "controller"


@dataclass(frozen=True, slots=True, repr=False)
class Generated:
    """A written package; ``seconds`` is the time from the model to the last file.

    ``warnings`` are about the files with options.
    """

    output: Output
    supervisor: Supervisor
    diagnostics: tuple[errors.Diagnostic, ...]
    package: str
    files: Written
    seconds: float
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<Generated: {self.package} in {self.files.folder}>"


@dataclass(frozen=True, slots=True)
class Loaded:
    """A robot without errors, and the warnings."""

    robot: Robot
    diagnostics: tuple[errors.Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Checked:
    """All that is to be said about a file. ``failure`` is why it cannot become a controller."""

    diagnostics: tuple[errors.Diagnostic, ...]
    failure: errors.RoboscError | None = None

    @property
    def exit_code(self) -> int:
        return 0 if self.failure is None else self.failure.exit_code


def load(model: Model, options: Options = Options(), target: Target | None = None) -> Loaded:
    """The robot in a model file; ``target`` decides which fields times and headers have.

    Raises:
        UsageError: the file cannot be read, or holds a library.
        ModelError: the model has errors.
    """
    robot, diagnostics = _read(model, options, target)
    if robot is None:
        if errors.has_errors(diagnostics):
            raise errors.ModelError(diagnostics)
        raise errors.UsageError(f"{_path_of(model)} holds a library; this needs a robot")
    return Loaded(robot, diagnostics)


def check(model: Model, options: Options = Options()) -> Checked:
    """Everything that is to be said about a robot or a library, synthesis included.

    Raises UsageError if the file cannot be read; whatever is wrong with the model is in the result.
    """
    robot, diagnostics = _read(model, options)
    if robot is None:
        failure = errors.ModelError(diagnostics) if errors.has_errors(diagnostics) else None
        return Checked(diagnostics, failure)
    try:
        supervisor = within_time(robot, options.progress, explaining=options.explaining)
    except errors.StateSpaceError as error:
        return Checked((*diagnostics, unchecked(robot, error)))
    try:
        _existing(supervisor)
    except (errors.EmptySupervisorError, errors.ModelError) as error:
        return Checked(diagnostics + error.diagnostics, error)
    return Checked(diagnostics + supervisor.diagnostics)


def within_time(
    robot: Robot,
    progress: Progress | None = None,
    max_states: int | None = None,
    explaining: float | None = None,
) -> Supervisor:
    """The supervisor of a robot as :func:`synthesize` finds it within ``limits.CHECK_SECONDS``; as
    much time again is for what explains it, and without that it comes with a warning.

    Raises:
        StateSpaceError: too large for the engine, the memory or the time.
    """
    from robosc.synthesis.time_limit import processor_time

    found: list[Supervisor] = []
    try:
        with processor_time(limits.CHECK_SECONDS, progress) as limited:

            def solved(supervisor: Supervisor) -> None:
                found.append(supervisor)
                limited.renew()

            return synthesize(robot, "auto", max_states, limited, explaining, solved)
    except errors.StateSpaceError as error:
        if not found:
            raise
        return replace(found[0], diagnostics=(_unexplained(robot, error),))


def _unexplained(robot: Robot, error: errors.StateSpaceError) -> errors.Diagnostic:
    return errors.Diagnostic(
        errors.Severity.WARNING,
        "explanations-left-out",
        f"guards were found, and what explains them was not: {error}",
        robot.span,
        "'robosc synthesize' has no time limit",
    )


def unchecked(robot: Robot, error: errors.StateSpaceError) -> errors.Diagnostic:
    """The warning that a robot was checked without synthesis."""
    message = f"checked without synthesis: {error}"
    return errors.Diagnostic(errors.Severity.WARNING, "synthesis-unchecked", message, robot.span)


def synthesize(
    robot: Robot,
    engine: str = "auto",
    max_states: int | None = None,
    progress: Progress | None = None,
    explaining: float | None = None,
    solved: Callable[[Supervisor], None] | None = None,
) -> Supervisor:
    """The supervisor of a robot; it may be empty. ``explaining`` as in :class:`Options`; ``solved``
    is called with guards and sizes before they are explained.

    Raises:
        StateSpaceError: too large for the engine and the limit, or for the memory.
    """
    from robosc.plant.build import lower
    from robosc.synthesis import synthesize as compute

    try:
        return compute(lower(robot), engine, max_states, progress, explaining, solved)
    except MemoryError:
        raise errors.StateSpaceError(errors.OUT_OF_MEMORY) from None


def supervise(robot: Robot, progress: Progress | None = None) -> Supervisor:
    """The supervisor of a robot, if a controller may be made of it.

    Raises:
        EmptySupervisorError: no controller can satisfy the requirements.
        ModelError: the state space shows an error of the model.
        StateSpaceError: it is too large.
    """
    return _existing(synthesize(robot, progress=progress))


def supervised(system: Robot | Supervisor, progress: Progress | None) -> Supervisor:
    """The supervisor of a robot, or that which was synthesized before, if it allows a controller.

    Raises:
        RoboscError: as :func:`supervise`.
    """
    from robosc.supervisor import Supervisor

    if isinstance(system, Supervisor):
        return _existing(system)
    return supervise(system, progress)


def explore(
    system: Robot | Supervisor,
    *,
    plant: bool = False,
    limit: int = 100_000,
    progress: Progress | None = None,
) -> Graph:
    """The controlled transition system of a robot, or with ``plant`` the uncontrolled one.

    ``system`` is a supervisor if it was synthesized before.

    Raises:
        EmptySupervisorError: there is no controlled system.
        StateSpaceError: it has more than ``limit`` states.
    """
    from robosc.model.entities import Robot
    from robosc.plant.build import lower
    from robosc.synthesis import explore as walk

    if plant:
        return walk(lower(system) if isinstance(system, Robot) else system.plant, limit)
    return walk(supervised(system, progress), limit)


def verify(system: Robot | Supervisor, progress: Progress | None = None) -> VerifyReport:
    """Proves the supervisor of a robot by independent means; or one that was synthesized before.

    Raises:
        EmptySupervisorError: there is none.
        StateSpaceError: the proof takes too much memory or time.
    """
    from robosc.synthesis.verify.verification import verify as prove

    return prove(supervised(system, progress), progress=progress)


def export(robot: Robot, format_: Format, *, with_supervisor: bool = False) -> str:
    """A robot as text for another tool; ``with_supervisor`` adds the guards to CIF.

    Raises:
        EmptySupervisorError: there is no supervisor to add.
        StateSpaceError: synthesis is needed, and the state space is too large.
        UsageError: a program that is needed is not installed.
    """
    from robosc.emit.export.export import exported
    from robosc.plant.build import lower

    return exported(lower(robot), format_, with_supervisor)


def generate(model: Model, options: Options = Options(), output: Output = Output()) -> Generated:
    """Write the package with the controller of the robot in a model file.

    Nothing is written unless all goes well.

    Raises:
        UsageError: the file cannot be read or holds a library, the package's name is none, the
            configuration is faulty, or something that robosc did not write is in the way.
        ModelError: the model has errors.
        EmptySupervisorError: no controller can satisfy the requirements.
        StateSpaceError: the state space is too large.
    """
    from robosc.emit.write.writer import write

    start = time.perf_counter()
    made = _package(model, options, output)
    files = write(made.package, made.folder, output.force, made.location)
    seconds = time.perf_counter() - start
    return Generated(
        output, made.supervisor, made.diagnostics, made.package.name, files, seconds, made.warnings
    )


def difference(
    model: Model, options: Options = Options(), output: Output = Output()
) -> tuple[str, tuple[errors.Diagnostic, ...]]:
    """What :func:`generate` would change, as a unified diff, and the diagnostics.

    Raises:
        RoboscError: as :func:`generate`.
    """
    from robosc.emit.write.writer import difference

    made = _package(model, options, output)
    return difference(made.package, made.folder, output.force, made.location), made.diagnostics


@dataclass(frozen=True, slots=True)
class _Made:
    """A package that is not written yet, and where it goes."""

    supervisor: Supervisor
    diagnostics: tuple[errors.Diagnostic, ...]
    package: Package
    folder: Path
    location: Path | None
    warnings: tuple[str, ...]


def _package(model: Model, options: Options, output: Output) -> _Made:
    from robosc.emit.package import ros1_target, ros2_target
    from robosc.emit.package.original_config import load_config
    from robosc.emit.package.package import namesake
    from robosc.traces.scripts import test_files

    supervises = options.supervises or output.mode != "controller"
    loaded = load(model, replace(options, supervises=supervises), output.target)
    if output.mode == "controller":
        refuse_corrections(loaded.robot)
    config = load_config(_path_of(model), output.config)
    # The configuration names the controller, which a supervisor must not overwrite.
    own = config.package if output.mode == "controller" else None
    name = own or f"{names.package_name(loaded.robot.name)}_{output.mode}"
    if output.package is not None:
        name = output.package
    if fault := names.package_name_fault(name):
        raise errors.UsageError(f"{name!r} is not a valid name for a package: {fault}")
    if other := namesake(name):
        raise errors.UsageError(
            f"{name!r} is not a valid name for a package: it would hide {other}"
        )
    supervisor = synthesize(loaded.robot, progress=options.progress, solved=options.solved)
    _existing(supervisor, loaded.diagnostics)
    _bounded(supervisor)
    diagnostics = loaded.diagnostics + supervisor.diagnostics
    emit = {"ros1": ros1_target.emit, "ros2": ros2_target.emit}[output.target]
    runs = test_files(supervisor, _path_of(model), output.target, config, output.mode)
    package = emit(supervisor, name, config.of_package(name), output.mode, runs)
    folder = output.folder or config.output.get(output.target) or Path()
    location = None if output.folder else config.locations.get((output.target, output.mode))
    return _Made(supervisor, diagnostics, package, folder, location, config.warnings)


def refuse_corrections(robot: Robot) -> None:
    """Refuse a controller of a model that corrects another one.

    Raises:
        ModelError: a provide statement reads what the other controller sends.
    """
    found = tuple(
        errors.Diagnostic(
            errors.Severity.ERROR,
            "data-of-others",
            "this corrects what another controller sends: a controller sends its own data",
            provide.span,
            "generate a supervisor (--mode supervisor), or provide the data without 'value'",
        )
        for provide in robot.provides
        if provide.corrects
    )
    if found:
        raise errors.ModelError(found)


def _bounded(supervisor: Supervisor) -> None:
    """Refuse a supervisor of which nobody knows whether its internal transitions end.

    Raises:
        StateSpaceError: the bound on them that a controller needs could not be found.
    """
    unknown = "bounded response" not in dict(supervisor.properties)
    if unknown and supervisor.step_bound is None:
        raise errors.StateSpaceError(
            "the state space is too large to find out whether internal transitions end;"
            " 'robosc check' says more"
        )


def _existing(supervisor: Supervisor, warnings: tuple[errors.Diagnostic, ...] = ()) -> Supervisor:
    """The same supervisor, if a controller may be made of it.

    Raises:
        EmptySupervisorError: nothing is left; the diagnostics say why.
        ModelError: the state space shows an error of the model, such as overlapping guards.
    """
    if supervisor.empty:
        name = supervisor.plant.robot.name
        message = f"no controller can satisfy the requirements of {name}"
        raise errors.EmptySupervisorError(message, warnings + supervisor.diagnostics)
    if errors.has_errors(supervisor.diagnostics):
        raise errors.ModelError(warnings + supervisor.diagnostics)
    return supervisor


def _path_of(model: Model) -> Path:
    return Path(model.path if isinstance(model, ModelText) else model)


def _source_of(model: Model) -> tuple[Source | None, tuple[errors.Diagnostic, ...]]:
    from robosc.syntax.parser import read_source, source_of

    if isinstance(model, ModelText):
        return source_of(str(model.path), model.text.encode("utf-8", "surrogatepass"))
    return read_source(str(model))


def _read(
    model: Model, options: Options, target: Target | None = None
) -> tuple[Robot | None, tuple[errors.Diagnostic, ...]]:
    from robosc.model.resolve import load as resolve
    from robosc.model.ros.definitions import MessageDefinitions

    ros_version = None if target is None else target.removeprefix("ros")
    definitions = MessageDefinitions.for_model(_path_of(model), ros_version=ros_version)
    library_path = [str(folder) for folder in options.library_path]
    with collector_at_rest():
        source, unreadable = _source_of(model)
        if source is None:
            return None, unreadable
        return resolve(
            source,
            library_path,
            definitions,
            strict=options.strict,
            supervises=options.supervises,
        )


@contextmanager
def collector_at_rest() -> Iterator[None]:
    """No search for garbage meanwhile.

    A model that is being read only grows, and holds next to no cycles. Each search walks through
    all of it in vain, and finds more to walk through than the one before: with it, the cost of
    reading a large model would grow faster than the model.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
