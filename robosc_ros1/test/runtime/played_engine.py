"""An engine for tests, whose clock and inputs the test moves."""

from __future__ import annotations

from runtime.lamp_robot import SENSOR, LampController, PlayedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import Settings


class Played:
    """An engine whose clock and inputs the test moves."""

    def __init__(self, **settings: object) -> None:
        self.port = PlayedPort()
        self.controller = LampController()
        self.engine = controller_engine(
            self.controller,
            self.port,
            Settings(**settings),
            steady=lambda: self.port.time,  # type: ignore[arg-type]
        )

    def begin(self) -> list[str]:
        self.engine.begin()
        self.engine.cycle()
        return self.port.take()

    def see(self, value: float) -> list[str]:
        self.engine.post(SENSOR, "response", value)
        self.engine.cycle()
        return self.port.take()

    def end(self, key: str, kind: str = "response", payload: object = None) -> list[str]:
        self.engine.report(key, self.port.tokens[key], kind, payload)
        self.engine.cycle()
        return self.port.take()

    def wait(self, seconds: float) -> list[str]:
        """Let time pass as the engine's thread would: waking whenever the engine asks to."""
        end = self.port.time + seconds
        while True:
            patience = self.engine.time_to_deadline()
            if patience is None or self.port.time + patience > end:
                break
            self.port.time += patience
            self.engine.cycle()
        self.port.time = end
        return self.port.take()

    def counter(self, name: str) -> int:
        return self.engine.recorder.counters[name]
