"""Operators bind as the language says, and the tree of any expression can be walked."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from syntax_support import expression, faults, shown

from robosc.syntax.nodes import Access, BinaryNode, ExprNode, LiteralNode, UnaryNode


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("a => b => c", "(a => (b => c))"),
        ("a or b => c or d", "((a or b) => (c or d))"),
        ("a or b and c or d", "((a or (b and c)) or d)"),
        ("a = b and c != d", "((a = b) and (c != d))"),
        ("a = b = c", "((a = b) = c)"),
        ("a != b = c", "((a != b) = c)"),
        ("a < b = c >= d", "((a < b) = (c >= d))"),
        ("a < b <= c", "((a < b) <= c)"),
        ("a + b < c - d", "((a + b) < (c - d))"),
        ("a - b - c + d", "(((a - b) - c) + d)"),
        ("a + b * c - d / e", "((a + (b * c)) - (d / e))"),
        ("a / b / c", "((a / b) / c)"),
        ("!a and b", "((!a) and b)"),
        ("!a = b", "((!a) = b)"),
        ("-a * b", "((-a) * b)"),
        ("a - -b", "(a - (-b))"),
        ("a--1", "(a - (-1))"),
        ("!!a", "(!(!a))"),
        ("-(a + b) * c", "((-(a + b)) * c)"),
        ("(a => b) => c", "((a => b) => c)"),
        ("a and (b or c)", "(a and (b or c))"),
        ("((a))", "a"),
        ("a=!b", "(a = (!b))"),
        ("a<-1", "(a < (-1))"),
        ("a.b[0].c[1][2] > 0", "(a.b[0].c[1][2] > 0)"),
        ("a . b [ 0 ] = c", "(a.b[0] = c)"),
        ("^value = value", "(value = value)"),
    ],
)
def test_operators(text: str, tree: str) -> None:
    assert shown(expression(text)) == tree


_OPERATORS = [["=>"], ["or"], ["and"], ["=", "!="], ["<", "<=", ">", ">="], ["+", "-"], ["*", "/"]]
_LEVEL = {op: level for level, ops in enumerate(_OPERATORS) for op in ops}


def _by_recursive_descent(tokens: list[str], level: int = 0) -> str:
    """A second, plain implementation: one level of precedence per call."""
    if level == len(_OPERATORS):
        token = tokens.pop(0)
        if token in "!-":
            return f"({token}{_by_recursive_descent(tokens, level)})"
        if token == "(":
            inner = _by_recursive_descent(tokens)
            assert tokens.pop(0) == ")"
            return inner
        return token
    left = _by_recursive_descent(tokens, level + 1)
    while tokens and tokens[0] in _OPERATORS[level]:
        operator = tokens.pop(0)
        right = _by_recursive_descent(tokens, 0 if operator == "=>" else level + 1)
        left = f"({left} {operator} {right})"
    return left


_operands = st.sampled_from(["a", "b", "c"])
_tokens = st.recursive(
    _operands.map(lambda a: [a]),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(sorted(_LEVEL)), inner).map(
            lambda t: [*t[0], t[1], *t[2]]
        ),
        st.tuples(st.sampled_from("!-"), _operands).map(list),
        inner.map(lambda t: ["(", *t, ")"]),
    ),
    max_leaves=20,
)


@settings(max_examples=300)
@given(_tokens)
def test_any_expression_is_read_as_a_recursive_descent_would(tokens: list[str]) -> None:
    assert shown(expression(" ".join(tokens))) == _by_recursive_descent(list(tokens))


def height(node: ExprNode) -> int:
    match node:
        case BinaryNode(left=left, right=right):
            return 1 + max(height(left), height(right))
        case UnaryNode(operand=operand):
            return 1 + height(operand)
        case LiteralNode() | Access():
            return 1


def leaves(node: ExprNode) -> list[str]:
    if isinstance(node, BinaryNode):
        return leaves(node.left) + leaves(node.right)
    return [shown(node)]


@pytest.mark.parametrize("operator", ["and", "or"])
def test_long_chains_of_one_connective_are_low_trees(operator: str) -> None:
    names = [f"n{i}" for i in range(5_000)]
    tree = expression(f" {operator} ".join(names))
    assert height(tree) < 100
    assert leaves(tree) == names


def test_short_chains_are_left_associative() -> None:
    tree: ExprNode = expression(" or ".join(["a"] * 64))
    for _ in range(63):
        assert isinstance(tree, BinaryNode)
        assert isinstance(tree.right, Access)
        tree = tree.left


@pytest.mark.parametrize("levels", [199, 200])
def test_nesting_is_limited(levels: int) -> None:
    text = "a" + " + a" * levels
    message = faults(f"robot R {{ requirement always {text} > 0 }}")
    assert ("error[too-deep]" in message) == (levels + 2 > 200)


@pytest.mark.parametrize("text", ["(" * 300 + "a" + ")" * 300, "!" * 300 + "a", "- " * 300 + "a"])
def test_what_nests_too_deep_is_one_clear_error(text: str) -> None:
    message = faults(f"robot R {{ requirement always {text}\n requirement a needs b }}")
    assert message.count("error[") == 1
    assert "error[too-deep]: this expression is nested more than 200 levels deep" in message


@pytest.mark.parametrize("levels", [59, 60, 61])
@pytest.mark.parametrize(
    "text",
    ["a = ({})", "({}) => a", "!{}", "1 / ({})", "a or {}", "1 - ({})", "- {}", "{} / 2", "{} % 2"],
)
def test_brackets_that_are_needed_are_limited(text: str, levels: int) -> None:
    whole = "a"
    for _ in range(levels):
        whole = text.format(whole)
    message = faults(f"robot R {{ requirement always {whole} }}")
    few = "or" in text
    assert ("nested more than 60 levels deep" in message) == (levels > 60 and not few)


def test_a_chain_needs_no_brackets() -> None:
    for chain in (" + a" * 150, " and a" * 1000, " - a" * 150):
        assert faults(f"robot R {{ requirement always a{chain} }}").count("too-deep") == 0


def test_parentheses_alone_make_no_tree_higher() -> None:
    assert shown(expression("(" * 200 + "a" + ")" * 200)) == "a"
