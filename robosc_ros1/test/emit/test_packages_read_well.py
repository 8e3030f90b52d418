"""Generated files are as somebody would have written them."""

from __future__ import annotations

import hashlib
import io
import re
import tokenize
from functools import cache
from typing import Any

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.golden_packages import PACKAGES, TARGETS, model_path, package_of

import robosc
from robosc.emit.write.line_breaks import WIDTH
from robosc.resources import templates_folder

GROUP = "golden"
"""One process makes the packages, for all tests that look at them."""


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_no_tuple_is_empty_over_two_lines(model: str, target: str, mode: str) -> None:
    for path, file in package_of(model, target, mode).files.items():
        assert not re.search(r"= ?\(\n *\)", file.content), path


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_strings_are_in_double_quotation_marks(model: str, target: str, mode: str) -> None:
    for path, file in package_of(model, target, mode).files.items():
        if path.endswith(".py"):
            assert in_single_marks(file.content) == [], path


@cache
def in_single_marks(content: str) -> list[str]:
    """Return the strings that need not be in single marks; most files are in several packages."""
    tokens = tokenize.generate_tokens(io.StringIO(content).readline)
    strings = [token.string for token in tokens if token.type == tokenize.STRING]
    return [s for s in strings if s[0] == "'" and '"' not in s]


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_no_line_of_generated_python_is_too_long(model: str, target: str, mode: str) -> None:
    files = package_of(model, target, mode).files
    lines = [
        (path, line)
        for path, file in files.items()
        if path.endswith(".py")
        for line in file.content.split("\n")
    ]
    assert lines
    assert [(path, line) for path, line in lines if len(line) > WIDTH] == []


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_the_page_has_no_gap_and_tells_of_what_there_is(model: str, target: str, mode: str) -> None:
    page = package_of(model, target, mode).files["README.md"].content
    assert "\n\n\n" not in page
    for word in ("goal_timeout", "goal is rejected"):
        assert word not in page or "| sends goals to the action |" in page
    assert "service call" not in page or "| calls the service |" in page


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_a_comparison_is_not_negated(model: str, target: str, mode: str) -> None:
    """Nor is the condition of a delayed transition tested once to leave and once to go on."""
    for path, file in package_of(model, target, mode).files.items():
        if path.endswith("/controller.py"):
            negated = re.findall(r"not [\w.]+ [!=]= |not \([\w.]+ [!=]= [^ ]+\)", file.content)
            assert negated == [], path
            assert not re.search(r"if not .*:\n +return None", file.content), path


GOAL = """
robot Gate {
    interface link use Point from geometry_msgs
    datatype object Point { x: double y: double }
    component Operator {
        outgoing message goal with type: Point links link
        incoming message go with type: none
        behaviour {
            variable last: Point
            initial marked state s { on response from goal do last := value }
        }
    }
    requirement go needs defined(Operator.last)
}
"""


def test_only_what_the_code_uses_is_imported() -> None:
    """Not what a comment says: a requirement's text has words that the runtime has, too."""
    source = controller_source(supervisor_of(GOAL))
    assert "defined(" in source
    assert "from ._runtime.core.functions import is_so\n" in source


@pytest.mark.parametrize("target", TARGETS)
def test_a_package_says_what_made_it_from_what_and_under_which_licence(target: str) -> None:
    files = package_of("lantern", target).files
    own = "lantern_controller/model.py"
    source = next(file.content for path, file in files.items() if path.endswith(own))
    found: dict[str, Any] = {}
    exec(source, found)
    assert found["GENERATOR"] == f"robosc {robosc.__version__}"
    of_file = hashlib.sha256(model_path("lantern").read_bytes()).hexdigest()
    assert found["SOURCES"] == {"lantern.rscd": of_file}
    licence = (templates_folder().parents[1] / "LICENSE").read_text()
    assert files["LICENSE"].content.partition("\n\n")[2] == licence
