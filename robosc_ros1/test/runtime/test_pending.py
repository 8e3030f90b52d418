"""What a monitor has still to judge, where judging itself fails."""

from __future__ import annotations

from typing import Any

import pytest

from robosc.runtime.judge.seen import Pending, Seen


@pytest.mark.parametrize("faulty", [0, 1, 2])
def test_one_that_cannot_be_judged_is_tried_once(faulty: int) -> None:
    tried: list[int] = []

    def is_decided(seen: Seen) -> bool:
        number: Any = seen.message
        tried.append(number)
        if number == faulty:
            raise RuntimeError("a fault of the model's functions")
        return True

    pending = Pending(is_decided)
    for number in range(3):
        pending.add(Seen(f"Base.{number}", "request", number, float(number), float(number)))
    with pytest.raises(RuntimeError):
        pending.judge(lambda entry, message: None)
    pending.judge(lambda entry, message: None)
    assert sorted(tried) == [0, 1, 2]
    assert pending.oldest is None
