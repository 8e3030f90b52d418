"""Files as they come from disk: encodings, line ends, files that are none."""

from __future__ import annotations

from pathlib import Path

import pytest

from robosc.errors import UsageError, render_all
from robosc.source import Source
from robosc.syntax.parser import parse, read_source

MODEL = "robot R {\n    // é\n    requirement a needs b\n}\n"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "m.rscd"


def messages(path: Path, data: bytes) -> str:
    """All messages about a file, its folder left out."""
    path.write_bytes(data)
    source, diagnostics = read_source(str(path))
    if source is not None:
        diagnostics = parse(source)[1]
    return render_all(diagnostics).replace(str(path), "m.rscd")


@pytest.mark.parametrize(
    "data",
    [
        MODEL.encode(),
        MODEL.encode("utf-8-sig"),
        MODEL.replace("\n", "\r\n").encode(),
        MODEL.replace("\n", "\r\n").encode("utf-8-sig"),
        MODEL.replace("\n", "\r").encode(),
    ],
    ids=["plain", "mark", "windows", "windows and mark", "old"],
)
def test_marks_and_line_ends_make_no_difference(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    source, diagnostics = read_source(str(path))
    assert source is not None
    assert (source.path, source.text, diagnostics) == (str(path), MODEL, ())


def test_bytes_that_are_no_text_are_shown(path: Path) -> None:
    assert messages(path, b"robot R {\r\n    // caf\xe9\r\n}") == (
        "m.rscd:2:11: error[invalid-utf8]: the byte 0xE9 is not UTF-8 text\n"
        "    2 |     // caf�\n"
        "      |           ^ save the file as UTF-8\n"
    )


def test_utf16_is_named(path: Path) -> None:
    assert "this looks like UTF-16" in messages(path, MODEL.encode("utf-16"))


def test_a_file_with_nul_is_one_fault(path: Path) -> None:
    assert messages(path, b"\x7fELF\0\0\0\1\0;;;;\0") == (
        "m.rscd:1:5: error[bad-character]: the file contains a NUL character\n"
        "    1 | �ELF�����;;;;�\n"
        "      |     ^\n"
    )


def test_an_empty_file_says_what_a_file_holds(path: Path) -> None:
    assert "expected 'robot' or 'library', but the file ends here" in messages(path, b"")


@pytest.mark.parametrize("name", ["absent.rscd", ".", "a\0b"])
def test_what_cannot_be_read_is_a_wrong_usage(tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match="cannot read"):
        read_source(f"{tmp_path}/{name}")


def test_text_in_memory_may_have_windows_line_ends_too() -> None:
    tree, diagnostics = parse(Source("m", "\ufeff" + MODEL.replace("\n", "\r\n")))
    assert tree is not None
    assert not diagnostics


def test_a_file_without_end_is_not_read_to_its_end() -> None:
    with pytest.raises(UsageError, match="no model has more than 64 MB"):
        read_source("/dev/zero")
