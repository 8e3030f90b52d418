"""The controller of random robots, searched by sets of states and state by state."""

from __future__ import annotations

import random
from collections import Counter

import pytest
from synthesis.subject import robot_of

from robosc.plant.build import lower
from robosc.synthesis import synthesize
from robosc.synthesis.bdd.run_to_completion import SymbolicController
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine
from robosc.synthesis.controlled_system import Runs
from robosc.synthesis.explain.run_to_completion import ExplicitController
from robosc.synthesis.explicit.search import GuardedSteps

_UPDATES = ("x := !x", "x := true", "n := 0", "n := 1", "n := n + 1")


def _condition(rng: random.Random, component: int, components: int) -> str:
    """A condition, mostly on the same component, as that keeps internal transitions apart."""
    other = component if rng.random() < 0.7 else rng.randrange(components)
    what = rng.choice([".a", ".b", ".c", ".x", ".n > 0", ".n = 1"])
    return f"C{other}{what}" if rng.random() < 0.6 else f"!(C{other}{what})"


def _state(rng: random.Random, name: str, component: int, components: int) -> str:
    marked = name == "a" or rng.random() < 0.4
    events = [f"response from m{component}", f"request to k{component}", f"request to l{component}"]
    rng.shuffle(events)
    lines = [] if marked else [f"on {events.pop()} goto a"]
    for _ in range(rng.randint(0, 3)):
        event = events.pop() if events and rng.random() < 0.55 else None
        update = rng.choice(_UPDATES) if rng.random() < 0.55 else ""
        if event is not None and event.startswith("response") and "+" in update:
            update = "n := 0"
        guard = f" if {_condition(rng, component, components)}" if rng.random() < 0.6 else ""
        effect = (f" do {update}" if update else "") + f" goto {rng.choice('abc')}"
        lines.append((f"on {event}" if event else "transition") + guard + effect)
    kinds = ("initial " if name == "a" else "") + ("marked " if marked else "")
    return f"{kinds}state {name} {{ {'  '.join(lines)} }}\n"


def _model(rng: random.Random) -> str:
    components = rng.randint(2, 4)
    parts = []
    for i in range(components):
        topic = rng.choice([f"/t{i}", "/shared"])
        parts.append(
            f"component C{i} {{\n"
            f'outgoing message m{i} with identifier: "{topic}", type: none\n'
            f"incoming message k{i} with type: none\nincoming message l{i} with type: none\n"
            "behaviour {\nvariable x: boolean\nvariable n: integer(0..2) = 0\n"
            + "".join(_state(rng, name, i, components) for name in "abc")
            + "}\n}\n"
        )
    commands = [f"{kind}{i}" for kind in "kl" for i in range(components)]

    def condition() -> str:
        return _condition(rng, rng.randrange(components), components)

    for _ in range(rng.randint(0, 3)):
        parts.append(f"requirement {rng.choice(commands)} needs {condition()}\n")
    if rng.random() < 0.5:
        parts.append(f"requirement never {condition()} and {condition()}\n")
    if rng.random() < 0.5:
        origin = f" from {condition()}" if rng.random() < 0.3 else ""
        along = f" while {condition()}" if rng.random() < 0.3 else ""
        parts.append(f"requirement possible {condition()}{origin}{along}\n")
    if rng.random() < 0.4:
        parts.append("prefer {} over {}\n".format(*rng.sample(commands, 2)))
    return f"robot R {{\n{''.join(parts)}}}\n"


def _failing(runs: Runs) -> tuple[object, ...]:
    ends = runs.livelock is None
    missed = None if runs.missed is None else runs.missed[1]
    return ends, runs.differing is None, ends and runs.stuck is None, ends and missed


@pytest.mark.slow
def test_what_fails_is_the_same_state_by_state() -> None:
    compared: Counter[tuple[object, ...]] = Counter()
    for seed in range(220):
        plant = lower(robot_of(_model(random.Random(seed))))
        solution = SymbolicEngine(plant).solve()
        if solution.empty:
            continue
        found = SymbolicController(solution).runs()
        guards = synthesize(plant, "explicit", explain_seconds=0.01).guards
        expected = ExplicitController(plant, GuardedSteps(plant, guards)).runs()
        assert _failing(found) == _failing(expected), seed
        if found.longest is not None and expected.longest is not None:
            assert found.longest >= expected.longest, seed
            exactly = SymbolicController(solution).runs(exactly=True).longest
            assert exactly == expected.longest, seed
        compared[_failing(found)] += 1
    assert sum(compared.values()) > 150
    assert len(compared) > 4
