"""Short forms mean what they mean written out: random robots in both ways of writing.

``provide … else with``, ``initial state a if index = 1``, functions that return objects and ranges
of double parameters are written out here, by a reading of docs/language.md, next to persistent
variables. Synthesis by both engines and the simulator must not tell the two texts apart.
"""

from __future__ import annotations

import json
import operator
import random
import re
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from synthesis.subject import robot_of
from synthesis.test_oracle_differential import engines

from robosc.pipeline import explore, synthesize
from robosc.simulate.machines.machine import Machine
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor
from robosc.synthesis.documents import explore_json, synthesize_document
from robosc.synthesis.verify.verification import verify

pytestmark = pytest.mark.slow

COPIES = {
    "index = 1": {1}, "index > 1": {2, 3}, "index % 2 = 0": {2}, "true": {1, 2, 3},
    "index = 1 or index = 3": {1, 3}, "!(index < 3)": {3},
}  # fmt: skip
SIGNS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


class Both:
    """Draws a robot and writes it twice: in short, and out."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.low = self.rng.choice((-1.0, 0.1, 0.5))
        self.high = self.low + self.rng.choice((0.0, 0.5, 2.0))
        self.short, self.out = self._robot()

    def _leaf(self) -> tuple[str, str]:
        gate, number = self.rng.randint(1, 3), self.rng.randint(0, 2)
        kind = self.rng.randrange(4)
        if kind == 0:
            state = self.rng.choice(("closed", "opened"))
            return f"Gate[{gate}].{state}", f"Gate{gate}.{state}"
        if kind == 1:
            return f"Gate[{gate}].n < {number}", f"Gate{gate}.n < {number}"
        if kind == 2:
            return f"Gate[{gate}].n = {number}", f"Gate{gate}.n = {number}"
        sign = self.rng.choice(list(SIGNS))
        limit = self.rng.choice((self.low, self.high, self.low - 0.25, self.high + 0.5, 0.75))
        ends = {SIGNS[sign](end, limit) for end in (self.low, self.high)}
        text = f"far {sign} {limit}"
        return text, text if len(ends) == 2 else str(ends.pop()).lower()

    def _condition(self, depth: int = 2) -> tuple[str, str]:
        if depth == 0 or self.rng.random() < 0.3:
            return self._leaf()
        word = self.rng.choice(("and", "or", "=>"))
        (a, b), (c, d) = self._condition(depth - 1), self._condition(depth - 1)
        return f"({a} {word} {c})", f"({b} {word} {d})"

    def _gates(self) -> tuple[str, str]:
        where = self.rng.choice(list(COPIES))
        first, after = self.rng.randint(0, 2), self.rng.choice(("0", "1", "2 - n", "n"))
        stays = self.rng.choice(("persistent ", ""))
        body = f"""
            outgoing message call# with identifier: "/call_@", type: boolean
            incoming message open# with identifier: "/open_@", type: none
            behaviour {{
                {stays}variable n: integer(0..2) = {first}
                CLOSED closed WHEN {{ on response from call# if value do n := {after} goto opened }}
                OPENED opened OTHERWISE {{
                    on request to open# goto closed
                    on response from call# if !value do n := 1
                }}
            }}"""
        marked = self.rng.choice(("marked ", ""))
        words = {"CLOSED": f"initial {marked}state", "OPENED": "initial marked state"}
        whens = {"WHEN": f"if {where}", "OTHERWISE": f"if !({where})"}
        short = f"component Gate[1..3] {{ {_filled(body, {**words, **whens})} }}"
        short = short.replace("#", "").replace("@", "{index}")
        out = ""
        for number in (1, 2, 3):
            plain = {"CLOSED": f"{marked}state", "OPENED": "marked state"}
            begins = "CLOSED" if number in COPIES[where] else "OPENED"
            plain[begins] = f"initial {plain[begins]}"
            text = _filled(body, {**plain, "WHEN": "", "OTHERWISE": ""})
            text = text.replace("#", str(number)).replace("@", str(number))
            out += f"component Gate{number} {{ {text} }}\n"
        return short, out

    def _robot(self) -> tuple[str, str]:
        gates, gates_out = self._gates()
        head = """datatype object Spot { x: double y: double n: integer }
            interface spots use Spot from spot_msgs
            component Base {
                incoming message go with identifier: "/go", type: Spot links spots
            }
            stop with go
        """
        default = self.rng.choice((self.low, self.high))
        range_ = f"({self.low}..{self.high})"
        short = f"parameter far: double{range_} = {default}\n{head}{gates}"
        short += "function spot(x: double, k: integer): Spot = { x: x * 2.0, n: k, y: 0.5 }\n"
        short += "function twice(s: Spot): Spot = { x: 2.0 * s.x, n: s.n }\n"
        out = f"parameter far: double = {default}\n{head}{gates_out}"
        tried: list[str] = []
        chain, apart = [], []
        for number in range(self.rng.randint(2, 3)):
            last = number and self.rng.random() < 0.4
            (when, when_out), x = self._condition(), float(number)
            data = f"spot({x}, Gate[1].n)"
            data_out = f"{{ x: {x} * 2.0, n: Gate1.n, y: 0.5 }}"
            if self.rng.random() < 0.5:
                data = f"twice(spot({x}, 2))"
                data_out = f"{{ x: 2.0 * ({x} * 2.0), n: 2 }}"
            chain.append(f"with {data}" + ("" if last else f" if {when}"))
            holds = " and ".join([*(f"!({e})" for e in tried), *([] if last else [when_out])])
            apart.append(f"provide go with {data_out} if {holds}\n")
            tried.append(when_out)
            if last:
                break
        short += "provide go " + " else ".join(chain) + "\n"
        out += "".join(reversed(apart))  # no two of them hold together
        for name, name_out in (("go", "go"), ("Gate[2].open", "open2"), ("Gate[3].open", "open3")):
            needs, needs_out = self._condition()
            short += f"requirement {name} needs {needs}\n"
            out += f"requirement {name_out} needs {needs_out}\n"
        return f"robot Written {{ {short} }}", f"robot Written {{ {out} }}"


def _filled(text: str, words: dict[str, str]) -> str:
    return re.sub("|".join(words), lambda match: words[match[0]], text)


def named(document: Any) -> Any:
    """A document with the names of the robot that is written out."""
    text = re.sub(r"Gate\[(\d)\]\.(call|open)\b", r"\2\1", json.dumps(document))
    return json.loads(re.sub(r"Gate\[(\d)\]", r"Gate\1", text))


def solved(text: str, engine: str) -> Supervisor:
    return synthesize(robot_of(text), engine)


@pytest.mark.timeout(0)
@engines
def test_engines_do_not_tell_them_apart(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    empty = 0
    for seed in range(first, first + (50 if count is None else count)):
        both = Both(seed)
        short, out = solved(both.short, engine), solved(both.out, engine)
        assert short.empty == out.empty, both.short
        empty += short.empty
        if short.empty:
            continue
        guards = [synthesize_document(s)["guards"] for s in (short, out)]
        assert named(guards[0]) == guards[1], both.short
        documents = [json.loads("".join(explore_json(explore(s)))) for s in (short, out)]
        assert named(documents[0]) == documents[1], both.short
        assert verify(short).verified
    assert empty < (50 if count is None else count) / 2


@pytest.mark.timeout(0)
@pytest.mark.parametrize("execute", [False, True])
def test_simulations_do_not_tell_them_apart(execute: bool, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    sent = 0
    for seed in range(30 if count is None else count):
        both = Both(seed)
        supervisors = supervisor_of(both.short), supervisor_of(both.out)
        if supervisors[0].empty:
            continue
        first, second = (machine_maker(s, execute=execute)({}) for s in supervisors)
        rngs = random.Random(seed), random.Random(seed)
        for _ in range(12):
            taken = [m.draw(rng) for m, rng in zip((first, second), rngs, strict=True)]
            happened = [
                m.wait(t) if isinstance(t, float) else m.fire(*t) if t else []
                for m, t in zip((first, second), taken, strict=True)
            ]
            told = [[h.document() for h in found] for found in happened]
            assert named(told[0]) == told[1], both.short
            assert named(_shown(first)) == _shown(second), both.short
            sent += sum(h.is_command and h.name == "go" for h in happened[1])
    assert sent > 20


def _shown(machine: Machine) -> Any:
    state = machine.state
    commands = [(c.event.name, c.enabled, c.data) for c in machine.commands()]
    return json.loads(json.dumps([state.components, state.variables, commands]))
