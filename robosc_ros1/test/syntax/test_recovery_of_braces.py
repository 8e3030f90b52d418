"""After a brace that is missing or too many, the parser finds the block that was meant."""

from __future__ import annotations

import pytest
from syntax_support import faults, read, shown

from robosc.errors import Severity
from robosc.model.resolve import load
from robosc.source import Source

CASES = {
    "a missing brace of a state": (
        """\
robot R {
    component A {
        behaviour {
            initial state s {
                transition goto t
            state t {
                transition goto s
            }
        }
    }
    requirement a needs b
}
""",
        """\
model.rscd:6:13: error[missing-brace]: expected '}' to close 'initial state s' before 'state'
    6 |             state t {
      |             ^^^^^
model.rscd:4:13: note: it is opened here
""",
    ),
    "a missing brace of a component before what may stand in it": (
        """\
robot R {
    component A {
        incoming message a with type: none
    requirement a needs B.s
    component B { behaviour { initial marked state s { } } }
}
""",
        """\
model.rscd:4:5: error[missing-brace]: expected '}' to close 'component A' before 'requirement'
    4 |     requirement a needs B.s
      |     ^^^^^^^^^^^
model.rscd:2:5: note: it is opened here
""",
    ),
    "missing braces of a behaviour and its component before what may stand in it": (
        """\
robot R {
    component A {
        behaviour {
            initial state s { }
    provide a with 3
    constant c: integer = 3
}
""",
        """\
model.rscd:5:5: error[missing-brace]: expected '}' to close 'behaviour' before 'provide'
    5 |     provide a with 3
      |     ^^^^^^^
model.rscd:3:9: note: it is opened here
""",
    ),
    "missing braces of a component and its behaviour": (
        """\
robot R {
    component A {
        behaviour {
            initial state s { }
    component B { }
}
""",
        """\
model.rscd:5:5: error[missing-brace]: expected '}' to close 'behaviour' before 'component'
    5 |     component B { }
      |     ^^^^^^^^^
model.rscd:3:9: note: it is opened here
""",
    ),
    "a missing brace of a behaviour, as the indentation tells": (
        """\
robot R {
    component A {
        behaviour {
            initial state s { }
    }
    component B { }
}
""",
        """\
model.rscd:5:5: error[missing-brace]: expected '}' to close 'behaviour' before this one
    5 |     }
      |     ^
model.rscd:3:9: note: it is opened here
""",
    ),
    "a missing brace of the last state of a file, as the indentation tells": (
        """\
robot R {
    component A {
        behaviour {
            initial state s {
                on request to a goto s
        }
    }
}
""",
        """\
model.rscd:6:9: error[missing-brace]: expected '}' to close 'initial state s' before this one
    6 |         }
      |         ^
model.rscd:4:13: note: it is opened here
""",
    ),
    "a brace too many in the middle of a behaviour": (
        """\
robot R {
    component A {
        behaviour {
            initial state s { } }
            state t { }
            state u { }
        }
        incoming message m with type: none
    }
    component B { }
}
""",
        """\
model.rscd:5:13: error[unexpected-brace]: 'state' is not allowed here
    5 |             state t { }
      |             ^^^^^ is there an extra '}' above?
""",
    ),
    "a brace too many behind a component": (
        """\
robot R {
    component A { } }
    component B { }
    requirement a needs b
}
""",
        """\
model.rscd:3:5: error[unexpected-brace]: the robot has ended before this
    3 |     component B { }
      |     ^^^^^^^^^ is there an extra '}' above?
""",
    ),
    "what stands in a behaviour, in a component without one": (
        """\
robot R {
    component A {
        incoming message m with type: none
        variable n: integer(0..3)
        initial state s { }
    }
}
""",
        """\
model.rscd:4:9: error[unexpected-brace]: 'variable' is not allowed here
    4 |         variable n: integer(0..3)
      |         ^^^^^^^^ it stands in a behaviour
""",
    ),
    "what stands in a component, in the robot": (
        """\
robot R {
    outgoing message m with type: none
    component A { }
}
""",
        """\
model.rscd:2:5: error[unexpected-brace]: 'outgoing' is not allowed here
    2 |     outgoing message m with type: none
      |     ^^^^^^^^ it stands in a component
""",
    ),
    "the opening brace of a state is missing": (
        """\
robot R {
    component A {
        behaviour
            state s
                on request to m
            }
            state t }
        }
    }
}
""",
        """\
model.rscd:4:13: error[missing-brace]: expected '{' to open 'behaviour'
    4 |             state s
      |             ^^^^^
model.rscd:5:17: error[missing-brace]: expected '{' to open 'state s'
    5 |                 on request to m
      |                 ^^
model.rscd:7:21: error[missing-brace]: expected '{' to open 'state t'
    7 |             state t }
      |                     ^
""",
    ),
    "an object that is not closed": (
        """\
robot R {
    provide move with {
        linear: { x: 0.4 },
        angular: { z: 1 }
    provide stop with { }
    requirement a needs b
}
""",
        """\
model.rscd:5:5: error[syntax]: expected ',' or '}'
    5 |     provide stop with { }
      |     ^^^^^^^
""",
    ),
    "a file that ends too early": (
        """\
robot R {
    component A {
        behaviour {
            variable v:
""",
        """\
model.rscd:4:24: error[syntax]: expected a type after ':', but the file ends here
    4 |             variable v:
      |                        ^
""",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_messages(case: str) -> None:
    text, expected = CASES[case]
    assert faults(text) == expected


@pytest.mark.parametrize(
    "case",
    [
        "a missing brace of a state",
        "missing braces of a component and its behaviour",
        "a brace too many in the middle of a behaviour",
        "a brace too many behind a component",
        "the opening brace of a state is missing",
    ],
)
def test_a_wrong_brace_loses_nothing(case: str) -> None:
    text, _ = CASES[case]
    tree, _ = read(text)
    assert tree is not None
    assert not tree.broken
    everything = shown(tree)
    assert everything.count("Component(") == text.count("component ")
    assert everything.count("State(") == text.count("state ")
    assert everything.count("Requirement(") == text.count("requirement ")


OUTSIDE = """\
robot R {
    component A {
        behaviour {
            initial marked state s {
            }
        }
%s
    constant low: double = 0.2
    condition near = A.s and low < 1

    requirement go needs near
    component B { incoming message go with type: none }
}
"""


@pytest.mark.parametrize("header", ["component A {", "behaviour {", "initial marked state s {"])
def test_a_missing_brace_is_one_fault_where_the_lines_stand_further_left(header: str) -> None:
    whole = (OUTSIDE % "    }").splitlines()
    place = next(n for n, line in enumerate(whole) if header in line)
    indent = len(whole[place]) - len(whole[place].lstrip())
    end = next(n for n, line in enumerate(whole) if n > place and line == " " * indent + "}")
    text = "\n".join([*whole[:end], *whole[end + 1 :]])
    _, found = load(Source("model.rscd", text))
    assert [d.code for d in found if d.severity is Severity.ERROR] == ["missing-brace"]
    # The braces behind a missing one close the wrong blocks: it is seen where they are used up.
    assert end < found[0].span.line <= 7, found[0]
