"""What of the runtime a package carries: the modules that it imports, and no others."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
from emit.golden_packages import PACKAGES, package_of
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.emit.package import ros1_target
from robosc.emit.package.package import File

GROUP = "golden"
"""One process makes the packages, for all tests that look at them."""

ALL = {
    "__init__", *(f"core/{name}" for name in (
        "__init__", "calls", "clocks", "connections", "engine", "engine_parts", "gate", "inbox", "intake",
        "model", "original_state", "pauses", "places", "port", "reasons", "recorder",
        "requests", "scheduler", "settings", "shortening", "telemetry", "values",
    ))
}  # fmt: skip
JUDGES = {f"judge/{name}" for name in ("__init__", "fields", "judge", "matching", "sight")}
OF_MONITORS = (
    "crossings",
    "findings",
    "gathering",
    "monitoring",
    "observation",
    "seen",
    "shadowing",
)
MODES = {
    "controller": {"core/commanding", "core/sending"},
    "supervisor": {"judge/supervising", "core/sending"} | JUDGES,
    "monitor": {"core/ages", *(f"judge/{name}" for name in OF_MONITORS)} | JUDGES,
}
OF_ROS_2 = {"core/launch_arguments", "core/qos", "core/resting"}


def of_model(files: Mapping[str, File], mode: str) -> set[str]:
    """The modules that the tables of a controller ask for."""
    source = next(file.content for path, file in files.items() if path.endswith("controller.py"))
    node = next(file.content for path, file in files.items() if path.endswith("/node.py"))
    names = {Path(path).stem for path in files}
    answers = "outgoing service" in source or "outgoing action" in source
    served = (
        "__init__",
        "served_calls",
        "waiting_call",
        *(["relayed_calls"] if mode == "supervisor" else []),
    )
    return {
        *({"core/functions"} if "_runtime.core.functions import" in source else ()),
        *({"core/operations"} if "_runtime.core.operations import" in source else ()),
        *({"core/heavy"} if mode != "supervisor" and "heavy=heavy_input" in node else ()),
        *({"core/shapes"} if "shape=" in source else ()),
        *({"core/internal_transitions"} if "        Tau(" in source else ()),
        *({"core/goal_ends"} if mode == "monitor" or "ros_actions" in names else ()),
        *({"core/timers"} if "        After(" in source else ()),
        *({"core/ages"} if "max_age=" in source else ()),
        *(f"served/{name}" for name in served if answers and mode != "monitor"),
    }


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_modules_of_the_runtime(model: str, target: str, mode: str) -> None:
    files = package_of(model, target, mode).files
    paths = [path.partition("_runtime/") for path in files]
    modules = {name.removesuffix(".py") for _, folder, name in paths if folder}
    ros = OF_ROS_2 if target == "ros2" else set()
    assert modules == ALL | MODES[mode] | ros | of_model(files, mode)


def test_a_node_of_a_small_model_is_small() -> None:
    """A sensor with a timeout and a service: nothing that only other models or modes use."""
    model = EXAMPLES / "door" / "door.rscd"
    supervisor = pipeline.synthesize(pipeline.load(model, pipeline.Options()).robot)
    files = ros1_target.emit(supervisor, "door_controller").files
    own = [f.content for path, f in files.items() if path.endswith(".py") and "test/" not in path]
    assert sum(text.count("\n") for text in own) <= 6750
    names = {Path(path).stem for path in files}
    assert names.isdisjoint({"fields", "heavy", "operations", "persistence", "shapes", "timers"})
    assert names.isdisjoint({"goal_ends", "ros_actions", "ros_goal_table", "ros_heavy"})


ENGINES = {
    "controller": "core.commanding controller_engine",
    "supervisor": "judge.supervising supervisor_engine",
    "monitor": "judge.monitoring monitor_engine",
}
PROGRAM = """
import importlib, sys
controller = importlib.import_module("package.controller")
runtime = importlib.import_module("package._runtime.core.settings")
telemetry = importlib.import_module("package._runtime.core.telemetry")
JudgingPort = object
if {judges}:
    from package._runtime.judge.judge import JudgingPort
class Port(JudgingPort):
    now = stamp_time = lambda self: 1.0
    is_heard = ready = lambda self, key: True
    silence = absent = found = check = log = lambda *_: None
    send = call = start = cancel = abandon = exit = lambda *_: None
    connects = works = lost = await_inputs = lambda *_: False
    faults = lambda self: []
    unheard = lambda self: {{}}
module, name = "{engine}".split()
make = getattr(importlib.import_module("package._runtime." + module), name)
kind = next(c for n, c in vars(controller).items() if n.endswith("Controller") and n != "Controller")
given = {{p.name: p.default for p in kind.PARAMETERS if p.required}}
settings, _ = runtime.read(kind.COMMUNICATIONS, given, kind.PARAMETERS)
for shadow in (False, {judges}):
    it = kind()
    it.configure(settings.more)
    engine = make(it, Port(), settings._replace(shadow=shadow))
    engine.begin()
    engine.cycle()
    engine.snapshot()
    class Heard:
        name = "/package"
        wants_events = wants_state = lambda self: True
        faults = unconnected = lambda self: []
        state = lambda self, text: heard.append(text)
        events = lambda self, texts: None
        diagnostics = lambda self, level, message, values: heard.append(message)
    heard, model = [], {{"components": []}}
    reporter = telemetry.Reporter(engine, Heard(), model)
    reporter.close()
    reporter._report(True)
    assert len(heard) == 2 and not heard[0].startswith("cannot report"), heard
assert not [name for name in sys.modules if name.startswith("robosc")]
"""


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_a_package_has_all_that_its_engine_imports(
    model: str, target: str, mode: str, tmp_path: Path
) -> None:
    """Also the modules that it imports only if the model asks for them."""
    for path, file in package_of(model, target, mode).files.items():
        _, is_runtime, module = path.partition("/_runtime/")
        if is_runtime or path.endswith("/controller.py"):
            name = f"_runtime/{module}" if is_runtime else "controller.py"
            place = tmp_path / "package" / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(file.content, encoding="utf-8")
    program = PROGRAM.format(engine=ENGINES[mode], judges=mode != "controller")
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
