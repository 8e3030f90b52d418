"""Fixtures of the tests of the language server and of the extension that uses it."""

from __future__ import annotations

from pathlib import Path

import pytest
from extension_build import extension_folder
from lsp_support import Unavailable, client_python
from ros_support import SOURCES


@pytest.fixture(scope="session")
def client() -> str:
    """A Python that has pygls."""
    try:
        return client_python()
    except Unavailable as reason:
        pytest.skip(f"no client of the language server: {reason}")


@pytest.fixture(scope="session")
def robosc_program(client: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """robosc as it is installed for editors: with its extra, in an environment of its own."""
    program = tmp_path_factory.mktemp("bin") / "robosc"
    program.write_text(f'#!/bin/sh\nPYTHONPATH={SOURCES} exec {client} -m robosc "$@"\n')
    program.chmod(0o755)
    return program


@pytest.fixture(scope="session")
def extension() -> Path:
    """Where the extension is built."""
    try:
        return extension_folder()
    except Unavailable as reason:
        pytest.skip(str(reason))
