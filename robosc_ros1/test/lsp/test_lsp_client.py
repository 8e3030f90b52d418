"""The server through a real client: the tests in ``client/``, each file in a pytest of its own."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from lsp_support import HERE
from ros_support import SOURCES, run_robosc

FILES = sorted((HERE / "client").glob("client_*.py"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_through_a_client(client: str, file: Path, tmp_path: Path) -> None:
    environment = os.environ | {
        "PYTHONPATH": f"{SOURCES}{os.pathsep}{file.parent}",
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }
    command = [client, "-m", "pytest", "-q", "-c", os.devnull, "--rootdir", str(tmp_path)]
    command += ["--confcutdir", str(file.parent), "-p", "no:cacheprovider"]
    command += ["-o", "asyncio_default_fixture_loop_scope=function"]
    for plugin in ("pytest_asyncio.plugin", "pytest_lsp", "lsp_session"):
        command += ["-p", plugin]
    command += ["--basetemp", str(tmp_path / "tests")]
    done = subprocess.run(
        [*command, str(file)],
        cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def test_missing_library_is_named(tmp_path: Path) -> None:
    """Debian has no pygls: who starts the server there is told what to install."""
    try:
        import pygls.lsp.server  # noqa: F401
    except ModuleNotFoundError:
        done = run_robosc(["lsp"], tmp_path, {})
        assert done.returncode == 2
        assert "pip install 'pygls>=2,<3'" in done.stderr
        assert "Traceback" not in done.stderr
    else:
        pytest.skip("pygls is installed")
