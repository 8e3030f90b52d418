"""The extension in Visual Studio Code itself, by keyboard and eye."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from code_editor import BACKSPACE, END, ENTER, ESCAPE, Code, code_server, running_code
from extension_build import npm
from lsp_support import Unavailable
from ros_support import EXAMPLES, await_condition
from view.browser import headless, missing_browser

pytestmark = pytest.mark.timeout(600)  # the first time, code-server is installed
MODEL = EXAMPLES / "line_follower_unhandled" / "line_follower_unhandled.rscd"
TEXT = MODEL.read_text(encoding="utf-8")
TERMINAL = ".terminal-wrapper.active .xterm-rows"


def place(words: str) -> tuple[int, int]:
    """Line and column of words in the model."""
    before = TEXT[: TEXT.index(words)]
    return before.count("\n") + 1, len(before.rpartition("\n")[2]) + 1


@pytest.fixture(scope="module")
def editor(
    extension: Path, robosc_program: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Code]:
    reason = missing_browser()
    if reason is not None:
        pytest.skip(reason)
    try:
        command = code_server()
    except Unavailable as reason:
        pytest.skip(str(reason))
    npm(extension, "run", "package")
    home = tmp_path_factory.mktemp("code")
    with (
        headless(tmp_path_factory.mktemp("browser")) as browser,
        running_code(browser, command, extension / "robosc.vsix", robosc_program, home) as code,
    ):
        browser.look(1000, 640)
        code.start()
        yield code


@pytest.fixture
def code(editor: Code) -> Code:
    """The editor with the model, when synthesis has told what it found, too."""
    model = editor.folder / MODEL.name
    if model.is_file() and model.read_text(encoding="utf-8") == TEXT and editor.is_saved:
        return editor  # as the test before had it
    editor.close()
    # A package beside it would be offered while the model's name is typed.
    shutil.rmtree(editor.folder / "line_follower_controller", ignore_errors=True)
    shutil.copy(MODEL, editor.folder / MODEL.name)
    editor.open(MODEL.name)
    editor.problems("Warnings: 2")
    return editor


def test_hover_tells_what_synthesis_found(code: Code) -> None:
    code.go_to(*place("grab with"))
    code.palette("Show or Focus Hover")
    code.shows(".monaco-hover", "request is never allowed")
    code.shows(".monaco-hover", "on error from grab")
    code.picture("editor-hover")


def test_quick_fix_carries_out_the_remedy(code: Code) -> None:
    code.go_to(*place("grab with"))
    code.palette("Quick Fix...")
    code.shows(".action-widget", "on error from grab")
    code.picture("editor-quick-fix")
    code.type(ENTER)
    code.shows(".view-lines", "on error from grab goto idle")


def test_faults_are_told_while_typing_and_names_completed(code: Code) -> None:
    line, _ = place("requirement move needs ObstacleGrabber")
    code.go_to(line, 1)
    code.type(f"{END} and Motors{ESCAPE}")
    code.problems("Errors: 1")
    code.sees("document.querySelector('.squiggly-error')")
    code.type(BACKSPACE * len("Motors") + "DistanceSensor.")
    code.shows(".suggest-widget .monaco-list-row", "current")
    code.picture("editor-completion")


def test_renaming_and_going_to_the_declaration(code: Code) -> None:
    code.go_to(*place("current = free"))
    code.palette("Go to Definition")
    line, column = place("current: Clearance")
    code.shows(".statusbar-item", f"Ln {line}, Col {column}")
    code.palette("Rename Symbol")
    # The old name is selected a moment after its input is there: what is typed before is put beside it.
    code.sees("document.activeElement?.classList.contains('rename-input')")
    code.sees(
        "(input => input.value.slice(input.selectionStart, input.selectionEnd) === 'current')"
        "(document.activeElement)"
    )
    code.type("clearance")
    code.sees("document.activeElement?.value === 'clearance'")
    code.type(ENTER)
    code.shows(".view-lines", "variable clearance: Clearance")
    code.problems("Warnings: 2")


@pytest.mark.parametrize(
    ("command", "shown"),
    [
        ("Check Model", "1 file: 0 errors, 2 warnings"),
        ("Simulate", "from where no marked state can be reached"),
        ("View", "http://127.0.0.1:"),
    ],
)
def test_commands_run_verbs_in_a_terminal(code: Code, command: str, shown: str) -> None:
    code.palette(f"RoboSC: {command}")
    code.shows(TERMINAL, shown)
    code.picture(f"editor-{command.split()[0].lower()}")


def test_a_controller_is_generated_into_the_folder_that_is_chosen(code: Code) -> None:
    code.palette("RoboSC: Generate Controller")
    code.asks(f"{code.folder}/")
    code.type(ENTER)
    code.shows(TERMINAL, "line_follower_controller")
    manifest = code.folder / "line_follower_controller" / "package.xml"
    await_condition(manifest.is_file, "the package")


def test_a_server_that_does_not_start_says_why(code: Code, robosc_program: Path) -> None:
    text = robosc_program.read_text()
    robosc_program.write_text("#!/bin/sh\necho 'this robosc is broken' >&2\nexit 2\n")
    try:
        code.palette("RoboSC: Restart Language Server")
        code.shows(".notification-list-item-message", "does not start: this robosc is broken")
    finally:
        robosc_program.write_text(text)
    code.palette("RoboSC: Restart Language Server")
    code.problems("Warnings: 2")
    code.palette("Notifications: Clear All Notifications")


def test_a_restart_while_a_server_is_starting(code: Code, robosc_program: Path) -> None:
    text = robosc_program.read_text()
    begun = robosc_program.with_name("begun")
    robosc_program.write_text(f"#!/bin/sh\ntouch {begun}\nexec sleep 600\n")
    try:
        code.palette("RoboSC: Restart Language Server")
        await_condition(begun.exists, "the server that answers nothing")
    finally:
        robosc_program.write_text(text)
    code.palette("RoboSC: Restart Language Server")
    code.problems("Warnings: 2")
