"""A supervisor of which the two sides are joined by remapping is refused, in whichever way."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

import pytest
from emit.golden_packages import package_of

from robosc.emit.write.writer import write
from robosc.runtime.core.settings import Settings

GROUP = "golden"

PARTS = ("/goal", "/end")
NAMES = ("scan", "odom", "vel", "horn", "lamp", "door", "go", "order")


@pytest.fixture(scope="module")
def tables(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("package")
    write(package_of("gauntlet", mode="supervisor", tested=False), folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder / "gauntlet_supervisor" / "src"))
        module: Any = import_module("gauntlet_supervisor.supervisor_tables")
    for name in [n for n in sys.modules if n.split(".")[0] == "gauntlet_supervisor"]:
        del sys.modules[name]
    rows = {name: ("supervised/" + name, name, None, ()) for name in NAMES}
    return module, module.SupervisorTables(
        [(robot, own, *rest) for own, robot, *rest in (rows["scan"], rows["odom"])],
        [rows["vel"], rows["horn"]],
        [rows["lamp"]],
        [rows["go"]],
        [rows["door"]],
        [rows["order"]],
    )


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        *((name, "supervised/" + name, "/supervised/" + name) for name in NAMES),
        *(("supervised/" + name, name, "/" + name) for name in NAMES),
        ("vel", "supervised/horn", "/supervised/horn"),  # comes back as another command
        ("supervised/scan", "odom", "/odom"),  # as another input
        ("supervised/scan", "vel", "/vel"),
        ("door", "supervised/lamp", "/supervised/lamp"),
        ("go/goal", "supervised/go/goal", "/supervised/go/goal"),  # as a launch file remaps actions
        ("supervised/order/end", "order/end", "/order/end"),
        ("go/goal", "supervised/go/end", "/supervised/go/end"),
        ("vel", "horn", None),  # both to the robot
        ("lamp", "supervised/vel", None),  # a service and a topic
        ("other", "else", None),
    ],
)
def test_the_sides_of_a_supervisor_stay_apart(
    tables: Any, old: str, new: str, told: str | None
) -> None:
    module, made = tables

    def resolved(name: str) -> str:
        name = name.lstrip("/")
        return "/" + (new if name == old else name)

    if told is None:
        made.demand_fit(Settings(), resolved, PARTS)
        return
    with pytest.raises(module.ParameterError, match="is the same on both sides") as raised:
        made.demand_fit(Settings(), resolved, PARTS)
    assert str(raised.value).startswith(told + " is")


def test_a_supervisor_is_no_shadow(tables: Any) -> None:
    module, made = tables
    with pytest.raises(module.ParameterError, match="a shadow is a mode of the monitor"):
        made.demand_fit(Settings(shadow=True), lambda name: "/" + name, PARTS)
