"""After a fault the parser goes on: one message per faulty declaration, none of its effects."""

from __future__ import annotations

import pytest
from syntax_support import faults, read, shown

CASES = {
    "two faulty declarations of every block": (
        """\
robot R {
    component A {
        outgoing message a with typ: double
        incoming message b with identifier "/b", type: T
        service c with request: T response: U
        outgong message d with type: none
        message e with type: none
        behaviour {
            variable x integer
            variable y: integer(0..z) = 3
            initial state s {
                on respnse from a goto t
                on response from a goto t if x
                transition iff x goto t
                on error from c goto s
            }
            marked initial state t { }
            state u { on response from a do x = 3 }
        }
    }
    component B frm lib import C
    datatype object T {
        x double
        y:
        z: integer
    }
    datatype enum E from double to {
        value >= 10 free
        value > -> foo
        value == 3 -> bar
        value < 1 ->
        default -> x
    }
    interface a use b from
    requirement a + 1 needs d
    requirement a.b, c needs d
    provide a with { x: 3 y: 4 }
    provide b with 3 iff c
    requirement fine needs d
}
""",
        """\
model.rscd:3:33: error[syntax]: expected 'identifier:', 'timeout:', 'max_age:' or 'type:' after 'with'
    3 |         outgoing message a with typ: double
      |                                 ^^^ did you mean 'type'?
model.rscd:4:33: error[syntax]: expected 'identifier:', 'rate:', 'stop:' or 'type:' after 'with'
    4 |         incoming message b with identifier "/b", type: T
      |                                 ^^^^^^^^^^ write 'identifier:' with its colon
model.rscd:5:35: error[syntax]: expected ',' and 'response:'
    5 |         service c with request: T response: U
      |                                   ^^^^^^^^ a ',' is missing before it
model.rscd:6:9: error[syntax]: expected 'incoming message', 'outgoing message', 'outgoing transform', 'outgoing service', 'outgoing action', 'service', 'action', 'behaviour', 'requirement', 'provide', 'constant', 'parameter', 'condition', 'function' or 'prefer'
    6 |         outgong message d with type: none
      |         ^^^^^^^ did you mean 'outgoing'?
model.rscd:7:9: error[syntax]: expected 'incoming message', 'outgoing message', 'outgoing transform', 'outgoing service', 'outgoing action', 'service', 'action', 'behaviour', 'requirement', 'provide', 'constant', 'parameter', 'condition', 'function', 'prefer' or '}'
    7 |         message e with type: none
      |         ^^^^^^^ write 'incoming message' or 'outgoing message'
model.rscd:9:24: error[syntax]: expected ':' after the name of the variable
    9 |             variable x integer
      |                        ^^^^^^^ write 'variable x: integer'
model.rscd:10:36: error[syntax]: expected a whole number
   10 |             variable y: integer(0..z) = 3
      |                                    ^
model.rscd:12:20: error[syntax]: expected 'request', 'response', 'feedback', 'error', 'cancel', 'cancelled' or 'timeout' after 'on'
   12 |                 on respnse from a goto t
      |                    ^^^^^^^ did you mean 'response'?
model.rscd:13:43: error[syntax]: expected 'state', 'on', 'transition', 'after', 'retry' or '}'
   13 |                 on response from a goto t if x
      |                                           ^^ 'if' comes before 'do' and 'goto'
model.rscd:14:28: error[syntax]: expected 'if', 'do', 'goto', 'state', 'on', 'transition', 'after', 'retry' or '}'
   14 |                 transition iff x goto t
      |                            ^^^ did you mean 'if'?
model.rscd:17:20: error[syntax]: 'initial' comes before 'marked'
   17 |             marked initial state t { }
      |                    ^^^^^^^
model.rscd:18:47: error[syntax]: expected ':=' after the variable
   18 |             state u { on response from a do x = 3 }
      |                                               ^ write ':=' to assign
model.rscd:21:17: error[syntax]: expected '{' or 'from' after the name of the component
   21 |     component B frm lib import C
      |                 ^^^ did you mean 'from'?
model.rscd:23:11: error[syntax]: expected ':' after the property name
   23 |         x double
      |           ^^^^^^
model.rscd:25:9: error[syntax]: expected a type after ':'
   25 |         z: integer
      |         ^
model.rscd:28:21: error[syntax]: expected '->'
   28 |         value >= 10 free
      |                     ^^^^
model.rscd:29:17: error[syntax]: expected a value after '>'
   29 |         value > -> foo
      |                 ^^
model.rscd:30:15: error[syntax]: '==' is not an operator
   30 |         value == 3 -> bar
      |               ^^ write '='
model.rscd:32:9: error[syntax]: expected the name of the value after '->'
   32 |         default -> x
      |         ^^^^^^^
model.rscd:35:5: error[syntax]: expected the name of the ROS package after 'from'
   35 |     requirement a + 1 needs d
      |     ^^^^^^^^^^^
model.rscd:35:17: error[syntax]: expected the name of a communication before 'needs'
   35 |     requirement a + 1 needs d
      |                 ^^^^^
model.rscd:36:20: error[syntax]: expected 'needs' or 'disables'
   36 |     requirement a.b, c needs d
      |                    ^ write several in braces: { …, … }
model.rscd:37:27: error[syntax]: expected ',' or '}'
   37 |     provide a with { x: 3 y: 4 }
      |                           ^ a ',' is missing before it
model.rscd:38:22: error[syntax]: expected 'if', 'component', 'requirement', 'provide', 'datatype', 'interface', 'constant', 'parameter', 'condition', 'function', 'prefer', 'assume', 'stop', 'for' or '}'
   38 |     provide b with 3 iff c
      |                      ^^^ did you mean 'if'?
""",
    ),
    "declarations in the wrong block": (
        """\
robot R {
    component A {
        datatype object T { x: double }
        stop with m
        behaviour {
            incoming message m with type: T
            state s {
                variable v: boolean
            }
        }
    }
}
""",
        """\
model.rscd:3:9: error[misplaced]: 'datatype' is not allowed inside 'component A'
    3 |         datatype object T { x: double }
      |         ^^^^^^^^
model.rscd:2:5: note: it is opened here
model.rscd:4:9: error[misplaced]: 'stop' is not allowed inside 'component A'
    4 |         stop with m
      |         ^^^^
model.rscd:2:5: note: it is opened here
model.rscd:6:13: error[misplaced]: 'incoming' is not allowed inside 'behaviour'
    6 |             incoming message m with type: T
      |             ^^^^^^^^
model.rscd:5:9: note: it is opened here
model.rscd:8:17: error[misplaced]: 'variable' is not allowed inside 'state s'
    8 |                 variable v: boolean
      |                 ^^^^^^^^
model.rscd:7:13: note: it is opened here
""",
    ),
    "names that are missing": (
        """\
robot R {
    component {
    }
    component A from lib import
    component B {
        behaviour {
            initial state s {
                on request to
                on response from goto t
                transition if
                transition goto
            }
            state {
            }
        }
    }
    requirement never
    requirement a needs
    provide a with
}
""",
        """\
model.rscd:2:15: error[syntax]: expected a name for the component
    2 |     component {
      |               ^
model.rscd:5:5: error[syntax]: expected the name of a component after 'import'
    5 |     component B {
      |     ^^^^^^^^^
model.rscd:9:17: error[syntax]: expected the name of a communication
    9 |                 on response from goto t
      |                 ^^
model.rscd:9:34: error[syntax]: expected the name of a communication
    9 |                 on response from goto t
      |                                  ^^^^
model.rscd:11:17: error[syntax]: expected a condition after 'if'
   11 |                 transition goto
      |                 ^^^^^^^^^^
model.rscd:12:13: error[syntax]: expected the name of a state after 'goto'
   12 |             }
      |             ^
model.rscd:13:19: error[syntax]: expected a name for the state
   13 |             state {
      |                   ^
model.rscd:18:5: error[syntax]: expected a condition after 'never' or 'always'
   18 |     requirement a needs
      |     ^^^^^^^^^^^
model.rscd:19:5: error[syntax]: expected a condition after 'needs'
   19 |     provide a with
      |     ^^^^^^^
model.rscd:20:1: error[syntax]: expected a value or '{'
   20 | }
      | ^
""",
    ),
    "a second robot": (
        """\
robot R {
    requirement a nees b
}
library L {
    requirement faulty
}
""",
        """\
model.rscd:2:19: error[syntax]: expected 'needs' or 'disables'
    2 |     requirement a nees b
      |                   ^^^^ did you mean 'needs'?
model.rscd:4:1: error[several-robots]: a file holds one robot or library, and there is a robot above
    4 | library L {
      | ^^^^^^^ move this to a file of its own
""",
    ),
    "a robot's statements in a library": (
        """\
library L {
    component A { }
    requirement a needs b
    provide a with 3
    component B { }
}
""",
        """\
model.rscd:3:5: error[misplaced]: a library itself cannot contain requirements: write this in a component of it
    3 |     requirement a needs b
      |     ^^^^^^^^^^^
model.rscd:4:5: error[misplaced]: a library itself cannot contain provided data: write this in a component of it
    4 |     provide a with 3
      |     ^^^^^^^
""",
    ),
    "no robot at all": (
        """\
component A { }
""",
        """\
model.rscd:1:1: error[syntax]: expected 'robot' or 'library'
    1 | component A { }
      | ^^^^^^^^^
""",
    ),
    "a misspelt robot": (
        """\
robt R {
    requirement a nees b
}
""",
        """\
model.rscd:1:1: error[syntax]: expected 'robot' or 'library'
    1 | robt R {
      | ^^^^ did you mean 'robot'?
model.rscd:2:19: error[syntax]: expected 'needs' or 'disables'
    2 |     requirement a nees b
      |                   ^^^^ did you mean 'needs'?
""",
    ),
    "a robot without name": (
        """\
robot {
    requirement a nees b
}
""",
        """\
model.rscd:1:7: error[syntax]: expected a name for the robot
    1 | robot {
      |       ^
model.rscd:2:19: error[syntax]: expected 'needs' or 'disables'
    2 |     requirement a nees b
      |                   ^^^^ did you mean 'needs'?
""",
    ),
    "junk between declarations": (
        """\
robot R {
    42
    component A { } foo bar
    component B { ( }
    requirement a needs b ) or c
}
""",
        """\
model.rscd:2:5: error[syntax]: expected 'component', 'requirement', 'provide', 'datatype', 'interface', 'constant', 'parameter', 'condition', 'function', 'prefer', 'assume', 'stop', 'for' or '}'
    2 |     42
      |     ^^
model.rscd:3:21: error[syntax]: expected 'component', 'requirement', 'provide', 'datatype', 'interface', 'constant', 'parameter', 'condition', 'function', 'prefer', 'assume', 'stop', 'for' or '}'
    3 |     component A { } foo bar
      |                     ^^^
model.rscd:4:19: error[syntax]: expected 'incoming message', 'outgoing message', 'outgoing transform', 'outgoing service', 'outgoing action', 'service', 'action', 'behaviour', 'requirement', 'provide', 'constant', 'parameter', 'condition', 'function', 'prefer' or '}'
    4 |     component B { ( }
      |                   ^
model.rscd:5:27: error[syntax]: expected 'to start', 'component', 'requirement', 'provide', 'datatype', 'interface', 'constant', 'parameter', 'condition', 'function', 'prefer', 'assume', 'stop', 'for' or '}'
    5 |     requirement a needs b ) or c
      |                           ^
""",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_messages(case: str) -> None:
    text, expected = CASES[case]
    assert faults(text) == expected


def test_the_rest_of_the_file_is_in_the_tree() -> None:
    tree, _ = read(CASES["two faulty declarations of every block"][0])
    assert tree is not None
    assert [shown(d) for d in tree.declarations] == [
        "Component(A, [Message(outgoing, d, -, none, -), Behaviour([State(s, True, False,"
        " [ResultTransition([response], [a], -, [], t), Tau(-, [], -),"
        " ResultTransition([error], [c], -, [], s)]), State(t, True, True, []),"
        " State(u, False, False, [])])])",
        "Object(T, [Property(z, integer)])",
        "Enum(E, double, [EnumRule(-, x)])",
        "Provide(b, 3, -)",
        "Requirement(needs, [fine], d)",
    ]


def test_what_was_skipped_is_known_by_its_words() -> None:
    tree, _ = read(CASES["two faulty declarations of every block"][0])
    assert tree is not None
    # Declared in faulty declarations: nobody shall call these unknown.
    assert {"a", "b", "c", "e", "x", "y", "B", "foo", "bar"} <= tree.broken
    assert "fine" not in tree.broken


def test_declarations_in_the_wrong_block_are_given_to_the_right_one() -> None:
    tree, _ = read(CASES["declarations in the wrong block"][0])
    assert tree is not None
    assert [shown(d) for d in tree.declarations] == [
        "Component(A, [Behaviour([State(s, False, False, []), Variable(False, v, boolean, -)]),"
        " Message(incoming, m, -, T, -)])",
        "Object(T, [Property(x, double)])",
        "Stop(m)",
    ]


def test_after_a_hundred_errors_there_is_one_more_and_no_tree() -> None:
    tree, diagnostics = read("robot R {\n" + "requirement\n" * 300 + "}")
    assert tree is None
    assert [d.code for d in diagnostics] == ["syntax"] * 100 + ["too-many-errors"]
