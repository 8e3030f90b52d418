"""The models whose packages are kept as golden ones, and how they are generated."""

from __future__ import annotations

from pathlib import Path

from robosc import pipeline
from robosc.emit import ros1, ros2
from robosc.emit.package import File, Package

__all__ = ["MODELS", "TARGETS", "golden_folder", "kept_files", "model_path", "package_of"]

GOLDEN = Path(__file__).resolve().parents[1] / "golden"

TARGETS = {"ros1": ros1.emit, "ros2": ros2.emit}

MODELS = ("lantern", "gauntlet")
"""``lantern`` needs no message definitions; ``gauntlet`` those of gauntlet_interfaces beside it."""


def model_path(model: str) -> Path:
    return GOLDEN / "models" / f"{model}.rscd"


def package_of(model: str, target: str = "ros1") -> Package:
    supervisor = pipeline.synthesize(pipeline.load(model_path(model)).robot)
    return TARGETS[target](supervisor, f"{model}_controller")


def golden_folder(model: str, target: str = "ros1") -> Path:
    return GOLDEN / target / f"{model}_controller"


def kept_files(package: Package, target: str = "ros1") -> dict[str, File]:
    """All files but those that are copied as they are, which only would be noise here."""
    copied = ["/_runtime/", "test/judge.py", "test/shadow.py"]
    copied += [f"/{name}" for name in (ros1 if target == "ros1" else ros2).WIRING]
    # These are the same for all targets, which a test of its own says.
    copied += [] if target == "ros1" else ["/controller.py", "/model.py", "test/plant_data.py"]
    return {p: f for p, f in package.files.items() if not any(c in f"/{p}" for c in copied)}
