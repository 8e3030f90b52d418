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
        ("requirement a needs b to start", "Requirement(needs, [a], b, True)"),
        ("requirement { a, c } needs b to start", "Requirement(needs, [a, c], b, True)"),
        ("requirement b disables { a, c } to start", "Requirement(disables, [a, c], b, True)"),
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
            "action a with goals: replace, request: none, response: none, feedback: none links l",
            "Action(a, -, none, none, none, l, -, -, -, -, replace)",
        ),
        (
            "incoming message a with rate: 20 Hz, type: none",
            "Message(incoming, a, -, none, -, -, Rate(20))",
        ),
        (
            "incoming message a with rate: once, type: none",
            "Message(incoming, a, -, none, -, -, once)",
        ),
        (
            "incoming message a with stop: none, type: none",
            "Message(incoming, a, -, none, -, -, -, -, none)",
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
        ("persistent variable a: boolean", "Variable(True, a, boolean, -)"),
        ("variable a: boolean", "Variable(False, a, boolean, -)"),
        ("variable a: integer(0..9) = 3", "Variable(False, a, integer(0..9), 3)"),
        ("variable a: E = free", "Variable(False, a, E, free)"),
        ("variable a: double = -0.5", "Variable(False, a, double, (-0.5))"),
        ("state a { }", "State(a, False, False, [])"),
        ("initial state a { }", "State(a, True, False, [])"),
        ("marked state a { }", "State(a, False, True, [])"),
        ("initial marked state a { }", "State(a, True, True, [])"),
        ("transition else do n := 1", "Tau(Else(), [Assignment(n, 1)], -)"),
        ("transition", "Tau(-, [], -)"),
        ("transition goto b", "Tau(-, [], b)"),
        ("transition if a > 3 goto b", "Tau((a > 3), [], b)"),
        ("on request to a", "ResultTransition([request], [a], -, [], -)"),
        ("on response from A.b goto c", "ResultTransition([response], [A.b], -, [], c)"),
        (
            "on feedback from a if b do c := value, D.e := 1 + c goto f",
            "ResultTransition([feedback], [a], b, [Assignment(c, value), Assignment(D.e, (1 + c))], f)",
        ),
        (
            "on error from a do b := true",
            "ResultTransition([error], [a], -, [Assignment(b, True)], -)",
        ),
        (
            "on response, error from { a, B.c } goto b",
            "ResultTransition([response, error], [a, B.c], -, [], b)",
        ),
        ("on cancel to a goto b", "ResultTransition([cancel], [a], -, [], b)"),
    ],
)
def test_parts_of_a_behaviour(text: str, tree: str) -> None:
    found = declarations(f"component A {{ behaviour {{ {text} }} }}")
    assert found == [f"Component(A, [Behaviour([{tree}])])"]


def test_transitions_belong_to_their_state() -> None:
    text = "component A { behaviour { state s { on error from a goto t transition goto s } } }"
    state = "State(s, False, False, [ResultTransition([error], [a], -, [], t), Tau(-, [], s)])"
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
    assert "error[misplaced]: a library itself cannot contain" in faults(f"library L {{ {word} }}")


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("constant a: double = 0.2", "Constant(a, double, 0.2)"),
        ("constant a: array(double) = [1, b]", "Constant(a, array(double), Array([1, b]))"),
        ("parameter a: duration = 2 min", "Parameter(a, duration, Duration(2, min))"),
        ("condition a = b and c", "Condition(a, (b and c))"),
        ("prefer a over b", "Prefer([a], [b])"),
        ("prefer { a, B.c } over { d }", "Prefer([a, B.c], [d])"),
        (
            "prefer a except B over all except { c, S[1] } except d",
            "Prefer([a, Except([B])], [all, Except([c, S[1], Except([d])])])",
        ),
        ("requirement all except a needs b", "Requirement(needs, [all, Except([a])], b)"),
        ("requirement S[i] needs b", "Requirement(needs, [S[i]], b)"),
        ("requirement b disables { S[2], all } except a",
         "Requirement(disables, [S[2], all, Except([a])], b)"),
        (
            "for i in 1..6 { requirement S[i-1].go needs S[i].on for j in -2..2 { } }",
            "For(i, Range(1, 6), [Requirement(needs, [S[(i - 1)].go], Member(Element(S, i), [on])),"
            " For(j, Range(-2, 2), [])])",
        ),
        ("component A[0..3] { }", "Component(A, [], Range(0, 3))"),
        (
            "component A[1..2] from L import C with prefix: '/a', x: 0.2, y: 2 * b",
            "Import(A, L, C, '/a', [Argument(x, 0.2), Argument(y, (2 * b))], Range(1, 2))",
        ),
        ("component A { constant a: T = 1 }", "Component(A, [Constant(a, T, 1)])"),
        ("component A { parameter a: T = 1 }", "Component(A, [Parameter(a, T, 1)])"),
        ("component A { condition a = b }", "Component(A, [Condition(a, b)])"),
        (
            "component A { outgoing message a with identifier: '/a', timeout: 0.5 s, type: p/T }",
            "Component(A, [Message(outgoing, a, '/a', RosType(p, T), -, Duration(0.5, s))])",
        ),
        (
            "component A { action a with timeout: k, type: p/action/T }",
            "Component(A, [Action(a, -, RosType(p, T, action, action), RosType(p, T, action, action, 1),"
            " RosType(p, T, action, action, 2), -, k)])",
        ),
        (
            "component A { service a with request: L.T, response: p/msg/T links i }",
            "Component(A, [Service(a, -, L.T, RosType(p, T, msg), i)])",
        ),
        ("datatype object O { a: p/T b: array(L.T) }", "Object(O, [Property(a,"
         " RosType(p, T)), Property(b, array(L.T))])"),
        ("provide a with { b: [{ c: 2 s }, 1], d: [] }", "Provide(a, DataObject([DataField(b,"
         " Array([DataObject([DataField(c, Duration(2, s))]), 1])), DataField(d, Array([]))]), -)"),
        ("requirement A[3].b needs c", "Requirement(needs, [A[3].b], c)"),
        ("requirement a disables { A[i].b, c }", "Requirement(disables, [A[i].b, c], a)"),
        ("provide A[i + 1].b with c", "Provide(A[(i + 1)].b, c, -)"),
    ],
)  # fmt: skip
def test_statements_and_types_of_the_second_edition(text: str, tree: str) -> None:
    assert declarations(text) == [tree]


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("on timeout from a goto b", "ResultTransition([timeout], [a], -, [], b)"),
        ("on response from A[2].a", "ResultTransition([response], [A[2].a], -, [], -)"),
        ("after 0.5 s goto a", "After(Duration(0.5, s), -, [], a)"),
        ("after A.b if c do d := 1, e := 2 goto f",
         "After(A.b, c, [Assignment(d, 1), Assignment(e, 2)], f)"),
    ],
)  # fmt: skip
def test_transitions_of_the_second_edition(text: str, tree: str) -> None:
    found = declarations(f"component A {{ behaviour {{ state s {{ {text} }} }} }}")
    assert found == [f"Component(A, [Behaviour([State(s, False, False, [{tree}])])])"]


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("state s performs a then", "State(s, False, False, [], Performs(a, -, -, [], -))"),
        ("state s performs A.b with { x: 1 } then do c := value goto d { }",
         "State(s, False, False, [], Performs(A.b, -, DataObject([DataField(x, 1)]),"
         " [Assignment(c, value)], d))"),
        ("initial state s performs a meanwhile with b then goto c { retry }",
         "State(s, True, False, [Retry(-, -, -, -)], Performs(a, meanwhile, b, [], c))"),
        ("state s performs a then { retry 2 times every 5 s goto c else do d := 1 goto e.f }",
         "State(s, False, False, [Retry(2, Duration(5, s), c, Effect([Assignment(d, 1)], e.f))],"
         " Performs(a, -, -, [], -))"),
        ("state s performs a then { retry every A.b goto c }",
         "State(s, False, False, [Retry(-, A.b, c, -)], Performs(a, -, -, [], -))"),
    ],
)  # fmt: skip
def test_states_that_perform(text: str, tree: str) -> None:
    found = declarations(f"component A {{ behaviour {{ {text} }} }}")
    assert found == [f"Component(A, [Behaviour([{tree}])])"]


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("abs(x) < hypot(a.x, -1)", "(Call(abs, [x]) < Call(hypot, [a.x, (-1)]))"),
        ("now() + L.Way(value.a[0])", "(Call(now, []) + Call(L.Way, [value.a[0]]))"),
        ("!a in { b, c } or d", "(In((!a), [b, c]) or d)"),
        ("a + 1 in { 2 } = b", "(In((a + 1), [2]) = b)"),
        ("a[i+1].b[2].c", "Member(Element(a, (i + 1)), [b, 2, c])"),
        ("a[i][j]", "Element(Element(a, i), j)"),
        ("a[-30..30]", "Slice(a, (-30), 30)"),
        ("f(a)[i].b", "Member(Element(Call(f, [a]), i), [b])"),
        ("any(x > 0 for x in a)", "Aggregate(any, (x > 0), x, a, -)"),
        (
            "first(x for i, x in a if i > 2).b[0]",
            "Member(Aggregate(first, x, x, a, (i > 2), i), [b, 0])",
        ),
        ("length([x * 2 for x in [a]])", "Call(length, [Aggregate([, (x * 2), x, Array([a]), -)])"),
        (
            "count(s.on for s in S[1..3] if s.x = 1 or b) < 2",
            "(Aggregate(count, s.on, s, Slice(S, 1, 3), ((s.x = 1) or b)) < 2)",
        ),
        ("a = [1, [b]]", "(a = Array([1, Array([b])]))"),
        ("1.5 ms + 2 h", "(Duration(1.5, ms) + Duration(2, h))"),
    ],
)
def test_expressions_of_the_second_edition(text: str, tree: str) -> None:
    assert declarations(f"requirement c needs {text}") == [f"Requirement(needs, [c], {tree})"]
