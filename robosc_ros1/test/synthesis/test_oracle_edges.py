"""Robots at the edge of the language, held against the oracle by every engine."""

from __future__ import annotations

from pathlib import Path

import pytest
from synthesis.differential import ENGINES, differences
from synthesis.oracle import Oracle
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.synthesis.bdd.manager import available

pytestmark = pytest.mark.slow

LINK = "interface link use Thing from some_robot_msgs\n"
RULES = " ".join(f"value = {i} -> v{i}" for i in range(63))

ROBOTS = {
    "nothing at all": "",
    "64 values of an enum": f"""
        datatype enum E from integer to {{ {RULES} default -> v63 }}
        component A {{
            outgoing message m with type: E
            incoming message go with type: none
            behaviour {{
                variable e: E
                initial marked state s {{ on response from m do e := value }}
            }}
        }}
        requirement go needs A.e = v5 or A.e = v63
    """,
    "a variable of one value": """
        component A {
            incoming message go with type: none
            behaviour {
                variable x: integer(3..3)
                initial marked state s { on request to go if x = 3 do x := x }
            }
        }
    """,
    "integers beyond 32 bits": """
        component A {
            incoming message go with type: none
            behaviour {
                variable x: integer(-3000000000..-2999999998) = -3000000000
                initial marked state s { on request to go do x := x + 1 }
            }
        }
        requirement always A.x < 0
    """,
    "division by zero": """
        component A {
            incoming message go with type: none
            behaviour {
                variable x: integer(-2..2) = -2
                variable y: integer(-2..2)
                initial marked state s {
                    on request to go
                        if x / y < -1 or y / x > 0.4 or x / y != x / y or y / x = 0
                        do x := x + 1, y := -y
                }
            }
        }
        requirement always A.x + A.y < 9
    """,
    "comparisons of booleans": """
        component A {
            incoming message go with type: none
            outgoing message m with type: boolean
            behaviour {
                variable p: boolean
                variable q: boolean
                initial marked state s {
                    on request to go if p = q do p := !p
                    on response from m do q := value != p
                }
            }
        }
        requirement go needs A.p => A.q = A.s
    """,
    "a value that only an unreachable state takes": """
        component A {
            outgoing message m with type: integer(0..2)
            incoming message go with type: none
            behaviour {
                variable x: integer(0..2)
                on response from m
                initial marked state here {}
                marked state nowhere { on response from m do x := value }
            }
        }
        requirement go needs A.x = 0
    """,
    "a value that only hidden transitions take": """
        component A {
            outgoing message m with type: integer(0..2)
            incoming message go with type: none
            behaviour {
                variable x: integer(0..2)
                on response from m do x := value
                initial marked state one { on response from m goto two }
                marked state two { on response from m goto one }
            }
        }
        requirement go needs A.x = 0
    """,
    "a range left only by what another component holds": """
        component A {
            outgoing message m with type: none
            behaviour {
                variable x: integer(0..1)
                initial marked state s { on response from m do x := B.x }
            }
        }
        component B {
            incoming message set with type: none
            behaviour {
                variable x: integer(0..5)
                initial marked state s {
                    on request to set do x := x + 1
                    on response from m do x := A.x
                }
            }
        }
        requirement always A.x = 0 or B.x >= 0
    """,
    "a variable that only a provide condition reads": """
        component A {
            incoming message go with type: boolean
            outgoing message m with type: boolean
            behaviour {
                variable b: boolean
                initial marked state s { on response from m do b := value }
            }
        }
        provide go with true if A.b
    """,
    "requirements on a set with an action in it": LINK + """
        component A {
            action a with request: none, response: none, feedback: none links link
            incoming message g with type: none
            outgoing message m with type: boolean
            behaviour {
                variable b: boolean
                initial marked state s { on response from m do b := value }
            }
        }
        requirement {a, g} needs A.b
        requirement A.b disables a
    """,
    "internal transitions that go round": """
        component A {
            behaviour {
                initial marked state one { transition goto two }
                state two { transition goto one }
            }
        }
    """,
    "a service whose phase two components mirror": LINK + """
        component A {
            service s with request: none, response: none links link
            behaviour {
                initial marked state idle { on request to s goto busy }
                state busy { on response from s goto idle on error from s goto idle }
            }
        }
        component B {
            behaviour {
                variable n: integer(0..2)
                on request to s do n := n + 1
                on error from s do n := n - 1
                initial marked state s {}
            }
        }
        requirement never A.idle and B.n = 2
    """,
}  # fmt: skip

engines = pytest.mark.parametrize("engine", ENGINES)


def skip_missing(engine: str) -> None:
    if engine == "bdd" and not available():
        pytest.skip("the symbolic engine is not installed (oxidd)")


@engines
@pytest.mark.parametrize("name", ROBOTS)
def test_robot_at_the_edge(name: str, engine: str) -> None:
    skip_missing(engine)
    robot = robot_of("robot R {" + ROBOTS[name] + "}")
    assert differences(robot, Oracle(robot), engine) == []


LIBRARY = """
library Wheels {
    interface link use Thing from some_robot_msgs
    component Wheel {
        service turn with identifier: "turn", request: none, response: none links link
        incoming message brake with type: none
        behaviour {
            initial marked state still { on request to turn goto turning }
            state turning { on response from turn goto still on error from turn goto still }
        }
    }
}
"""

TWO_WHEELS = """
robot Cart {
    component Left from Wheels import Wheel with prefix: "/left"
    component Right from Wheels import Wheel with prefix: "/right"
    requirement Left.turn needs Right.still
    requirement Right.turn needs Left.still
    requirement {Left.brake, Right.brake} needs Left.still and Right.still
}
"""


@engines
def test_two_imports_of_one_component(tmp_path: Path, engine: str) -> None:
    skip_missing(engine)
    (tmp_path / "wheels.rscd").write_text(LIBRARY)
    (tmp_path / "cart.rscd").write_text(TWO_WHEELS)
    robot = pipeline.load(tmp_path / "cart.rscd").robot
    oracle = Oracle(robot)
    assert differences(robot, oracle, engine) == []
    names = {t["event"]["name"] for t in oracle.document()["transitions"]}
    assert names == {"Left.turn", "Left.brake", "Right.turn", "Right.brake"}
    assert len(oracle.controlled[0]) == 3
