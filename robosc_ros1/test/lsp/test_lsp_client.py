"""The server through a real client: the tests in ``client/``, each file in a pytest of its own."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import IO

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


REFUSED = {
    "without parameters": {"method": "textDocument/hover"},
    "of another form": {"method": "textDocument/hover", "params": {"textDocument": 5}},
    "with a part missing": {"method": "textDocument/rename", "params": {"newName": "x"}},
    "a name that is none": {
        "method": "textDocument/rename",
        "params": {
            "textDocument": {"uri": "file:///robot.rscd"},
            "position": {"line": 0, "character": 7},
            "newName": "no name",
        },
    },
    "an unknown method": {"method": "textDocument/nothing", "params": {}},
    "an unknown method without parameters": {"method": "textDocument/nothing"},
}


def test_every_request_is_answered_and_none_with_a_traceback(client: str, tmp_path: Path) -> None:
    """Byte by byte: a client of a library would not send such requests."""
    opened = {
        "uri": "file:///robot.rscd",
        "languageId": "robosc",
        "version": 1,
        "text": "robot Rover {}",
    }
    messages: list[dict[str, object]] = [
        {"id": "begin", "method": "initialize", "params": {"processId": None, "rootUri": None, "capabilities": {}}},
        {"method": "initialized", "params": {}},
        {"method": "textDocument/didOpen", "params": {"textDocument": opened}},
        {"method": "textDocument/didChange"},  # a notification is faulty as well
        *({"id": name, **message} for name, message in REFUSED.items()),
        {"id": "end", "method": "shutdown"},
    ]  # fmt: skip
    server = subprocess.Popen(
        [client, "-m", "robosc", "lsp"], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(SOURCES)},
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert server.stdin is not None and server.stdout is not None and server.stderr is not None
    answers: dict[object, dict[str, object]] = {}
    for message in messages:
        send(server.stdin, message)
        while "id" in message and message["id"] not in answers:
            answer = received(server.stdout)
            answers[answer.get("id")] = answer
    send(server.stdin, {"method": "exit"})
    _, complaints = server.communicate(timeout=60)
    assert set(REFUSED) == {name for name, answer in answers.items() if "error" in answer}
    assert b"Traceback" not in complaints


def send(stream: IO[bytes], message: dict[str, object]) -> None:
    body = json.dumps({"jsonrpc": "2.0", **message}).encode()
    stream.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
    stream.flush()


def received(stream: IO[bytes]) -> dict[str, object]:
    length = 0
    while line := stream.readline().strip():
        name, _, value = line.partition(b":")
        length = int(value) if name.lower() == b"content-length" else length
    assert length, "the server has ended"
    answer: dict[str, object] = json.loads(stream.read(length))
    return answer


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
