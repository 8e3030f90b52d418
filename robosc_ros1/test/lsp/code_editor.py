"""Visual Studio Code in a browser (code-server), with the extension installed, for tests.

What a test does goes through the keyboard and the command palette, as a user's hands would; what it
sees is what the page shows.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path

from lsp_support import REPOSITORY, Unavailable
from ros_support import await_condition, free_port
from view.browser import Browser

__all__ = ["Code", "code_server", "running_code"]

CACHE = REPOSITORY / ".cache" / "code-server"
VERSION = "4.100.3"
BACKSPACE, DOWN, END, ENTER, ESCAPE = "\ue003", "\ue015", "\ue010", "\ue007", "\ue00c"
PALETTE = "\ue031"

_SETTINGS = {
    "chat.commandCenter.enabled": False,
    "editor.minimap.enabled": False,
    "files.autoSave": "off",  # what a test left would be written over what the next one opens
    "files.simpleDialog.enable": True,
    "extensions.autoCheckUpdates": False,
    "remote.autoForwardPorts": False,
    "security.workspace.trust.enabled": False,
    "telemetry.telemetryLevel": "off",
    "terminal.integrated.gpuAcceleration": "off",  # so that its text is in the page
    "window.menuBarVisibility": "hidden",
    "workbench.startupEditor": "none",
    "workbench.tips.enabled": False,
}
# Of its native modules only those of terminals and passwords are built; it does without the others.
_INSTALL = f"""
npm init --yes
npm install --ignore-scripts --no-audit --no-fund code-server@{VERSION}
npm rebuild argon2
cd node_modules/code-server/lib/vscode
npm install --ignore-scripts --no-audit --no-fund --omit=dev
ln -s node_modules node_modules.asar
npm rebuild node-pty || ls node_modules/node-pty/build/Release/pty.node
node ../../out/node/entry.js --version
"""


def code_server() -> list[str]:
    """How it is started; installed by npm if it is not there.

    Raises:
        Unavailable: it cannot be had here.
    """
    CACHE.mkdir(parents=True, exist_ok=True)
    folder = CACHE / VERSION
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "installed").exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            _install(folder)
            (folder / "installed").touch()
    return ["node", str(folder / "node_modules" / "code-server" / "out" / "node" / "entry.js")]


def _install(folder: Path) -> None:
    command = ["sh", "-e", "-c", _INSTALL]
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
    except subprocess.TimeoutExpired:
        raise Unavailable("installing code-server takes too long") from None
    if done.returncode:
        reasons = [line for line in done.stderr.splitlines() if "rror" in line]
        raise Unavailable(f"code-server cannot be installed: {reasons[0] if reasons else '?'}")


class Code:
    """One window of the editor, open on a folder."""

    def __init__(self, browser: Browser, address: str, folder: Path) -> None:
        self.browser = browser
        self._address = address
        self.folder = folder

    def start(self) -> None:
        """Open the window."""
        self.browser.open(f"http://{self._address}/?folder={self.folder}")
        self.sees("document.querySelector('.monaco-workbench .explorer-folders-view')")
        self.palette("View: Toggle Primary Side Bar Visibility")

    def open(self, name: str) -> None:
        """Show a file of the folder."""
        self.palette("File: Open File...")
        self.asks(f"{self.folder}/")
        self.type(name)
        self.shows(".quick-input-list .monaco-list-row", name)
        self.asks(f"{self.folder}/{name}")
        self.type(ENTER)
        self.sees("document.querySelector('.tab.active')?.innerText.includes(arguments[0])", name)
        self.sees("document.querySelector('.view-line')?.innerText")

    def close(self) -> None:
        """Close the file that is shown, if there is one, as it is on disk."""
        if self.browser.run("return document.querySelector('.tab.active')"):
            self.palette("View: Revert and Close Editor")
            self.sees("!document.querySelector('.tab.active')")

    @property
    def is_saved(self) -> bool:
        """Whether the file that is shown is as it is on disk."""
        return bool(self.browser.run("return document.querySelector('.tab.active:not(.dirty)')"))

    def sees(self, script: str, *arguments: object) -> object:
        """Wait until an expression is true in the page; what is seen instead is kept as a picture."""
        try:
            return self.browser.sees(script, *arguments)
        except AssertionError:
            self.picture("editor-failed")
            raise

    def shows(self, selector: str, text: str) -> None:
        """Wait until elements have a text, blanks aside."""
        self.sees(
            "[...document.querySelectorAll(arguments[0])].map(e => e.innerText).join(' ')"
            ".replace(/[\\s\\u00a0\\u200b]+/g, ' ').includes(arguments[1])",
            selector,
            text,
        )

    def asks(self, text: str) -> None:
        """Wait until the input at the top has a text."""
        self.sees(
            "document.querySelector('.quick-input-widget input')?.value === arguments[0]", text
        )

    def problems(self, text: str) -> None:
        """Wait until the status bar counts so many faults: ``Errors: 1, Warnings: 2``."""
        script = "document.getElementById('status.problems')?.ariaLabel?.startsWith(arguments[0])"
        self.sees(script, text)

    def type(self, text: str) -> None:
        self.browser.press(text)

    def palette(self, command: str) -> None:
        """Do a command of the palette by its title."""
        self.type(PALETTE)
        self.sees("document.activeElement?.closest('.quick-input-widget')")
        self.type(command)
        rows = "[...document.querySelectorAll('.quick-input-list .monaco-list-row')]"
        named = "row => row.ariaLabel?.startsWith(arguments[0])"
        self.sees(f"{rows}.some({named})", command)
        while not self.browser.run(f"return {rows}.find({named})?.matches('.focused')", command):
            self.type(DOWN)
        self.type(ENTER)

    def go_to(self, line: int, column: int) -> None:
        """Put the cursor there."""
        self.palette("Go to Line/Column...")
        self.asks(":")
        self.type(f"{line}:{column}{ENTER}")
        self.shows(".statusbar-item", f"Ln {line}, Col {column}")

    def picture(self, name: str) -> None:
        self.browser.picture(name)


@contextlib.contextmanager
def running_code(
    browser: Browser, command: list[str], extension: Path, robosc: Path, home: Path
) -> Iterator[Code]:
    """An editor with the extension; ``robosc`` is the program for the language server and verbs."""
    for folder in ("models", "data/User"):
        (home / folder).mkdir(parents=True)
    settings = _SETTINGS | {"robosc.command": [str(robosc)]}
    (home / "data/User/settings.json").write_text(json.dumps(settings))
    environment = os.environ | {"HOME": str(home), "PS1": "$ "}
    command = [*command, "--user-data-dir", str(home / "data"), "--extensions-dir"]
    command += [str(home / "extensions"), "--auth", "none"]
    with (home / "log").open("wb") as log:
        subprocess.run(
            [*command, "--install-extension", str(extension)],
            env=environment, stdout=log, stderr=log, check=True, timeout=600,
        )  # fmt: skip
        address = f"127.0.0.1:{free_port()}"
        server = subprocess.Popen(
            [*command, "--bind-addr", address, "--disable-telemetry", "--disable-update-check"],
            env=environment, stdout=log, stderr=log,
        )  # fmt: skip
        try:
            await_condition(lambda: server.poll() is not None or _is_up(address), "code-server")
            yield Code(browser, address, home / "models")
            browser.open("about:blank")
        finally:
            server.terminate()
            server.wait(60)


def _is_up(address: str) -> bool:
    connection = HTTPConnection(address, timeout=600)
    try:
        connection.request("GET", "/healthz")
        return connection.getresponse().status == 200
    except OSError:
        return False
    finally:
        connection.close()
