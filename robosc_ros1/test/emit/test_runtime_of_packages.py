"""What of the runtime a package carries: the modules that it imports, and no others."""

from __future__ import annotations

import pytest
from emit.golden_packages import PACKAGES, package_of

ALL = {"__init__", "ages", "calls", "clocks", "run_to_completion", "deadlines", "effects", "engine", "engine_parts", "commanding", "role", "eventlog", "gate", "heavy", "inbox", "input_events", "intake", "internal_transitions", "lateness", "model", "open_requests", "original_state", "pauses", "places", "port", "reasons", "recorder", "requests", "served",
       "operating", "parameter_values", "scheduler", "sending", "settings", "shapes", "shortening", "sight", "snapshots", "telemetry", "time_monitor", "connections", "engine_queue", "value_topics", "values"}  # fmt: skip
MONITOR = {
    "allowances",
    "crossings",
    "findings",
    "gathering",
    "invariants",
    "matching",
    "offers",
    "judge",
    "monitoring",
    "observation",
    "orderings",
    "pending",
    "seen",
    "seen_goals",
    "unseen",
    "verdicts",
}
SHADOW = MONITOR | {"shadowing"}
GUARD = MONITOR | {"relayed_calls", "supervising"}
ONLY = {
    ("ros1", "controller"): SHADOW,
    ("ros1", "supervisor"): GUARD,
    ("ros1", "monitor"): MONITOR,
    ("ros2", "controller"): {"launch_arguments", "qos"} | SHADOW,
    ("ros2", "supervisor"): {"launch_arguments", "qos"} | GUARD,
    ("ros2", "monitor"): {"launch_arguments", "qos"} | MONITOR,
}


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_modules_of_the_runtime(model: str, target: str, mode: str) -> None:
    paths = [path.rpartition("_runtime/") for path in package_of(model, target, mode).files]
    modules = {name.removesuffix(".py") for _, folder, name in paths if folder}
    assert modules == ALL | ONLY[target, mode]
