"""The states of a moment ago are those that there were: against a list of all of them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from robosc.runtime.judge.seen import RecentStates

NAMES = "abc"
TOPICS = ("", "/one", "/other")
values = st.integers(0, 2)
events = st.tuples(
    st.integers(0, 3),  # how much later than the last
    st.sampled_from(TOPICS),
    st.dictionaries(st.sampled_from(NAMES), values),
)
conditions = st.dictionaries(st.sampled_from(NAMES), values, min_size=1)


@given(
    st.lists(events, max_size=12),
    conditions,
    st.sets(st.sampled_from(NAMES)),
    st.sampled_from(TOPICS[1:]),
    st.integers(0, 10),
)
def test_a_condition_held_where_one_of_the_remembered_states_meets_it(
    happened: list[tuple[int, str, dict[str, int]]],
    condition: dict[str, int],
    reads: set[str],
    topic: str,
    span: int,
) -> None:
    controller: Any = SimpleNamespace(undefined={}, **dict.fromkeys(NAMES, 0))
    state = vars(controller)
    recent = RecentStates(controller)
    recent.begin()
    states = [(dict(state), 0, "", frozenset[str]())]
    now = 0
    for later, of, writes in happened:
        now += later
        states.append((dict(state), now, of, frozenset(writes)))
        state.update(writes)
        recent.note(now, of, frozenset(writes), now - span)
    present = dict(state)

    def holds(of: dict[str, Any]) -> bool:
        return all(of[name] == value for name, value in condition.items())

    if holds(state):
        return  # it is asked only of what does not hold now
    expected = False
    for former, until, of, writes in reversed(states[1:]):
        if until <= now - span or (of == topic and not writes.isdisjoint(reads)):
            break
        expected |= holds(former)
    assert recent.held(lambda: holds(state), frozenset(reads), now - span, topic) is expected
    assert state == present
