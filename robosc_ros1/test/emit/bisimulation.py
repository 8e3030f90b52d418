"""Comparing two controllers of one model in all pairs of states that they reach together.

What can happen in a state is what the engine can do there: any message of some samples, the end of
what is under way, a timeout, the lapse of a time, or a command that both allow; then internal
transitions run to completion. A controller's engine performs cancels before requests, so while one
is enabled nothing is said of requests; a supervisor lets either pass.

A mutant differs from its controller in one method. So all that the controller itself does is
recorded once (:class:`Recording`), with the methods that are called on the way, and a mutant is run
only where its method is called. If that leads nowhere else, both reach the same states. A mutant
that leads to states that differ in what nobody sees is compared state by state (:func:`compare`).

Numbers and messages in variables have no end. Pairs of states that differ in nothing else are of
one *class* if the same requirements hold and the same commands are allowed in them. Each pair that
is reached is compared; of one class, what follows is looked at for some of them.
"""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from robosc.runtime.core.model import Command, Controller, Input
from robosc.runtime.core.reasons import blocked_by, violated
from robosc.runtime.core.values import Mismatch, Undefined
from robosc.simulate.machines.supervised import with_fields

__all__ = ["Comparison", "Recording", "compare"]

PAIRS_OF_CLASS = 4
"""Of so many pairs of states of one class it is looked at what follows."""
_FAULTS = (Mismatch, Undefined, AttributeError, TypeError, ValueError, LookupError)


Samples = Mapping[tuple[str, str], Sequence[Any]]
"""What is said, by key and kind: by the robot, and by a controller that is supervised."""
_Event = tuple[str, str, int]


class Comparison(NamedTuple):
    """How many classes of pairs of states were looked at, whether these are all of them, and the
    shortest way to a difference (None: there is none)."""

    classes: int
    is_complete: bool
    difference: str | None


class _State:
    """A controller and which of its timers run."""

    def __init__(
        self,
        controller: Controller,
        cancels_first: bool,
        samples: Samples,
        running: tuple[bool, ...] = (),
    ) -> None:
        self.controller = controller
        self.cancels_first = cancels_first
        self.samples = samples
        self.running = running
        self.told: list[Any] = []
        """What the last event showed, besides the state it led to."""

    def begin(self) -> _State:
        at = self.controller.__dict__
        self._run_to_completion()
        self.running = tuple(at[row.location] == row.state for row in self.controller.AFTERS)
        return self

    def after(self, event: Sequence[Any]) -> _State:
        """The state after an event: inputs with their message, a command, or a timer's number."""
        twin = _State(self.controller.copy(), self.cancels_first, self.samples, self.running)
        twin.controller.undefined = {}
        entries = twin._entries()
        for part in event:
            twin._happen(*part)
        twin._run_to_completion()
        at = twin.controller.__dict__
        restarted = [new != old for new, old in zip(twin._entries(), entries, strict=True)]
        there = [at[row.location] == row.state for row in twin.controller.AFTERS]
        twin.running = tuple(
            here if anew else runs
            for here, anew, runs in zip(there, restarted, twin.running, strict=True)
        )
        twin.told.append([h and a for h, a in zip(there, restarted, strict=True)])
        return twin

    def _happen(self, what: Any, message: Any) -> None:
        controller = self.controller
        try:
            if isinstance(what, Input):
                value = what.read(controller, message) if what.read else None
                self.told.append(value)
                what.apply(controller, value)
            elif isinstance(what, Command):
                if what.apply is not None:
                    what.apply(controller, *self._passed_on(what, message))
            else:
                path = controller.AFTERS[what].step(controller)
                self.told.append(path)
                if path is not None:
                    self.running = (*self.running[:what], False, *self.running[what + 1 :])
        except _FAULTS as fault:
            self.told.append(type(fault).__name__)

    def _run_to_completion(self) -> None:
        for _ in range(self.controller.STEP_BOUND + 1):
            for tau in self.controller.TAUS:
                path = tau.step(self.controller)
                if path is not None:
                    self.told.append((tau.component, tau.number, path))
                    break
            else:
                return
        self.told.append("never ends")

    def _entries(self) -> list[int]:
        return [self.controller.__dict__[row.entries] for row in self.controller.AFTERS]

    def _values(self) -> list[tuple[str, Any]]:
        counters = {row.entries for row in self.controller.AFTERS} | {"undefined"}
        at = self.controller.__dict__
        return sorted((k, v) for k, v in at.items() if k not in counters)

    def key(self) -> str:
        return repr((self._values(), self.running))

    def digest(self) -> tuple[int, int]:
        """What is seen of the state, and the state, as numbers."""
        return hash(self.shown()), hash(self.key())

    def class_key(self) -> str:
        """The state without the numbers and messages in it, but with what they decide."""
        values = [(k, v) for k, v in self._values() if isinstance(v, bool | int | str)]
        return repr((values, self.running, self._requirements(), sorted(self.enabled())))

    def _requirements(self) -> list[Any]:
        rows = self.controller.REQUIREMENTS
        return [None if row.on_data else row.holds(self.controller) for row in rows]

    def enabled(self) -> dict[_Event, Any]:
        """The commands that are possible, with their data; cancels alone if there are any. Of one
        of another controller that is judged by its data: by the number of the sample."""
        found: dict[_Event, Any] = {}
        for command in self.controller.COMMANDS:
            if not command.possible(vars(self.controller)):
                continue
            for number, data in self._offered(command):
                if self._is_enabled(command, *data):
                    found[command.kind, command.key, number] = repr(data) + self._data(command)
        cancels = {event: data for event, data in found.items() if event[0] == "cancel"}
        return (self.cancels_first and cancels) or found

    def _is_enabled(self, command: Command, *data: Any) -> bool:
        try:
            return self._is_authorised(command, *data) and not self._violated(command, *data)
        except Undefined:
            return False

    def _is_authorised(self, command: Command, *data: Any) -> bool:
        return bool(command.guard(self.controller, *data)) and (
            command.synchronisation is None or bool(command.synchronisation(self.controller, *data))
        )

    def _violated(self, command: Command, *data: Any) -> list[Any]:
        """The requirements that a supervisor looks at where guards allow a command."""
        is_looked_at = not self.cancels_first and command.kind != "cancel"
        return violated(self.controller, command, *data) if is_looked_at else []

    def _offered(self, command: Command) -> Iterator[tuple[int, list[Any]]]:
        """What is read of the samples of a command that another controller sends, as corrected."""
        is_read = command.read is not None
        for number, message in enumerate(
            self.samples[command.key, command.kind] if is_read else [None]
        ):
            with suppress(*_FAULTS):
                yield number, self._passed_on(command, message)

    def _passed_on(self, command: Command, message: Any) -> list[Any]:
        """What is read of a message of another controller, as corrected; none for other commands."""
        if command.read is None:
            return []
        value = command.read(self.controller, message)
        correction = command.correct and command.correct(self.controller, value)
        if correction:
            value = command.read(self.controller, with_fields(message, correction[0]))
        return [value]

    def _data(self, command: Command) -> str:
        try:
            own = command.data if command.read is None else None
            return repr(own(self.controller)) if own else ""
        except Undefined:
            return "undefined"

    def _reasons(self, command: Command) -> list[Any]:
        """Why a command is blocked; where it cannot happen anyway, a guard may say anything."""
        if command.read is not None:
            return [
                self._violated(command, *data)
                if self._is_authorised(command, *data)
                else blocked_by(self.controller, command, *data)
                for _, data in self._offered(command)
            ]
        reasons = blocked_by(self.controller, command) or self._violated(command)
        if command.kind == "cancel":
            return [bool(reasons)]
        impossible = [r for r in reasons if r["kind"] in ("phase", "synchronisation", "range")]
        return impossible or reasons

    def shown(self) -> str:
        phases = [self.controller.phase(c) for c in self.controller.COMMUNICATIONS]
        state = self.controller.components(), self.controller.variables(), phases, self.running
        reasons = [self._reasons(command) for command in self.controller.COMMANDS]
        return repr((state, self.enabled(), reasons, self.told))


class _Step(NamedTuple):
    """One event in a state of the recording: which of its events, and what the state after it is;
    the state and the event None for the start."""

    state: int | None
    event: int
    digest: tuple[int, int]
    called: frozenset[str]


class Recording:
    """All that a controller does, for some seconds of processor time at most.

    ``called`` is the set into which its methods, which are ``make``'s, put their names.
    """

    def __init__(
        self,
        make: Callable[[], Controller],
        called: set[str],
        samples: Samples,
        topics: Sequence[Sequence[str]],
        seconds: float,
        cancels_first: bool = True,
    ) -> None:
        self._samples, self._topics, self._cancels_first = samples, topics, cancels_first
        self._called = called
        self._states: list[_State] = []
        self._ways: list[tuple[str, ...]] = []
        self._steps: list[_Step] = []
        self._digests: set[tuple[int, int]] = set()
        self.classes: Counter[str] = Counter()
        start = _State(make(), cancels_first, samples).begin()
        self._note(None, 0, start)
        end = time.process_time() + seconds
        queue = deque([(start, ())])
        self.is_complete = True
        while queue and self.is_complete:
            self.is_complete = time.process_time() < end
            state, way = queue.popleft()
            class_key = state.class_key()
            if self.classes[class_key] == PAIRS_OF_CLASS:
                continue
            self.classes[class_key] += 1
            self._states.append(state)
            self._ways.append(way)
            for number, (text, events) in enumerate(_events((state, state), samples, topics)):
                called.clear()
                after = state.after(events[0])
                if self._note(len(self._states) - 1, number, after):
                    queue.append((after, (*way, text)))

    def _note(self, state: int | None, event: int, after: _State) -> bool:
        """Note a step; whether it leads to something new."""
        during = frozenset(self._called)
        digest = after.digest()
        is_new = digest not in self._digests
        self._digests.add(digest)
        called = frozenset(self._called) if is_new else during
        self._steps.append(_Step(state, event, digest, called))
        return is_new

    def compare(self, make: Callable[[], Controller], method: str) -> Comparison | None:
        """Compare a controller that differs in one method; None: the states that it reaches differ
        in what nobody sees."""
        found = len(self.classes)
        start = _State(make(), self._cancels_first, self._samples).begin()
        if start.digest() != self._steps[0].digest:
            return None
        events: list[tuple[str, Any]] = []
        twin, last = None, None
        for step in self._steps[1:]:
            if method not in step.called:
                continue
            assert step.state is not None
            if step.state != last:
                last, state = step.state, self._states[step.state]
                twin = _State(make(), self._cancels_first, self._samples, state.running)
                twin.controller.__dict__.update(state.controller.copy().__dict__)
                pair = state, twin
                events = list(_events(pair, self._samples, self._topics))
            assert twin is not None
            if step.event >= len(events):
                return None
            text, both = events[step.event]
            shown, key = twin.after(both[1]).digest()
            if shown != step.digest[0]:
                return Comparison(found, False, ", ".join((*self._ways[step.state], text)))
            if key != step.digest[1]:
                return None
        return Comparison(found, self.is_complete, None)


def compare(
    first: Controller,
    second: Controller,
    samples: Samples,
    topics: Sequence[Sequence[str]],
    seconds: float,
    cancels_first: bool = True,
) -> Comparison:
    """Compare two controllers of one model, for some seconds of processor time at most.

    ``cancels_first``: they send commands, instead of guarding what another one sends.
    """
    end = time.process_time() + seconds
    start = tuple(_State(c, cancels_first, samples).begin() for c in (first, second))
    classes: Counter[tuple[str, str]] = Counter()
    seen: set[tuple[str, str]] = set()
    queue = deque([(start, ("at the start",))])
    while queue:
        pair, way = queue.popleft()
        if pair[0].shown() != pair[1].shown():
            return Comparison(len(classes), False, ", ".join(way[1:]) or way[0])
        if time.process_time() > end:
            return Comparison(len(classes), False, None)
        key = pair[0].key(), pair[1].key()
        class_key = pair[0].class_key(), pair[1].class_key()
        if key in seen or classes[class_key] == PAIRS_OF_CLASS:
            continue
        seen.add(key)
        classes[class_key] += 1
        for text, events in _events(pair, samples, topics):
            queue.append(((pair[0].after(events[0]), pair[1].after(events[1])), (*way, text)))
    return Comparison(len(classes), True, None)


def _events(
    pair: tuple[_State, _State],
    samples: Samples,
    topics: Sequence[Sequence[str]],
) -> Iterator[tuple[str, tuple[Sequence[Any], Sequence[Any]]]]:
    """What can happen in both states, as text and for each of them."""
    one, other = (state.controller for state in pair)
    inputs = [{(e.key, e.kind): e for e in c.INPUTS} for c in (one, other)]
    phases = {c.key: one.phase(c) for c in one.COMMUNICATIONS}
    for keys in topics:
        for message in samples[keys[0], "response"]:
            both = tuple([(table[key, "response"], message) for key in keys] for table in inputs)
            yield f"{keys[0]} {message}", both  # type: ignore[misc]
    told = {key for keys in topics for key in keys}
    for (key, kind), entry in inputs[0].items():
        if (kind == "response" and key in told) or phases[key] in ("", "idle", "silent"):
            continue
        if (kind == "cancelled") > (phases[key] == "cancelling"):
            continue
        for message in samples.get((key, kind), (None,)):
            yield f"{kind} of {key}", ([(entry, message)], [(inputs[1][key, kind], message)])
    for number, runs in enumerate(pair[0].running):
        if runs:
            yield f"lapse {number}", ([(number, None)], [(number, None)])
    for kind, key, number in pair[0].enabled():
        messages = samples.get((key, kind), ())
        message = messages[number] if number < len(messages) else None
        commands = tuple(
            [(c, message) for c in own.COMMANDS if (c.kind, c.key) == (kind, key)]
            for own in (one, other)
        )
        yield f"{kind} of {key} {message or ''}".rstrip(), commands  # type: ignore[misc]
