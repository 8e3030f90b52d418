"""A model with every construct, to be typed, and helpers to find places in it."""

from __future__ import annotations

from lsprotocol import types

__all__ = ["LARGE", "LIBRARY", "MODEL", "place"]

LIBRARY = """\
library Arms {
    component Arm {
        service grip with identifier: "/grip", request: none, response: none links empty
        behaviour {
            initial marked state open { on request to grip goto closing }
            state closing { on response from grip goto open on error from grip goto open }
        }
    }
    interface empty use Empty from std_srvs
}
"""

MODEL = """\
// Ein Hüter 🤖 /* of */
robot Keeper {
    component Eye {
        outgoing message seen with identifier: "/seen", type: Sight
        behaviour {
            variable last: Sight = nothing
            variable count: integer(0..3) = 0
            initial marked state open {
                on response from seen if value != nothing do last := value, count := 1
                on response from seen if value = nothing do last := nothing
            }
        }
    }
    component Wheel {
        incoming message drive with type: Twist links twist
        behaviour {
            initial marked state still { on request to drive goto moving }
            marked state moving { transition if Eye.last = nothing goto still }
        }
    }
    component Hand from Arms import Arm with prefix: "/left"
    requirement drive needs Eye.last = far and !(Eye.count > 2)
    requirement Wheel.moving disables { grip }
    never Wheel.moving => Hand.closing
    requirement never Hand.closing and Wheel.moving
    provide drive with { linear: { x: 0.5e-1 }, angular: { z: -Eye.count / 2 } } if Eye.open
    datatype object Twist { linear: Vector angular: Vector }
    datatype object Vector { x: double y: double z: double }
    datatype enum Sight from double to { value > 1.5 -> far value > 0 -> near default -> nothing }
    interface twist use Twist from geometry_msgs
}
"""
"""One line of it is wrong."""

_PHILOSOPHER = """\
    component Phil{0} {{
        incoming message first{0} with type: none
        incoming message second{0} with type: none
        outgoing message done{0} with type: none
        behaviour {{
            initial marked state thinking {{ on request to first{0} goto waiting }}
            state waiting {{ on request to second{0} goto eating }}
            state eating {{ on response from done{0} goto thinking }}
        }}
    }}
    requirement first{0} needs !Phil{1}.eating
    requirement second{0} needs Phil{2}.thinking
"""
_SEATS = 13
LARGE = "".join([
    "robot Philosophers {\n",
    *(_PHILOSOPHER.format(i, (i - 1) % _SEATS, (i + 1) % _SEATS) for i in range(_SEATS)),
    "}\n",
])  # fmt: skip
"""Its synthesis takes minutes."""


def place(text: str, words: str, inside: int = 0) -> types.Position:
    """Where some words begin, in the units of the protocol."""
    before = text[: text.index(words) + inside]
    line = before.rpartition("\n")[2]
    return types.Position(before.count("\n"), len(line.encode("utf-16-le")) // 2)
