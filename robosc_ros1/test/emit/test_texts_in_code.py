"""What stands in strings of a model is never taken for code of its controller."""

from __future__ import annotations

import pytest
from emit.generated_code import controller_class, supervisor_of

from robosc.emit.literals import literal, without_texts
from robosc.emit.reactions import attributes_read

TEXTS = [
    "self.bogus",
    'say "self.bogus"',
    "back\\slash\\",
    "it's self.requirement_1()",
    "in_range(self.level)",
    "new\nline self.x",
    "",
]


@pytest.mark.parametrize("text", TEXTS)
def test_strings_are_no_code(text: str) -> None:
    code = f"self.mode == {literal(text)} and self.level > {literal(text)} or self.check()"
    assert without_texts(code) == 'self.mode == "" and self.level > "" or self.check()'
    assert attributes_read([code]) == {"mode", "level"}


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
