"""The classes of a node that its engine calls have all that it may call: no package carries the
interfaces, and types of nodes are not checked."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

import pytest
from emit.golden_packages import PACKAGES, package_of

from robosc.runtime.core import interfaces as core
from robosc.runtime.judge import ports as judge

PORTS = {"controller": core.Port, "monitor": judge.MonitorPort, "supervisor": judge.SupervisorPort}


def classes_of(source: str) -> Iterator[ast.ClassDef]:
    return (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ClassDef))


def has(name: str, classes: Mapping[str, ast.ClassDef]) -> set[str]:
    """What a class and those above it have."""
    if name not in classes:
        return set()
    class_ = classes[name]
    above = [ast.unparse(base).rpartition(".")[2] for base in class_.bases]
    functions = {one.name for one in ast.walk(class_) if isinstance(one, ast.FunctionDef)}
    attributes = {
        node.attr
        for node in ast.walk(class_)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }
    return functions | attributes | {each for one in above for each in has(one, classes)}


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_they_have_all_that_is_called(model: str, target: str, mode: str) -> None:
    files = package_of(model, target, mode).files
    sources = [
        f.content for path, f in files.items() if path.endswith(".py") and "test/" not in path
    ]
    classes = {one.name: one for source in sources for one in classes_of(source)}
    above = {ast.unparse(base) for one in classes.values() for base in one.bases}
    for kind, interface in (("Port", PORTS[mode]), ("Outlet", core.Outlet)):
        (name,) = (n for n in classes if n.endswith(kind) and n not in above)
        asked = {each for each in dir(interface) if not each.startswith("_")}
        assert asked <= has(name, classes), asked - has(name, classes)
