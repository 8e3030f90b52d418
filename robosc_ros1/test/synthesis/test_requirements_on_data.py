"""Requirements on the data of commands mean what the same model says without ``value``."""

from __future__ import annotations

import pytest
from plants import guard_text, supervisor_of

STICK = """
component Stick {
    outgoing message stick with timeout: 1 s, type: double
    outgoing message pick with type: boolean
    behaviour {
        variable speed: double
        variable fast: boolean
        on response from stick do speed := value
        on response from pick do fast := value
        initial marked state ready {}
    }
}
component Base {
    incoming message move with type: double
    action lift with request: double, response: none, feedback: none links link
}
provide move with Stick.speed if Stick.fast
provide move with 0.2 if stick.fresh
provide lift with Stick.speed
"""
CASES = [
    (
        "move needs value <= 0.5",
        "move needs Stick.fast and Stick.speed <= 0.5 or !Stick.fast",
    ),
    (
        "value > 0.1 disables move",
        "move needs Stick.fast and !(Stick.speed > 0.1) or !Stick.fast and !stick.fresh",
    ),
    (
        "move needs value > 0.1 => stick.fresh",
        "move needs Stick.fast and (Stick.speed > 0.1 => stick.fresh)"
        " or !Stick.fast and (stick.fresh and stick.fresh or !stick.fresh)",
    ),
    (
        "lift needs stick.fresh and value < 1.0",
        "lift needs stick.fresh requirement lift needs Stick.speed < 1.0 to start",
    ),
]


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
@pytest.mark.parametrize(("on_data", "on_state"), CASES)
def test_the_supervisor_is_that_of_the_conditions_on_the_state(
    on_data: str, on_state: str, engine: str
) -> None:
    found = supervisor_of(f"{STICK} requirement {on_data}", engine)
    expected = supervisor_of(f"{STICK} requirement {on_state}", engine)
    assert found.controlled_states == expected.controlled_states
    for name in ("move.request", "lift.request", "lift.cancel"):
        assert guard_text(found, name) == guard_text(expected, name)
