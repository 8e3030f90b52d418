"""Who may import whom: the flow goes one way, and each library has its place.

The imports are read from the source, those inside functions included.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from ros_support import EXAMPLES, SOURCES

ORDER = (
    "lazy_dataclasses", "limits", "remedies", "source", "errors", "codes", "names", "dotted", "resources", "progress", "runtime", "language", "syntax", "expr",
    "model", "plant", "supervisor", "synthesis", "emit", "simulate", "traces", "view", "new", "evidence", "pipeline", "report", "interface", "lsp", "agents",
    "model_files", "arguments", "console", "verbs", "cli", "start", "executables", "__main__",
)  # fmt: skip
"""Each imports only what stands left of it, and within itself."""

THIRD_PARTY = {
    "pyparsing": ("syntax",),
    "dd": ("synthesis",),
    "oxidd": ("synthesis",),
    "jinja2": ("emit.package.rendering",),
    "yaml": ("emit.package.config", "simulate.bags.bag_files"),
    "lsprotocol": ("lsp.open_texts", "lsp.server", "lsp.protocol"),
    # The official SDK, and what it runs on; verbs tells what to install.
    "mcp": ("agents.server", "verbs"),
    "mcp_types": ("agents.server",),
    "anyio": ("agents.server", "agents.start"),
    "jsonschema": ("agents.server", "verbs"),
    "uvicorn": ("agents.server",),
    "actionlib": ("agents.ros1",),
    "action_msgs": ("agents.ros2",),
    "argcomplete": ("cli",),
    "pygls": (
        "lsp.open_texts",
        "lsp.refusals",
        "lsp.server",
        "verbs",
    ),  # verbs tells what to install
    "prompt_toolkit": ("simulate.script.terminal",),
    "rospkg": ("model.ros.packages",),
    "catkin_pkg": ("model.ros.packages",),
    # A node of ROS that only listens; whatever else is shown needs no ROS.
    "rospy": ("view.ros1", "new.from_ros1", "agents.ros1"),
    "rosgraph": ("view.ros1", "new.from_ros1"),
    "genpy": ("view.ros1",),
    "roslib": ("view.ros1", "agents.ros1"),
    "rosservice": ("new.from_ros1",),
    "tf2_msgs": ("new.from_ros1", "new.from_ros2"),
    "rosbags": ("simulate.bags.recorded_messages",),
    "lz4": ("simulate.bags.storage",),
    "compression": ("simulate.bags.storage",),
    "backports": ("simulate.bags.storage",),
    "rclpy": ("view.ros2", "new.from_ros2", "agents.ros2"),
    "rosidl_parser": ("view.ros2",),
    "std_msgs": ("view.ros1", "view.ros2"),
    "diagnostic_msgs": ("view.ros1", "view.ros2"),
}
"""Library to the modules that may import it."""

ENVIRONMENT = ("cli", "console", "verbs", "model.ros.packages", "runtime.core.persistence")
"""Only these look at environment variables."""

PACKAGE = SOURCES / "robosc"
MODULES = sorted(PACKAGE.rglob("*.py"))


@cache
def tree(file: Path) -> ast.Module:
    return ast.parse(file.read_bytes())


def module_name(file: Path) -> str:
    """``expr.types`` for robosc/expr/types.py; a package's __init__ is the package."""
    parts = file.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def statements(block: ast.AST) -> Iterator[ast.AST]:
    """All statements in a block, in any depth; expressions have none."""
    for field in ("body", "handlers", "orelse", "finalbody", "cases"):
        for node in getattr(block, field, ()):
            yield node
            yield from statements(node)


def imports(file: Path) -> Iterator[tuple[int, str]]:
    """Line and full name of each module that a file imports."""
    for node in statements(tree(file)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom) and node.level:
            package = ("robosc", *file.parent.relative_to(PACKAGE).parts)
            base = package[: len(package) - node.level + 1]
            yield node.lineno, ".".join((*base, *filter(None, [node.module])))
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            if module == "robosc":  # from robosc import pipeline
                yield from ((node.lineno, f"robosc.{alias.name}") for alias in node.names)
            elif (SOURCES / module.replace(".", "/")).is_dir():  # from robosc.expr import tree
                yield from ((node.lineno, f"{module}.{alias.name}") for alias in node.names)
            else:
                yield node.lineno, module


def within(name: str, places: tuple[str, ...]) -> bool:
    return any(name == place or name.startswith(place + ".") for place in places)


def test_modules_import_only_what_they_may() -> None:
    faults = [
        f"{module_name(file)}:{line} imports {imported}"
        for file in MODULES
        for line, imported in imports(file)
        if not allowed(module_name(file), imported)
    ]
    assert faults == []


def allowed(importer: str, imported: str) -> bool:
    library = imported.split(".")[0]
    if library == "robosc":
        return allowed_inside(importer, imported.removeprefix("robosc").removeprefix("."))
    if library in sys.stdlib_module_names:
        return True
    return library in THIRD_PARTY and within(importer, THIRD_PARTY[library])


def allowed_inside(importer: str, imported: str) -> bool:
    layer, target = importer.split(".")[0], imported.split(".")[0]
    if layer == "runtime":
        return target == "runtime"
    if layer == "":  # the façade
        return target == "interface"
    if target == "__version__":
        return True
    if target not in ORDER or layer not in ORDER:
        return False
    return ORDER.index(target) <= ORDER.index(layer)


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Neither when they are loaded nor for their types; a function may import when it is called."""
    needs = {module_name(file): loaded(file) & NAMES for file in MODULES}
    TopologicalSorter(needs).prepare()  # raises CycleError, which names the circle


NAMES = {module_name(file) for file in MODULES}


def loaded(file: Path) -> set[str]:
    """The modules of robosc that a file imports outside functions."""
    work: list[ast.AST] = [tree(file)]
    found = set()
    while work:
        node = work.pop()
        if isinstance(node, ast.ImportFrom):
            package = module_name(file).split(".")[: -node.level] if node.level else []
            base = [*package, *filter(None, [(node.module or "").removeprefix("robosc.")])]
            found |= {".".join(base), *(".".join([*base, alias.name]) for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name.removeprefix("robosc.") for alias in node.names}
        elif not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            work += ast.iter_child_nodes(node)
    return found


LARGEST = 800
"""Lines of a module, which is one concept."""


def test_modules_are_no_longer_than_they_should_be() -> None:
    lengths = {module_name(file): len(file.read_text().splitlines()) for file in MODULES}
    assert not [name for name, lines in lengths.items() if lines > LARGEST]


def test_modules_that_are_copied_are_no_longer_either() -> None:
    lengths = {
        file.name: len(file.read_text().splitlines())
        for file in (SOURCES.parent / "templates").rglob("*.py")
    }
    assert {name for name, lines in lengths.items() if lines > LARGEST} == set()


def test_environment_is_read_in_few_places() -> None:
    readers = {
        module_name(file)
        for file in MODULES
        for node in ast.walk(tree(file))
        if isinstance(node, ast.Attribute) and node.attr in {"environ", "getenv", "expandvars"}
    }
    assert readers <= set(ENVIRONMENT)


def test_runtime_needs_nothing_but_python() -> None:
    """It runs inside generated packages, on robots where robosc was never installed."""
    for file in sorted((PACKAGE / "runtime").rglob("*.py")):
        outside = {
            name.split(".")[0] for _, name in imports(file) if not name.startswith("robosc.runtime")
        }
        assert outside <= set(sys.stdlib_module_names), file.name


def test_the_core_of_the_runtime_needs_neither_judge_nor_served_calls() -> None:
    """A controller ships it alone; what only some models need is imported when it is called for."""
    needs = {n for file in (PACKAGE / "runtime" / "core").glob("*.py") for n in loaded(file)}
    outside = {name for name in needs & NAMES if name.startswith("runtime.")}
    assert {name for name in outside if not name.startswith("runtime.core")} <= {
        "runtime.served.served_calls",
        "runtime.served.relayed_calls",
        "runtime.served.waiting_call",
    }


@pytest.mark.parametrize(
    ("importer", "imported", "verdict"),
    [
        ("model.resolve", "robosc.syntax.nodes", True),
        ("syntax.parser", "robosc.expr.types", False),
        ("synthesis.explicit", "numpy", False),
        ("plant.build", "numpy", False),
        ("emit.package.target", "jinja2", False),
        ("runtime.core.engine", "robosc.errors", False),
        ("emit.package.target", "rospy", False),
    ],
)
def test_the_rules_tell_right_from_wrong(importer: str, imported: str, verdict: bool) -> None:
    assert allowed(importer, imported) is verdict


def test_a_small_check_loads_no_library_that_it_can_do_without() -> None:
    model = EXAMPLES / "line_follower" / "line_follower.rscd"
    loaded = libraries_after(f"from robosc.cli import main; main(['check', {str(model)!r}])")
    assert loaded <= {"pyparsing", "rospkg", "catkin_pkg"}


def test_watching_a_node_needs_nothing_but_its_ros() -> None:
    assert libraries_after("import robosc.cli, robosc.view.node") == set()


def libraries_after(program: str) -> set[str]:
    code = (
        f"import sys; sys.path.insert(0, {str(SOURCES)!r}); {program}\n"
        f"print(sorted({{*sys.modules}} & {{*{[*THIRD_PARTY]!r}}}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=600
    )
    return set(ast.literal_eval(done.stdout.splitlines()[-1]))


def test_modules_cite_only_documents_of_this_repository() -> None:
    faults = []
    for file in MODULES:
        text = file.read_text()
        pages = set(re.findall(r"docs/[\w-]+\.md", text))
        gone = {name for name in pages if not (EXAMPLES.parent / name).exists()}
        elsewhere = set(re.findall(r"\b[A-Z][A-Z-]+(?: section|\.md)\b", text))
        faults += [
            f"{module_name(file)} cites {name}"
            for name in sorted(gone | (elsewhere - {"README.md", "CONTRIBUTING.md"}))
        ]
    assert faults == []


def test_no_two_stages_have_classes_of_one_name() -> None:
    """But for what a generated controller knows of the model's entities."""
    found: dict[str, list[str]] = {}
    for file in MODULES:
        for node in tree(file).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                found.setdefault(node.name, []).append(module_name(file))
    twice = {tuple(modules) for modules in found.values() if len(modules) > 1}
    ours = ("model.automata", "model.entities")
    assert twice <= {(module, "runtime.core.model") for module in ours}


IDENTITIES = ("model", "plant", "supervisor", "synthesis", "emit", "simulate.machines", "traces")
"""Here names of the model are values; what people wrote or read is taken apart elsewhere."""
OF_TEXTS = ("model.ros", "emit.write", "emit.package.config")
"""Definitions of messages, generated Python, and options."""
TAKEN_APART = {"partition", "rpartition", "split", "rsplit"}


def test_nobody_but_its_module_takes_a_name_of_the_model_apart() -> None:
    """``Base.drive``, ``moving->standing``, ``docking performing`` and ``Station[3]``."""
    faults = [
        f"{module_name(file)}:{node.lineno}"
        for file in MODULES
        if within(module_name(file), IDENTITIES) and not within(module_name(file), OF_TEXTS)
        for node in ast.walk(tree(file))
        if isinstance(node, ast.Call) and is_taken_apart(node)
    ]
    assert faults == []


def is_taken_apart(call: ast.Call) -> bool:
    at = call.args[0] if call.args else None
    method = call.func.attr if isinstance(call.func, ast.Attribute) else ""
    return (
        method in TAKEN_APART and isinstance(at, ast.Constant) and at.value in {".", " ", "->", "["}
    )


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("key.partition('.')", True),
        ("place.split('->')[1]", True),
        ("name.rpartition('.')[2]", True),
        ("dotted.last(name)", False),
        ("words.split()", False),
        ("path.split('/')", False),
    ],
)
def test_what_counts_as_taken_apart(source: str, found: bool) -> None:
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]
    assert any(map(is_taken_apart, calls)) is found


def test_engines_are_composed() -> None:
    """An engine has a role; no class of the runtime extends what another one does."""
    files = sorted((PACKAGE / "runtime").rglob("*.py"))
    assert [file.name for file in files if "super()" in file.read_text()] == []


def test_only_packages_list_what_they_offer() -> None:
    """A module's underscores say which names are its own; a second list would only be edited."""
    listing = {
        module_name(file)
        for file in MODULES
        for node in tree(file).body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    }
    assert listing == {"", "synthesis"}
