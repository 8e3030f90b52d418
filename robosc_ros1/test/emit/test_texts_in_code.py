"""What stands in strings of a model is never taken for code of its controller."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from emit.generated_code import controller_class, supervisor_of
from emit.golden_packages import MODELS, model_path
from quick import quick_first
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.emit.controller.python_literals import literal
from robosc.emit.controller.template_data import ControllerContext

ROBOTS = [
    *(file for file in sorted(EXAMPLES.rglob("*.rscd")) if file.parent.name != "libraries"),
    *map(model_path, MODELS),
]
TEXTS = [
    "self.bogus",
    'say "self.bogus"',
    "back\\slash\\",
    "it's self.requirement_1()",
    "in_range(self.level)",
    "new\nline self.x",
    "",
]


MODEL = """robot T {
    condition fine = (A.mode = %s or A.mode = "x") and A.level <= 3
    component A {
        outgoing message m with identifier: "/m", type: string
        outgoing message l with identifier: "/l", type: integer(0..9)
        incoming message go with identifier: "/go", type: string
        behaviour {
            variable mode: string = ""
            variable level: integer(0..9) = 0
            initial marked state s {
                on response from m do mode := value
                on response from l do level := value
                on request to go do level := 1
            }
        }
    }
    requirement go needs fine
    provide go with A.mode + %s
}
"""


@pytest.mark.parametrize("text", TEXTS)
def test_a_command_reads_the_same_whatever_the_strings_say(text: str) -> None:
    def command(written: str) -> tuple[object, ...]:
        _, context = controller_class(supervisor_of(MODEL % (written, written)))
        return tuple((c.reads, c.reaction) for c in context.commands)

    assert command(literal(text).replace("\\'", "'")) == command('"y"')


@pytest.mark.parametrize("model", quick_first(ROBOTS, 8), ids=lambda model: model.stem)
def test_reads_of_commands_are_those_of_their_code(model: Path) -> None:
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    _, context = controller_class(supervisor)
    for command in context.commands:
        texts = [command.guard_text, command.synchronisation_text]
        assert command.reads == tuple(sorted(set(_read_by(texts, context)))), command.key


def _read_by(texts: list[str], context: ControllerContext) -> Iterator[str]:
    """The attributes that Python reads in conditions and in the methods that they call."""
    methods = {r.method: r.condition for r in context.requirements}
    methods |= {part.method: part.condition for part in context.guard_parts}
    for text in filter(None, texts):
        tree = ast.parse(text, mode="eval")
        called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "self":
                if id(node) not in called:
                    yield node.attr
                elif node.attr in methods:
                    yield from _read_by([methods[node.attr]], context)
