"""Serves catkin (devel and install space) and a plain ``pip install .`` alike.

What package.xml says is read from there. The templates go to ``share/robosc/templates`` of the
prefix, and the page about diagnostics, to which editors link, to ``share/robosc/docs``;
:mod:`robosc.resources` finds them in every layout. Package data would not do, because
catkin refuses packages that lie in two folders. The page of ``robosc view`` lies in its package.
"""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

ROOT = Path(__file__).resolve().parent
SOURCES = "robosc_ros1/src"
TEMPLATES = "robosc_ros1/templates"

package = ElementTree.parse(ROOT / "package.xml").getroot()


def text(tag: str) -> str:
    return " ".join(package.findtext(tag, "").split())


def shared_files() -> "list[tuple[str, list[str]]]":
    folders = {}
    for file in sorted((ROOT / TEMPLATES).rglob("*")):
        if file.is_file() and "__pycache__" not in file.parts:
            target = Path("share/robosc/templates", file.parent.relative_to(ROOT / TEMPLATES))
            folders.setdefault(target.as_posix(), []).append(file.relative_to(ROOT).as_posix())
    folders["share/robosc/docs"] = ["docs/diagnostics.md"]
    return sorted(folders.items())


setup(
    name=text("name"),
    version=text("version"),
    description=text("description"),
    license=text("license"),
    python_requires=">=3.11",
    install_requires=[
        "catkin_pkg>=0.5",
        "jinja2>=3.1",
        "networkx>=2.8",
        "numpy>=1.24",
        "oxidd>=0.13",
        "pyparsing>=3.0.9",
        "pyyaml>=5",
        "rospkg>=1.4",
    ],
    extras_require={
        "lsp": ["pygls>=2,<3"],
    },
    packages=find_packages(str(ROOT / SOURCES)),
    package_dir={"": SOURCES},
    package_data={"robosc.view": ["page/*"]},
    data_files=shared_files(),
    scripts=["robosc_ros1/scripts/robosc"],
)
