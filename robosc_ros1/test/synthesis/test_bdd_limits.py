"""What the symbolic engine does when it cannot: too little memory, or no library."""

from __future__ import annotations

import random
import subprocess
import sys

import families
import pytest
import steep_families
from random_models import random_model
from synthesis.plants import plant_of

from robosc.errors import StateSpaceError
from robosc.synthesis import synthesize
from robosc.synthesis.bdd import manager
from robosc.synthesis.bdd.manager import install_hint
from robosc.synthesis.bdd.synthesize import synthesize_bdd

needs_library = pytest.mark.skipif(
    not manager.available(), reason="the symbolic engine needs the Python package oxidd"
)


def scattered(count: int) -> str:
    """Switches under clauses of three chosen at random: no order of variables keeps this small."""
    rng = random.Random(1)
    pairs = [(i % count, j) for i in range(3 * count) for j in [rng.randrange(count)]]
    clauses = " and ".join(f"(S{i}.x or !S{j}.x or S{(i + j) % count}.x)" for i, j in pairs)
    return (
        f"{families.switches(count)} component B {{ incoming message go with type: none }}"
        f" requirement go needs {clauses}"
    )


@needs_library
def test_too_little_memory_is_told() -> None:
    with pytest.raises(StateSpaceError, match=r"ran out of the 1 MB .* others \(2 values each\)"):
        synthesize_bdd(plant_of(scattered(60)), memory=2**20)


@needs_library
@pytest.mark.parametrize("seed", range(3))
def test_garbage_is_no_lack_of_memory(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The library collects in its own thread, and does not wait for that."""
    monkeypatch.setattr(manager, "_FEWEST_NODES", 2**14)
    rng = random.Random(seed)
    diagrams = manager.Manager(40, memory=2**19)
    assert diagrams.capacity < 2**15
    # Whether there is room is asked before an operation, which may be long.
    monkeypatch.setattr(diagrams, "make_room", lambda forget: None)

    def build() -> object:
        pairs = [(rng.randrange(40), rng.randrange(40)) for _ in range(8)]
        return diagrams.union(
            diagrams.literal(left, True) & diagrams.literal(right, True) for left, right in pairs
        )

    for _ in range(1000):
        diagrams.run(build)


@pytest.mark.slow
@needs_library
def test_memory_stays_within_the_limit() -> None:
    """In a process of its own, which reports its largest size."""
    script = (
        "from robosc.errors import StateSpaceError\n"
        "from robosc.synthesis.bdd.synthesize import synthesize_bdd\n"
        "from synthesis.plants import plant_of\n"
        "from synthesis.test_bdd_limits import scattered\n"
        "plant = plant_of(scattered(90))\n"
        "def largest():\n"
        "    lines = open('/proc/self/status').read().splitlines()\n"
        "    return next(int(l.split()[1]) for l in lines if l.startswith('VmHWM'))\n"
        "before = largest()\n"
        "try:\n"
        "    synthesize_bdd(plant, memory=128 * 2**20)\n"
        "except StateSpaceError:\n"
        "    print(largest() - before)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", script],
        env={"PYTHONPATH": ":".join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
        timeout=600,
    )
    kilobytes = int(run.stdout)
    assert 32 * 2**10 < kilobytes < 192 * 2**10


@needs_library
def test_collects_garbage_before_it_gives_up() -> None:
    """A megabyte does where a hundred were used in passing."""
    text = families.transfer_line(6, 3)
    found = synthesize_bdd(plant_of(text), memory=2**20)
    assert found.sizes.controlled_states == families.line_states(6, 3)


@needs_library
def test_auto_takes_it_when_there_are_too_many_states() -> None:
    plant = plant_of(families.hands(5))
    assert synthesize(plant, "auto", max_states=2**10).engine == "explicit"
    assert synthesize(plant, "auto", max_states=100).engine == "bdd"
    with pytest.raises(StateSpaceError, match="more than 100 states"):
        synthesize(plant, "explicit", max_states=100)


def test_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(manager, "available", lambda: False)
    with pytest.raises(StateSpaceError, match=r"needs the Python package oxidd; type: .* oxidd"):
        synthesize_bdd(plant_of(random_model(random.Random(0), 1)))


def test_the_hint_installs_for_the_running_python() -> None:
    words = install_hint().split()
    assert sys.executable in words
    assert words[-1] == "oxidd"
    assert ("--user" in words) == (sys.prefix == sys.base_prefix)


@pytest.mark.parametrize("engine", ["explicit", pytest.param("bdd", marks=needs_library)])
def test_progress_is_told_where_time_may_run_out(engine: str) -> None:
    """By it `check` keeps its limit of time: not only fixpoints can take long."""
    told: set[str] = set()
    synthesize(plant_of(steep_families.crew(4)), engine, progress=lambda what, *_: told.add(what))
    assert {"guards", "explanations"} < told
