"""Synthesis: both engines against libFAUDES on the same systems, and at sizes of their own.

Each measurement is a process of its own, bound to one core. Counts must be equal: a difference is
an error, not a figure. libFAUDES (``pip install faudes``) gets the components, services and
requirements as automata; measured is the composition of the plant, of the specification, and
SupCon. robosc's time is from the plant to guards and counts.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["main", "synthesize_with_faudes"]

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Comparison:
    """The dense engine must be ``ratio`` times as fast as libFAUDES; 0: only equal counts matter.

    Below some ten thousand states what is measured is how long it takes to begin.
    """

    family: str
    size: tuple[int, ...]
    ratio: int


@dataclass(frozen=True)
class Alone:
    """One engine at a size of its own: seconds, megabytes, transitions per second."""

    engine: str
    family: str
    size: tuple[int, ...]
    seconds: float
    megabytes: int
    rate: float = 0.0


COMPARISONS = (
    Comparison("hands", (7,), 0),
    Comparison("hands", (8,), 500),
    Comparison("services_hands", (7,), 0),
    Comparison("services_hands", (8,), 50),
    Comparison("transfer_line", (5, 4), 0),
    Comparison("transfer_line", (6, 4), 50),
    Comparison("action_robot", (3,), 50),
)
ALONE = (
    Alone("dense", "hands", (13,), 10, 300, 1e8),
    Alone("bdd", "hands", (60,), 30, 2048),
    Alone("bdd", "services_hands", (60,), 30, 2048),
    Alone("bdd", "transfer_line", (31, 4), 30, 2048),
    Alone("bdd", "action_robot", (30,), 30, 2048),
    Alone("bdd", "philosophers", (40,), 30, 2048),
)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="only what takes seconds")
    parser.add_argument("--run", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.run:
        engine, family, size = options.run
        print(json.dumps(_run(engine, family, tuple(map(int, size.split(","))))))
        return 0
    from robosc.synthesis.bdd.manager import install_hint

    missing = [
        f"{what} is not measured; type: {install_hint(package)}"
        for what, package in (("libFAUDES", "faudes"), ("the symbolic engine", "oxidd"))
        if importlib.util.find_spec(package) is None
    ]
    print("\n".join(missing) + "\n" if missing else "", end="")
    missed = _compare(options.quick) if importlib.util.find_spec("faudes") else 0
    return int(bool(missed + _alone()))


def _compare(quick: bool) -> int:
    print(f"{'system':<24}{'states':>10}{'transitions':>13}{'libFAUDES':>11}{'dense':>9}{'bdd':>9}")
    missed = 0
    for case in COMPARISONS:
        if quick and case.ratio:
            continue
        faudes = _measure("faudes", case.family, case.size)
        row = f"{_name(case):<24}{faudes['states']:>10}{faudes['transitions']:>13}"
        row += f"{faudes['seconds']:>10.2f}s"
        for engine in _engines():
            own = _measure(engine, case.family, case.size)
            for count in ("states", "transitions"):
                if own[count] != faudes[count]:
                    raise SystemExit(
                        f"{_name(case)}: {engine} counts {own[count]} {count},"
                        f" libFAUDES {faudes[count]}"
                    )
            ratio = faudes["seconds"] / own["seconds"]
            row += f"{ratio:>8.0f}x"
            if engine == "dense" and ratio < case.ratio:
                row += f" (target {case.ratio}x)"
                missed += 1
        print(row, flush=True)
    return missed


def _alone() -> int:
    missed = 0
    for case in ALONE:
        if case.engine not in _engines():
            continue
        own = _measure(case.engine, case.family, case.size)
        rate = own["transitions"] / own["seconds"]
        print(
            f"{case.engine:<6}{_name(case):<24}{own['states']:>10.3g} states"
            f"{own['transitions']:>10.3g} transitions{own['seconds']:>8.2f}s"
            f"{own['megabytes']:>6}MB{rate:>10.2g}/s",
            flush=True,
        )
        targets = {
            f"{case.seconds:g} s": own["seconds"] <= case.seconds,
            f"{case.megabytes} MB": own["megabytes"] <= case.megabytes,
            f"{case.rate:g} transitions per second": rate >= case.rate,
        }
        for target, met in targets.items():
            if not met:
                print(f"      target missed: {target}")
                missed += 1
    return missed


def _name(case: Comparison | Alone) -> str:
    return f"{case.family}({', '.join(map(str, case.size))})"


def _engines() -> list[str]:
    return ["dense", "bdd"] if importlib.util.find_spec("oxidd") else ["dense"]


def _measure(engine: str, family: str, size: tuple[int, ...]) -> Any:
    """One run in a process of its own."""
    command = [sys.executable, str(HERE / "synthesis_bench.py")]
    command += ["--run", engine, family, ",".join(map(str, size))]
    run = subprocess.run(command, capture_output=True, text=True, timeout=1200)
    if run.returncode:
        raise SystemExit(f"{' '.join(command)} failed:\n{run.stderr}")
    return json.loads(run.stdout)


# --- inside the process --------------------------------------------------------------------------


def _run(engine: str, family: str, size: tuple[int, ...]) -> dict[str, float]:
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    import families

    from robosc.ir.lower import lower
    from robosc.model.resolve import load
    from robosc.source import Source

    robot, _ = load(Source(f"{family}.rscd", getattr(families, family)(*size)))
    assert robot is not None
    plant = lower(robot)
    found = synthesize_with_faudes(plant) if engine == "faudes" else _robosc(plant, engine)
    found["megabytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return found


def _robosc(plant: Any, engine: str) -> dict[str, float]:
    from robosc.synthesis import synthesize

    supervisor = synthesize(plant, engine)
    return {
        "seconds": supervisor.seconds,
        "states": supervisor.controlled_states,
        "transitions": supervisor.controlled_transitions,
    }


def synthesize_with_faudes(plant: Any) -> dict[str, float]:
    """Seconds, states and transitions of composition and SupCon in this process."""
    import faudes
    from bench.generators import Automata, Automaton, automata_of

    automata: Automata = automata_of(plant)

    def generator(automaton: Automaton) -> Any:
        made = faudes.System()
        made.StateNamesEnabled(False)
        for state in range(1, automaton.states + 1):
            made.InsState(state)
        made.InsInitState(1)
        for state in sorted(automaton.marked):
            made.InsMarkedState(state + 1)
        for event in sorted(automaton.events):
            if automata.controllable[event]:
                made.InsControllableEvent(event)
            else:
                made.InsUncontrollableEvent(event)
        for source, event, target in automaton.transitions:
            made.SetTransition(source + 1, made.EventIndex(event), target + 1)
        return made

    def composition(parts: list[Any]) -> Any:
        whole = parts[0]
        for part in parts[1:]:
            result = faudes.System()
            result.StateNamesEnabled(False)
            faudes.Parallel(whole, part, result)
            whole = result
        return whole

    plants = [generator(one) for one in automata.plant]
    specifications = [generator(one) for one in automata.specification]
    start = time.perf_counter()
    whole, specification = composition(plants), composition(specifications)
    # SupCon wants both over the same events.
    faudes.InvProject(specification, whole.Alphabet())
    supervisor = faudes.System()
    supervisor.StateNamesEnabled(False)
    faudes.SupCon(whole, specification, supervisor)
    seconds = time.perf_counter() - start
    return {
        "seconds": seconds,
        "states": supervisor.Size(),
        "transitions": supervisor.TransRelSize(),
    }


if __name__ == "__main__":
    sys.path[:0] = [str(HERE.parent), str(HERE.parent.parent / "src")]
    raise SystemExit(main())
