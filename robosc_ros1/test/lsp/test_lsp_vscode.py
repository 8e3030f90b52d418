"""The extension for Visual Studio Code: its grammar, what it promises, and that it can be packed."""

from __future__ import annotations

import json
import re
import shutil
import zipfile
from pathlib import Path
from typing import Any

from extension_build import EXTENSION, npm
from view.browser import ARTEFACTS

from robosc.verbs import VERBS

MANIFEST: dict[str, Any] = json.loads((EXTENSION / "package.json").read_text(encoding="utf-8"))


def test_grammar(extension: Path) -> None:
    output = npm(extension, "test")
    for file in (EXTENSION / "test").glob("*.rscd"):
        assert f"test/{file.name} run success" in output


def test_package(extension: Path) -> None:
    npm(extension, "run", "package")
    with zipfile.ZipFile(extension / "robosc.vsix") as package:
        names = set(package.namelist())
    needed = {"extension.js", "package.json", "language-configuration.json", "readme.md"}
    needed |= {"syntaxes/rscd.tmLanguage.json"}
    assert {f"extension/{name}" for name in needed} <= names
    assert "extension/node_modules/vscode-languageclient/node.js" in names
    assert not [n for n in names if n.startswith("extension/test/") or "/@vscode/vsce/" in n]
    ARTEFACTS.mkdir(parents=True, exist_ok=True)  # ready to be installed, for whoever has no npm
    shutil.copy(extension / "robosc.vsix", ARTEFACTS)


def test_commands_are_verbs_and_registered() -> None:
    code = (EXTENSION / "extension.js").read_text(encoding="utf-8")
    declared = {item["command"] for item in MANIFEST["contributes"]["commands"]}
    assert declared == set(re.findall(r'registerCommand\("([\w.]+)"', code))
    verbs = {verb.name for verb in VERBS}
    assert {name.removeprefix("robosc.") for name in declared} - {"restart"} <= verbs


def test_lock_file_names_no_host() -> None:
    """Whoever installs gets the packages from the registry that npm is told to use."""
    assert "://" not in (EXTENSION / "package-lock.json").read_text(encoding="utf-8")
