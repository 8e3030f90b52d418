"""What is ready by the clock comes before every command, beginning with what was due first.

The witness keeps its own times: it knows nothing of the engine but what it does to the controller.
"""

from __future__ import annotations

import random
from typing import Any

import pytest
from runtime.lamp_robot import PlayedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.model import Command, Communication, Controller, Input
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.timers import After

FLAGS = tuple(f"flag_{number}" for number in range(4))


class Witness:
    """The times at which things are due, and what came in a wrong order."""

    def __init__(self, port: PlayedPort) -> None:
        self.port = port
        self.controller: Any = None
        self.delays: dict[str, float] = {}
        self.due: dict[str, float] = {}
        self.guards: dict[str, str] = {}
        self.faults: list[str] = []
        self.seen: list[str] = []
        self.together = 0

    def start(self, thing: str) -> None:
        self.due[thing] = self.port.time + self.delays[thing]

    def ready(self) -> dict[str, float]:
        """The things that are ready, with the times at which they were due."""
        return {
            thing: due
            for thing, due in self.due.items()
            if due <= self.port.time and getattr(self.controller, self.guards.get(thing, "always"))
        }

    def happens(self, thing: str) -> None:
        ready = self.ready()
        self.together += len(ready) > 1
        self.seen.append(thing)
        if thing not in ready or ready[thing] > min(ready.values()):
            self.faults.append(f"{self.port.time}: {thing}, but ready were {ready}")
        del self.due[thing]

    def commands(self, key: str) -> None:
        self.seen.append("command")
        if ready := self.ready():
            self.faults.append(f"{self.port.time}: {key} before {ready}")


class WitnessedPort(PlayedPort):
    witness: Witness

    def send(self, key: str, data: Any) -> None:
        self.witness.commands(key)
        super().send(key, data)

    def call(self, key: str, data: Any, token: int) -> None:
        self.witness.commands(key)
        self.witness.start(key)

    def start(self, key: str, data: Any, token: int) -> None:
        self.call(key, data, token)


class RandomController(Controller):
    """Components with `after`, messages with a timeout, services and commands; all react by setting
    flags, which are the guards of others."""

    ROBOT, SOURCE, STEP_BOUND, TAUS, REQUIREMENTS = "Random", "random.rscd", 1, (), ()
    always = True

    def __init__(self, chance: random.Random, witness: Witness) -> None:
        self.undefined = {}
        self._chance, self._witness = chance, witness
        self._set_flags()
        self.COMMUNICATIONS = self.INPUTS = self.COMMANDS = self.AFTERS = ()
        for number in range(chance.randint(1, 4)):
            self._add_component(f"A{number}", f"at_{number}", f"entries_{number}")
        for number in range(chance.randint(1, 3)):
            self._add_message(f"M.m{number}", f"fresh_{number}")
        for number in range(chance.randint(1, 3)):
            self._add_service(f"S.s{number}", f"busy_{number}")
        for number in range(2):
            key, flag = f"C.c{number}", chance.choice(FLAGS)
            self.COMMUNICATIONS += (Communication(key, key, "incoming"),)
            self._add_command(key, flag, None)

    def _set_flags(self) -> None:
        for flag in self._chance.sample(FLAGS, 2 if hasattr(self, FLAGS[0]) else len(FLAGS)):
            setattr(self, flag, self._chance.random() < 0.6)

    def _add_component(self, name: str, location: str, entries: str) -> None:
        setattr(self, location, "s")
        setattr(self, entries, 0)
        guard = self._witness.guards[name] = self._chance.choice(FLAGS)
        delay = self._witness.delays[name] = self._chance.choice([0.5, 1.0, 1.5])

        def step(_: Controller) -> str | None:
            if not getattr(self, self._witness.guards[name]):
                return None
            self._witness.happens(name)
            self._set_flags()
            setattr(self, entries, getattr(self, entries) + 1)
            self._witness.start(name)
            return "s->s"

        reads, writes = (guard, location), (entries, *FLAGS)
        self.AFTERS += (After(name, 1, "s", delay, location, entries, step, reads, writes),)

    def _add_message(self, key: str, fresh: str) -> None:
        setattr(self, fresh, False)
        delay = self._witness.delays[key] = self._chance.choice([0.5, 1.0])

        def heard(_: Controller, __: Any) -> None:
            self._witness.start(key)
            self._set_flags()
            setattr(self, fresh, True)

        phases = ("silent", "fresh")
        self.COMMUNICATIONS += (Communication(key, key, "outgoing", (fresh,), phases, delay),)
        self.INPUTS += (Input(key, "response", None, heard, (fresh, *FLAGS)),)
        self._add_end(key, "timeout", fresh)

    def _add_service(self, key: str, busy: str) -> None:
        setattr(self, busy, False)
        delay = self._witness.delays[key] = self._chance.choice([0.5, 1.0, 1.5])
        phases = ("idle", "busy")
        self.COMMUNICATIONS += (Communication(key, key, "service", (busy,), phases, delay),)
        self._add_end(key, "error", busy)
        self._add_command(key, self._chance.choice(FLAGS), busy)

    def _add_end(self, key: str, kind: str, phase: str) -> None:
        def ended(_: Controller, __: Any) -> None:
            self._witness.happens(key)
            self._set_flags()
            setattr(self, phase, False)

        self.INPUTS += (Input(key, kind, None, ended, (phase, *FLAGS)),)

    def _add_command(self, key: str, flag: str, busy: str | None) -> None:
        def allowed(_: Controller) -> bool:
            return bool(getattr(self, flag))

        def begin(_: Controller) -> None:
            setattr(self, str(busy), True)

        apply, reads = (begin, (flag, busy)) if busy else (None, (flag,))
        writes = (busy,) if busy else ()
        row = Command(key, "request", allowed, None, None, apply, reads, writes, (), unless=writes)
        self.COMMANDS += (row,)


def random_engine(chance: random.Random) -> tuple[Engine[Any], Witness]:
    port = WitnessedPort()
    witness = port.witness = Witness(port)
    witness.controller = RandomController(chance, witness)
    settings = Settings(timeout=dict(witness.delays), rate=chance.choice([1.0, 10.0]))
    engine = controller_engine(witness.controller, port, settings, steady=lambda: port.time)
    for name in witness.guards:
        witness.start(name)
    return engine, witness


@pytest.mark.parametrize("seed", range(60))
def test_what_was_due_first_comes_first_and_commands_come_last(seed: int) -> None:
    chance = random.Random(seed)
    engine, witness = random_engine(chance)
    messages = [c.key for c in engine.controller.COMMUNICATIONS if c.sort == "outgoing"]
    engine.begin()
    for _ in range(150):
        engine.cycle()
        assert not witness.faults
        witness.port.time += chance.choice([0.0, 0.25, 0.5, 0.75, 2.0, 5.0])
        if chance.random() < 0.3:
            engine.post(chance.choice(messages), "response")
    assert engine.stopped is None
    assert {"command", "A0", "M.m0"} <= {*witness.seen}
    assert witness.together, "nothing was ready together with anything else"


def test_a_clock_with_hardly_any_delay_does_not_keep_the_engine() -> None:
    engine, witness = random_engine(random.Random(1))
    controller = witness.controller
    controller.AFTERS = (controller.AFTERS[0]._replace(delay=1e-12),)
    name = controller.AFTERS[0].component
    witness.guards = {name: "always"}
    witness.port.time = 1.8e9  # seconds since 1970, of which a double does not resolve so little
    engine = controller_engine(controller, witness.port, engine.settings, steady=lambda: 0.0)
    engine.begin()
    for _ in range(10):
        witness.port.time += 0.01
        witness.due[name] = 0.0
        engine.cycle()
    assert witness.seen.count(name) == 10
