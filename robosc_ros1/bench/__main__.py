"""``./dev bench``: every benchmark, or those that are named.

A benchmark is a module ``<name>_bench.py`` in ``robosc_ros1/test/bench`` whose ``main(arguments)``
prints what it measured and returns 1 if that misses its target. What stands behind ``--`` goes to
it.
"""

from __future__ import annotations

import importlib
import signal
import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1] / "test"


def main(arguments: list[str]) -> int:
    if {"-h", "--help"} & {*arguments}:
        print(f"usage: ./dev bench [NAME]... [-- ARGUMENT...]\n\n{__doc__}")
        return 0
    sys.path[:0] = [str(TESTS.parent / "src"), str(TESTS)]
    names = sorted(p.stem.removesuffix("_bench") for p in (TESTS / "bench").glob("*_bench.py"))
    own: list[str] = []
    if "--" in arguments:
        cut = arguments.index("--")
        arguments, own = arguments[:cut], arguments[cut + 1 :]
    unknown = [name for name in arguments if name not in names]
    if unknown:
        print(f"no such benchmark: {', '.join(unknown)}; there are {', '.join(names)}")
        return 2
    # Nodes and a roscore are in sessions of their own, and would outlive a benchmark that is ended;
    # one that is not killed outright also removes its files.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    importlib.import_module("reaper").watch()
    missed = []
    for name in arguments or names:
        print(f"== {name}", flush=True)
        if importlib.import_module(f"bench.{name}_bench").main(own):
            missed.append(name)
    print(f"targets missed: {', '.join(missed) or 'none'}")
    return int(bool(missed))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
