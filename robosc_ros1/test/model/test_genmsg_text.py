"""Definitions of ROS 1 are read as genmsg reads them."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robosc.model.ros.genmsg_text import parts
from robosc.model.ros.interfaces import Definition

FILES = sorted(Path("/usr/share").glob("*/msg/*.msg")) + sorted(
    Path("/opt/ros").glob("*/share/*/msg/*.msg")
)

TYPES = (
    "int8",
    "uint8",
    "byte",
    "char",
    "bool",
    "float32",
    "string",
    "time",
    "Header",
    "T",
    "p/T",
    "a/b/c",
    "1",
    "",
)
ARRAYS = ("", "[]", "[3]", "[x]", "[")
NAMES = ("a", "A1", "a_b", "1a", "_a", "")
VALUES = ("1", " -1", "300", "True", "0x1F", "1e3", " a # b", "x = y", "", "'q'")


def line_texts() -> st.SearchStrategy[str]:
    """Lines that declare fields and constants, many of them faulty."""
    field = st.builds(
        "{}{}{}{}{}".format,
        st.sampled_from(TYPES),
        st.sampled_from(ARRAYS),
        st.sampled_from((" ", "   ", "")),
        st.sampled_from(NAMES),
        st.sampled_from(("", " # of a field", " b")),
    )
    constant = st.builds(
        "{} {}{}{}".format,
        st.sampled_from(TYPES),
        st.sampled_from(("a", "A1", "a_b")),  # genmsg takes every name, and Python not its code
        st.sampled_from(("=", " = ")),
        st.sampled_from(VALUES),
    )
    return st.one_of(field, constant, st.sampled_from(("", "# only this", "  ")))


def read_by_genmsg(text: str) -> list[object] | None:
    """Fields and constants of a message ``p/M``; None if genmsg refuses the text."""
    genmsg = pytest.importorskip("genmsg")
    loader = pytest.importorskip("genmsg.msg_loader")
    context = genmsg.MsgContext.create_default()
    try:
        spec = loader.load_msg_from_string(context, text, "p/M")
    except Exception:  # InvalidMsgSpec; IndexError and so on where it does not expect the fault
        return None
    fields = [(field.name, field.type) for field in spec.parsed_fields()]
    return [fields, [(c.name, c.val) for c in spec.constants]]


def read(text: str) -> list[object] | None:
    try:
        (part,) = parts(text, "p", "M", "msg")
    except ValueError:
        return None
    return shown(part)


def shown(part: Definition) -> list[object]:
    return [[(f.name, str(f.type)) for f in part.fields], list(part.constants)]


def test_installed_definitions() -> None:
    if not FILES:
        pytest.skip("no definitions of ROS 1 are installed")
    for file in FILES:
        text = file.read_text(encoding="utf-8")
        if "builtin_interfaces" not in text:  # one of ROS 2
            assert read(text) == read_by_genmsg(text), file


@given(line_texts())
def test_every_line(line: str) -> None:
    assert read(line) == read_by_genmsg(line)
