"""Long guards read shared parts by names; with each name replaced they are the guards again."""

from __future__ import annotations

import random
import re
from collections.abc import Iterable
from itertools import product
from pathlib import Path

import pytest
import steep_families
from synthesis.plants import plant_of
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, NamedPart, StateRef
from robosc.lsp import synthesis_process
from robosc.plant import part_names
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.model_text import to_dsl
from robosc.plant.part_names import PartNames
from robosc.plant.step import holds
from robosc.report import supervisor_text
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.synthesis import synthesize
from robosc.synthesis.documents import synthesize_document

_NAME = re.compile(r"\bpart_[a-z]+\b")
MACHINES = steep_families.not_all_busy(6)


@pytest.fixture
def every_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """Names for all that guards share, however short."""
    monkeypatch.setattr(part_names, "LONG", 0)
    monkeypatch.setattr(part_names, "_LEAST_SAVED", -1000)


def without_names(text: str, parts: Iterable[tuple[str, str]]) -> str:
    """The text with what stands for each name, in which only earlier ones are read."""
    meanings: dict[str, str] = {}
    for name, condition in parts:
        assert name not in meanings
        meanings[name] = _NAME.sub(lambda found: f"({meanings[found[0]]})", condition)
    return _NAME.sub(lambda found: f"({meanings[found[0]]})", text)


def conditions(model: str, texts: Iterable[str]) -> list[Expr]:
    """Texts as the front end reads them."""
    body, _, end = model.rpartition("}")
    added = [f"requirement always {text}\n" for text in texts]
    robot = robot_of(body + "".join(added) + "}" + end)
    return [r.condition for r in robot.requirements[len(robot.requirements) - len(added) :]]


def some_condition(rng: random.Random, depth: int) -> Expr:
    if not depth or rng.random() < 0.15:
        leaf = StateRef(f"Machine{rng.randrange(6)}", "busy")
        return leaf if rng.random() < 0.7 else negation(leaf)
    parts = [some_condition(rng, depth - 1) for _ in range(rng.randrange(2, 5))]
    found = rng.choice([conjunction, disjunction])(parts)
    return negation(found) if rng.random() < 0.2 else found


@pytest.mark.parametrize("seed", range(8))
def test_random_guards_are_what_they_were(seed: int, every_part: None) -> None:
    rng = random.Random(seed)
    shared = [some_condition(rng, 2) for _ in range(4)]
    exprs = [
        rng.choice([conjunction, disjunction])([*rng.sample(shared, 2), some_condition(rng, 2)])
        for _ in range(8)
    ]
    robot = robot_of(MACHINES)
    names = PartNames(robot, exprs)
    assert names.definitions
    short = [names.of_guard(expr) for expr in exprs]
    parts = [(part.name, part.text(robot)) for part in names.definitions]
    read = conditions(MACHINES, [without_names(to_dsl(expr, robot), parts) for expr in short])
    for busy in product((False, True), repeat=6):
        values = {StateRef(f"Machine{i}", "busy"): value for i, value in enumerate(busy)}
        for expr, again in zip(exprs, read, strict=True):
            assert evaluate(expr, values.__getitem__) == evaluate(again, values.__getitem__)
    assert names.used(short) == names.definitions
    for expr in short:
        found = {part.name for part in names.used([expr])}
        assert {p.variable for p in walk(expr) if isinstance(p, NamedPart)} <= found


FAMILIES = [
    ("crew", 4), ("allocation", 4), ("not_all_busy", 6), ("not_all_busy", 9), ("priorities", 5), ("corridor_mesh", 2, 3),
    ("road", 3, 2),
]  # fmt: skip


@pytest.mark.parametrize(("family", "size"), [(name, size) for name, *size in FAMILIES])
def test_texts_parse_back(family: str, size: list[int], every_part: None) -> None:
    """What ``synthesize`` prints and its JSON say the same, and it is the guard."""
    model = getattr(steep_families, family)(*size)
    supervisor = pipeline.synthesize(robot_of(model))
    robot = supervisor.plant.robot
    document = synthesize_document(supervisor)
    parts = [(part["name"], part["condition"]) for part in document["definitions"]]
    assert parts
    told = supervisor_text(supervisor)
    assert re.findall(r"^let (\w+) = (.*)$", told, re.MULTILINE) == parts
    for guard, entry in zip(supervisor.guards, document["guards"], strict=True):
        assert entry["guard"] == to_dsl(guard.expr, robot)
        assert f"\n    {entry['short']}\n" in told
    texts = [without_names(entry["short"], parts) for entry in document["guards"]]
    plant, rng = supervisor.plant, random.Random(1)
    read = conditions(model, texts)
    for _ in range(60):
        state = tuple(rng.randrange(variable.size) for variable in plant.variables)
        for guard, again in zip(supervisor.guards, read, strict=True):
            assert holds(plant, guard.expr, state) == holds(plant, again, state)


def test_a_count_that_guards_share_has_a_name() -> None:
    supervisor = synthesize(plant_of(steep_families.not_all_busy(13)))
    robot = supervisor.plant.robot
    names = supervisor.part_names
    machines = ", ".join(f"Machine{i}.busy" for i in range(13))
    (part,) = names.definitions
    assert part.text(robot) == f"count(x for x in [{machines}]) < 12"
    assert {to_dsl(names.of_guard(g.expr), robot) for g in supervisor.guards} == {part.name}


def test_only_long_guards_read_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part_names, "LONG", 100)
    supervisor = synthesize(plant_of(steep_families.allocation(5)))
    robot = supervisor.plant.robot
    names = supervisor.part_names
    assert [part.name for part in names.definitions] == ["part_a", "part_b"]
    texts = [to_dsl(guard.expr, robot) for guard in supervisor.guards]
    short = [to_dsl(names.of_guard(guard.expr), robot) for guard in supervisor.guards]
    assert [text == given for text, given in zip(texts, short, strict=True)] == [
        len(text) <= 100 for text in texts
    ]


def test_names_are_not_those_of_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part_names, "LONG", 100)
    model = steep_families.allocation(5).replace("Product0", "part_a")
    supervisor = synthesize(plant_of(model))
    names = supervisor.part_names
    assert [part.name for part in names.definitions] == ["part_b", "part_c"]


def test_no_names_where_all_guards_are_short() -> None:
    supervisor = synthesize(plant_of(steep_families.priorities(4)))
    assert supervisor.part_names.definitions == ()
    assert "let" not in supervisor_text(supervisor)


def test_whoever_shows_one_guard_shows_its_parts(every_part: None, tmp_path: Path) -> None:
    """The simulator's ``why``, an editor, and the README of a package."""
    model = steep_families.crew(4)
    supervisor = synthesize(plant_of(model))
    robot = supervisor.plant.robot
    names = supervisor.part_names
    guard = next(g for g in supervisor.guards if names.of_guard(g.expr) != g.expr)
    short = names.of_guard(guard.expr)
    text = to_dsl(short, robot)
    parts = [(part.name, part.text(robot)) for part in names.used([short])]
    assert parts
    lines = [f"let {name} = {condition}" for name, condition in parts]
    why = Session(machine_maker(supervisor, execute=False)).do(f"why {guard.event.name}").text
    assert "".join(f"  {line}\n" for line in lines) + f"  allowed where {text}" in why
    told = synthesis_process.answer(
        {"path": "crew.rscd", "text": model, "library_path": [], "texts": {}}
    )
    (found,) = [g["text"] for g in told["guards"] if g["communication"] == guard.event.key]
    assert found == "\n".join([*lines, text])
    path = tmp_path / "crew.rscd"
    path.write_text(model)
    package = pipeline.generate(path, output=pipeline.Output(folder=tmp_path)).files.folder
    readme = (package / "README.md").read_text()
    assert "".join(f"- `{p.name}`: `{p.text(robot)}`\n" for p in names.definitions) in readme
    assert f"- **{guard.event.name} request**: `{text}` (restricted)\n" in readme
