"""The test of a generated supervisor, played without ROS: its judge and its guide beside it.

The other controller wishes for commands against all requirements. A message of it is known by its
topic alone here: what tells several commands on one topic apart is no part of ``controller.py``.
"""

from __future__ import annotations

import copy
import importlib
from types import SimpleNamespace
from typing import Any

from emit.judged_controllers import Robot, engine_of, guide_of, play

from robosc.runtime.matching import CommandPattern
from robosc.runtime.supervising import supervisor_engine

__all__ = ["judged_supervisor"]


class Both(Robot):
    """The robot and the controller that is guarded, at the two sides of a supervisor."""

    judge: Any

    def __init__(self, judging: Any, seed: int) -> None:
        super().__init__(judging, seed, lambda data: data)
        self.commands = [k for k, c in self.plant.items() if c["kind"] != "outgoing message"]

    def blocked(self, text: str) -> None:
        self.judge.on_blocked(SimpleNamespace(data=text))

    def act_both(self, engine: Any, step: Any, phase: dict[str, str]) -> None:
        """Do as the step says, or whatever comes, on both sides."""
        self.act(engine, step, phase)
        if step is None or step[0] == "wait":
            for _ in range(self.chance.randint(0, 2)):
                self._wish_anything(engine)
        elif step[0] == "request":
            self._wish(engine, step[1])
        elif step[0] == "cancel":
            engine.role.withdraw(step[1])

    def _wish_anything(self, engine: Any) -> None:
        if self.running and self.chance.random() < 0.2:
            actions = [key for key in self.running if self.plant[key]["kind"] == "action"]
            if actions:
                engine.role.withdraw(self.chance.choice(actions))
        elif self.commands:
            self._wish(engine, self.chance.choice(self.commands))

    def _wish(self, engine: Any, key: str) -> None:
        read = key in self.plant_data.get("reads_data", ())
        message = self.message(key, "request") if read else None
        if self.plant[key]["kind"] == "incoming message":
            engine.role.offer(
                self.plant[key]["identifier"], (CommandPattern(key),), message, message
            )
        else:
            engine.role.request(key, message, message, lambda kind, what: None)

    def corrected(self, message: Any, data: dict[str, Any]) -> Any:
        made = copy.deepcopy(message)
        _set(made, data)
        return made

    def deliver(self, engine: Any, keys: list[str], message: Any) -> None:
        engine.role.follow(keys, message, lambda: None)


def _set(message: Any, data: dict[str, Any]) -> None:
    for name, value in data.items():
        if isinstance(value, dict):
            _set(getattr(message, name), value)
        else:
            setattr(message, name, value)


def judged_supervisor(judging: Any, source: str, seed: int = 1, rounds: int = 150) -> Any:
    """The judge of a supervisor that has run as the controller of ``judged``."""
    both = Both(judging, seed)
    guarding = importlib.import_module("guard_checker")
    judge = both.judge = guarding.GuardChecker(both, [], guide_of(judging, both))
    play(engine_of(supervisor_engine, source, both), both, judge, rounds, both.act_both)
    return judge
