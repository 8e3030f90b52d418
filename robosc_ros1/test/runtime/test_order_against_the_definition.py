"""The command scheduler beside its definition: a slow one that looks at every command every time."""

from __future__ import annotations

import random
from typing import Any

import pytest

from robosc.runtime.core.model import Command, Communication, Controller
from robosc.runtime.core.scheduler import CommandScheduler, ScheduledCommand
from robosc.runtime.core.settings import Settings

FLAGS = tuple(f"flag_{number}" for number in range(6))
BUSY = tuple(f"busy_{number}" for number in range(3))


class SlowScheduler:
    """What docs/running.md says about commands, without indexes and heaps."""

    def __init__(self, commands: list[ScheduledCommand], order: str) -> None:
        self.commands = commands
        self.rotates = order == "rotate"
        self.due = {c.index: 0.0 for c in commands}
        self.was = dict.fromkeys(self.due, False)
        self.rising = dict.fromkeys(self.due, False)
        self.turn = {index: index for index in self.due}
        self.done: set[int] = set()  # in this round
        self.turns = len(commands)
        self.now = 0.0

    def follow(self, now: float) -> None:
        if now < self.now:
            for c in self.commands:
                self.due[c.index] = min(self.due[c.index], now + c.period)
        self.now = now

    def update(self, ended: str | None, now: float) -> None:
        for c in self.commands:
            own_end = ended == c.key
            if own_end and self.due[c.index] <= now:
                self.due[c.index] += c.period * (1 + (now - self.due[c.index]) // c.period)
            allowed = c.allowed()
            if (
                allowed
                and not self.was[c.index]
                and c.possible
                and not (own_end and not c.is_cancel)
            ):
                self.rising[c.index] = True
            if not allowed:
                self.rising[c.index] = False
            self.was[c.index] = allowed

    def next(self, now: float) -> int | None:
        self.follow(now)
        due = [
            (not c.is_cancel, self.turn[c.index], c.index)
            for c in self.commands
            if self.was[c.index] and c.possible and c.index not in self.done
            and (self.rising[c.index] or self.due[c.index] <= now)
        ]  # fmt: skip
        if due:
            return min(due)[2]
        self.done.clear()
        self.rising = dict.fromkeys(self.rising, False)
        return None

    def performed(self, index: int, now: float) -> None:
        period = self.commands[index].period
        on_beat = not self.rising[index] and 0.0 <= now - self.due[index] < period
        self.due[index] = (self.due[index] if on_beat else now) + period
        self.rising[index] = False
        self.done.add(index)
        if self.rotates:
            self.turn[index] = self.turns
            self.turns += 1


def phases(command: ScheduledCommand) -> tuple[str, ...]:
    return (*command.row.during, *command.row.unless)


def random_controller(chance: random.Random) -> Controller:
    """Messages and actions with guards over flags; some wait for others."""
    controller = Controller()
    rows: list[Command] = []
    sorts: dict[str, str] = {}

    def guard(names: tuple[str, ...], wanted: bool) -> Any:
        return lambda c: all(getattr(c, name) for name in names) is wanted

    for number in range(chance.randint(3, 9)):
        names = tuple(chance.sample(FLAGS, chance.randint(1, 2)))
        key = f"C.c{number}"
        busy = chance.choice([None, *BUSY])
        sorts[key] = "action" if busy else "incoming"
        above = tuple(chance.sample(range(number), min(number, chance.randint(0, 2))))
        above = tuple(n for n in above if rows[n].kind == "request")
        rows.append(
            Command(
                key, "request", guard(names, chance.random() < 0.7), None, None, None,
                names, (), (), yields_to=above if chance.random() < 0.4 else (),
                unless=(busy,) if busy else (),
            )
        )  # fmt: skip
        if busy and chance.random() < 0.6:
            names = tuple(chance.sample(FLAGS, 1))
            allowed = guard(names, True)
            cancel = Command(
                key, "cancel", allowed, None, None, None, names, (), (), during=(busy,)
            )
            rows.append(cancel)
    controller.COMMANDS = tuple(rows)
    controller.COMMUNICATIONS = tuple(Communication(k, k, s) for k, s in sorts.items())
    for name in (*FLAGS, *BUSY):
        setattr(controller, name, False)
    return controller


@pytest.mark.parametrize("order", ["rotate", "declared"])
@pytest.mark.parametrize("seed", range(40))
def test_the_same_commands_in_the_same_order(order: str, seed: int) -> None:
    chance = random.Random(seed)
    controller = random_controller(chance)
    rates = {c.key: chance.choice([1.0, 3.0, 10.0]) for c in controller.COMMUNICATIONS}
    fast = CommandScheduler(controller, Settings(rates=rates, order=order))
    slow = SlowScheduler(fast.commands, order)
    now = 0.0
    fast.begin(now)
    slow.update(None, now)
    performed = 0
    for step in range(300):
        now = max(
            0.0,
            now + chance.choice([0.0, 0.01, 0.05, 0.1, 0.35, 2.0, -0.5 if step % 9 == 0 else 0.0]),
        )
        slow.follow(now)
        fast.time_to_next(now)
        written = chance.sample((*FLAGS, *BUSY), chance.randint(0, 3))
        for name in written:
            setattr(controller, name, chance.random() < 0.5)
        changed = [c for c in fast.commands if set(phases(c)) & set(written)]
        ended = next((c.key for c in changed if not c.possible), None)
        fast.update(frozenset(written), ended, now)
        if written:
            slow.update(ended, now)
        while True:
            command, wanted = fast.next(now), slow.next(now)
            assert (None if command is None else command.index) == wanted, step
            if command is None or wanted is None:
                break
            performed += 1
            writes: set[str] = set()
            for busy in phases(command):
                setattr(controller, busy, not command.is_cancel)
                writes.add(busy)
            if chance.random() < 0.2:
                flag = chance.choice(FLAGS)
                setattr(controller, flag, not getattr(controller, flag))
                writes.add(flag)
            fast.performed(command, now)
            slow.performed(wanted, now)
            over = command.key if command.is_cancel else None
            fast.update(frozenset(writes), over, now)
            slow.update(over, now)
    assert performed > 20
