"""The extension for Visual Studio Code: its grammar, what it promises, and that it can be packed."""

from __future__ import annotations

import fcntl
import hashlib
import json
import re
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import pytest
from lsp_support import REPOSITORY

from robosc.cli import VERBS

EXTENSION = REPOSITORY / "editors" / "vscode"
CACHE = REPOSITORY / ".cache" / "vscode"
MANIFEST: dict[str, Any] = json.loads((EXTENSION / "package.json").read_text(encoding="utf-8"))
_NOT_TO_BE_HAD = ("ENOTFOUND", "EAI_AGAIN", "ECONNREFUSED", "ETIMEDOUT", "E404", "ENETUNREACH")


def node_version() -> int:
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return 0
    done = subprocess.run([node, "--version"], capture_output=True, text=True)
    return int(done.stdout.removeprefix("v").split(".")[0])


@pytest.fixture(scope="module")
def folder() -> Path:
    """A copy of the extension with its packages; skips where there are none."""
    if node_version() < 20:
        pytest.skip("needs node 20 or newer, and npm")
    CACHE.mkdir(parents=True, exist_ok=True)
    build = CACHE / "build"
    lock_file = EXTENSION / "package-lock.json"
    made_from = hashlib.sha256(lock_file.read_bytes()).hexdigest()
    stamp = CACHE / "made-from"
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        build.mkdir(exist_ok=True)
        for file in build.iterdir():
            if file.name != "node_modules":
                shutil.rmtree(file) if file.is_dir() else file.unlink()
        shutil.copytree(
            EXTENSION, build, dirs_exist_ok=True, ignore=shutil.ignore_patterns("node_modules")
        )
        if not (stamp.is_file() and stamp.read_text() == made_from):
            install(build)
            stamp.write_text(made_from)
    return build


def install(build: Path) -> None:
    command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    done = subprocess.run(command, cwd=build, capture_output=True, text=True, timeout=280)
    if done.returncode and any(sign in done.stderr for sign in _NOT_TO_BE_HAD):
        pytest.skip("the packages cannot be had: " + done.stderr.strip().splitlines()[0])
    assert done.returncode == 0, done.stdout + done.stderr


def npm(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["npm", *arguments], cwd=folder, capture_output=True, text=True, timeout=200
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_grammar(folder: Path) -> None:
    output = npm(folder, "test")
    for file in (EXTENSION / "test").glob("*.rscd"):
        assert f"test/{file.name} run success" in output


def test_package(folder: Path) -> None:
    npm(folder, "run", "package")
    with zipfile.ZipFile(folder / "robosc.vsix") as package:
        names = set(package.namelist())
    needed = {"extension.js", "package.json", "language-configuration.json", "readme.md"}
    needed |= {"syntaxes/rscd.tmLanguage.json", "snippets/rscd.json"}
    assert {f"extension/{name}" for name in needed} <= names
    assert "extension/node_modules/vscode-languageclient/node.js" in names
    assert not [n for n in names if n.startswith("extension/test/") or "/@vscode/vsce/" in n]


def test_commands_are_verbs_and_registered() -> None:
    code = (EXTENSION / "extension.js").read_text(encoding="utf-8")
    declared = {item["command"] for item in MANIFEST["contributes"]["commands"]}
    assert declared == set(re.findall(r'registerCommand\("([\w.]+)"', code))
    verbs = {verb.name for verb in VERBS}
    assert {name.removeprefix("robosc.") for name in declared} - {"restart"} <= verbs


def test_snippets_are_read_as_they_should_be() -> None:
    """With their defaults, in the block they are for, no snippet has an error of syntax."""
    from robosc.source import Source
    from robosc.syntax.parser import parse

    snippets = json.loads((EXTENSION / "snippets" / "rscd.json").read_text(encoding="utf-8"))
    for name, snippet in snippets.items():
        body = snippet["body"]
        text = body if isinstance(body, str) else "\n".join(body)
        text = re.sub(r"\$\{\d+:([^}]*)\}", r"\1", text).replace("$0", "")
        if name != "Robot":
            text = f"robot R {{\n{text}\n}}\n"
        _, diagnostics = parse(Source("snippet.rscd", text))
        assert not diagnostics, (name, diagnostics)


def test_lock_file_names_no_host() -> None:
    """Whoever installs gets the packages from the registry that npm is told to use."""
    assert "://" not in (EXTENSION / "package-lock.json").read_text(encoding="utf-8")
