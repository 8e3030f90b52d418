"""Controllers of several of a kind: one function for copies that are alike, and it means the same."""

from __future__ import annotations

import random
import re
from typing import Any

import pytest
from emit.generated_code import controller_class, controller_source, supervisor_of

from robosc.emit.controller import folding
from robosc.runtime.model import Controller
from robosc.runtime.values import Mismatch

DOCKS = """
robot Docks {
    interface park use Fibonacci from actionlib_tutorials
    interface place use SetBool from std_srvs
    datatype enum Load from integer to { value > 3 -> heavy value > 0 -> light default -> none }
    datatype object Request { data: boolean }
    datatype object Answer { success: boolean }

    component Yard {
        outgoing message open with identifier: "/open", timeout: 1 s, type: boolean
        incoming message bell with type: none
        behaviour {
            variable gate: boolean
            on response from open do gate := value
            on timeout from open do gate := false
            initial marked state day { on response from Dock[6].weight goto night }
            marked state night { on request to bell goto day }
        }
    }
    component Dock[1..6] {
        outgoing message weight with identifier: "/dock_{index}/weight", timeout: 2 s, type: Load
        incoming message lamp with identifier: "/dock_{index}/lamp", type: integer
        service lift with request: Request, response: Answer links place
        action park with request: none, response: none, feedback: none links park
        behaviour {
            variable load: Load
            variable lifted: boolean
            variable count: integer(0..3)
            on response from weight do load := value
            initial marked state empty {
                on request to park goto parking
            }
            state parking {
                on response from park goto full
                on error from park goto empty
                on cancelled from park goto empty
            }
            marked state full {
                on request to lift do count := 1
                on response from lift if value.success do lifted := value.success, count := 1
                on error from lift do count := 0
                transition if lifted goto leaving
            }
            marked state leaving { after 3 s if count < 2 goto empty }
        }
    }
    component Cart[1..4] {
        incoming message roll with identifier: "/cart_{index}/roll", type: double
        outgoing message seen with identifier: "/cart_{index}/seen", type: boolean
        behaviour {
            variable near: boolean
            on response from seen do near := value
            initial marked state on {}
        }
    }
    for i in 1..6 {
        requirement Dock[i].park needs Yard.gate and Dock[i].load != heavy
        requirement Dock[i].lift needs Dock[i].weight.fresh
        provide Dock[i].lamp with i
        provide Dock[i].lift with { data: Dock[i].load = heavy }
        prefer Dock[i].lift over Dock[i].lamp
    }
    for i in 2..4 {
        requirement Cart[i].roll needs !Cart[i-1].near
        provide Cart[i].roll with 0.5 if Cart[i].near
    }
    requirement Dock[5].lamp needs Yard.day
    requirement bell needs any(d.parking for d in Dock) and Yard.open.fresh
}
"""
"""The fifth dock has a requirement of its own, the sixth concerns the yard, the first cart has none
before it."""


CODE_AS_TEXT = """
robot Line {
    component Station[1..3] {
        incoming message serve with type: none
        incoming message say with identifier: "/say_{index}", type: string
        behaviour { initial marked state idle {} }
    }
    for i in 1..3 { requirement Station[i].serve needs Station[i].idle }
    provide Station[2].say with "self.requirement_1()"
}
"""


STATION = """
robot Line {{
    component Station[1..{count}] {{
        outgoing message button with type: none
        incoming message serve with type: none
        behaviour {{
            initial marked state idle {{ on response from button goto waiting }}
            marked state waiting {{ on request to serve goto idle }}
        }}
    }}
    for i in 1..{count} {{ requirement Station[i].serve needs Station[i].waiting }}
}}
"""


def loaded(source: str) -> Any:
    namespace: dict[str, Any] = {"__name__": "controller"}
    exec(source.replace("from ._runtime.", "from robosc.runtime."), namespace)
    (found,) = (c for c in namespace.values() if isinstance(c, type) and c.__base__ is Controller)
    return found


@pytest.fixture(scope="module")
def sources() -> tuple[str, str]:
    """The controller of the docks as it is, and with every copy written out."""
    supervisor = supervisor_of(DOCKS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(folding, "LEAST", 1_000)
        whole = controller_source(supervisor)
    return controller_source(supervisor), whole


def plain(row: Any) -> Any:
    """A row of a table without its methods."""
    if isinstance(row, tuple):
        return tuple(map(plain, row))
    return bool(row) if callable(row) else row


def test_the_tables_are_the_same(sources: tuple[str, str]) -> None:
    folded, whole = map(loaded, sources)
    for table in ("COMMUNICATIONS", "INPUTS", "COMMANDS", "TAUS", "AFTERS", "REQUIREMENTS"):
        rows = [list(map(plain, getattr(c, table))) for c in (folded, whole)]
        assert rows[0] == rows[1], table


def values(key: str, kind: str, chance: random.Random) -> Any:
    if kind == "response" and key.endswith("weight"):
        return chance.choice(["heavy", "light", "none"])
    if kind == "response" and key.endswith("lift"):
        return {"success": chance.random() < 0.7}
    return chance.random() < 0.7


def outcome(method: Any, *arguments: Any) -> Any:
    try:
        return method(*arguments)
    except Mismatch as mismatch:
        return str(mismatch)


def test_it_does_the_same(sources: tuple[str, str]) -> None:
    classes = [loaded(source) for source in sources]
    pair = [controller() for controller in classes]
    chance = random.Random(1)
    seen = set()
    for _ in range(1_500):
        number = chance.randrange(len(classes[0].INPUTS))
        entry = classes[0].INPUTS[number]
        value = values(entry.key, entry.kind, chance)
        told = [
            outcome(c.INPUTS[number].apply, one, value)
            for c, one in zip(classes, pair, strict=True)
        ]
        assert told[0] == told[1]
        for table in ("TAUS", "AFTERS"):
            for rows in zip(*(getattr(c, table) for c in classes), strict=True):
                paths = [row.step(one) for row, one in zip(rows, pair, strict=True)]
                assert paths[0] == paths[1]
                seen.add(paths[0])
        for commands in zip(*(c.COMMANDS for c in classes), strict=True):
            found = [
                (
                    command.guard(one),
                    command.synchronisation is None or command.synchronisation(one),
                    None if command.data is None else command.data(one),
                )
                for command, one in zip(commands, pair, strict=True)
            ]
            assert found[0] == found[1]
            if found[0][:2] == (True, True) and commands[0].apply and chance.random() < 0.5:
                seen.add(commands[0].key)
                told = [
                    outcome(command.apply, one) for command, one in zip(commands, pair, strict=True)
                ]
                assert told[0] == told[1]
        holds = [
            [r.holds(one) for r in c.REQUIREMENTS] for c, one in zip(classes, pair, strict=True)
        ]
        assert holds[0] == holds[1]
        assert vars(pair[0]) == vars(pair[1])
        assert pair[0].components() == pair[1].components()
        assert pair[0].variables() == pair[1].variables()
    assert {f"Dock[{n}].{c}" for n in range(1, 7) for c in ("park", "lift")} <= seen


def test_copies_that_differ_stay_as_they_are(sources: tuple[str, str]) -> None:
    ranges = re.findall(r"^(\w+) = .* in range\((\d+), (\d+)\)\]$", sources[0], re.MULTILINE)
    assert ranges == [
        ("DOCK_ROWS", "1", "5"),
        ("CART_ROWS", "2", "5"),
        ("REQUIREMENTS_1_ROWS", "1", "7"),
        ("REQUIREMENTS_2_ROWS", "2", "5"),
    ]
    assert "def can_request_dock_5_lamp(self):" in sources[0]
    assert "state[CART_I_MINUS_1_NEAR]" in sources[0]


def test_what_a_string_says_is_no_call() -> None:
    controller, context = controller_class(supervisor_of(CODE_AS_TEXT))
    assert not context.requirements  # the first one has no method
    (command,) = (c for c in controller.COMMANDS if c.key == "Station[2].say")
    assert command.data(controller()) == {"data": "self.requirement_1()"}


def test_more_copies_are_no_more_code() -> None:
    lines = [
        len(controller_source(supervisor_of(STATION.format(count=count))).splitlines())
        for count in (3, 12)
    ]
    assert lines[0] == lines[1]


@pytest.mark.parametrize(
    ("texts", "pattern"),
    [
        (["a 3 x", "a 4 x", "a 5 x"], "a ⟦1:0⟧ x"),
        (["a 2 9", "a 3 9", "a 4 9"], "a ⟦1:-1⟧ 9"),
        (["requirement_6()", "requirement_8()", "requirement_10()"], "requirement_⟦2:0⟧()"),
        (["x_6", "x_8", "x_10"], None),
        (["0.3", "0.4", "0.5"], None),
        (["3.5", "4.5", "5.5"], None),
        (["03", "04", "05"], None),
        (["3 a", "4 b", "5 c"], None),
        (["3", "4", "7"], None),
        (["⟦1:0⟧", "⟦1:0⟧", "⟦1:0⟧"], None),
    ],
)
def test_patterns(texts: list[str], pattern: str | None) -> None:
    (*found,) = folding.runs(list(enumerate(texts, 3)))
    assert found == ([] if pattern is None else [folding.Run(pattern, 3, 5)])


def test_runs_end_where_an_index_is_left_out_or_a_value_differs() -> None:
    indexes = [1, 2, 3, 4, 6, 7, 8, 9]
    values = [(n, f"v {n}" if n != 9 else "other") for n in indexes]
    assert list(folding.runs(values)) == [
        folding.Run("v ⟦1:0⟧", 1, 4),
        folding.Run("v ⟦1:0⟧", 6, 8),
    ]


def test_patterns_as_python() -> None:
    text = (
        "    def can_⟦1:0⟧(self):\n"
        '        """Return whether S[⟦1:0⟧] may (m.rscd:3)."""\n'
        "        # requirement S[i].go needs S[i-1].on (i = ⟦1:0⟧)  (m.rscd:4)\n"
        "        x_⟦1:0⟧ = self.s_⟦1:-1⟧ and self.other\n"
        '        return {"{a}": "S[⟦1:0⟧]", "b": ⟦1:0⟧, "c": 2 * ⟦1:1⟧, "d": "{"}\n'
    )
    body, names = folding.in_function(text)
    assert names == (("S_I_MINUS_1", 'f"s_{i - 1}"'),)
    assert body == (
        "    def can_i(self):\n"
        '        """Return whether S[i] may (m.rscd:3)."""\n'
        "        state = self.__dict__\n"
        "        # requirement S[i].go needs S[i-1].on  (m.rscd:4)\n"
        "        x_i = state[S_I_MINUS_1] and self.other\n"
        '        return {"{a}": f"S[{i}]", "b": i, "c": 2 * (i + 1), "d": "{"}\n'
    )
