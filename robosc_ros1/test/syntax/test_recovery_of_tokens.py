"""After characters, literals and operators that the language does not have, the parser goes on."""

from __future__ import annotations

import pytest
from syntax_support import faults

CASES = {
    "characters that mean nothing": (
        """\
robot R {
    requirement a needs b && c
    requirement d needs b;
    # a comment
    requirement e needs naïve.b
    requirement f needs g ≤ 3
    requirement h needs ==
}
""",
        """\
model.rscd:2:27: error[bad-character]: '&&' has no meaning here
    2 |     requirement a needs b && c
      |                           ^^ write 'and'
model.rscd:3:26: error[bad-character]: ';' has no meaning here
    3 |     requirement d needs b;
      |                          ^ no separator stands between declarations
model.rscd:4:5: error[bad-character]: '#' has no meaning here
    4 |     # a comment
      |     ^ a comment begins with '//'
model.rscd:5:27: error[bad-character]: 'ï' has no meaning here
    5 |     requirement e needs naïve.b
      |                           ^ names have the letters a-z and A-Z, digits and '_'
model.rscd:6:27: error[bad-character]: '≤' has no meaning here
    6 |     requirement f needs g ≤ 3
      |                           ^ write '<='
model.rscd:7:25: error[syntax]: expected a condition after 'needs'
    7 |     requirement h needs ==
      |                         ^^
""",
    ),
    "habits of other languages": (
        """\
robot R {
    component A { }
    # a comment: it isn't one
    component B {
        incoming message go with identifier: "/go"
        incoming message halt with type: none
        behaviour { variable ok: boolean := true }
    }
}
""",
        """\
model.rscd:3:5: error[bad-character]: '#' has no meaning here
    3 |     # a comment: it isn't one
      |     ^ a comment begins with '//'
model.rscd:6:9: error[syntax]: expected ',' and 'type:'
    6 |         incoming message halt with type: none
      |         ^^^^^^^^
model.rscd:7:42: error[syntax]: expected '=', 'variable', 'state', 'on', 'transition' or '}'
    7 |         behaviour { variable ok: boolean := true }
      |                                          ^^ write '=' for an initial value
""",
    ),
    "a string without end spoils only its declaration": (
        """\
robot R {
    component A {
        outgoing message a with identifier: "/a, type: double
        outgoing message b with identifier: '/b', typ: double
    }
}
""",
        """\
model.rscd:3:45: error[unterminated-string]: this string has no end
    3 |         outgoing message a with identifier: "/a, type: double
      |                                             ^^^^^^^^^^^^^^^^^ close it with "
model.rscd:4:51: error[syntax]: expected 'identifier:', 'timeout:', 'max_age:' or 'type:'
    4 |         outgoing message b with identifier: '/b', typ: double
      |                                                   ^^^ did you mean 'type'?
""",
    ),
    "a comment without end spoils what follows": (
        """\
robot R {
    requirement a nees b
    component A { /* never closed
    component B { }
}
""",
        """\
model.rscd:2:19: error[syntax]: expected 'needs' or 'disables'
    2 |     requirement a nees b
      |                   ^^^^ did you mean 'needs'?
model.rscd:3:19: error[unterminated-comment]: this comment has no end
    3 |     component A { /* never closed
      |                   ^^ close it with */
""",
    ),
    "operators of other languages": (
        """\
robot R {
    requirement a needs b == c
    requirement a needs b <> c
    requirement a needs not b
    requirement a needs b =< c
    requirement a needs (b or c
    requirement a needs b. = c
    requirement a needs b[] = 3
}
""",
        """\
model.rscd:2:27: error[syntax]: '==' is not an operator
    2 |     requirement a needs b == c
      |                           ^^ write '='
model.rscd:3:27: error[syntax]: '<>' is not an operator
    3 |     requirement a needs b <> c
      |                           ^^ write '!='
model.rscd:4:25: error[syntax]: expected a condition after 'needs'
    4 |     requirement a needs not b
      |                         ^^^ write '!' for 'not'
model.rscd:5:27: error[syntax]: '=<' is not an operator
    5 |     requirement a needs b =< c
      |                           ^^ write '<='
model.rscd:6:31: error[syntax]: expected an operator, or ')' to close the '(' of 6:25
    6 |     requirement a needs (b or c
      |                               ^
model.rscd:7:28: error[syntax]: expected a name after '.'
    7 |     requirement a needs b. = c
      |                            ^
model.rscd:8:27: error[syntax]: expected an index in '[…]'
    8 |     requirement a needs b[] = 3
      |                           ^
""",
    ),
    "numbers and strings that are none": (
        """\
robot R {
    requirement a needs 12abc > 1.5.2
    requirement a needs 0x10 > 1
    requirement a needs 1e = 1
    requirement a needs 1e400 = 1
    requirement a needs 99999999999999999999 = 1
    requirement a needs "\\d" = "a"
    requirement a needs .5 = b
}
""",
        """\
model.rscd:2:25: error[bad-number]: '12abc' is not a number
    2 |     requirement a needs 12abc > 1.5.2
      |                         ^^^^^ numbers look like 42, 4.25 or 1e-3
model.rscd:3:25: error[bad-number]: '0x10' is not a number
    3 |     requirement a needs 0x10 > 1
      |                         ^^^^ numbers look like 42, 4.25 or 1e-3
model.rscd:4:25: error[bad-number]: '1e' is not a number
    4 |     requirement a needs 1e = 1
      |                         ^^ numbers look like 42, 4.25 or 1e-3
model.rscd:5:25: error[number-too-large]: this number is too large for a double
    5 |     requirement a needs 1e400 = 1
      |                         ^^^^^
model.rscd:6:25: error[number-too-large]: this number is too large: whole numbers go up to 18446744073709551615
    6 |     requirement a needs 99999999999999999999 = 1
      |                         ^^^^^^^^^^^^^^^^^^^^
model.rscd:7:26: error[bad-escape]: '\\d' is not an escape
    7 |     requirement a needs "\\d" = "a"
      |                          ^^ there are \\n \\t \\\\ \\" \\'
model.rscd:8:25: error[syntax]: expected a condition after 'needs'
    8 |     requirement a needs .5 = b
      |                         ^ a number begins with a digit, as in 0.5
""",
    ),
    "reserved words": (
        """\
robot R {
    datatype object V { value: double and: integer }
    component value { }
}
""",
        """\
model.rscd:2:25: error[reserved-name]: 'value' is a keyword everywhere
    2 |     datatype object V { value: double and: integer }
      |                         ^^^^^ write '^value'
model.rscd:2:39: error[reserved-name]: 'and' is a keyword everywhere
    2 |     datatype object V { value: double and: integer }
      |                                       ^^^ write '^and'
model.rscd:3:15: error[reserved-name]: 'value' is a keyword everywhere
    3 |     component value { }
      |               ^^^^^ write '^value'
""",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_messages(case: str) -> None:
    text, expected = CASES[case]
    assert faults(text) == expected
