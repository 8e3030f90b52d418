"""Which atoms alone decide a condition: those that change it if they alone come out otherwise."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from itertools import product

from synthesis.plants import supervisor_of

from robosc.expr.tree import Binary, Expr, Unary, VariableRef
from robosc.expr.types import BooleanType
from robosc.plant.part_names import LONG
from robosc.traces.coverage import Coverage
from robosc.traces.deciding_atoms import DecidedCondition
from robosc.traces.exact_steps import Steps
from robosc.traces.scripts import choose, requirement_rows, run_names

Meaning = Callable[[Mapping[str, bool]], bool]
BOOLEAN = BooleanType()
TABLES: Mapping[str, Callable[[bool, bool], bool]] = {
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
    "=>": lambda a, b: b if a else True,
    "=": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}


def condition(rng: random.Random, names: Sequence[str]) -> tuple[Expr, Meaning]:
    """A random condition in which each name occurs once, and what it means."""
    if len(names) == 1:
        (name,) = names
        return VariableRef("C", name, BOOLEAN), lambda values: values[f"C.{name}"]
    if rng.random() < 0.15:
        inner, means = condition(rng, names)
        return Unary("!", inner, BOOLEAN), lambda values: not means(values)
    word = rng.choice(["and", "and", "or", "or", "=>", "=", "!="])
    cut = rng.randrange(1, len(names))
    (left, first), (right, second) = condition(rng, names[:cut]), condition(rng, names[cut:])
    table = TABLES[word]
    return Binary(word, left, right, BOOLEAN), lambda v: table(first(v), second(v))


def deciding(means: Meaning, state: Mapping[str, bool]) -> tuple[bool, set[tuple[str, bool]]]:
    value = means(state)
    changing = {(k, v) for k, v in state.items() if means({**state, k: not v}) != value}
    return value, changing


def test_an_atom_decides_if_all_changes_with_it() -> None:
    for seed in range(200):
        rng = random.Random(seed)
        names = [f"a{n}" for n in range(rng.randint(1, 7))]
        expr, means = condition(rng, names)
        decided = DecidedCondition(expr, lambda e: e.key if isinstance(e, VariableRef) else "")
        unknown = {f"C.{name}" for name in names if rng.random() < 0.4}
        possible: dict[bool, set[tuple[str, bool]]] = {}
        known: dict[str, bool] = {f"C.{n}": rng.random() < 0.5 for n in names}
        for values in product((False, True), repeat=len(names)):
            state = dict(zip(known, values, strict=True))
            value, atoms = deciding(means, state)
            found, outcomes = decided.deciding(state)
            assert found == value, seed
            assert {(decided.atoms[n].text, held) for n, held, _ in outcomes} == atoms, seed
            assert {decided.comes_to(n, held) for n, held, _ in outcomes} <= {value, None}, seed
            if all(state[key] == known[key] for key in known if key not in unknown):
                possible.setdefault(value, set()).update(atoms)
        partial = decided.possible({k: v for k, v in known.items() if k not in unknown})
        assert {
            value: {(decided.atoms[n].text, held) for n, held, _ in outcomes}
            for value, outcomes in partial.items()
        } == possible, seed


def test_what_an_atom_decides_is_known_without_the_others() -> None:
    """Unless both sides of a comparison of conditions may be either."""
    a, b, c, d = (VariableRef("C", name, BOOLEAN) for name in "abcd")
    same = Binary("=", c, d, BOOLEAN)
    expr = Binary("=>", Binary("and", a, Unary("!", b, BOOLEAN), BOOLEAN), same, BOOLEAN)
    decided = DecidedCondition(expr, lambda e: "")
    assert [decided.comes_to(n, True) for n in range(4)] == [False, True, None, None]
    assert [decided.comes_to(n, False) for n in range(4)] == [True, False, None, None]


def test_a_chain_of_thousands() -> None:
    names = [f"a{n}" for n in range(20_000)]
    chain: Expr = VariableRef("C", names[0], BOOLEAN)
    for name in names[1:]:
        chain = Binary("or", chain, VariableRef("C", name, BOOLEAN), BOOLEAN)
    decided = DecidedCondition(chain, lambda e: "")
    none = {f"C.{name}": False for name in names}
    assert decided.deciding(none) == (False, {(n, False, "") for n in range(len(names))})
    assert decided.deciding({**none, "C.a7": True}) == (True, {(7, True, "")})
    assert decided.possible({**none, "C.a7": True, "C.a8": True}) == {True: frozenset()}


def test_a_long_requirement_is_told_by_its_beginning() -> None:
    """There are cases for each of its parts, so the texts would be as many times as long."""
    terms = " or ".join(f"C.x = {n}" for n in range(100))
    supervisor = supervisor_of(f"""
        component C {{
            incoming message go with type: none
            outgoing message level with type: integer(0..100)
            behaviour {{
                variable x: integer(0..100) = 0
                on response from level do x := value
                initial marked state s {{ on request to go }}
            }}
        }}
        requirement go needs {terms}
    """)
    texts = Coverage(Steps(supervisor)).cases.values()
    assert any("go.request, requirement go needs C.x = 0 or C.x = 1 or " in text for text in texts)
    assert max(map(len, texts)) < 2 * LONG


def test_scripts_show_a_requirement_violated_only_where_it_does_not_hold() -> None:
    """Not where one of its parts does not hold, nor met wherever one of them holds."""
    supervisor = supervisor_of("""
        component Base {
            outgoing message near with timeout: 1 s, type: boolean
            incoming message limit with type: double
            incoming message go with type: none
            behaviour {
                variable blocked: boolean
                initial marked state on { on response from near do blocked := value }
            }
        }
        requirement limit needs Base.blocked => value < 0.3
        requirement go needs !Base.blocked or near.silent
        provide limit with 0.2 if Base.blocked else with 1.0
    """)
    traces = choose(supervisor)
    shown = {
        text: (bool(met[0]), bool(violated[0]))
        for text, _, met, violated in requirement_rows(supervisor, traces)
    }
    assert shown == {
        "requirement limit needs Base.blocked => value < 0.3": (True, False),
        "requirement go needs !Base.blocked or near.silent": (True, True),
    }
    for row in requirement_rows(supervisor, traces):
        for name in row[3][0]:
            run = traces.runs[run_names(traces).index(name)]
            assert f"disabled go.request because {row[0]}" in str(run.lines)
