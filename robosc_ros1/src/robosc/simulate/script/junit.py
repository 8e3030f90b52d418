"""What came of a script as JUnit XML, which continuous integration reads."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree

from robosc.lazy_dataclasses import dataclass
from robosc.simulate.faults import Failed, LineFault

_NO_XML = re.compile("[^\\t\\n\\r\\x20-\\ud7ff\\ue000-\\ufffd\\U00010000-\\U0010ffff]")
"""Characters that XML 1.0 cannot hold."""


@dataclass(frozen=True, slots=True)
class Case:
    """A line of a script that had to come true: an expectation, or what ended the script.

    ``number`` is its line from 1, ``fault`` why it did not come true.
    """

    number: int
    line: str
    fault: LineFault | None = None

    @property
    def is_expectation(self) -> bool:
        return self.line.split()[:1] == ["expect"]


def junit_text(script: str, robot: str, cases: Sequence[Case]) -> str:
    """A test suite with a test case for each case.

    An expectation that was not met is a failure, what ended the script an error.
    """
    failures = sum(isinstance(case.fault, Failed) for case in cases)
    errors = sum(case.fault is not None for case in cases) - failures
    suite = ElementTree.Element(
        "testsuite",
        name=_text(script), tests=str(len(cases)), failures=str(failures), errors=str(errors),
    )  # fmt: skip
    for case in cases:
        name = f"line {case.number}: {case.line.strip()}"
        one = ElementTree.SubElement(
            suite, "testcase",
            classname=_text(robot), name=_text(name), file=_text(script), line=str(case.number),
        )  # fmt: skip
        if case.fault is not None:
            kind = "failure" if isinstance(case.fault, Failed) else "error"
            told = ElementTree.SubElement(one, kind, message=_text(str(case.fault)))
            told.text = _text(f"{script}:{case.number}: {case.fault.kind}: {case.fault}")
    return _document(suite)


@dataclass(frozen=True, slots=True)
class Outcome:
    """A statement about a recording: what contradicts it, and its place in the model.

    ``unjudged`` is why it could not be judged, where nothing contradicts it; empty: it was.
    """

    name: str
    failures: Sequence[str]
    file: str = ""
    line: int = 0
    unjudged: str = ""


def suite_text(title: str, robot: str, outcomes: Sequence[Outcome]) -> str:
    """A test suite with a test case for each outcome."""
    failures = sum(bool(outcome.failures) for outcome in outcomes)
    skipped = sum(bool(outcome.unjudged and not outcome.failures) for outcome in outcomes)
    suite = ElementTree.Element(
        "testsuite",
        name=_text(title), tests=str(len(outcomes)), failures=str(failures), errors="0",
        skipped=str(skipped),
    )  # fmt: skip
    for outcome in outcomes:
        one = ElementTree.SubElement(
            suite, "testcase", classname=_text(robot), name=_text(outcome.name)
        )
        if outcome.file:
            one.set("file", _text(outcome.file))
            one.set("line", str(outcome.line))
        if outcome.failures:
            told = ElementTree.SubElement(one, "failure", message=_text(outcome.failures[0]))
            told.text = _text("\n".join(outcome.failures))
        elif outcome.unjudged:
            ElementTree.SubElement(one, "skipped", message=_text(outcome.unjudged))
    return _document(suite)


def _document(suite: ElementTree.Element) -> str:
    ElementTree.indent(suite)
    text = ElementTree.tostring(suite, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _text(text: str) -> str:
    return _NO_XML.sub("\N{REPLACEMENT CHARACTER}", text)
