"""Plant faults into the controllers of models, and see whether the test of the package finds them.

    ./dev mutants [MODEL...]

Prints a table of how many mutants are found in a controller and in a supervisor, by kind, with each
that is not. Those are compared with the controller itself in all states that both reach
(``bisimulation.py``): without a difference a mutant is equivalent, and no test can find it; it is
undecided if the time was too short for all states; else it was missed, and the way to the
difference is printed. Both are tested by the scripts of their packages, as ``robosc simulate`` follows
them.
"""

from __future__ import annotations

import argparse
import itertools
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS), str(TESTS.parent / "src")]

from emit.bisimulation import Comparison, Recording, compare  # noqa: E402
from emit.generated_code import controller_source  # noqa: E402
from emit.mutants import Mutant, mutants  # noqa: E402
from emit.scripted_controllers import class_of, scripts_of, tells_apart  # noqa: E402

from robosc import pipeline  # noqa: E402
from robosc.emit.package.config import shared_topics  # noqa: E402
from robosc.emit.supervisor.command_recognition import command_matches  # noqa: E402
from robosc.errors import ModelError, RoboscError, render_all  # noqa: E402
from robosc.plant.automaton import Plant  # noqa: E402
from robosc.traces.samples import Sample, Samples  # noqa: E402

KINDS = ("guard", "data", "rule", "update")
MODES: dict[str, tuple[str, ...]] = {
    "controller": (*KINDS, "preference"),
    "supervisor": ("guard", "rule", "update"),
}
"""The faults that show in a package: a supervisor sends no data, and which command is preferred is
not its choice."""
NOT_MADE = {
    "commands-alike": "its commands cannot be told apart",
    "data-of-others": "it corrects another controller",
}
"""Why there is no package of a model in a mode, by the code of the error."""
SAMPLES = 64
"""The most messages of each sort with which controllers are compared."""


class Verdict(NamedTuple):
    """What became of a mutant: found (nothing to compare), or how it differs."""

    mutant: Mutant
    comparison: Comparison | None


def verdicts(model: Path, mode: str, every: int, seconds: float) -> Iterator[Verdict]:
    """Yield what becomes of the mutants of a model's controller."""
    guards = mode == "supervisor"
    robot = pipeline.load(model, pipeline.Options(supervises=guards)).robot
    if not guards:
        pipeline.refuse_corrections(robot)  # no controller is generated of such a model
    supervisor = pipeline.synthesize(robot)
    if guards:
        command_matches(robot)  # an error where it cannot be guarded
    source, plant = controller_source(supervisor, model.name), supervisor.plant
    finds = partial(tells_apart, supervisor, scripts_of(supervisor))
    faults = finds(source)
    assert not faults, f"{model}: the controller itself: {faults}"
    said = messages(plant)
    topics = [keys for _, keys in shared_topics(robot) if (keys[0], "response") in said]
    options = said, topics, seconds, not guards
    called: set[str] = set()
    recording = Recording(class_of(source, called, plant), called, *options)
    for mutant in [m for m in mutants(source) if m.kind in MODES[mode]][::every]:
        comparison = None
        if not finds(mutant.source):
            both = [class_of(text, None, plant) for text in (source, mutant.source)]
            comparison = recording.compare(both[1], mutant.method)
            comparison = comparison or compare(both[0](), both[1](), *options)
        yield Verdict(mutant, comparison)


def messages(plant: Plant) -> dict[tuple[str, str], list[Any]]:
    """What the robot may say, and a supervised controller, by key and kind."""
    said = dict.fromkeys(e.whole or e for e in plant.events if not e.kind.clocked)
    samples = Samples(plant.robot, said)
    return {(e.key, e.kind.word): [s.given for s in _spread(samples.of(e))] for e in said}


def _spread(found: list[Sample]) -> list[Sample]:
    """The plainest ones, and of the others some of each kind: they differ in one part after the
    other."""
    plain, others = found[: SAMPLES // 2], found[SAMPLES // 2 :]
    return plain + others[:: max(1, -(-len(others) // (SAMPLES // 2)))]


def print_row(name: str, found: list[Verdict], seconds: float) -> None:
    """A row of the table, and below it each mutant that is not found."""
    tried = Counter(verdict.mutant.kind for verdict in found)
    caught = Counter(v.mutant.kind for v in found if v.comparison is None)
    rest = [comparison for _, comparison in found if comparison is not None]
    equivalent = sum(c.is_complete for c in rest)
    missed = sum(c.difference is not None for c in rest)
    counts = f"{equivalent} | {len(rest) - equivalent - missed} | {missed}"
    kinds = " | ".join(f"{caught[kind]}/{tried[kind]}" for kind in KINDS)
    print(f"| {name} | {kinds} | {counts} | {seconds:.0f} s |", flush=True)
    for mutant, comparison in found:
        if comparison is not None:
            print(f"    {mutant.method}: {mutant.before}  =>  {mutant.after}")
            print(f"        {shortened(reason(comparison))}")


def shortened(text: str) -> str:
    """A text in which of elements of arrays that are alike the first is told."""
    return re.sub(r"([^\s\[]+)(, \1)+(?=[,\]])", r"\1, …", text)


def reason(comparison: Comparison) -> str:
    """Why a mutant is not found."""
    pairs = f"{comparison.classes:,} classes of states"
    if comparison.difference is not None:
        return "missed; differs after: " + comparison.difference
    if comparison.is_complete:
        return f"equivalent: the same in all {pairs}"
    return f"undecided: the same in the first {pairs}"


def main() -> None:
    parser = argparse.ArgumentParser(prog="./dev mutants", description=__doc__.partition("\n")[0])
    parser.add_argument(
        "models", nargs="*", type=Path, help="their files; all of examples/, if none is named"
    )
    parser.add_argument("--every", type=int, default=1, help="take one of so many mutants")
    parser.add_argument(
        "--seconds", type=float, default=20.0, help="of processor, for a comparison"
    )
    arguments = parser.parse_args()
    models = arguments.models or [
        path
        for path in sorted((TESTS.parents[1] / "examples").glob("**/*.rscd"))
        if not re.search("^library ", path.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    print("| model | guards | data | rules | updates | equivalent | undecided | missed | time |")
    print("|---|---|---|---|---|---|---|---|---|")
    for model, mode in itertools.product(models, MODES):
        start = time.perf_counter()
        options = mode, arguments.every, arguments.seconds
        try:
            found = list(verdicts(model, *options))
        except ModelError as error:
            why = {NOT_MADE.get(diagnostic.code) for diagnostic in error.diagnostics}
            if None in why:
                raise
            print(f"| {model.stem}, {mode} | {why.pop()} |", flush=True)
            continue
        print_row(f"{model.stem}, {mode}", found, time.perf_counter() - start)


def run() -> int:
    """The exit code of the program, as that of robosc."""
    try:
        main()
    except ModelError as error:
        print(render_all(error.diagnostics), end="", file=sys.stderr)
        return error.exit_code
    except (RoboscError, OSError) as error:
        print(f"mutants: {error}", file=sys.stderr)
        return getattr(error, "exit_code", 2)
    return 0


if __name__ == "__main__":
    sys.exit(run())
