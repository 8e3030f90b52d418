"""What the extension's README says for other editors, word by word, in these editors."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from extension_build import EXTENSION
from ros_support import EXAMPLES

README = (EXTENSION / "README.md").read_text(encoding="utf-8")
MODEL = EXAMPLES / "line_follower_unhandled" / "line_follower_unhandled.rscd"

NEOVIM = """\
vim.wait(60000, function() return #vim.diagnostic.get(0) >= 2 end, 50)
for _, found in ipairs(vim.diagnostic.get(0)) do print(found.code, found.lnum + 1) end
vim.fn.search("action grab")
vim.fn.search("grab")
local place = vim.lsp.util.make_position_params()
local answers = vim.lsp.buf_request_sync(0, "textDocument/hover", place, 30000)
for _, answer in pairs(answers) do print(answer.result.contents.value) end
print(vim.bo.filetype)
"""
EMACS = """\
(require 'flymake)
(setq eglot-sync-connect 60)
(find-file (pop command-line-args-left))
(run-hooks 'post-command-hook)
(let ((left 600))
  (while (and (> left 0) (< (length (flymake-diagnostics)) 2))
    (setq left (1- left))
    (accept-process-output nil 0.1)))
(dolist (found (flymake-diagnostics)) (message "%s" (flymake-diagnostic-text found)))
(search-forward "action gra")
(message "%S" (jsonrpc-request (eglot--current-server-or-lose) :textDocument/hover
                               (eglot--TextDocumentPositionParams)))
(message "%s" major-mode)
"""


def block(language: str, words: str) -> str:
    """The block of the README that has these words."""
    blocks = re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)
    (found,) = [b for b in blocks if words in b]
    return str(found)


@pytest.fixture
def home(robosc_program: Path, tmp_path: Path) -> Path:
    """Someone's home, where robosc is installed as the README says."""
    program = tmp_path / ".robosc" / "bin" / "robosc"
    program.parent.mkdir(parents=True)
    program.symlink_to(robosc_program)
    shutil.copy(MODEL, tmp_path / "model.rscd")
    return tmp_path


def shown(command: list[str], home: Path) -> str:
    done = subprocess.run(
        [*command], cwd=home, env=os.environ | {"HOME": str(home)},
        capture_output=True, text=True, timeout=600, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    return " ".join((done.stdout + done.stderr).split())


def test_neovim(home: Path) -> None:
    if shutil.which("nvim") is None:
        pytest.skip("there is no Neovim (apt-get install neovim)")
    (home / "init.lua").write_text(block("lua", "start_client"))
    (home / "try.lua").write_text(NEOVIM)
    found = shown(
        [
            "nvim",
            "--headless",
            "-u",
            "init.lua",
            "model.rscd",
            "-c",
            "luafile try.lua",
            "-c",
            "qa!",
        ],
        home,
    )
    assert "never-allowed 39" in found and "package-not-found" in found
    assert "`request` is never allowed" in found and "on error from grab goto idle" in found
    assert found.endswith("rscd")


def test_emacs(home: Path) -> None:
    probe = ["emacs", "--batch", "-f", "package-initialize", "--eval"]
    if shutil.which("emacs") is None or subprocess.run([*probe, "(require 'eglot)"]).returncode:
        pytest.skip("there is no Emacs with eglot (apt-get install emacs-nox elpa-eglot)")
    (home / "init.el").write_text(block("elisp", "eglot-ensure"))
    (home / "try.el").write_text(EMACS)
    found = shown([*probe[:-1], "-l", "init.el", "-l", "try.el", "model.rscd"], home)
    assert "[never-allowed]" in found and "[package-not-found]" in found
    assert "`request` is never allowed" in found and "on error from grab goto idle" in found
    assert "rscd-mode" in found.rpartition("`cancel`")[2]
