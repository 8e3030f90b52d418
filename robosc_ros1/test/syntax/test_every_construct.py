"""Each construct of the language becomes the node that says it."""

from __future__ import annotations

import pytest
from syntax_support import declarations, faults, parsed, shown


@pytest.mark.parametrize("kind", ["robot", "library"])
def test_a_file_is_one_robot_or_one_library(kind: str) -> None:
    tree = parsed(f"{kind} Line_2 {{ }}")
    assert (tree.kind, tree.name.text, tree.declarations) == (kind, "Line_2", ())


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("component A { }", "Component(A, [])"),
        ("component A from lib import B", "Import(A, lib, B, -)"),
        ("component A from lib import B with prefix: '/left'", "Import(A, lib, B, '/left')"),
        ("interface twist use Twist from geometry_msgs", "Interface(twist, Twist, geometry_msgs)"),
        ("datatype object A { }", "Object(A, [])"),
        (
            "datatype object A { x: double y: B z: array(array(string)) }",
            "Object(A, [Property(x, double), Property(y, B), Property(z, array(array(string)))])",
        ),
        (
            "datatype enum E from double to { value >= 10 -> free default -> obstructed }",
            "Enum(E, double, [EnumRule((value >= 10), free), EnumRule(-, obstructed)])",
        ),
        (
            "datatype enum E from Scan to { value.ranges[0] < 0.5 -> near default -> far }",
            "Enum(E, Scan, [EnumRule((value.ranges[0] < 0.5), near), EnumRule(-, far)])",
        ),
        ("datatype enum E from none to { }", "Enum(E, none, [])"),
        ("requirement move needs a.b", "Requirement(needs, [move], a.b)"),
        ("requirement { a, B.c } needs d", "Requirement(needs, [a, B.c], d)"),
        ("requirement a.b = c disables d", "Requirement(disables, [d], (a.b = c))"),
        ("requirement a disables { b, c }", "Requirement(disables, [b, c], a)"),
        ("requirement never a and b", "Requirement(never, [], (a and b))"),
        ("requirement always !a", "Requirement(always, [], (!a))"),
        ("provide a with { }", "Provide(a, DataObject([]), -)"),
        ("provide A.b with 3 + c if d", "Provide(A.b, (3 + c), d)"),
        (
            "provide a with { x: { y: 1, z: 'q' }, w: b.c } if d or e",
            "Provide(a, DataObject([DataField(x, DataObject([DataField(y, 1), DataField(z, 'q')])),"
            " DataField(w, b.c)]), (d or e))",
        ),
    ],
)
def test_declarations_of_a_robot(text: str, tree: str) -> None:
    assert declarations(text) == [tree]


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        (
            "incoming message a with type: none",
            "Message(incoming, a, -, none, -)",
        ),
        (
            'outgoing message a with identifier: "/a/b", type: T links l',
            "Message(outgoing, a, '/a/b', T, l)",
        ),
        (
            "outgoing message a with identifier : '/x' , type : integer(-3 .. 4)",
            "Message(outgoing, a, '/x', integer(-3..4), -)",
        ),
        (
            "service a with request: T, response: boolean links l",
            "Service(a, -, T, boolean, l)",
        ),
        (
            "service a with identifier: 'b', request: none, response: none",
            "Service(a, 'b', none, none, -)",
        ),
        (
            "action a with request: none, response: double, feedback: string links l",
            "Action(a, -, none, double, string, l)",
        ),
        (
            "action a with identifier: 'b', request: T, response: U, feedback: V",
            "Action(a, 'b', T, U, V, -)",
        ),
        ("behaviour { }", "Behaviour([])"),
    ],
)
def test_parts_of_a_component(text: str, tree: str) -> None:
    assert declarations(f"component A {{ {text} }}") == [f"Component(A, [{tree}])"]


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("variable a: boolean", "Variable(a, boolean, -)"),
        ("variable a: integer(0..9) = 3", "Variable(a, integer(0..9), 3)"),
        ("variable a: E = free", "Variable(a, E, free)"),
        ("variable a: double = -0.5", "Variable(a, double, (-0.5))"),
        ("state a { }", "State(a, False, False, [])"),
        ("initial state a { }", "State(a, True, False, [])"),
        ("marked state a { }", "State(a, False, True, [])"),
        ("initial marked state a { }", "State(a, True, True, [])"),
        ("transition", "Tau(-, -)"),
        ("transition goto b", "Tau(-, b)"),
        ("transition if a > 3 goto b", "Tau((a > 3), b)"),
        ("on request to a", "ResultTransition(request, a, -, [], -)"),
        ("on response from A.b goto c", "ResultTransition(response, A.b, -, [], c)"),
        (
            "on feedback from a if b do c := value, D.e := 1 + c goto f",
            "ResultTransition(feedback, a, b, [Assignment(c, value), Assignment(D.e, (1 + c))], f)",
        ),
        ("on error from a do b := true", "ResultTransition(error, a, -, [Assignment(b, True)], -)"),
        ("on cancel to a goto b", "ResultTransition(cancel, a, -, [], b)"),
    ],
)
def test_parts_of_a_behaviour(text: str, tree: str) -> None:
    found = declarations(f"component A {{ behaviour {{ {text} }} }}")
    assert found == [f"Component(A, [Behaviour([{tree}])])"]


def test_transitions_belong_to_their_state() -> None:
    text = "component A { behaviour { state s { on error from a goto t transition goto s } } }"
    state = "State(s, False, False, [ResultTransition(error, a, -, [], t), Tau(-, s)])"
    assert declarations(text) == [f"Component(A, [Behaviour([{state}])])"]


def test_order_and_number_of_declarations_are_free() -> None:
    text = """
        requirement a needs b
        component A { behaviour { } incoming message a with type: none behaviour { } }
        component A { }
        requirement a needs b
    """
    assert [line.split("(")[0] for line in declarations(text)] == [
        "Requirement", "Component", "Component", "Requirement",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("literal", "value"),
    [
        ("0", 0),
        ("42", 42),
        ("18446744073709551615", 2**64 - 1),
        ("007", 7),
        ("4.25", 4.25),
        ("1e-3", 0.001),
        ("2.5E4", 25000.0),
        ("1E+2", 100.0),
        ("true", True),
        ("false", False),
        ('"a b"', "a b"),
        ("'a b'", "a b"),
        (r'"\n\t\\\"\' "', "\n\t\\\"' "),
        ('"// no comment"', "// no comment"),
        ('"/* no comment"', "/* no comment"),
        ('"é €"', "é €"),
    ],
)
def test_literals(literal: str, value: object) -> None:
    (line,) = declarations(f"requirement a needs {literal}")
    assert line == f"Requirement(needs, [a], {value!r})"


def test_comments_and_blanks_stand_anywhere() -> None:
    text = """// first
    robot/**/R/* { */{ // }
        requirement a // needs c
            needs /* not
            this */ b
    }
    // last"""
    assert shown(parsed(text).declarations) == "[Requirement(needs, [a], b)]"


def test_text_without_line_ends_or_with_windows_ones_means_the_same() -> None:
    text = "robot R {\n component A {\n }\n requirement a\n needs b\n}\n"
    assert parsed(text) == parsed(text.replace("\n", " ")) == parsed(text.replace("\n", "\r\n"))


@pytest.mark.parametrize("word", ["requirement a needs b", "provide a with 3"])
def test_a_library_says_nothing_about_control(word: str) -> None:
    assert "error[misplaced]: a library holds no" in faults(f"library L {{ {word} }}")
