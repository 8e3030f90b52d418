"""Titles of requirements: ids that are unique, and stand first wherever one is cited."""

from __future__ import annotations

from pathlib import Path

import pytest

from robosc import pipeline
from robosc.errors import ModelError, Severity
from robosc.model.entities import Robot

CART = """
    component Cart {{
        incoming message go with identifier: "/go", type: none
        incoming message halt with identifier: "/halt", type: none
        outgoing message near with identifier: "/near", type: boolean
        behaviour {{
            variable close: boolean
            initial marked state rest {{
                on response from near do close := value
                on request to {{ go, halt }}
            }}
        }}
        {inside}
    }}
"""


def robot(tmp_path: Path, statements: str, inside: str = "") -> Robot:
    path = tmp_path / "cart.rscd"
    path.write_text("robot R {" + CART.format(inside=inside) + statements + "}", encoding="utf-8")
    return pipeline.load(path).robot


def codes(tmp_path: Path, statements: str, inside: str = "") -> list[str]:
    with pytest.raises(ModelError) as caught:
        robot(tmp_path, statements, inside)
    return [
        diagnostic.code
        for diagnostic in caught.value.diagnostics
        if diagnostic.severity is Severity.ERROR
    ]


def test_the_title_stands_first_and_its_first_word_is_the_id(tmp_path: Path) -> None:
    found = robot(
        tmp_path,
        'requirement "SR-1 slow near people" go needs !Cart.close'
        ' requirement possible Cart.close  assume "A-1" near needs true'
        ' requirement "SR-2" possible Cart.rest',
    )
    (requirement,) = found.requirements
    assert requirement.id == "SR-1"
    assert requirement.text == "SR-1 slow near people: requirement go needs !Cart.close"
    assert [(goal.id, goal.text) for goal in found.goals] == [
        ("", "requirement possible Cart.close"),
        ("SR-2", "SR-2: requirement possible Cart.rest"),
    ]
    assert [(one.id, one.text) for one in found.assumptions] == [
        ("A-1", "A-1: assume near needs true")
    ]


@pytest.mark.parametrize("where", ["robot", "component", "for"])
def test_members_of_a_group_are_requirements_with_its_title(tmp_path: Path, where: str) -> None:
    group = """requirement "SR-2 all of it" {
        (go) needs Cart.rest
        halt needs Cart.close  // a comment
        { go, halt } needs Cart.rest
        Cart.close disables go
        never Cart.close and !Cart.rest
        possible Cart.close
    }"""
    plain = """requirement (go) needs Cart.rest
        requirement halt needs Cart.close
        requirement { go, halt } needs Cart.rest
        requirement Cart.close disables go
        requirement never Cart.close and !Cart.rest
        requirement possible Cart.close"""
    if where == "component":
        grouped, single = robot(tmp_path, "", group), robot(tmp_path, "", plain)
    elif where == "for":
        grouped = robot(tmp_path, f"for i in 1..1 {{ {group} }}")
        single = robot(tmp_path, f"for i in 1..1 {{ {plain} }}")
    else:
        grouped, single = robot(tmp_path, group), robot(tmp_path, plain)
    assert [(r.kind, r.communications, r.condition) for r in grouped.requirements] == [
        (r.kind, r.communications, r.condition) for r in single.requirements
    ]
    assert [goal.condition for goal in grouped.goals] == [goal.condition for goal in single.goals]
    assert [r.text for r in grouped.requirements] == [
        f"SR-2 all of it: {r.text}" for r in single.requirements
    ]
    assert {r.id for r in grouped.requirements} == {"SR-2"} == {goal.id for goal in grouped.goals}


@pytest.mark.parametrize(
    "statements",
    [
        'requirement "A x" go needs true requirement "A y" halt needs true',
        'requirement "A" { go needs true } requirement "A" { halt needs true }',
        'requirement "A" go needs true assume "A" near needs true',
        'requirement "A" go needs true prefer "A" halt over go',
        'requirement "A" go needs true requirement "A" possible Cart.close',
        'requirement "" go needs true',
        'requirement "  " { go needs true }',
    ],
)
def test_ids_are_unique_and_there(tmp_path: Path, statements: str) -> None:
    assert codes(tmp_path, statements) == ["duplicate-id"]


def test_an_id_in_a_component_and_in_the_robot_are_the_same(tmp_path: Path) -> None:
    inside = 'requirement "A" go needs true'
    assert codes(tmp_path, 'requirement "A" halt needs true', inside) == ["duplicate-id"]


def test_copies_of_a_statement_share_its_id(tmp_path: Path) -> None:
    found = robot(tmp_path, 'for i in 1..3 { requirement "A all" go needs i > 0 or Cart.rest }')
    assert [r.id for r in found.requirements] == ["A"] * 3
    assert found.requirements[1].text.endswith("(i = 2)")


def test_ids_of_libraries_have_the_name_of_the_import(tmp_path: Path) -> None:
    library = CART.format(inside='requirement "SR-1 slow" go needs !close')
    (tmp_path / "Base.rscd").write_text(f"library Base {{ {library} }}", encoding="utf-8")
    path = tmp_path / "two.rscd"
    path.write_text(
        """robot Two {
            component Left from Base import Cart with prefix: "left"
            component Right from Base import Cart with prefix: "right"
            requirement "SR-1 both" Left.go needs Right.rest
        }""",
        encoding="utf-8",
    )
    found = pipeline.load(path).robot
    assert sorted(r.id for r in found.requirements) == ["Left.SR-1", "Right.SR-1", "SR-1"]
    assert any(r.text.startswith("Left.SR-1 slow: requirement") for r in found.requirements)


def test_a_string_that_is_compared_is_no_title(tmp_path: Path) -> None:
    found = robot(tmp_path, 'requirement "a" = "b" disables go')
    assert (found.requirements[0].kind, found.requirements[0].id) == ("disables", "")


@pytest.mark.parametrize(
    ("group", "place"),
    [
        ('requirement "A" { go needs }', "}"),
        ('requirement "A" { go needs true go }', "}"),
        ('requirement "A" { requirement go needs true }', "requirement"),
    ],
)
def test_a_fault_in_a_group_is_told_at_its_place(tmp_path: Path, group: str, place: str) -> None:
    with pytest.raises(ModelError) as caught:
        robot(tmp_path, group)
    first = caught.value.diagnostics[0]
    assert first.span.text == place, first
