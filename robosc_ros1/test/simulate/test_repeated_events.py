"""``every 0.5 s battery 0.9``: what a robot sends again and again, in scripts."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robosc import pipeline
from robosc.simulate.faults import LineFault
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.simulate.values.literals import parse_raw

MODEL = """robot Cart {
    component Base {
        outgoing message battery with timeout: 1 s, type: double
        outgoing message bump with type: boolean
        incoming message stop with type: none, rate: once
        behaviour {
            variable level: double
            variable hit: boolean
            initial marked state on {
                on response from battery do level := value
                on response from bump do hit := value
                on request to stop
            }
        }
    }
    requirement stop needs Base.hit
    stop with stop
}"""


@pytest.fixture
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return _session(tmp_path_factory.mktemp("cart"))


def _session(folder: Path, *, execute: bool = True) -> Session:
    path = folder / "cart.rscd"
    path.write_text(MODEL, encoding="utf-8")
    supervisor = pipeline.supervise(pipeline.load(path).robot)
    return Session(machine_maker(supervisor, execute=execute))


def times(session: Session, name: str) -> list[float]:
    """When an event happened, by the lines that do all again."""
    time, found = 0.0, []
    for line in session.history:
        if line.startswith("wait "):
            time = round(time + float(line.removeprefix("wait ")), 6)
        elif line.startswith(name):
            found.append(time)
    return found


def test_it_comes_until_it_is_stopped(session: Session) -> None:
    session.do("every 0.5 s battery 0.9")
    session.do("wait 1.2")
    session.do("expect battery.fresh")
    session.do("stop battery")
    session.do("wait 2")
    session.do("expect !battery.fresh")
    assert times(session, "battery.response") == [0.0, 0.5, 1.0]


def test_two_at_once_and_one_given_anew(session: Session) -> None:
    for line in ("every 0.5 battery 0.9", "every 0.2 s bump true", "wait 0.5"):
        session.do(line)
    session.do("every 0.4 s battery 0.1")
    session.do("wait 0.8")
    assert times(session, "bump") == [0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2]
    assert times(session, "battery.response") == [0.0, 0.5, 0.5, 0.9, 1.3]
    session.do("expect Base.level = 0.1")


def test_a_command_called_stop_is_still_that(session: Session) -> None:
    session.do("bump true")
    session.do("expect sent stop")
    session.do("every 0.5 battery 0.9")
    with pytest.raises(LineFault):
        session.do("stop bump")
    session.do("stop battery")
    session.do("wait 2")
    assert times(session, "battery.response") == [0.0]


@pytest.mark.parametrize("again", ["restart", "set rate/stop 5"])
def test_who_begins_again_begins_without_them(session: Session, again: str) -> None:
    session.do("every 0.5 battery 0.9")
    session.do(again)
    session.do("wait 2")
    assert times(session, "battery") == []


@pytest.mark.parametrize(
    "line",
    [
        "every battery 0.9",
        "every 0 battery 0.9",
        "every 0.5 nothing 1",
        "every 0.5",
        "every -1 bump",
    ],
)
def test_what_means_nothing_changes_nothing(session: Session, line: str) -> None:
    with pytest.raises(LineFault):
        session.do(line)
    session.do("wait 3")
    assert session.history == ["wait 3.0"]


def test_without_a_clock_it_is_refused(tmp_path: Path) -> None:
    session = _session(tmp_path, execute=False)
    with pytest.raises(LineFault, match="needs --execute"):
        session.do("every 0.5 battery 0.9")
    assert session.history == []


@settings(max_examples=40, deadline=None)
@given(
    periods=st.lists(st.integers(1, 9), min_size=1, max_size=2),
    waits=st.lists(st.integers(1, 30), min_size=1, max_size=4),
)
def test_the_times_are_multiples_however_one_waits(
    tmp_path_factory: pytest.TempPathFactory, periods: list[int], waits: list[int]
) -> None:
    session = _session(tmp_path_factory.mktemp("cart"))
    names = ["battery", "bump"][: len(periods)]
    for name, period in zip(names, periods, strict=True):
        session.do(f"every 0.{period} {name} {'0.5' if name == 'battery' else 'false'}")
    for tenths in waits:
        session.do(f"wait {tenths / 10:.1f}")
    for name, period in zip(names, periods, strict=True):
        expected = [t / 10 for t in range(0, sum(waits) + 1, period)]
        assert times(session, f"{name}.response") == expected


@pytest.mark.parametrize(
    ("written", "same"),
    [
        ("linear: { x: 0.3 }", "linear.x: 0.3"),
        ("linear: { x: 0.3, y: 1 }, angular.z: 2", "linear.x: 0.3, linear.y: 1, angular.z: 2"),
        ("{ linear: { x: 1 } }", "linear.x: 1"),
        ("points: [{ x: 1, y: 2 }, { }]", 'points: [{"x": 1, "y": 2}, {}]'),
        ("points: [], name: free", "points: [], name: free"),
    ],
)
def test_objects_are_written_as_in_the_model(written: str, same: str) -> None:
    assert parse_raw(written) == parse_raw(same)


@pytest.mark.parametrize(
    "written",
    ["linear: { x: 1", "linear: { 1 }", "a: { x: 1 }, a.x: 2", "points: [{ x: 1 }", "a: [1 2]"],
)
def test_a_fault_in_an_object_is_told(written: str) -> None:
    with pytest.raises(LineFault):
        parse_raw(written)


@pytest.mark.parametrize("opening", ["{ a: ", "[{ a: ", "["])
def test_what_is_nested_too_deep_is_told(opening: str) -> None:
    closing = "".join({"{": " }", "[": "]"}[c] for c in reversed(opening) if c in "{[")
    assert parse_raw(f"a: {opening * 5}1{closing * 5}")
    with pytest.raises(LineFault):
        parse_raw(f"a: {opening * 3000}1{closing * 3000}, b: free x")
