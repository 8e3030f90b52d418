"""What is advised to those who write what other languages have."""

from __future__ import annotations

import pytest

from robosc.language.attributes import ATTRIBUTES
from robosc.model.resolve import load
from robosc.source import Source

MODEL = """
robot R {
    component S {
        outgoing message bits with type: integer
        outgoing message level with type: double
        behaviour {
            variable b: integer
            variable f: boolean
            variable l: double
            initial marked state on {
                on response from bits do b := value, f := has(value, 4)
                on response from level do l := value
            }
        }
    }
    component M { incoming message go with type: none }
    %s
}
"""
BITS = "has(number, mask) tells whether bits are set"
NAMING = "write 'condition NAME = …', or 'constant NAME: type = …'"


@pytest.mark.parametrize(
    ("condition", "hint"),
    [
        ("S.b & 4 != 0", f"write 'and'; {BITS}"),
        ("S.b | 4 = 4", f"write 'or'; {BITS}"),
        ("S.f && S.f", "write 'and'"),
        ("S.f || S.f", "write 'or'"),
        ("S.b in (1, 2)", "write the values in braces: x in { a, b }"),
        ("S.b in [1, 2]", "write the values in braces: x in { a, b }"),
        ("S.b in 1..3", "write the values in braces: x in { a, b }"),
        ("S.b not in { 1, 2 }", "write !(x in { a, b })"),
        ("S.l between 0 and 1", "write a <= x and x <= b"),
        ("0 < S.l < 1", "write 0 < S.l and S.l < …"),
        (
            "S.l > 0 ? true : false",
            "there is no conditional expression: use 'provide … if', or 'if' in transitions",
        ),
        ("abs S.l < 1", "write abs(…)"),
        ("Math.abs(S.l) < 1", "write abs(…)"),
        ("pow(S.l, 2) > 1", "write x * x"),
        ("min([S.l, 1]) > 0", "write min(S.l, 1)"),
        ("max(S.l) > 0", "of an array: max(x for x in S.l)"),
    ],
)
def test_expressions_of_other_languages(condition: str, hint: str) -> None:
    assert hint_of(f"requirement go needs {condition}") == hint


@pytest.mark.parametrize(
    ("declaration", "hint"),
    [
        ("let ready = S.f", NAMING),
        ("define ready = S.f", NAMING),
        ("def ready = S.f", NAMING),
        ("macro ready = S.f", NAMING),
        ("const limit: double = 0.5", "did you mean 'constant'?"),
        ("constant limit = 0.5", "write 'constant NAME: type = …'"),
        ("condition ready: boolean = S.f", "write 'condition NAME = …': a condition has no type"),
        ("condition ready { S.f }", "write 'condition NAME = …': a condition has no type"),
        ("var x: double", "a component's behaviour has variables: 'variable NAME: type'"),
    ],
)
def test_declarations_of_other_languages(declaration: str, hint: str) -> None:
    assert hint_of(declaration) == hint


def hint_of(line: str) -> str | None:
    """The hint of the first diagnostic."""
    _, diagnostics = load(Source("m.rscd", MODEL % line))
    return diagnostics[0].hint


def in_order(communication: str) -> str:
    labels = ", ".join(f"{a.name}: …" for a in ATTRIBUTES if communication in a.communications)
    return f"in this order: with {labels}"


MESSAGE, SERVICE = in_order("outgoing"), in_order("service")
COMMAND = "the controller sends it: only what it receives or requests has a timeout"


@pytest.mark.parametrize(
    ("declaration", "hint"),
    [
        ("outgoing message m with type: double, timeout: 3 s", MESSAGE),
        ("outgoing message m with type: double timeout: 3 s", MESSAGE),
        ("outgoing message m with type: double, timeout 3 s", MESSAGE),
        ("outgoing message m with type: double, identifier: '/m'", MESSAGE),
        ("outgoing message m with timeout: 3 s, identifier: '/m', type: double", MESSAGE),
        ("outgoing message m with identifier: '/a', identifier: '/m', type: double", MESSAGE),
        ("outgoing message m with request: double", MESSAGE),
        ("incoming message m with type: none, identifier: '/m'",
         in_order("incoming")),
        ("service m with response: none, request: none", SERVICE),
        ("service m with request: none, response: none, timeout: 3 s", SERVICE),
        ("service m with request: none, response: none, feedback: none", SERVICE),
        ("service m with type: p/T, timeout: 3 s", MESSAGE),
        ("action m with request: none, feedback: none, response: none", f"{SERVICE}, feedback: …"),
        ("incoming message m with type: none, timeout: 3 s", COMMAND),
        ("incoming message m with type: none timeout: 3 s", COMMAND),
        ("outgoing message m with identifier: '/m' type: double", "a ',' is missing before it"),
        ("outgoing message m identifier: '/m', type: double", "'with' is missing before it"),
        # What comes before is another communication.
        ("service a with request: none, response: none links l service m timeout: 1 s",
         "'with' is missing before it"),
    ],
)  # fmt: skip
def test_attributes_in_a_wrong_order(declaration: str, hint: str) -> None:
    interface = "interface l use Trigger from std_srvs"
    text = f"robot R {{ component C {{ {declaration} }} {interface} }}"
    _, found = load(Source("m.rscd", text))
    assert [diagnostic.hint for diagnostic in found if diagnostic.code == "syntax"] == [hint]


@pytest.mark.parametrize("named", ["", 'identifier: "/go", '])
@pytest.mark.parametrize("kind", ["incoming", "outgoing"])
def test_a_timeout_of_a_command(named: str, kind: str) -> None:
    again = "timeout: 1 s, " if kind == "outgoing" else ""
    first = "incoming message a with type: none "
    message = f"{kind} message m with {named}{again}timeout: 3 s, type: none"
    _, (found, *_) = load(Source("m.rscd", f"robot R {{ component C {{ {first}{message} }} }}"))
    assert found.hint == (COMMAND if kind == "incoming" else MESSAGE)
