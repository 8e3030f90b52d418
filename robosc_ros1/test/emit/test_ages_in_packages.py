"""The test of a package knows which messages are too old, and that they do not count."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from emit.golden_packages import model_path
from emit.judged_controllers import judged, judging_model

from robosc.runtime import ages
from robosc.runtime.ages import Ages
from robosc.runtime.values import Mismatch


@pytest.fixture(scope="module")
def judging(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    model = model_path("sonar").read_text(encoding="utf-8")
    with judging_model(tmp_path_factory.mktemp("judge"), model) as found:
        yield found


def test_old_messages_are_sent_and_do_not_count(judging: tuple[Any, str]) -> None:
    judge, source = judging
    node = judged(judge, source, seed=2)
    assert node.faults == []
    assert node.events["response", "depth", 0] > 10


def _nothing(*_: Any) -> None:
    """Take every message."""


def _everything(*_: Any) -> None:
    raise Mismatch("too old")


def _only_the_past(self: Ages, key: str, message: Any, arrival: float | None) -> None:
    stamp = ages.seconds_of(message.header.stamp)
    if not stamp or arrival is None or arrival - stamp > 0.4:
        raise Mismatch("too old")


FAULTS: dict[str, Callable[..., None]] = {
    "takes every message": _nothing,
    "takes none": _everything,
    "takes those of the future": _only_the_past,
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_test_of_a_package_finds(
    judging: tuple[Any, str], fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    judge, source = judging
    monkeypatch.setattr(Ages, "check", FAULTS[fault])
    assert judged(judge, source).faults != []


def test_the_test_of_a_package_finds_a_wrong_communication(judging: tuple[Any, str]) -> None:
    judge, source = judging
    right = 'max_age="Depth/patience"'
    assert right in source
    assert judged(judge, source.replace(right, "max_age=None")).faults != []
