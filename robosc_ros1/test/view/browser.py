"""A headless Chromium, driven as the W3C's WebDriver says, by Python's own HTTP client.

``chromedriver`` is all that is needed: Debian's package chromium-driver, which brings chromium.
"""

from __future__ import annotations

import base64
import contextlib
import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

from ros_support import REPOSITORY, await_condition, free_port

__all__ = ["ARTEFACTS", "Browser", "headless", "missing_browser"]

ARTEFACTS = REPOSITORY / ".cache" / "artefacts"
"""Pictures of the page, to be looked at after a run."""

_ARGUMENTS = [
    "--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
    "--force-color-profile=srgb",
]  # fmt: skip


def missing_browser() -> str | None:
    """Why there can be no browser; None if there can."""
    if shutil.which("chromedriver"):
        return None
    return "there is no chromedriver (apt-get install --no-install-recommends chromium-driver)"


class ScriptError(AssertionError):
    """A script in the page raised an error."""


class Browser:
    """One tab."""

    def __init__(self, port: int, session: str) -> None:
        self._port = port
        self._path = f"/session/{session}"

    def open(self, url: str) -> None:
        _call(self._port, "POST", f"{self._path}/url", {"url": url})

    def run(self, script: str, *arguments: Any) -> Any:
        """What a script in the page returns."""
        body = {"script": script, "args": arguments}
        return _call(self._port, "POST", f"{self._path}/execute/sync", body)

    def sees(self, script: str, *arguments: Any) -> Any:
        """Wait until an expression is true in the page.

        What it reads may not have been drawn yet: an expression that raises is not true.
        """
        problem = None

        def true() -> Any:
            nonlocal problem
            try:
                return self.run(f"return {script}", *arguments)
            except ScriptError as error:
                problem = error

        try:
            return await_condition(true, f"{script} {list(arguments)}")
        except AssertionError as error:
            raise error from problem

    def text(self, selector: str) -> str:
        """What is written in an element; empty if there is none."""
        found = self.run("return document.querySelector(arguments[0])?.innerText ?? ''", selector)
        return " ".join(str(found).split())

    def press(self, keys: str) -> None:
        """Type on the keyboard, wherever the focus is."""
        steps = [{"type": kind, "value": key} for key in keys for kind in ("keyDown", "keyUp")]
        actions = [{"type": "key", "id": "keyboard", "actions": steps}]
        _call(self._port, "POST", f"{self._path}/actions", {"actions": actions})

    def mouse(self, *steps: dict[str, Any]) -> None:
        """Move, press and let go of the mouse; what is pressed stays so until the next call."""
        mouse = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}}
        body = {"actions": [{**mouse, "actions": [{"duration": 0, **step} for step in steps]}]}
        _call(self._port, "POST", f"{self._path}/actions", body)

    def middle(self, selector: str) -> dict[str, Any]:
        """A mouse's move to the middle of an element."""
        box = "const r = document.querySelector(arguments[0]).getBoundingClientRect();"
        x, y = self.run(f"{box} return [r.x + r.width / 2, r.y + r.height / 2]", selector)
        return {"type": "pointerMove", "x": round(x), "y": round(y)}

    def look(self, width: int = 1400, height: int = 1000, scheme: str = "light") -> None:
        """Give the window another size and another scheme of colours."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self._command("Emulation.setDeviceMetricsOverride", size)
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self._command("Emulation.setEmulatedMedia", {"features": [feature]})

    def picture(self, name: str) -> Path:
        """Keep what can be seen as ``.cache/artefacts/<name>.png``."""
        ARTEFACTS.mkdir(parents=True, exist_ok=True)
        # The page draws what is read ten times per second, and has another size perhaps.
        self.run("window.settled = false; setTimeout(() => { settled = true }, 150)")
        self.sees("settled")
        data = _call(self._port, "GET", f"{self._path}/screenshot")
        path = ARTEFACTS / f"{name}.png"
        path.write_bytes(base64.b64decode(data))
        return path

    def complaints(self) -> list[str]:
        """Errors on the browser's console since the last call."""
        entries = _call(self._port, "POST", f"{self._path}/se/log", {"type": "browser"})
        return [e["message"] for e in entries if e["level"] == "SEVERE"]

    def _command(self, name: str, parameters: dict[str, Any]) -> Any:
        body = {"cmd": name, "params": parameters}
        return _call(self._port, "POST", f"{self._path}/goog/cdp/execute", body)


@contextlib.contextmanager
def headless(folder: Path) -> Iterator[Browser]:
    """A browser of one's own, its profile and log in ``folder``."""
    port = free_port()
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    with (folder / "chromedriver.log").open("wb") as log:
        driver = subprocess.Popen(
            ["chromedriver", f"--port={port}"], stdout=log, stderr=log, env=os.environ
        )
        try:
            await_condition(lambda: driver.poll() is not None or _ready(port), "chromedriver")
            options = {"args": [*_ARGUMENTS, *sandbox, f"--user-data-dir={folder / 'profile'}"]}
            wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
            body = {"capabilities": {"alwaysMatch": wanted}}
            session = _call(port, "POST", "/session", body)["sessionId"]
            try:
                yield Browser(port, session)
            finally:
                _call(port, "DELETE", f"/session/{session}")
        finally:
            driver.terminate()
            driver.wait(10)


def _ready(port: int) -> bool:
    try:
        return bool(_call(port, "GET", "/status")["ready"])
    except OSError:
        return False


def _call(port: int, method: str, path: str, body: Any = None) -> Any:
    connection = HTTPConnection("127.0.0.1", port, timeout=60)
    try:
        text = None if body is None else json.dumps(body)
        connection.request(method, path, text, {"Content-Type": "application/json"})
        value = json.loads(connection.getresponse().read())["value"]
    finally:
        connection.close()
    if isinstance(value, dict) and "error" in value:
        kind = ScriptError if value["error"] == "javascript error" else AssertionError
        raise kind(f"{value['error']}: {value['message']}")
    return value
