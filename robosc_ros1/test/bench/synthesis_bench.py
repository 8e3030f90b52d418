"""Synthesis: both engines against libFAUDES on the same systems, at sizes of their own, and ``auto``.
Whole commands on families from the literature.

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
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["command_time", "main", "synthesize_with_faudes"]

HERE = Path(__file__).resolve().parent
SOURCES = HERE.parent.parent / "src"


@dataclass(frozen=True)
class Comparison:
    """robosc's own choice must be ``ratio`` times as fast as libFAUDES; 0: only equal counts matter.

    Below some ten thousand states what is measured is how long it takes to begin.
    """

    family: str
    size: tuple[int, ...]
    ratio: int


@dataclass(frozen=True)
class Alone:
    """One engine at a size of its own: seconds and megabytes."""

    engine: str
    family: str
    size: tuple[int, ...]
    seconds: float
    megabytes: int


COMPARISONS = (
    Comparison("hands", (7,), 0),
    Comparison("hands", (8,), 500),
    Comparison("services_hands", (7,), 0),
    Comparison("services_hands", (8,), 50),
    Comparison("transfer_line", (5, 4), 0),
    Comparison("transfer_line", (6, 4), 50),
    Comparison("action_robot", (3,), 50),
    Comparison("cluster_tool", (4,), 0),
    Comparison("road", (3, 3), 0),
    Comparison("elevator", (7,), 0),
)
ALONE = (
    Alone("bdd", "hands", (60,), 30, 2048),
    Alone("bdd", "services_hands", (60,), 30, 2048),
    Alone("bdd", "transfer_line", (31, 4), 30, 2048),
    Alone("bdd", "action_robot", (30,), 30, 2048),
    Alone("bdd", "philosophers", (40,), 30, 2048),
)
CHOICES: tuple[tuple[str, tuple[int, ...]], ...] = (
    ("allocation", (6,)),
    ("allocation", (9,)),
    ("broad", (300,)),
    ("budget", (7, 10)),
    ("budget", (14, 20)),
    ("cat_and_mouse", (7, 3)),
    ("chain", (16,)),
    ("chain", (80,)),
    ("cluster_tool", (5,)),
    ("cluster_tool", (9,)),
    ("conveyor", (20,)),
    ("conveyor", (60,)),
    ("corridor_mesh", (3, 4)),
    ("corridor_mesh", (4, 4)),
    ("crew", (8,)),
    ("crew", (13,)),
    ("elevator", (8,)),
    ("elevator", (12,)),
    ("gauges", (200,)),
    ("gauges", (2000,)),
    ("not_all_busy", (10,)),
    ("not_all_busy", (17,)),
    ("priorities", (40,)),
    ("readings", (40,)),
    ("restless", (18,)),
    ("road", (4, 4)),
    ("road", (6, 8)),
    ("tanks", (300,)),
    ("token", (23,)),
    ("unrelated", (5,)),
    ("unrelated", (60,)),
    ("unrelated", (1000,)),
    ("hands", (8,)),
    ("services_hands", (6,)),
    ("transfer_line", (6, 4)),
    ("action_robot", (3,)),
    ("philosophers", (8,)),
)
"""Models on which ``auto`` may take twice the processor time of the better engine."""
_WORST_RATIO = 2.0
_COMMAND_SECONDS = 3.0
"""Processor seconds of a whole ``robosc synthesize`` of a published family."""
_LARGE_COMMANDS = {("cells", (6, 2)): 5.0, ("cells", (12, 2)): 15.0}
"""The same where more is allowed."""
_SHORT = 0.5
"""Seconds below which it does not matter what is chosen: loading the library takes about as long."""


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
    if len(_engines()) > 1:
        missed += _choices(options.quick) + _commands(options.quick)
    return int(bool(missed + (0 if options.quick else _alone())))


def _compare(quick: bool) -> int:
    print(
        f"{'system':<24}{'states':>10}{'transitions':>13}{'libFAUDES':>11}"
        + "".join(f"{engine:>9}" for engine in _engines())
    )
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
            if engine == "auto" and ratio < case.ratio:
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
        }
        for target, met in targets.items():
            if not met:
                print(f"      target missed: {target}")
                missed += 1
    return missed


def _choices(quick: bool) -> int:
    """What ``auto`` takes, against each engine by itself."""
    print(
        f"{'system':<24}{'explicit':>9}{'bdd':>9}{'auto':>9}{'ratio':>7}   processor seconds, guards"
    )
    missed = 0
    for family, size in CHOICES[::4] if quick else CHOICES:
        case = Alone("auto", family, size, 0, 0)
        symbolic = _measure("bdd", family, size)
        auto = _measure("auto", family, size)
        explicit = _measure_within(4 * symbolic["cpu"] + 5, "explicit", family, size)
        if explicit is not None and explicit["states"] != symbolic["states"]:
            raise SystemExit(f"{_name(case)}: {explicit['states']} states, {symbolic['states']}")
        best = min(one["cpu"] for one in (explicit, symbolic) if one is not None)
        ratio = auto["cpu"] / best
        late = ratio > _WORST_RATIO and auto["cpu"] > _SHORT
        missed += late
        shown = "       -" if explicit is None else f"{explicit['cpu']:>8.2f}"
        print(
            f"{_name(case):<24}{shown}s{symbolic['cpu']:>8.2f}s{auto['cpu']:>8.2f}s{ratio:>6.1f}x"
            f" {auto['letters']:>8} letters{' (target 2x)' if late else ''}",
            flush=True,
        )
    return missed


def _commands(quick: bool) -> int:
    """Whole commands on families from the literature."""
    import published_families

    print("robosc synthesize: processor seconds and megabytes of the whole command")
    missed = 0
    for family, sizes in published_families.SIZES.items():
        row = f"{family:<14}"
        for size in sizes[:2] if quick else sizes:
            seconds, megabytes = command_time(getattr(published_families, family)(*size))
            most = _LARGE_COMMANDS.get((family, size), _COMMAND_SECONDS)
            late = f" (target {most:g} s)" if seconds > most else ""
            missed += bool(late)
            row += f"  {'/'.join(map(str, size))}: {seconds:.2f}s {megabytes}MB{late}"
        print(row, flush=True)
    return missed


def command_time(text: str) -> tuple[float, int]:
    """Processor seconds and megabytes of ``robosc synthesize`` of this checkout.

    Raises SystemExit with what the command said, if it fails.
    """
    sources = os.pathsep.join([str(SOURCES), *filter(None, [os.environ.get("PYTHONPATH")])])
    with (
        tempfile.NamedTemporaryFile("w", suffix=".rscd") as model,
        tempfile.TemporaryFile("w+") as said,
    ):
        model.write(text)
        model.flush()
        command = [sys.executable, "-m", "robosc", "synthesize", model.name]
        with subprocess.Popen(
            command,
            env=os.environ | {"PYTHONPATH": sources},
            stdout=subprocess.DEVNULL,
            stderr=said,
        ) as run:
            _, status, used = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
        if run.returncode:
            said.seek(0)
            raise SystemExit(f"{' '.join(command)} failed:\n{said.read()}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss // 1024


def _measure_within(seconds: float, *run: Any) -> Any:
    """The same within some seconds of processor time and 3 GB; None if that is too little."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))
        resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30,) * 2)

    done = subprocess.run(_command(*run), capture_output=True, text=True, preexec_fn=limit)
    return None if done.returncode else json.loads(done.stdout)


def _command(engine: str, family: str, size: tuple[int, ...]) -> list[str]:
    script = str(HERE / "synthesis_bench.py")
    return [sys.executable, script, "--run", engine, family, ",".join(map(str, size))]


def _name(case: Comparison | Alone) -> str:
    return f"{case.family}({', '.join(map(str, case.size))})"


def _engines() -> list[str]:
    return ["explicit", "bdd", "auto"] if importlib.util.find_spec("oxidd") else ["explicit"]


def _measure(engine: str, family: str, size: tuple[int, ...]) -> Any:
    """One run in a process of its own."""
    command = _command(engine, family, size)
    run = subprocess.run(command, capture_output=True, text=True, timeout=1200)
    if run.returncode:
        raise SystemExit(f"{' '.join(command)} failed:\n{run.stderr}")
    return json.loads(run.stdout)


# --- inside the process --------------------------------------------------------------------------


def _run(engine: str, family: str, size: tuple[int, ...]) -> dict[str, float]:
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    import families
    import steep_families

    from robosc.model.resolve import load
    from robosc.plant.build import lower
    from robosc.source import Source

    text = getattr(families, family, None) or getattr(steep_families, family)
    robot, _ = load(Source(f"{family}.rscd", text(*size)))
    assert robot is not None
    plant = lower(robot)
    found = synthesize_with_faudes(plant) if engine == "faudes" else _robosc(plant, engine)
    found["megabytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return found


def _robosc(plant: Any, engine: str) -> dict[str, float]:
    from robosc.plant.model_text import to_dsl
    from robosc.synthesis import synthesize

    start = time.process_time()
    supervisor = synthesize(plant, engine)
    cpu = time.process_time() - start
    return {
        "cpu": cpu,
        "letters": sum(len(to_dsl(guard.expr, plant.robot)) for guard in supervisor.guards),
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
    sys.path[:0] = [str(HERE.parent), str(SOURCES)]
    raise SystemExit(main())
