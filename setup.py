"""Serves catkin (devel and install space), colcon and a plain ``pip install .`` alike.

What package.xml says is read from there. The templates go to ``share/robosc/templates`` of the
prefix, and the page about diagnostics, to which editors link, to ``share/robosc/docs``;
:mod:`robosc.resources` finds them in every layout. Package data would not do, because
catkin refuses packages that lie in two folders. The page of ``robosc view`` lies in its package.

pip gives one command ``robosc``. colcon, whose packages of the type ament_python are installed by
this file, gives ``ros2 run robosc VERB`` as catkin's CMakeLists.txt gives ``rosrun robosc VERB``.
"""

import os
import sys
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

ROOT = Path(__file__).resolve().parent
SOURCES = "robosc_ros1/src"
SCRIPTS = "robosc_ros1/scripts"
EXTRAS = ".cache/extras"
TEMPLATES = "robosc_ros1/templates"
LIBRARIES = "robosc_ros1/libraries"
FOR_ROS_2 = os.environ.get("ROS_VERSION") == "2"
BUILT_BY_ROS = bool({"install", "develop"}.intersection(sys.argv))
BY_COLCON = FOR_ROS_2 and BUILT_BY_ROS

package = ElementTree.parse(ROOT / "package.xml").getroot()


def text(tag: str) -> str:
    return " ".join(package.findtext(tag, "").split())


def shared_files() -> "list[tuple[str, list[str]]]":
    folders = {"share/robosc/docs": ["docs/diagnostics.md"]}

    def share(files: "list[Path]", source: str, target: str) -> None:
        for file in sorted(files):
            if file.is_file() and "__pycache__" not in file.parts:
                folder = Path("share/robosc", target, file.parent.relative_to(ROOT / source))
                path = file.relative_to(ROOT).as_posix()
                folders.setdefault(folder.as_posix(), []).append(path)

    share([*(ROOT / TEMPLATES).rglob("*")], TEMPLATES, "templates")
    share([*(ROOT / LIBRARIES).rglob("*")], LIBRARIES, "libraries")
    if BUILT_BY_ROS and Path(EXTRAS).is_dir():
        # What ./dev setup has fetched, because no archive has a package of it.
        extras = ROOT / EXTRAS
        fetched = [
            file for file in extras.rglob("*") if "faudes" not in str(file.relative_to(extras))
        ]
        share(fetched, EXTRAS, "extras")
    if FOR_ROS_2:
        folders["share/robosc"] = ["package.xml"]
        folders["share/ament_index/resource_index/packages"] = ["robosc_ros1/resource/robosc"]
    return sorted(folders.items())


def executables() -> "dict[str, object]":
    """pip's command, or colcon's for ``ros2 run``, with the folder in which that looks."""
    if not BY_COLCON:
        return {"scripts": [f"{SCRIPTS}/robosc"]}
    names = sorted(file.name for file in (ROOT / SCRIPTS).iterdir())
    return {
        "entry_points": {"console_scripts": [f"{n} = robosc.executables:{n}" for n in names]},
        "options": {
            "install": {"install_scripts": "$base/lib/robosc"},
            "develop": {"script_dir": "$base/lib/robosc"},
        },
    }


setup(
    name=text("name"),
    version=text("version"),
    description=text("description"),
    license=text("license"),
    python_requires=">=3.10",
    # The lower bounds are the versions of Ubuntu 22.04, with which the tests have passed.
    install_requires=[
        "argcomplete>=1.8.1",
        "catkin_pkg>=0.5",
        "jinja2>=3.0.3",
        "oxidd>=0.13",
        "pyparsing>=2.4.7",
        "pyyaml>=5",
        "rospkg>=1.4",
    ],
    extras_require={
        "bags": ["rosbags>=0.11"],
        "lsp": ["pygls>=2,<3"],
        "mcp": ["mcp>=2.3,<3"],
    },
    packages=find_packages(str(ROOT / SOURCES)),
    package_dir={"": SOURCES},
    package_data={
        "robosc.lsp.completion": ["snippets.txt"],
        "robosc.new": ["small.rscd"],
        "robosc.view": ["page/*"],
    },
    data_files=shared_files(),
    **executables(),
)
