"""Keywords are names wherever no ambiguity arises; five words always need the escape."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace

import pytest
from syntax_support import declarations, faults, parsed, read

from robosc.language import keywords
from robosc.language.keywords import BASIC_TYPES, RESERVED
from robosc.language.tokens import pattern
from robosc.syntax.nodes import ComponentNode, MessageNode, NamedTypeNode

KEYWORDS = sorted(keywords.KEYWORDS.keys() - RESERVED)

# Every place where a name may stand, with "@" for the name.
PLACES = {
    "robot": "robot @ { }",
    "component": "robot R { component @ { } }",
    "import": "robot R { component @ from @ import @ with prefix: 'a' }",
    "interface": "robot R { interface @ use @ from @ interface b use c from d }",
    "property": "robot R { datatype object O { @: double a: string @: none } }",
    "enum value": "robot R { datatype enum @ from double to { value > 3 -> @ default -> @ } }",
    "message": "robot R { component C { incoming message @ with type: none links @ } }",
    "service": "robot R { component C { service @ with request: T, response: T links @ } }",
    "action": (
        "robot R { component C { action @ with request: T, response: T, feedback: T links @"
        " behaviour { } } }"
    ),
    "variable": "robot R { component C { behaviour { variable @: E = @ variable b: E } } }",
    "state": (
        "robot R { component C { behaviour { initial marked state @ { transition goto @"
        " on request to @ do @ := @ goto @ on error from @ if @ goto @ } state @ { } } } }"
    ),
    "expression": "robot R { requirement @.@ = @ and @ + @ > @ disables @ requirement @ needs @ }",
    "requirement": "robot R { requirement { @, @.@ } needs @ requirement @ disables { @ } }",
    "provide": "robot R { provide @ with { @: @, @: { @: @ } } if @ provide @.@ with @ if @ }",
}


@pytest.mark.parametrize("place", PLACES)
def test_every_keyword_may_be_a_name(place: str) -> None:
    text = PLACES[place]
    assert [word for word in KEYWORDS if not _read_as_a_name(text, word)] == []


def _read_as_a_name(text: str, word: str) -> bool:
    """Whether the tree is that of the escaped word, and that of any other name renamed."""
    tree = _without_faults(text.replace("@", word))
    return tree == _without_faults(text.replace("@", f"^{word}")) == _renamed(text, word)


def _without_faults(text: str) -> object:
    tree, found = read(text)
    return None if found else tree


def _renamed(text: str, word: str) -> object:
    """The tree with an ordinary name, and then the word in its place."""

    def rename(node: object) -> object:
        if isinstance(node, tuple):
            return tuple(rename(part) for part in node)
        if is_dataclass(node) and not isinstance(node, type):
            changes = {f.name: rename(getattr(node, f.name)) for f in fields(node) if f.compare}
            return replace(node, **changes)
        return word if node == "zebra" else node

    return rename(parsed(text.replace("@", "zebra")))


@pytest.mark.parametrize("word", sorted(RESERVED))
def test_reserved_words_need_the_escape(word: str) -> None:
    text = f"robot R {{ datatype object O {{ {word}: double }} }}"
    tree, (fault,) = read(text)
    assert (fault.code, fault.hint) == ("reserved-name", f"write '^{word}'")
    assert fault.span.text == word
    assert tree == parsed(text.replace(word, f"^{word}"))


@pytest.mark.parametrize("word", sorted(BASIC_TYPES - {"array"}))
def test_a_basic_type_is_one_unless_escaped(word: str) -> None:
    text = f"robot R {{ component C {{ outgoing message m with type: ^{word} }} }}"
    assert isinstance(_message(text).type, NamedTypeNode)
    assert not isinstance(_message(text.replace("^", "")).type, NamedTypeNode)


def _message(text: str) -> MessageNode:
    (component,) = parsed(text).declarations
    assert isinstance(component, ComponentNode)
    (message,) = component.items
    assert isinstance(message, MessageNode)
    return message


def test_array_without_its_element_is_an_error() -> None:
    text = "robot R { datatype object O { a: array\n b: ^array } }"
    assert "expected '(' after 'array'" in faults(text)


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("requirement never needs a", "Requirement(needs, [never], a)"),
        ("requirement always disables a", "Requirement(disables, [a], always)"),
        ("requirement start needs start", "Requirement(needs, [start], start)"),
        ("requirement start.to needs to to start", "Requirement(needs, [start.to], to, True)"),
        ("requirement to disables to to start", "Requirement(disables, [to], to, True)"),
        ("requirement never.a disables b", "Requirement(disables, [b], never.a)"),
        ("requirement always = a disables b", "Requirement(disables, [b], (always = a))"),
        ("requirement never or a disables b", "Requirement(disables, [b], (never or a))"),
        ("requirement never a", "Requirement(never, [], a)"),
        ("requirement never never", "Requirement(never, [], never)"),
        ("requirement never (a)", "Requirement(never, [], a)"),
        ("requirement always -a < b", "Requirement(always, [], ((-a) < b))"),
        ("requirement always !a", "Requirement(always, [], (!a))"),
        ("requirement ^never needs a", "Requirement(needs, [never], a)"),
    ],
)
def test_never_and_always_are_keywords_only_before_an_expression(text: str, tree: str) -> None:
    assert declarations(text) == [tree]


def test_the_tree_tells_the_keyword_value_from_a_name() -> None:
    (plain,) = parsed("robot R { requirement a needs value }").declarations
    (escaped,) = parsed("robot R { requirement a needs ^value }").declarations
    assert plain == escaped
    assert [d.condition.root.escaped for d in (plain, escaped)] == [False, True]  # type: ignore[union-attr]


def test_a_name_may_begin_with_a_keyword() -> None:
    text = "component A { behaviour { variable valuex: doubles = orange on request to onward } }"
    assert declarations(text) == [
        "Component(A, [Behaviour([Variable(False, valuex, doubles, orange),"
        " ResultTransition([request], [onward], -, [], -)])])"
    ]


def test_a_keyword_with_an_underscore_is_one_word_of_the_grammar() -> None:
    with pytest.raises(KeyError, match="goal_timeout"):  # no keyword today
        pattern("goal_timeout ':'")
