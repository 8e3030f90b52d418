"""``./dev bench``: how fast robosc is, as ratios where a machine's speed would hide it.

Each section prints a table; nothing is asserted. ``./dev bench NAME…`` runs some of them.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "robosc_ros1" / "src"), str(ROOT / "robosc_ros1" / "test")]

from families import hands, hands_states, line_states, services_hands, transfer_line  # noqa: E402
from large_model import large_model  # noqa: E402

from robosc.ir.lower import lower  # noqa: E402
from robosc.model.resolve import load  # noqa: E402
from robosc.source import Source  # noqa: E402
from robosc.synthesis import synthesize  # noqa: E402

MODEL = ROOT / "examples" / "line_follower" / "line_follower.rscd"


def startup() -> None:
    """``check`` of the line follower as a whole process, against importing its libraries."""
    check = process("-m", "robosc", "check", str(MODEL))
    imports = process("-c", "import pyparsing, jinja2, numpy")
    row("check line_follower", f"{check:.3f} s")
    row("import pyparsing, jinja2, numpy", f"{imports:.3f} s", f"ratio {check / imports:.2f}")


def process(*arguments: str) -> float:
    """Median wall time of seven runs of Python."""
    env = os.environ | {"PYTHONPATH": str(ROOT / "robosc_ros1" / "src")}
    return statistics.median(
        timed(
            lambda: subprocess.run(
                [sys.executable, *arguments], env=env, check=True, stdout=subprocess.DEVNULL
            )
        )
        for _ in range(7)
    )


def frontend() -> None:
    """Parse, resolve and check models of 10,000 and 20,000 lines."""
    seconds = []
    for components in (500, 1000):
        text = large_model(components)
        seconds.append(timed(lambda text=text: load(Source("large.rscd", text))))  # type: ignore[misc]
        row(f"{text.count(chr(10)):,} lines", f"{seconds[-1]:.2f} s")
    row("twice the lines cost", f"{seconds[1] / seconds[0]:.2f} times")


def synthesis() -> None:
    """Families of systems, with their sizes."""
    for name, text, expected in (
        ("hands 7", hands(7), hands_states(7)),
        ("hands 8", hands(8), hands_states(8)),
        ("services 6", services_hands(6), hands_states(6)),
        ("transfer line 6, 3", transfer_line(6, 3), line_states(6, 3)),
    ):
        robot, _ = load(Source(f"{name}.rscd", text))
        assert robot is not None
        result = synthesize(lower(robot))
        assert result.controlled_states == expected, (name, result.controlled_states, expected)
        rate = result.controlled_transitions / result.seconds
        row(
            name,
            f"{result.controlled_states:,} states",
            f"{result.seconds:.3f} s",
            f"{rate:,.0f} transitions/s",
        )


def engine() -> None:
    """The generated controller's own cost of one input, without ROS."""
    from robosc.pipeline import Options, Output, generate

    class Silent:
        """A port to nowhere."""

        def __getattr__(self, name: str) -> Callable[..., object]:
            return time.monotonic if name == "now" else lambda *arguments: None

    with tempfile.TemporaryDirectory() as folder:
        package = generate(MODEL, Options(), Output(folder=Path(folder))).files.folder
        sys.path.insert(0, str(package / "src"))
        from line_follower_controller._runtime.engine import Engine
        from line_follower_controller._runtime.settings import Settings
        from line_follower_controller.controller import LineFollowerController

        run = Engine(LineFollowerController(), Silent(), Settings())
        run.begin()
        count = 50_000
        start = time.perf_counter()
        message = SimpleNamespace(data=0.5)
        for _ in range(count):
            run.post("LineDetector.correction", "response", message)
            run.cycle()
        row(
            "one input of the line follower",
            f"{1e6 * (time.perf_counter() - start) / count:.1f} µs",
        )


def ros() -> None:
    """Latency and flood of the generated controller on a real roscore, beside a bare relay."""
    test = ROOT / "robosc_ros1" / "test"
    paths = [str(ROOT / "robosc_ros1" / "src"), str(test)]
    env = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
    subprocess.run([sys.executable, test / "bench" / "ros_bench.py"], env=env, check=True)


SECTIONS: dict[str, Callable[[], None]] = {
    "startup": startup,
    "frontend": frontend,
    "synthesis": synthesis,
    "engine": engine,
    "ros": ros,
}


def timed(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def row(name: str, *values: str) -> None:
    print(f"  {name:34}" + "".join(f"{value:>26}" for value in values), flush=True)


def main(names: list[str]) -> int:
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        print(f"bench: no section {unknown[0]!r}; there are {', '.join(SECTIONS)}", file=sys.stderr)
        return 2
    for name in names or SECTIONS:
        print(f"{name}: {(SECTIONS[name].__doc__ or '').strip()}")
        SECTIONS[name]()
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
