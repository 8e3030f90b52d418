"""Results as people read them, and the diagnostics as programs do."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robosc import errors, supervisor
from robosc.plant import automaton, model_text
from robosc.runtime.core.places import place_of, stage_of
from robosc.synthesis import formatting

if TYPE_CHECKING:
    from robosc.pipeline import Generated
    from robosc.synthesis.explore import Graph
    from robosc.synthesis.verify.verify_report import VerifyReport

Document = dict[str, Any]


def diagnostics(found: Iterable[errors.Diagnostic]) -> Document:
    """``check --json``."""
    return {
        "version": 1,
        "diagnostics": [
            {
                "file": d.span.source.path,
                "line": d.span.line,
                "column": d.span.column,
                "endLine": d.span.end_line,
                "endColumn": d.span.end_column,
                "severity": d.severity.value,
                "code": d.code,
                "message": d.message,
                "hint": d.hint,
            }
            for d in errors.sort_diagnostics(found)
        ],
    }


def github_text(diagnostics: Iterable[errors.Diagnostic]) -> str:
    """``check --format github``: workflow commands, which annotate lines of a pull request."""
    return "".join(
        f"::{d.severity.value} file={_escaped(d.span.source.path, ':,')},line={d.span.line},"
        f"col={d.span.column},endLine={d.span.end_line},endColumn={d.span.end_column},"
        f"title={d.code}::{_escaped(_with_hint(d))}\n"
        for d in errors.sort_diagnostics(diagnostics)
    )


def _escaped(text: str, also: str = "") -> str:
    for character in f"%\r\n{also}":
        text = text.replace(character, f"%{ord(character):02X}")
    return text


def _with_hint(diagnostic: errors.Diagnostic) -> str:
    message, hint = diagnostic.message, diagnostic.hint
    return message if hint is None else f"{message}; {hint}"


def sarif(diagnostics: Iterable[errors.Diagnostic], version: str) -> Document:
    """``check --format sarif``: a log of SARIF 2.1.0, which code scanners read."""
    from urllib.parse import quote

    ordered = errors.sort_diagnostics(diagnostics)
    rules = [{"id": code} for code in sorted({d.code for d in ordered})]
    results = [
        {
            "ruleId": d.code,
            "level": d.severity.value,
            "message": {"text": _with_hint(d)},
            "locations": [
                {
                    "physicalLocation": {
                        "artifactLocation": {"uri": quote(Path(d.span.source.path).as_posix())},
                        "region": {
                            "startLine": d.span.line,
                            "startColumn": d.span.column,
                            "endLine": d.span.end_line,
                            "endColumn": d.span.end_column,
                        },
                    }
                }
            ],
        }
        for d in ordered
    ]
    driver = {"name": "robosc", "version": version, "rules": rules}
    return {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [
            {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
        ],
    }


# --- synthesize ----------------------------------------------------------------------------------


def supervisor_text(result: supervisor.Supervisor) -> str:
    """Sizes, guards and reasons for people."""
    return guards_text(result) + reasons_text(result)


def guards_text(result: supervisor.Supervisor) -> str:
    """Sizes and guards, which need no explanations."""
    return "".join(f"{line}\n" for line in _guard_lines(result))


def reasons_text(result: supervisor.Supervisor) -> str:
    """What follows them: reasons, what is taken as free, properties."""
    return "".join(f"{line}\n" for line in _reason_lines(result))


def _guard_lines(result: supervisor.Supervisor) -> Iterator[str]:
    yield sizes(result)
    robot = result.plant.robot
    width = max((len(formatting.event_text(g.event)) for g in result.guards), default=0)
    names = result.part_names
    if names.definitions:
        yield ""
        yield from (part.line(robot) for part in names.definitions)
    for guard in result.guards:
        yield ""
        yield f"{formatting.event_text(guard.event):{width}}  {guard.status}"
        yield f"    {model_text.to_dsl(names.of_guard(guard.expr), robot)}"


def _reason_lines(result: supervisor.Supervisor) -> Iterator[str]:
    for explanation in filter(attrgetter("told"), result.explanations):
        yield from _explanation_lines(explanation)
    if result.plant.view.free:
        yield ""
        yield "taken as free: every outcome counts as possible, so too much may be forbidden:"
        yield from (f"    {text}: {reason}" for text, reason in result.plant.view.free.items())
    if result.properties:
        yield ""
        yield from (_property_text(name, holds) for name, holds in result.properties)


def sizes(result: supervisor.Supervisor) -> str:
    return (
        f"{result.plant.robot.name}: {result.controlled_states:,} of"
        f" {errors.counted(result.plant_states, 'state')}"
        f" under control, {errors.counted(result.controlled_transitions, 'transition')}"
        f" ({result.engine} engine, {result.seconds:.2f} s)"
    )


def _explanation_lines(explanation: supervisor.Explanation) -> Iterator[str]:
    yield ""
    yield explanation.diagnostic.message
    if explanation.remedy:
        yield f"    remedy: {explanation.remedy}"


def generated_text(result: Generated, reason: str, verbose: bool = False) -> str:
    """What was written, for which ROS and for which reason, how long it took, what to type next.

    With ``verbose``, each file that was written has a line.
    """
    files = result.files
    changes = [f"{len(files.written)} written", f"{len(files.unchanged)} unchanged"]
    if files.removed:
        changes.append(f"{len(files.removed)} removed")
    version = {"ros1": "ROS 1", "ros2": "ROS 2"}[result.output.target]
    lines = [
        f"{files.folder}: for {version} ({reason}), {', '.join(changes)}",
    ]
    if verbose:
        lines += [f"    {path}" for path in files.written]
    if files.edited:
        lines.append(
            "changed by hand, and so kept as it is (--force replaces it); + is the model's:"
        )
        for path, differences in files.edited.items():
            lines += [f"    {path}", *(f"        {line}" for line in differences)]
    if files.kept:
        lines.append("no longer part of the package, but changed by hand, and so kept:")
        lines += [f"    {path}" for path in files.kept]
    lines.append(f"done in {result.seconds:.2f} s; next:")
    lines += (f"    {command}" for command in _next_commands(result))
    return "\n".join(lines) + "\n"


def _next_commands(result: Generated) -> Iterator[str]:
    """What builds the package and starts it, from the folder in which robosc was called."""
    import shlex

    folder = result.files.folder
    workspace = folder.parent
    if workspace.resolve().name == "src":
        workspace = Path(os.path.normpath(workspace / ".."))
    elif result.output.target == "ros1":  # catkin_make builds what lies in src of a workspace
        link = f"ln -sfn {shlex.quote(str(folder.absolute()))} ~/catkin_ws/src"
        yield f"mkdir -p ~/catkin_ws/src && {link} && cd ~/catkin_ws"
        workspace = Path()
    if workspace != Path():
        yield f"cd {shlex.quote(str(workspace))}"
    name = result.package
    if result.output.target == "ros1":
        path = _path_for_catkin()
        yield f"{path}catkin_make && source devel/setup.bash"
        yield f"roslaunch {name} {name}.launch"
        yield f"{path}catkin_make run_tests_{name}    # tests the package"
    else:
        yield "colcon build && source install/setup.bash"
        yield f"ros2 launch {name} {name}.launch.py"
        yield f"colcon test --packages-select {name} && colcon test-result    # tests the package"


def _path_for_catkin() -> str:
    """What makes the Python of ROS the first, where another python3 is on PATH, as pyenv's is.

    The option of CMake for it would not do: tests ask PATH.
    """
    import shutil

    first = shutil.which("python3")
    if first is None or first in ("/usr/bin/python3", "/bin/python3"):
        return ""
    installed = Path("/usr/lib/python3/dist-packages/catkin_pkg").is_dir()
    return "PATH=/usr/bin:$PATH " if installed else ""


def verify_text(verified: VerifyReport) -> str:
    """Each property with ``yes`` or ``no`` and, where it fails, how."""
    states = errors.counted(verified.states, "state")
    size = f"{states}, {errors.counted(verified.transitions, 'transition')}"
    lines = [f"{verified.robot}: {size}"]
    if verified.method == "symbolic":
        lines.append("too many states to visit one by one: verified with sets of states")
    lines.append(f"shared with synthesis: {', '.join(verified.shared)}")
    for check in verified.checks:
        lines.append(_property_text(check.name, check.holds))
        if check.detail:
            lines.append(f"    {check.detail}")
        if check.trace:
            lines.append(f"    trace: {formatting.trace_text(check.trace)}")
    lines += [_property_text(name, holds) for name, holds in verified.properties]
    return "\n".join(lines) + "\n"


def _property_text(name: str, holds: bool) -> str:
    return f"{name}: {'yes' if holds else 'no'}"


# --- explore -------------------------------------------------------------------------------------


def graph_text(system: Graph) -> str:
    """Each state with the steps out of it; ``*`` marks marked states, ``!`` controllable events."""
    from robosc.synthesis.listing import listed

    plant = system.plant
    steps: list[list[str]] = [[] for _ in system.states]
    for one in listed(system):
        sign = "!" if one.step.event.controllable else " "
        steps[one.source].append(f"    {sign} {formatting.step_text(one.step)} -> {one.target}")
    transitions = errors.counted(len(system.transitions), "transition")
    size = f"{errors.counted(len(system.states), 'state')}, {transitions}"
    lines = [f"{plant.robot.name}: {size}"]
    if sum(map(len, steps)) < len(system.transitions):
        lines.append("parts of a value on which a step does not depend are left out")
    for number, state in enumerate(system.states):
        values = ", ".join(_variable_texts(plant, state))
        lines.append(f"{number}{'*' if plant.is_marked(state) else ''}  {values}")
        lines += steps[number]
    return "\n".join(lines) + "\n"


def _variable_texts(plant: automaton.Plant, state: automaton.PlantState) -> Iterator[str]:
    for variable, index in zip(plant.variables, state, strict=True):
        if variable.labels is not None:
            yield variable.labels[index]
            continue
        value = variable.values[index]
        value = str(value).lower() if isinstance(value, bool) else str(value)
        match variable.kind:
            case automaton.VariableKind.LOCATION:
                yield f"{variable.name}.{place_of(value)}"
                if stage_of(value):
                    yield f"{variable.name}.{value}"
            case automaton.VariableKind.DATA | automaton.VariableKind.TEST:
                yield f"{variable.name} = {value}"
            case automaton.VariableKind.PHASE:
                if index:
                    yield f"{plant.robot.display_names[variable.name]}.{value}"
