"""Records a run of a supervisor or of a monitor: what the plant says of another one's commands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from robosc.expr.tree import TRUE
from robosc.language.events import EventKind
from robosc.plant.automaton import Event
from robosc.plant.build import lower
from robosc.runtime.core.values import NOW, jsonable
from robosc.simulate.machines.machine import label
from robosc.supervisor import Guard, Supervisor
from robosc.traces.attempts import Attempt, attempted
from robosc.traces.coverage import Case
from robosc.traces.exact_steps import ExactStep, State
from robosc.traces.recorder import Recorder, RunLine, _assigned
from robosc.traces.samples import Sample, fields_of, fields_text
from robosc.traces.search import Move


class GuardRecorder(Recorder):
    """One run from the start of a supervisor, beside which the virtual clock of one runs."""

    def _parameters(self) -> dict[str, Any]:
        given = super()._parameters()
        del given["rate"]
        return given if self._robot.stop is None else {**given, "stop_command": ""}

    def play(self, move: Move) -> None:
        step, sample = move
        if self._steps.comes_by_time(step):
            self._await(step)
        elif step.event.controllable:
            self._attempt(step, sample)
        else:
            self._fire(step, sample)

    def beat(self) -> None:
        """Nothing is repeated."""

    def _demand_all(self, *_: Any) -> None:
        """Nothing is sent by itself."""

    def _take(self, step: ExactStep, sample: Sample, attempt: Attempt) -> None:
        """Let the supervisor on the clock take a command, too."""
        if not self.machine.can(step.event, None):
            self.is_over = True
            return
        for happening in self.machine.fire(step.event, sample.given):
            named = (happening.kind, happening.name) == (step.event.kind.word, step.event.name)
            if named and (happening.outcome == "applied") is not attempt.is_allowed:
                self.is_over = True

    def _attempt(self, step: ExactStep, sample: Sample) -> None:
        before = self.state
        text = f"{label(step.event)} {sample.text}".strip()
        attempt = attempted(self._steps, self._coverage, step, before, sample.parts)
        if attempt is None:
            self.is_over = True
            return
        assigned = set(_assigned(step, before, sample.parts))
        self.state, cases = self._coverage.of_settled(attempt.after)
        cases |= attempt.cases
        if attempt.is_allowed and step.event.key in self._overdue:
            self._due[step.event.key] = self.machine.time + self._overdue[step.event.key]
        if step.event.kind is EventKind.REQUEST and (attempt.is_allowed or self._steps.follows):
            self._note_request(step.event.key, before)
        self._take(step, sample, attempt)
        if self.machine.stopped is not None:
            self.is_over = True
            return
        expected = tuple(self._outcome(step, sample, attempt))
        self._tell(text, expected, assigned, self._stays(step, before, cases), before, cases)

    def _outcome(self, step: ExactStep, sample: Sample, attempt: Attempt) -> Iterator[str]:
        """What becomes of a command."""
        name = label(step.event)
        if attempt.is_allowed:
            yield f"sent {name}"
            made = {path: jsonable(value) for path, value in attempt.set_fields.items()}
            fields = {p: v for p, v in {**fields_of(sample.raw), **made}.items() if v != NOW}
            if fields and step.event.kind.sent:
                yield f"data {name} {fields_text(fields)}"
        else:
            yield "sent nothing"
            word = "forbidden" if self._steps.follows else "blocked"
            yield word + (f" because {'; '.join(attempt.reasons)}" if attempt.reasons else "")

    def _tell(
        self,
        text: str,
        expected: tuple[str, ...],
        assigned: set[str],
        staying: set[str],
        before: State,
        cases: set[Case],
    ) -> None:
        expected = (*expected, *self._changes(before, assigned, staying), *self._reasons())
        expected = (*expected, *self._violations())
        self.run.lines.append(RunLine(text, expected, frozenset(cases)))


class MonitorRecorder(GuardRecorder):
    """One run from the start of a monitor, with the clock of a supervisor that forbids nothing."""

    def _own(self, event: Event) -> Event:
        events = (one.whole or one for one in self.machine.plant.events)
        return next(one for one in events if one.identity == event.identity)

    def _take(self, step: ExactStep, sample: Sample, attempt: Attempt) -> None:
        self.machine.fire(self._own(step.event), sample.given)
        components = self.machine.state.components
        self.is_over |= any(place != self.state[name] for name, place in components.items())

    def _reasons(self) -> Iterator[str]:
        """Guards mean nothing in states that no controller allows."""
        return iter(())


def permissive(supervisor: Supervisor) -> Supervisor:
    """A supervisor that forbids and corrects nothing."""
    plant = lower(replace(supervisor.plant.robot, requirements=(), provides=()))
    guards = [Guard(e, TRUE, TRUE, "as required") for e in plant.events if e.controllable]
    return replace(supervisor, plant=plant, guards=tuple(guards), explanations=())
