"""The controller as it executes: the generated code, its engine, a clock that is turned by hand.

Nothing happens between two lines. What the robot sends is taken at once, with all that it makes the
controller do; commands that are repeated at ``rate`` wait until the clock goes on. Requests to
services stay open until they are answered, or until their deadline. Goals are accepted at once, and
open until they are answered, even if they were cancelled.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from robosc import limits
from robosc.emit.package import config
from robosc.expr import traversal, tree
from robosc.expr.types import IntegerType, ObjectType
from robosc.language.events import EventKind, Kind
from robosc.model import entities
from robosc.plant import acceptance, event_values
from robosc.plant.automaton import Event, Plant
from robosc.plant.step import valuations
from robosc.runtime.core import calls, interfaces, model, recorder, telemetry
from robosc.runtime.core import model as runtime
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.operations import in_range
from robosc.runtime.core.settings import ParameterError, Settings, read
from robosc.runtime.core.values import Undefined
from robosc.runtime.served.waiting_call import WaitingCall
from robosc.simulate.faults import InvalidLine, Refused
from robosc.simulate.machines import machine
from robosc.simulate.machines.state import (
    SystemState,
    controller_class,
    restore,
    state_of_controller,
)
from robosc.simulate.values.event_data import Given, by_path, complete, hint, random_raw
from robosc.supervisor import Supervisor

_ROUNDING = 1e-9
"""Seconds by which the sum of many periods may miss the end of a wait and still be in it."""

Check: TypeAlias = Callable[[str, str, interfaces.Data], None]
"""Raises what sending a command, by key and kind, with these data would."""

_Step: TypeAlias = tuple[Event, Given] | float


class Clockwork(interfaces.Port):
    """The clock, and the requests that are open; ``check`` raises what sending them would."""

    def __init__(self, check: Check = lambda *command: None) -> None:
        self._check = check
        self.time = 0.0
        self.open: dict[str, int] = {}
        self.withdrawn: set[int] = set()
        self.accept: Callable[[str, int], None] = lambda key, token: None
        self.ended: Callable[[str, int], None] = lambda key, token: None

    def now(self) -> float:
        return self.time

    def check(self, key: str, kind: str, data: interfaces.Data) -> None:
        self._check(key, kind, data)

    def send(self, key: str, data: interfaces.Data) -> None:
        self.check(key, "request", data)  # the recorder has it already

    def call(self, key: str, data: interfaces.Data, token: int) -> None:
        self.open[key] = token

    def start(self, key: str, data: interfaces.Data, token: int) -> None:
        """Only the latest goal of an action can be typed to end: one that is replaced ends now."""
        replaced = self.open.get(key)
        self.open[key] = token
        self.accept(key, token)
        if replaced is not None:
            self.ended(key, replaced)

    def cancel(self, key: str, token: int) -> None:
        self.withdrawn.add(token)

    def abandon(self, key: str, token: int) -> None:
        if self.open.get(key) == token:
            del self.open[key]

    def log(self, level: str, text: str) -> None:
        """What matters is in the recorder."""


class _Call(WaitingCall):
    """A call of which the recorder has how it ended; ``accepted`` keeps it if it is taken."""

    def __init__(self, accepted: dict[str, WaitingCall], key: str, check: Check) -> None:
        self._accepted = accepted
        self._key = key
        self._check = check

    def accept(self) -> None:
        self._accepted[self._key] = self

    def report(self, data: Any) -> None:
        self._check(self._key, "feedback", data)

    def answer(self, data: Any) -> None:
        self._check(self._key, "response", data)

    def refuse(self, text: str, data: Any = None) -> None:
        pass


class Execution:
    """A :class:`~robosc.simulate.machines.machine.Machine` that executes the controller."""

    def __init__(
        self,
        supervisor: Supervisor,
        settings: Settings,
        check: Check = lambda *command: None,
    ) -> None:
        self.supervisor = supervisor
        self._check = check
        self._events = {
            (e.key, e.kind.word): e for e in self.plant.events if not e.kind.of_component
        }
        self._inputs = tuple(e for e in self.plant.events if not (e.controllable or e.kind.clocked))
        self._settings = settings._replace(whole_values=True)
        topics = (keys for _, keys in config.shared_topics(self.plant.robot) if len(keys) > 1)
        outgoing = {e.key for e in self._inputs if e.kind is EventKind.RESPONSE}
        self._shared = [keys for keys in topics if outgoing.issuperset(keys)]
        self._past: list[_Step] = []
        self._kind = controller_class(supervisor)
        self._begin()

    @property
    def plant(self) -> Plant:
        return self.supervisor.plant

    @property
    def typeable(self) -> Sequence[Event]:
        return self._inputs

    @property
    def state(self) -> SystemState:
        return state_of_controller(self._controller)

    @property
    def time(self) -> float:
        return self._clock.time

    @property
    def stopped(self) -> str | None:
        return self._engine.stopped

    @property
    def next_command(self) -> float | None:
        """Seconds until a command is due; None: none is."""
        due: float | None = self._engine.role.due()
        return due

    @property
    def clocks(self) -> Mapping[str, float]:
        """Seconds until each running clock of the model is due, by its message or state."""
        left: Mapping[str, float] = self._engine.snapshot()["clocks"]
        return left

    def restart(self) -> None:
        self._past.clear()
        self._begin()

    def restore(self, state: Mapping[str, Any]) -> list[str]:
        """Go on from a state as ``~state`` tells it; what led there cannot be undone.

        Returns the names of variables of which the document has not all.
        """
        self._past.clear()
        return restore(self._controller, self.plant, state)

    def undo(self, count: int) -> None:
        """An engine cannot go back; another one does the same again, but for the last steps."""
        steps = self._past[: len(self._past) - count]
        self.restart()
        for step in steps:
            if isinstance(step, float):
                self.wait(step)
            else:
                self.fire(*step)

    def _make(self) -> Engine[Any]:
        """The engine, with a clock and a controller in its initial state."""
        self._clock = Clockwork(self._check)
        self._controller = self._kind()
        read_given(self._controller, self.plant)
        engine = controller_engine(self._controller, self._clock, self._settings, self._clock.now)
        engine.recorder.now = self._clock.now
        return engine

    def _begin(self) -> None:
        self._engine = self._make()
        self._called: dict[str, WaitingCall] = {}  # the latest that was accepted, by key
        self._clock.accept = lambda key, token: self._engine.report(key, token, "accepted")
        replaced = calls.Failure("replaced")
        self._clock.ended = lambda key, token: self._engine.report(
            key, token, EventKind.CANCELLED.word, replaced
        )
        self._engine.begin()
        self._engine.cycle()
        self.beginning: Sequence[machine.Happening] = self._happened()

    # --- what can happen -------------------------------------------------------------------------

    def can(self, event: Event, given: Given | None) -> bool:
        if event.controllable or event.kind.clocked:
            return False
        if event.kind is EventKind.CALL:  # the node refuses it where no component takes it
            return True
        if event.kind is EventKind.RECALL:
            return self._phase(event) in self._sources(event)
        calling = self.plant.robot.communications[event.key].kind in (Kind.SERVICE, Kind.ACTION)
        return not calling or self._may_end(event)

    def _may_end(self, event: Event) -> bool:
        """Whether a service or an action can answer so: a goal that missed a deadline was cancelled
        by the node, too."""
        if event.key not in self._clock.open:
            return False
        if event.kind is EventKind.CANCELLED:
            return self._clock.open[event.key] in self._clock.withdrawn
        return self._phase(event) in self._sources(event)

    def _phase(self, event: Event) -> str:
        return self.state.phases[event.key]

    def _sources(self, event: Event) -> list[str]:
        phase = acceptance.phase_of(event)
        assert phase is not None
        phases = self.plant.variables[phase.variable].values
        return [str(phases[source]) for source in phase.sources]

    def choices(self) -> list[machine.Choice]:
        found = []
        robot = self.plant.robot
        for event in self._inputs:
            if not self.can(event, None):
                continue
            if machine.is_typed(robot, event) or any(p.test for p in event.parameters):
                found.append(machine.Choice(event, None, machine.label(event), hint(robot, event)))
                continue
            for values in valuations(event):
                given = by_path(event, values)
                found.append(machine.Choice(event, given, machine.typed_text(event, given)))
        return found

    def commands(self) -> list[machine.CommandState]:
        snapshot = self._engine.snapshot()
        counts = snapshot["counts"]
        commands = [
            machine.CommandState(
                self._events[c.key, c.kind],
                self._reasons(c, snapshot),
                None if c.data is None else _data(c.data, self._controller),
                counts[c.key, c.kind],
            )
            for c in self._controller.COMMANDS
        ]
        return machine.with_preferences(commands, self.plant.robot, self.state.phases)

    def _reasons(
        self, command: runtime.Command, snapshot: dict[str, Any]
    ) -> tuple[machine.Reason, ...]:
        found = [machine.Reason(**r) for r in telemetry.obstacles(snapshot, command)]
        if self.stopped is not None:
            found.insert(0, machine.Reason("stopped", "there was a safe stop"))
        return tuple(found)

    # --- what happens ----------------------------------------------------------------------------

    def fire(self, event: Event, given: Given) -> list[machine.Happening]:
        if not self.can(event, given):
            raise Refused(
                f"{machine.label(event)} cannot happen now: {event.name} is {self._phase(event)}"
            )
        if event.kind is EventKind.CALL:
            self._engine.serve(event.key, given, _Call(self._called, event.key, self._clock.check))
        elif event.kind is EventKind.RECALL:
            self._engine.recall(event.key, self._called[event.key])
        else:
            self._report(event, given)
        self._engine.cycle()
        self._past.append((event, given))
        return self._happened()

    def _report(self, event: Event, given: Given) -> None:
        """Pass on a message, or what becomes of a request."""
        payload: Any = given
        if event.kind in (EventKind.ERROR, EventKind.CANCELLED):
            word = str(given.get(tree.REASON) or calls.FAILED)
            payload = calls.Failure("simulated", given, word)
        token = self._clock.open.get(event.key)
        together = next((keys for keys in self._shared if event.key in keys), None)
        if together is not None:
            self._engine.poster(together)(payload)  # all that the message is
        elif acceptance.phase_of(event) is None or token is None:
            self._engine.post(event.key, event.kind.word, payload)
        else:
            if event.kind is not EventKind.FEEDBACK:
                del self._clock.open[event.key]
            self._engine.report(event.key, token, event.kind.word, payload)

    def wait(self, seconds: float) -> list[machine.Happening]:
        if not 0.0 < seconds <= limits.WAIT_SECONDS:
            raise InvalidLine(f"wait for more than 0 and at most {limits.WAIT_SECONDS:g} seconds")
        happenings = []
        end = self._clock.time + seconds
        while True:
            delay = self._engine.time_to_deadline()
            if delay is None or self._clock.time + delay > end + _ROUNDING:
                break
            # Adding a difference may end just short of its goal: the clock must go on all the same.
            onward = math.nextafter(self._clock.time, math.inf)
            self._clock.time = max(self._clock.time + delay, onward)
            self._meet()
            self._engine.cycle()
            happenings += self._happened()
        self._clock.time = max(self._clock.time, end)
        self._engine.cycle()
        self._past.append(seconds)
        return happenings + self._happened()

    def _meet(self) -> None:
        """Let what the model's clocks bring and what commands bring at one time come in one turn,
        as in a node, however their sums are rounded."""
        both = self._engine.role.due(), self._engine.deadlines.time_to_next()
        left = max((t for t in both if t is not None and t <= _ROUNDING), default=0.0)
        if left:
            self._clock.time = math.nextafter(self._clock.time + left, math.inf)

    def _happened(self) -> list[machine.Happening]:
        return [self._happening(e) for e in self._engine.recorder.take()]

    def _happening(self, entry: recorder.Entry) -> machine.Happening:
        decided = self.plant.robot.decides(entry.kind, entry.name)
        told = (entry.kind, entry.name, entry.value, entry.tau, entry.outcome, entry.detail)
        return machine.Happening(*told, entry.time, decided, reason=entry.reason)

    def path(self, condition: tree.Expr) -> list[tuple[Event, Given]] | None:
        raise InvalidLine("goto is for single events: here the controller decides where it goes")

    def draw(self, rng: random.Random) -> tuple[Event, Given] | float | None:
        """An input that the robot can give, or as often some time in which it gives none."""
        able = [event for event in self._inputs if self.can(event, None)]
        if not able or rng.random() < 0.5:
            return round(rng.uniform(0.01, 0.5), 2)
        event = rng.choice(able)
        robot = self.plant.robot
        return event, complete(robot, event, random_raw(robot, event, rng), machine.label(event))


def _data(data: Callable[[model.Controller], Any], controller: model.Controller) -> Any:
    """What a command would carry; None if nothing has come of it yet."""
    try:
        return data(controller)
    except Undefined:
        return None


def read_settings(robot: entities.Robot, parameters: Mapping[str, Any]) -> Settings:
    """The settings of the robot's node, from parameters by name.

    Raises:
        InvalidLine: one of them is unknown or has a wrong value.
    """
    try:
        communications = config.declared_communications(robot)
        settings, _ = read(
            communications, parameters, config.playable_parameters(robot), strict=True
        )
    except ParameterError as error:
        raise InvalidLine(str(error)) from None
    return settings


def read_given(controller: model.Controller, plant: Plant) -> None:
    """Let the controller read given values in place of messages of ROS.

    What a message says was found out before, by the same rules; that a value lies in its range is
    for the controller to check. Given values have no stamp: they are as young as the model asks.
    """
    controller.COMMUNICATIONS = tuple(c._replace(max_age=None) for c in controller.COMMUNICATIONS)
    events = {(e.key, e.kind.word): e for e in plant.events}
    controller.INPUTS = tuple(
        entry
        if entry.read is None
        else entry._replace(read=_reader(plant, events[entry.key, entry.kind]))
        for entry in controller.INPUTS
    )
    controller.COMMANDS = tuple(
        row if row.read is None else row._replace(read=_reader(plant, events[row.key, row.kind]))
        for row in controller.COMMANDS
    )


def _reader(plant: Plant, event: Event) -> Callable[[model.Controller, Given], Any]:
    whole = event_values.value_type(plant.robot, event)
    parts = event_values.value_parts(plant.robot, event)

    def read_given(_: model.Controller, given: Given) -> Any:
        given = given or {}  # an error may have no result
        for path, type_ in {(): whole, **parts}.items():
            if isinstance(type_, IntegerType) and type_.bounds and given.get(path) is not None:
                in_range(given[path], *type_.bounds, "the value")
        if not isinstance(whole, ObjectType):
            return given.get(())
        return {traversal.path_text(path): given.get(path) for path in parts}

    return read_given
