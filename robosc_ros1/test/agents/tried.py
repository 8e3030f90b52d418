"""An agent that tries every command of an example in every situation, and what an observer beside
the robot makes of what reaches it: known from the requirements, not from the product."""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from agents.agent_support import Agent
from ros_support import EXAMPLES, await_condition

LINE_FOLLOWER = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"
LIMITER = EXAMPLES / "gallery" / "limiter" / "limiter.rscd"
LIBRARIES = EXAMPLES / "gallery" / "libraries"

Call = tuple[str, dict[str, Any]]
Arrived = tuple[str, Any]
"""The name of a topic, service or action, and what reached the robot there."""

_ROUNDING = 1e-6  # a scan has numbers of 32 bits
_FASTEST, _NEAR, _NEAREST = 0.5, 0.25, 0.15


class Robot(Protocol):
    """A robot that a test plays, beside a supervisor."""

    def sense(self, value: float) -> None:
        """Publish a measurement, and wait until the supervisor shows that it has it."""

    def arrived(self) -> Mapping[str, list[Any]]:
        """All that has reached the robot, by topic, service or action."""


@dataclass(frozen=True)
class Trial:
    """``lawful`` says whether something may reach the robot in a situation."""

    situations: Sequence[float]
    calls: Callable[[random.Random], list[Call]]
    lawful: Callable[[float, Arrived], bool]


def _commands_of_the_line_follower(rng: random.Random) -> list[Call]:
    return [
        ("move", {"linear": {"x": rng.choice([0.0, 0.3, -2.0])}}),
        ("stop", {}),
        ("grab", {}),
        ("set_light_state", {"state": rng.random() < 0.5}),
    ]


def _line_follower_allows(distance: float, arrived: Arrived) -> bool:
    name, message = arrived
    free = distance >= 0.35
    if name == "/vel":
        return free or not message["linear"]["x"]
    return name != "/grab" or not free


def _commands_of_the_limiter(rng: random.Random) -> list[Call]:
    def move() -> Call:
        speed, turn = rng.uniform(-0.5, 1.5), rng.uniform(-2.0, 2.0)
        return "move", {"linear": {"x": speed}, "angular": {"z": turn}}

    return [move(), move(), ("halt", {}), move()]


def _limiter_allows(distance: float, arrived: Arrived) -> bool:
    speed, turn = arrived[1]["linear"]["x"], arrived[1]["angular"]["z"]
    if not speed and not turn:
        return True  # it halts
    most = min(_FASTEST, distance - _NEAREST, distance) if distance >= _NEAR else 0.0
    return distance > 0.0 and 0.0 <= speed <= most + _ROUNDING


TRIALS = {
    "line_follower": Trial([2.0, 0.1], _commands_of_the_line_follower, _line_follower_allows),
    # At 0 the scan is blind.
    "limiter": Trial([0.0, 0.2, 0.3, 0.5, 3.0], _commands_of_the_limiter, _limiter_allows),
}


def try_everything(agent: Agent, robot: Robot, trial: Trial, rounds: int, seed: int = 7) -> None:
    """Between two measurements, what reaches the robot is what that situation allows, and what the
    agent is told to have been sent reaches it."""
    rng = random.Random(seed)
    outcomes = set()
    for number in range(rounds):
        situation = rng.choice(trial.situations) if number else trial.situations[0]
        robot.sense(situation)
        before = robot.arrived()
        calls = trial.calls(rng)
        rng.shuffle(calls)
        passed = 0
        if not number:
            # On ROS 2, what goes out before both sides know of each other is lost.
            for name, arguments in calls:
                first = await_condition(lambda c=(name, arguments): _decided(agent, *c), name)
                passed += first["outcome"] != "blocked"
        told = [called(agent, name, arguments) for name, arguments in calls]
        for answer in told:
            outcomes.add(answer["outcome"])
            if answer["outcome"] == "blocked":
                assert answer["blocked_by"] and all(answer["why"]), answer
                for reason in answer["blocked_by"]:
                    if reason["kind"] == "requirement":
                        assert reason["text"] and reason["place"], answer
                        # One part alone is the whole of it.
                        assert reason.get("because") or " and " not in reason["text"], answer
            else:
                assert answer["outcome"] in ("sent", "corrected", "answered"), answer
                passed += 1
        await_condition(
            lambda b=before, n=passed: len(_since(b, robot.arrived())) >= n,
            "all that was said to be sent",
        )
        arrived = _since(before, robot.arrived())
        assert not number or len(arrived) == passed, (situation, calls, arrived)
        for each in arrived:
            assert trial.lawful(situation, each), (situation, each)
    assert "blocked" in outcomes and outcomes & {"sent", "corrected"}, outcomes


def _since(before: Mapping[str, list[Any]], now: Mapping[str, list[Any]]) -> list[Arrived]:
    return [(n, each) for n, all_ in now.items() for each in all_[len(before.get(n, ())) :]]


def rounds(few: int) -> int:
    """How many rounds a test takes, unless whoever runs it wants more."""
    return int(os.environ.get("ROBOSC_AGENT_ROUNDS", few))


def _decided(agent: Agent, tool: str, arguments: dict[str, Any]) -> dict[str, Any] | None:
    answer = called(agent, tool, arguments)
    return None if answer["outcome"] == "unknown" else answer


def called(agent: Agent, tool: str, arguments: dict[str, Any]) -> dict[str, Any]:
    """What comes of a call, once it is not one too many per second."""

    def answer() -> dict[str, Any] | None:
        told = agent.call(tool, **arguments)
        return None if "calls per second" in str(told.get("why")) else told

    found: dict[str, Any] = await_condition(answer, f"the end of {tool}")
    return found
