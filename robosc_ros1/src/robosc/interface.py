"""What ``import robosc`` offers to programs and notebooks: the verbs as functions with results.

Each function takes a path, a :class:`ModelText`, or what another function returned, so that nothing
is computed twice. Results print as the commands do, ``document()`` is what ``--json`` writes (with
schemas in docs/schemas), and Jupyter draws robots and supervisors.
"""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, get_args

from robosc import pipeline, report
from robosc.errors import Diagnostic, listing, render_all
from robosc.errors import EmptySupervisorError as EmptySupervisorError
from robosc.errors import ModelError as ModelError
from robosc.errors import RoboscError as RoboscError
from robosc.errors import StateSpaceError as StateSpaceError
from robosc.errors import UsageError as UsageError
from robosc.pipeline import Generated as Generated
from robosc.pipeline import Model
from robosc.pipeline import ModelText as ModelText
from robosc.pipeline import Options as Options
from robosc.pipeline import Output as Output
from robosc.simulate.faults import LineFault as LineFault

if TYPE_CHECKING:
    from robosc.emit.export.export import Format
    from robosc.model.entities import Robot
    from robosc.simulate.script.session import Session
    from robosc.supervisor import Supervisor
    from robosc.synthesis.explore import Graph
    from robosc.synthesis.verify.verify_report import Check, VerifyReport


Document: TypeAlias = dict[str, Any]

# --- results -------------------------------------------------------------------------------------


class _Shown:
    """A result: as text it is what the command prints, in a notebook that, below its picture."""

    def _dot(self) -> str | None:
        return None

    def __repr__(self) -> str:
        first, *_ = str(self).strip().splitlines() or [""]
        return f"<{type(self).__name__}: {first}>"

    def _repr_html_(self) -> str:
        text = f"<pre>{html.escape(str(self))}</pre>"
        dot = self._dot()
        if dot is None:
            return text
        try:
            return _svg(dot) + text
        except UsageError as error:
            return f"{text}<p>{html.escape(f'no picture: {error}')}</p>"


class _Drawn(_Shown):
    """A result that has a picture."""

    def svg(self) -> str:
        """The picture as SVG: each component's automaton, and controlled states if they are few.

        Raises:
            UsageError: graphviz is not installed.
        """
        dot = self._dot()
        assert dot is not None
        return _svg(dot)


def _svg(dot: str) -> str:
    """The element of a picture, without the head of a file, which a page must not have."""
    from robosc.emit.export.dot import svg_text

    picture = svg_text(dot)
    return picture[picture.index("<svg") :]


@dataclass(frozen=True, repr=False)
class Diagnosis(_Shown):
    """What there is to say about a model.

    ``diagnostics`` each have ``severity``, ``code``, ``message``, ``hint`` and a ``span`` with
    ``line`` and ``column``; ``failure`` is why the model cannot become a controller, else None.
    """

    diagnostics: tuple[Diagnostic, ...]
    failure: RoboscError | None = None

    @property
    def ok(self) -> bool:
        """Whether there is a controller for the model; there may be warnings."""
        return self.failure is None

    def document(self) -> Document:
        """``check --json``."""
        return report.diagnostics(self.diagnostics)

    def __str__(self) -> str:
        return render_all(self.diagnostics) or "no errors, no warnings\n"


@dataclass(frozen=True, repr=False)
class LoadedRobot(_Drawn):
    """A robot without errors; ``diagnostics`` are the warnings."""

    robot: Robot
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def name(self) -> str:
        return self.robot.name

    @property
    def components(self) -> tuple[str, ...]:
        """The names of the components, copies written out."""
        return tuple(component.name for component in self.robot.components)

    def _dot(self) -> str:
        from robosc.emit.export.dot import dot_text

        return dot_text(self.robot)

    def __str__(self) -> str:
        return f"{self.name}: {', '.join(self.components)}\n{render_all(self.diagnostics)}"


@dataclass(frozen=True, repr=False)
class Synthesized(_Drawn):
    """A supervisor; it may be empty. ``supervisor`` is the whole of it, for other functions."""

    supervisor: Supervisor

    @property
    def empty(self) -> bool:
        """Whether no controller can satisfy the requirements; ``explanations`` say why."""
        return self.supervisor.empty

    @property
    def guards(self) -> dict[str, str]:
        """When each command is allowed, in the words of the model, by ``name.request``."""
        from robosc.plant.model_text import to_dsl
        from robosc.simulate.machines.machine import label

        robot = self.supervisor.plant.robot
        return {label(g.event): to_dsl(g.expr, robot) for g in self.supervisor.guards}

    @property
    def explanations(self) -> tuple[str, ...]:
        """Why more is forbidden than the requirements say, in sentences."""
        return tuple(found.reason for found in self.supervisor.explanations)

    @property
    def states(self) -> int:
        """How many states the controlled system has."""
        return self.supervisor.controlled_states

    @property
    def plant_states(self) -> int:
        """How many states the robot would have without requirements."""
        return self.supervisor.plant_states

    @property
    def properties(self) -> dict[str, bool]:
        """The properties that a controller needs, by name, as far as they are known."""
        return dict(self.supervisor.properties)

    def document(self) -> Document:
        """``synthesize --json``."""
        from robosc.synthesis.documents import synthesize_document

        return synthesize_document(self.supervisor)

    def _dot(self) -> str:
        from robosc.emit.export.export import picture

        return picture(self.supervisor)

    def __str__(self) -> str:
        return report.supervisor_text(self.supervisor)


@dataclass(frozen=True, repr=False)
class Explored(_Shown):
    """A transition system. ``graph`` has it with numbers in place of names, for other functions."""

    graph: Graph

    @property
    def states(self) -> list[Document]:
        """Each state as ``explore --json`` has it: ``id``, ``components``, ``variables`` …"""
        return list(self.document()["states"])

    @property
    def transitions(self) -> list[Document]:
        """Each transition: ``source``, ``event``, ``controllable``, ``target``."""
        return list(self.document()["transitions"])

    def document(self) -> Document:
        """``explore --json``."""
        from robosc.synthesis.documents import explore_json

        found: Document = json.loads("".join(explore_json(self.graph)))
        return found

    def __len__(self) -> int:
        return len(self.graph.states)

    def __str__(self) -> str:
        return report.graph_text(self.graph)


@dataclass(frozen=True, repr=False)
class Verified(_Shown):
    """The result of a proof by independent means; ``report`` is the whole of it."""

    report: VerifyReport

    @property
    def ok(self) -> bool:
        """Whether all checks hold."""
        return self.report.verified

    @property
    def checks(self) -> tuple[Check, ...]:
        """Each with ``name``, ``holds``, and where it fails ``detail`` and ``trace``."""
        return self.report.checks

    def document(self) -> Document:
        """``verify --json``."""
        from robosc.synthesis.documents import step_document
        from robosc.synthesis.verify.verify_report import verify_document

        return verify_document(self.report, step_document)

    def __str__(self) -> str:
        return report.verify_text(self.report)


@dataclass(frozen=True, repr=False)
class Answer(_Shown):
    """What a line of a simulation did.

    ``happened`` are the events that it brought about, in order, as ``simulate --json`` has them
    (``event``, ``outcome``, ``detail``); ``text`` is what there is to say, to ``why`` for example.
    """

    happened: tuple[Document, ...]
    text: str
    shown: str

    def __str__(self) -> str:
        return self.shown


class Simulation(_Shown):
    """A robot that is played; each line is one of ``robosc simulate``."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def do(self, line: str) -> Answer:
        """Do one line: ``distance 0.4``, ``random 20 7``, ``why drive``, ``expect Motor.idle``.

        Raises:
            LineFault: it was not done, and nothing changed; ``kind`` is ``wrong`` (it means
                nothing), ``refused`` (it cannot happen now) or ``failed`` (it was expected).
        """
        from robosc.simulate.script.render import Style
        from robosc.simulate.script.run import done_text

        done = self._session.do(line)
        shown = done_text(self._session, done, Style())
        return Answer(tuple(h.document() for h in done.happenings), done.text, shown)

    def script(self) -> str:
        """All steps so far as a script for ``robosc simulate --script``."""
        return self._session.script()

    @property
    def state(self) -> Document:
        """``components``, ``variables``, ``communications``, ``marked``; ``time`` by execution."""
        from robosc.simulate.script.documents import state_document

        return state_document(self._session.machine)

    @property
    def choices(self) -> list[str]:
        """The events that can happen now, as they are written."""
        return [choice.text for choice in self._session.menu()]

    @property
    def blocked(self) -> dict[str, list[str]]:
        """The commands that are not enabled, by ``name.request``, and what holds each back."""
        from robosc.simulate.machines.machine import label

        commands = self._session.machine.commands()
        return {label(c.event): [str(r) for r in c.reasons] for c in commands if not c.enabled}

    def __str__(self) -> str:
        from robosc.simulate.script.render import Style, session_text

        return session_text(self._session, Style())


# --- the verbs -----------------------------------------------------------------------------------

_AS_USUAL = Options()
_HERE = Output()

Subject: TypeAlias = Model | LoadedRobot | Synthesized
"""A model, or what was made of one."""


def check(model: Model, options: Options = _AS_USUAL) -> Diagnosis:
    """Everything that there is to say about a robot or a library, synthesis included.

    Raises:
        UsageError: the file cannot be read. What is wrong with the model is in the result.
    """
    found = pipeline.check(_named(model), options)
    return Diagnosis(found.diagnostics, found.failure)


def load(model: Model, options: Options = _AS_USUAL) -> LoadedRobot:
    """The robot of a model.

    Raises:
        UsageError: the file cannot be read, or holds a library.
        ModelError: the model has errors.
    """
    found = pipeline.load(_named(model), options)
    return LoadedRobot(found.robot, found.diagnostics)


def synthesize(
    subject: Model | LoadedRobot,
    options: Options = _AS_USUAL,
    *,
    engine: str = "auto",
    max_states: int | None = None,
) -> Synthesized:
    """The supervisor of a robot: sizes, guards, reasons. It may be empty.

    ``engine`` is ``auto``, ``explicit`` or ``bdd``.

    Raises:
        UsageError, ModelError: as :func:`load`.
        StateSpaceError: it is too large for the engine and the limit, or for the memory.
    """
    _one_of(engine, ("auto", "explicit", "bdd"), "engine")
    robot = _robot(subject, options)
    found = pipeline.synthesize(robot, engine, max_states, options.progress, options.explaining)
    return Synthesized(found)


def verify(subject: Subject, options: Options = _AS_USUAL) -> Verified:
    """Prove the supervisor of a robot by independent means.

    Raises:
        EmptySupervisorError: there is none.
        RoboscError: as :func:`synthesize`.
    """
    return Verified(pipeline.verify(_system(subject, options), options.progress))


def explore(
    subject: Subject, options: Options = _AS_USUAL, *, plant: bool = False, limit: int = 100_000
) -> Explored:
    """The controlled transition system, or with ``plant`` the one without requirements.

    Raises:
        EmptySupervisorError: there is no controlled system.
        StateSpaceError: it has more than ``limit`` states.
        RoboscError: as :func:`synthesize`.
    """
    system = _system(subject, options)
    return Explored(pipeline.explore(system, plant=plant, limit=limit, progress=options.progress))


def simulate(
    subject: Subject,
    options: Options = _AS_USUAL,
    *,
    execute: bool = False,
    parameters: Mapping[str, Any] | None = None,
) -> Simulation:
    """A robot to play with: single events, or with ``execute`` as its generated node runs.

    ``parameters`` are those of the node, by name.

    Raises:
        LineFault: a parameter is unknown, or has a wrong value.
        EmptySupervisorError: there is nothing to play.
        RoboscError: as :func:`synthesize`.
    """
    from robosc.simulate.script.session import Session
    from robosc.simulate.start import machine_maker

    system = _system(subject, options)
    supervisor = pipeline.supervised(system, options.progress)
    return Simulation(Session(machine_maker(supervisor, execute=execute), parameters))


def generate(model: Model, options: Options = _AS_USUAL, output: Output = _HERE) -> Generated:
    """Write a ROS package with the controller; nothing is written unless all goes well.

    Raises:
        UsageError: the file cannot be read, or something that robosc did not write is in the way.
        ModelError, EmptySupervisorError, StateSpaceError: there is no controller.
    """
    _one_of(output.target, get_args(pipeline.Target), "target")
    _one_of(output.mode, ("controller", "supervisor", "monitor"), "mode")
    if output.folder is not None:
        output = replace(output, folder=Path(output.folder))
    if output.config is not None:
        output = replace(output, config=Path(output.config))
    return pipeline.generate(_named(model), options, output)


def export(subject: Model | LoadedRobot, format_: Format, options: Options = _AS_USUAL) -> str:
    """A robot as text for other tools: ``cif``, ``dot``, ``svg`` or ``json``.

    Raises:
        UsageError: graphviz is needed and not installed, or as :func:`load`.
        RoboscError: as :func:`synthesize`.
    """
    _one_of(format_, ("cif", "dot", "svg", "json"), "format")
    return pipeline.export(_robot(subject, options), format_)


def _one_of(word: str, words: tuple[str, ...], what: str) -> None:
    if word not in words:
        raise UsageError(f"{word!r} is no {what}: there are {listing(words)}")


def _named(model: Model) -> Model:
    """The same model, if a path can be meant by it."""
    if isinstance(model, str) and ("\n" in model or "{" in model) and not _is_file(model):
        raise UsageError("this is the text of a model, and no path: write robosc.ModelText(…)")
    if not isinstance(model, str | Path | ModelText):
        raise TypeError(f"a model is a path or a robosc.ModelText, not {type(model).__name__}")
    return model


def _is_file(path: str) -> bool:
    try:
        return Path(path).exists()
    except (OSError, ValueError):  # too long for a name, or with a null character
        return False


def _robot(subject: Model | LoadedRobot, options: Options) -> Robot:
    if isinstance(subject, LoadedRobot):
        return subject.robot
    return load(subject, options).robot


def _system(subject: Subject, options: Options) -> Robot | Supervisor:
    if isinstance(subject, Synthesized):
        return subject.supervisor
    return _robot(subject, options)
