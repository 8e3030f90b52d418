"""An agent for the tests: a client of the protocol, in a process of its own."""

from __future__ import annotations

import json
import queue
import subprocess
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from lsp.lsp_support import Unavailable, client_python
from ros_support import REPOSITORY, SOURCES

PATIENCE = 120.0
"""Seconds for an answer; a busy machine is slow."""
HERE = Path(__file__).resolve().parent


@pytest.fixture(scope="session")
def sdk() -> str:
    """A Python that has the official SDK, and sees ROS where there is one."""
    try:
        found = client_python(HERE / "requirements.txt", REPOSITORY / ".cache" / "mcp")
        # rosrun looks for its executables in the whole checkout, and this has the name of a verb.
        Path(found).with_name("mcp").unlink(missing_ok=True)
        return found
    except Unavailable as reason:
        pytest.skip(f"no SDK of the Model Context Protocol: {reason}")


class Agent:
    """The test's side of ``agent_process.py``."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        self._lines: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.put(line)
        self._lines.put("")

    def begin(self, **order: Any) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(order) + "\n")
        self.process.stdin.flush()

    def hear(self) -> dict[str, Any]:
        """The next line of the agent."""
        line = self._lines.get(timeout=PATIENCE)
        assert line, "the agent has ended"
        found: dict[str, Any] = json.loads(line)
        return found

    def do(self, **order: Any) -> Any:
        """What comes of an order, without what is reported before."""
        self.begin(**order)
        while "progress" in (answer := self.hear()):
            pass
        return answer

    def call(self, tool: str, **arguments: Any) -> dict[str, Any]:
        found: dict[str, Any] = self.do(call=tool, arguments=arguments)
        return found


StartAgent = Callable[..., Any]


@pytest.fixture
def start_agent(sdk: str, tmp_path: Path) -> StartAgent:
    """Starts an agent with a server of its own: ``start_agent(model, "--simulate")``; a context."""

    @contextmanager
    def start(*arguments: str, env: Mapping[str, str], whole: bool = False) -> Iterator[Agent]:
        command = list(arguments) if whole else [sdk, "-m", "robosc", "mcp", *arguments]
        with subprocess.Popen(
            [sdk, str(HERE / "agent_process.py"), *command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            env={**env, "PYTHONPATH": f"{SOURCES}:{env.get('PYTHONPATH', '')}"},
        ) as process:
            agent = Agent(process)
            try:
                yield agent
                if process.poll() is None:  # no test has killed it
                    agent.begin(end=True)
                    assert process.wait(PATIENCE) == 0
            finally:
                process.kill()

    return start
