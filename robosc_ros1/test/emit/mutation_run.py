"""Plant faults into the controllers of models, and see whether the test of the package finds them.

    python3 robosc_ros1/test/emit/mutation_run.py examples/*/*.rscd

Prints a table of found and surviving mutants by kind, and each survivor. The test's judge and guide
are the same in the packages for both versions of ROS and in both modes; they run without ROS here.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS), str(TESTS.parent / "src")]

from emit.generated_code import controller_source  # noqa: E402
from emit.judged_controllers import judged, judging_modules  # noqa: E402
from emit.mutants import Mutant, mutants  # noqa: E402

from robosc import pipeline  # noqa: E402


def survivors(model: Path, rounds: int, every: int) -> tuple[Counter[str], list[Mutant]]:
    """How many mutants of each kind there are, and those that are not found."""
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    source = controller_source(supervisor, model.name)
    tried: Counter[str] = Counter()
    found: list[Mutant] = []
    with (
        tempfile.TemporaryDirectory() as folder,
        judging_modules(Path(folder), supervisor) as judging,
    ):
        faults = judged(judging, source, rounds=rounds).faults
        assert not faults, f"{model}: the controller itself: {faults}"
        for mutant in list(mutants(source))[::every]:
            tried[mutant.kind] += 1
            if not judged(judging, mutant.source, rounds=rounds).faults:
                found.append(mutant)
    return tried, found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--rounds", type=int, default=150, help="as in a test of ten seconds")
    parser.add_argument("--every", type=int, default=1, help="take one of so many mutants")
    arguments = parser.parse_args()
    for model in arguments.models:
        start = time.perf_counter()
        tried, found = survivors(model, arguments.rounds, arguments.every)
        missed = Counter(mutant.kind for mutant in found)
        row = ", ".join(f"{kind} {n - missed[kind]}/{n}" for kind, n in sorted(tried.items()))
        print(f"{model}: {row} found, {time.perf_counter() - start:.0f} s", flush=True)
        for mutant in found:
            print(f"    {mutant.kind} in {mutant.method}: {mutant.before}  =>  {mutant.after}")


if __name__ == "__main__":
    main()
