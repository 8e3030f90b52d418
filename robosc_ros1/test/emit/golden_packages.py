"""The models whose packages are kept as golden ones, and how they are generated."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from quick import quick_first

from robosc import pipeline
from robosc.emit.package import ros1_target, ros2_target
from robosc.emit.package.config import DEFAULTS
from robosc.emit.package.package import File, Mode, Package
from robosc.resources import templates_folder
from robosc.traces.scripts import test_files

__all__ = [
    "MODELS", "PACKAGES", "TARGETS", "golden_folder", "kept_files", "model_path", "package_of",
]  # fmt: skip

GOLDEN = Path(__file__).resolve().parents[1] / "golden"

TARGETS = ("ros1", "ros2")
EMITTERS = {"ros1": ros1_target.emit, "ros2": ros2_target.emit}

MODELS = ("lantern", "thermostat", "gauntlet")
"""``lantern`` needs no message definitions; ``gauntlet`` those of gauntlet_interfaces beside it;
``thermostat`` has parameters of all types."""


def model_path(model: str) -> Path:
    return GOLDEN / "models" / f"{model}.rscd"


PACKAGES = quick_first(
    [
        *((model, target, "controller") for model in MODELS for target in TARGETS),
        *(("gauntlet", t, mode) for mode in ("supervisor", "monitor") for t in TARGETS),
    ],
    4,
)
"""Model, target, mode; those of ``gauntlet``, of which a test takes seconds to choose, are slow."""


@cache
def package_of(
    model: str,
    target: str = "ros1",
    mode: Mode = "controller",
    name: str | None = None,
    tested: bool = True,
) -> Package:
    """Return the package of a model, generated once per process, with its own test or without."""
    options = pipeline.Options(supervises=mode != "controller")
    supervisor = pipeline.synthesize(pipeline.load(model_path(model), options).robot)
    runs = test_files(supervisor, model_path(model), target, DEFAULTS, mode) if tested else {}
    return EMITTERS[target](supervisor, name or f"{model}_{mode}", mode=mode, runs=runs)


def golden_folder(model: str, target: str = "ros1", mode: str = "controller") -> Path:
    return GOLDEN / target / f"{model}_{mode}"


def kept_files(package: Package, target: str = "ros1", mode: str = "controller") -> dict[str, File]:
    """All files but those that are copied as they are, which only would be noise here."""
    copied = ["/_runtime/", *(f"/{source.name}" for source in templates_folder().rglob("*.py"))]
    if mode != "controller":
        # These are the controller's, which a test of its own says.
        copied += ["/controller.py", "/model.py"]
    # These are the same for all targets, which a test of its own says.
    copied += [] if target == "ros1" else ["/controller.py", "/model.py"]
    return {p: f for p, f in package.files.items() if not any(c in f"/{p}" for c in copied)}
