"""The models whose packages are kept as golden ones, and how they are generated."""

from __future__ import annotations

from pathlib import Path

from robosc import pipeline
from robosc.emit.package import File, Package
from robosc.emit.ros1 import emit

__all__ = ["MODELS", "golden_folder", "kept_files", "model_path", "package_of"]

GOLDEN = Path(__file__).resolve().parents[1] / "golden"

MODELS = ("lantern", "gauntlet")
"""``lantern`` needs no message definitions; ``gauntlet`` those of gauntlet_interfaces beside it."""


def model_path(model: str) -> Path:
    return GOLDEN / "models" / f"{model}.rscd"


def package_of(model: str) -> Package:
    supervisor = pipeline.synthesize(pipeline.load(model_path(model)).robot)
    return emit(supervisor, f"{model}_controller")


def golden_folder(model: str) -> Path:
    return GOLDEN / "ros1" / f"{model}_controller"


def kept_files(package: Package) -> dict[str, File]:
    """All files but those that are copied as they are, which only would be noise here."""
    copied = ("/_runtime/", "/ros.py", "test/judge.py", "test/shadow.py")
    return {p: f for p, f in package.files.items() if not any(c in f"/{p}" for c in copied)}
