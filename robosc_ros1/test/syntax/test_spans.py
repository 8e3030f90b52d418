"""Nodes and diagnostics point at exactly the text that they are about."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest
from large_model import large_model
from syntax_support import expression, parsed, read

from robosc.source import Source, Span
from robosc.syntax.nodes import (
    Access,
    ActionNode,
    AssignmentNode,
    BinaryNode,
    MessageNode,
    Name,
    ResultTransitionNode,
    ServiceNode,
)
from robosc.syntax.parser import parse

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*/*.rscd"))

MODEL = """\
robot R {
\tcomponent A { // the only one
        initial
    }
    component B { outgoing  message m with type: array ( T ) links  ^l
      behaviour {
        variable  v : integer ( - 3 .. 4 )  = - 1
        initial marked  state s {
            on response  from B . m if ( v = 1 ) do v := value , w := ( 2 )  goto s }
        transition  if v > 2
        transition
      }
    }
    component C from L import D with prefix: "/p"
    requirement  { a , b.c }  needs ( d  or e )
    provide  m with { x : { } , y: - z [ 0 ] . q }  if ( ! v )
    datatype  enum E from  integer to { value  > 1 -> one  default -> two }
}  """


def nodes(node: Any) -> Iterator[Any]:
    if isinstance(node, tuple):
        for part in node:
            yield from nodes(part)
    elif is_dataclass(node):
        yield node
        for field in fields(node):
            if field.compare:
                yield from nodes(getattr(node, field.name))


def test_every_node_spans_its_text_and_lies_in_its_parent() -> None:
    tree = parsed(MODEL.replace("        initial\n", ""))
    found = {(type(node).__name__, node.span.text) for node in nodes(tree)}
    for kind, text in [
        ("ComponentNode", "component A { // the only one\n    }"),
        ("MessageNode", "outgoing  message m with type: array ( T ) links  ^l"),
        ("ArrayTypeNode", "array ( T )"),
        ("NamedTypeNode", "T"),
        ("Name", "^l"),
        ("VariableNode", "variable  v : integer ( - 3 .. 4 )  = - 1"),
        ("BasicTypeNode", "integer ( - 3 .. 4 )"),
        ("UnaryNode", "- 1"),
        ("Access", "B . m"),
        ("BinaryNode", "v = 1"),
        ("AssignmentNode", "w := ( 2 )"),
        ("TauNode", "transition  if v > 2"),
        ("TauNode", "transition"),
        ("ImportNode", 'component C from L import D with prefix: "/p"'),
        ("StringNode", '"/p"'),
        ("RequirementNode", "requirement  { a , b.c }  needs ( d  or e )"),
        ("DataObjectNode", "{ x : { } , y: - z [ 0 ] . q }"),
        ("DataFieldNode", "y: - z [ 0 ] . q"),
        ("DataObjectNode", "{ }"),
        ("UnaryNode", "- z [ 0 ] . q"),
        ("ProvideNode", "provide  m with { x : { } , y: - z [ 0 ] . q }  if ( ! v )"),
        ("EnumNode", "datatype  enum E from  integer to { value  > 1 -> one  default -> two }"),
        ("EnumRuleNode", "value  > 1 -> one"),
        ("EnumRuleNode", "default -> two"),
        ("FileNode", MODEL.replace("        initial\n", "").rstrip()),
    ]:
        assert (kind, text) in found


@pytest.mark.parametrize("model", [*EXAMPLES, "large"], ids=lambda p: Path(p).stem)
def test_spans_nest_and_follow_the_order_of_the_text(model: Path | str) -> None:
    text = large_model(12) if isinstance(model, str) else model.read_text()
    tree, faults = parse(Source("model.rscd", text))
    assert tree is not None
    assert not faults

    def check(node: Any) -> None:
        inner = _parts(node)
        for part in inner:
            assert node.span.start <= part.span.start < part.span.end <= node.span.end
            check(part)
        if not isinstance(node, Access | BinaryNode) and _in_order(node):
            assert [p.span.start for p in inner] == sorted(p.span.start for p in inner)

    check(tree)


def _parts(node: Any) -> list[Any]:
    found: list[Any] = []
    for field in fields(node):
        value = getattr(node, field.name)
        if field.compare:
            found += [
                v for v in (value if isinstance(value, tuple) else [value]) if is_dataclass(v)
            ]
    return found


def _in_order(node: Any) -> bool:
    # 'e disables c' holds the communications before the condition, a component the numbers of its
    # copies last, a state what it performs, a requirement its name; the attributes of a
    # communication may stand in any order.
    last = any(getattr(node, name, None) for name in ("indexes", "performs", "title"))
    free = isinstance(node, MessageNode | ServiceNode | ActionNode)
    return getattr(node, "kind", "") != "disables" and not last and not free


def test_names_span_their_text_without_the_escape() -> None:
    tree = parsed(MODEL.replace("        initial\n", ""))
    for node in nodes(tree):
        if isinstance(node, Name):
            assert node.span.text.removeprefix("^") == node.text


def test_operators_and_events_have_places_of_their_own() -> None:
    tree = expression("a  and  b")
    assert isinstance(tree, BinaryNode)
    assert tree.operator_span.text == "and"
    (component,) = parsed(
        "robot R { component A { behaviour { on  feedback from a do b := c } } }"
    ).declarations
    (transition,) = component.items[0].items  # type: ignore[union-attr]
    assert isinstance(transition, ResultTransitionNode)
    assert transition.events[0].span.text == "feedback"
    assert isinstance(transition.assignments[0], AssignmentNode)


def test_lines_and_columns_count_characters_from_one() -> None:
    source = Source("m", "robot R {\n\t/* é€ */ requirement a needs b\n}")
    tree, _ = parse(source)
    assert tree is not None
    span = tree.declarations[0].span
    assert (span.line, span.column, span.end_line, span.end_column) == (2, 11, 2, 32)
    assert Span(source, 0, 5).text == "robot"


def test_a_fault_at_the_end_points_behind_the_last_character() -> None:
    _, (fault,) = read("robot R {\n  component A   // open\n\n\n")
    assert (fault.span.line, fault.span.column) == (2, 14)
