"""What the simulator looks like at a terminal, as a picture to be looked at."""

from __future__ import annotations

import html
import re
from pathlib import Path

import pytest
from simulate.typed_terminal import Terminal
from view.browser import headless, missing_browser

_PAGE = """\
<!doctype html><meta charset="utf-8"><style>
body { margin: 0; background: #fff; } pre { margin: 16px; font: 14px/1.4 monospace; color: #222; }
.p1 { font-weight: bold; } .p2 { color: #777; } .p31 { color: #b00020; } .p32 { color: #0a7d33; }
.p36 { color: #00708c; }
</style>"""


def page(shown: str) -> str:
    """What was written to a terminal, as a page: paints of text, and nothing that moves a cursor."""
    text = re.sub(r"\x1b\[\?[0-9;]*[a-z]|\r", "", shown)
    text = re.sub(r"(?s)\x1b\[(\d+)m(.*?)\x1b\[0m", "\x02\\1\x03\\2\x04", text)
    text = re.sub("\x02(\\d+)\x03", r'<span class="p\1">', html.escape(text, quote=False))
    return f"{_PAGE}<pre>{text.replace(chr(4), '</span>')}</pre>"


@pytest.mark.slow
def test_the_way_to_an_obstacle(tmp_path: Path) -> None:
    reason = missing_browser()
    if reason is not None:
        pytest.skip(reason)
    terminal = Terminal("readline", columns=96)
    try:
        terminal.await_prompt()
        terminal.type("goto ObstacleGrabber.grabbing\r")
        shown = terminal.await_text("it is busy")
        shown += "it is busy" + terminal.await_text("\n>")
    finally:
        terminal.close()
    (tmp_path / "page.html").write_text(page(f">{shown}\n>"))
    with headless(tmp_path) as browser:
        browser.look(860, 680)
        browser.open((tmp_path / "page.html").as_uri())
        forbidden = "[...document.querySelectorAll('.p31')].map(e => e.textContent.trim())"
        assert "move.request" in browser.run(f"return {forbidden}")
        assert "\x1b" not in browser.text("pre")
        browser.picture("simulate")
