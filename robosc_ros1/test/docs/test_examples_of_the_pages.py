"""What the pages for users show is what robosc does.

Fenced blocks marked ``rscd`` are models. The words behind it say how to read a block:

``robot``, ``component``, ``behaviour``
    it is a part, to be put into a robot, into a component ``Example`` of one, into the behaviour of
    that component. The robot has all declarations of the page's first block that the part does
    not make itself.
``file=NAME``
    later blocks find it under this name.
``needs=PACKAGE/TYPE``
    the example is about a message definition of ROS.
any other word
    the code that the block must show.

Fenced blocks marked ``console`` show commands, run at the root of the repository, and the lines of
their output; a line ``…`` stands for any number of lines.
"""

from __future__ import annotations

import re
import shlex
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from robosc import cli, pipeline
from robosc.codes import CODES
from robosc.errors import Severity, render_all
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import Interface
from robosc.source import Source
from robosc.syntax.parser import parse

ROOT = Path(__file__).parents[3]
PAGES = sorted((ROOT / "docs").glob("*.md"))
_BLOCK = re.compile(r"^([ ]*)```(\w+)([^\n]*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
_OF_WHOLES = ("no-stop", "stale-data", "stale-event")
_LEVELS = ("robot", "component", "behaviour")


@dataclass(frozen=True)
class Block:
    page: Path
    line: int
    words: tuple[str, ...]
    text: str

    @property
    def codes(self) -> set[str]:
        return {w for w in self.words if w not in _LEVELS and "=" not in w}

    def option(self, name: str) -> str | None:
        found = [w.partition("=")[2] for w in self.words if w.startswith(f"{name}=")]
        return found[0] if found else None

    def __str__(self) -> str:
        return f"{self.page.name}:{self.line}"


def blocks(language: str) -> Iterator[Block]:
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for match in _BLOCK.finditer(text):
            if match[2] == language:
                line = text.count("\n", 0, match.start()) + 1
                body = textwrap.dedent(match[4])
                yield Block(page, line, tuple(match[3].split()), body)


MODELS = list(blocks("rscd"))
COMMANDS = list(blocks("console"))


def whole(block: Block) -> str:
    """The block as a file."""
    level = next((w for w in block.words if w in _LEVELS), None)
    if level is None:
        return block.text
    text = block.text
    if level == "behaviour":
        text = f"behaviour {{\n{text}}}\n"
    if level != "robot":
        text = f"component Example {{\n{text}}}\n"
    own = set(re.findall(r"^\s*(?:component|interface|datatype \w+) (\w+)", text, re.MULTILINE))
    first = next(b for b in MODELS if b.page == block.page)
    node, faults = parse(Source("first.rscd", first.text))
    assert node is not None and not faults
    rest = [d.span.text for d in node.declarations if hasattr(d, "name") and d.name.text not in own]
    return "robot Page {\n" + text + "\n".join(rest) + _COMMON + "}\n"


_COMMON = "\ninterface empty use Empty from std_srvs\n"


def is_told(code: str, block: Block) -> bool:
    """Whether a diagnostic counts.

    A part of a model leaves names unused and commands without requirement or data, and need not be
    about silence or the node's end; and which packages are installed is not the page's concern.
    """
    entry = CODES[code]
    if code in block.codes or entry.severity is Severity.ERROR:
        return True
    is_part = any(w in _LEVELS for w in block.words)
    return code != "package-not-found" and not (
        is_part and (entry.needs_plant or code.startswith("unused-") or code in _OF_WHOLES)
    )


@pytest.mark.parametrize("block", MODELS, ids=str)
def test_model_shows_what_the_page_says(block: Block, tmp_path: Path) -> None:
    definition = block.option("needs")
    if definition is not None:
        package, _, type_ = definition.partition("/")
        if not isinstance(
            MessageDefinitions.for_model(ROOT).interface(package, type_, "msg"), Interface
        ):
            pytest.skip(f"{definition} is not installed")
    for other in MODELS:
        name = other.option("file")
        if name is not None and other.page == block.page:
            (tmp_path / name).write_text(other.text, encoding="utf-8")
    model = tmp_path / (block.option("file") or "page.rscd")
    model.write_text(whole(block), encoding="utf-8")
    checked = pipeline.check(model)
    found = {d.code for d in checked.diagnostics if is_told(d.code, block)}
    assert found == block.codes, render_all(checked.diagnostics)


@pytest.mark.parametrize("block", COMMANDS, ids=str)
def test_command_prints_what_the_page_says(
    block: Block, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    first, _, shown = block.text.partition("\n")
    program, *arguments = shlex.split(first.removeprefix("$ "))
    assert program == "robosc"
    cli.main(arguments)
    printed = capsys.readouterr()
    output = _steady(printed.err + printed.out)
    pattern = re.escape(_steady(shown)).replace(re.escape("…\n"), r"(?:.*\n)*?")
    assert re.fullmatch(pattern, output), output


def _steady(text: str) -> str:
    return re.sub(r"\d+\.\d+ s\b", "0.0 s", text)


def test_every_link_leads_somewhere() -> None:
    lost = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)\s]+)\)", _BLOCK.sub("", text)):
            if "://" in target:
                continue
            path, _, anchor = target.partition("#")
            other = page if not path else page.parent / path
            if not other.exists() or (anchor and anchor not in _anchors(other)):
                lost.append(f"{page.name}: {target}")
    assert lost == []


def _anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h).strip().lower().replace(" ", "-") for h in headings}


LONGEST_SENTENCE = 45
"""Words, outside of examples and tables."""


@pytest.mark.parametrize(
    "page", [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name
)
def test_sentences_can_be_read(page: Path) -> None:
    text = re.sub(r"^ *```.*?^ *```", "\n", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    prose = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("|"))
    paragraphs = re.split(r"\n\s*\n|\n\s*[-*] |\n\d+\. ", prose)
    sentences = [s for paragraph in paragraphs for s in re.split(r"[.:?!;]\s+", paragraph)]
    assert [s for s in sentences if len(s.split()) > LONGEST_SENTENCE] == []


def test_the_index_names_every_page() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    assert [p.name for p in PAGES if p.name != "README.md" and f"]({p.name})" not in index] == []


def test_no_page_speaks_of_editions() -> None:
    """Marks such as (3), which only those understand who wrote the language."""
    assert [p.name for p in PAGES if re.search(r"(^|\s)\(\d\)(\s|$)", p.read_text())] == []
