"""A second reading of the semantics, slow and plain: what the engines are compared with.

It starts from the resolved model (``robosc.model``) and shares no code with ``robosc.plant`` or the
engines. A state is a tuple of plain values, one per *slot*: ``("at", component)``,
``("var", "Component.variable")``, ``("phase", communication)``, ``("parameter", name)``. Everything else is dictionaries,
sets and loops that say what the language's documents say, in their order.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

from synthesis.oracle_events import AGREED, Event, Occurrence, OracleState
from synthesis.oracle_plant import OraclePlant, Transition
from synthesis.oracle_values import Path

from robosc.language.events import EventKind, Kind
from robosc.model.entities import Communication, Goal

SENT = (EventKind.REQUEST, EventKind.ANSWER, EventKind.PROGRESS)
"""What carries data of the controller, and yields to what is preferred."""


class Oracle(OraclePlant):
    """The plant of a robot, its supervisor and its controller, by exhaustive search."""

    # --- requirements and supervisor ---------------------------------------------------------

    def required(self, state: OracleState, event: Event) -> bool:
        """What the requirements on communications say about an event in a state."""
        if event.kind not in (*AGREED, EventKind.CANCEL):
            return True
        kept = [event.kind is not EventKind.REQUEST or not self.waits(state, event.key)]
        answer = {EventKind.PROGRESS: ".feedback", EventKind.REFUSAL: ".error"}.get(event.kind, "")
        for requirement in self.robot.requirements:
            if requirement.to_start if event.kind is EventKind.CANCEL else requirement.to_cancel:
                continue
            if " waits for " in requirement.text and requirement.implied:
                continue  # see waits
            if event.key + answer in requirement.communications:
                condition = self.holds(requirement.condition, state)
                kept.append(condition if requirement.kind == "needs" else not condition)
        return all(kept) if event.kind in AGREED else not all(kept[1:])

    def waits(self, state: OracleState, key: str) -> bool:
        """Whether a state asks while another action that its component performs is under way."""
        if self.robot.communications[key].kind not in (Kind.SERVICE, Kind.ACTION):
            return False
        for component in self.automata:
            here = self.get(state, "at", component.name)
            performing = [o for o in component.behaviour.composites if o.performs is not None]
            stages = ("due", "performing") if self._is_replaced(key) else ("due",)
            asks = any(
                outer.performs == key and not outer.meanwhile and here == f"{outer.name} {stage}"
                for outer in performing
                for stage in stages
            )
            for other in {outer.performs for outer in performing} - {key} if asks else ():
                communication = self.robot.communications.get(other)
                is_action = communication is not None and communication.kind is Kind.ACTION
                if is_action and self.get(state, "phase", other) != "idle":
                    return True
        return False

    def _is_replaced(self, key: str) -> bool:
        return self.robot.communications[key].goals is not None

    def unsafe(self, state: OracleState) -> bool:
        """A state requirement fails, or an uncontrollable event would leave a range."""
        for requirement in self.robot.requirements:
            if requirement.kind == "never" and self.holds(requirement.condition, state):
                return True
            if requirement.kind == "always" and not self.holds(requirement.condition, state):
                return True
        return self.leaves_a_range(state)

    @cached_property
    def kept(self) -> set[OracleState]:
        """The greatest set of states that is safe, controllable and nonblocking in itself.

        The largest set X of plant states without unsafe ones such that uncontrollable events stay
        in X and each state of X reaches a marked one of X, through X, by allowed events.
        """
        states, transitions = self.plant
        allowed = [t for t in transitions if self.required(t.source, t.occurrence.event)]
        keep = {state for state in states if not self.unsafe(state)}
        while True:
            smaller = set(keep)
            for t in transitions:
                if not t.occurrence.event.controllable and t.target not in keep:
                    smaller.discard(t.source)
            reaching = {state for state in keep if self.marked(state)}
            while True:
                more = {
                    t.source
                    for t in allowed
                    if t.source in keep and t.target in reaching and t.source not in reaching
                }
                if not more:
                    break
                reaching |= more
            smaller &= reaching
            for goal in self.robot.goals:
                smaller -= self._missing(goal, keep, allowed)
            if smaller == keep:
                return keep
            keep = smaller

    def _missing(
        self, goal: Goal, keep: set[OracleState], allowed: list[Transition]
    ) -> set[OracleState]:
        """The states of ``keep`` in which something must be possible, and no way in it leads there."""
        found = {state for state in keep if self.holds(goal.condition, state)}
        while True:
            more = {
                t.source
                for t in allowed
                if t.source in keep
                and t.source not in found
                and t.target in found
                and (goal.along is None or self.holds(goal.along, t.source))
            }
            if not more:
                break
            found |= more
        return {
            state for state in keep - found if goal.origin is None or self.holds(goal.origin, state)
        }

    @property
    def empty(self) -> bool:
        return not self.kept.issuperset(self.initials)

    @cached_property
    def controlled(self) -> tuple[list[OracleState], list[Transition]]:
        """What can be reached under the supervisor; nothing at all if it is empty."""
        if self.empty:
            return [], []
        return self._explore(
            lambda state, event, target: (
                not event.controllable or (self.required(state, event) and target in self.kept)
            )
        )

    def possible(self, state: OracleState) -> set[Event]:
        """Controllable events that the plant can do."""
        return {o.event for o, _ in self.successors(state) if o.event.controllable}

    def enabled(self, state: OracleState) -> set[Event]:
        """Controllable events that the supervisor allows."""
        return {
            occurrence.event
            for occurrence, target in self.successors(state)
            if occurrence.event.controllable
            and self.required(state, occurrence.event)
            and target in self.kept
        }

    def status(self, event: Event) -> str:
        """How the supervisor's guard of an event compares with its requirements."""
        states, _ = self.controlled
        if not any(event in self.enabled(state) for state in states):
            return "never"
        for state in states:
            asked_for = event in self.possible(state) and self.required(state, event)
            if asked_for and event not in self.enabled(state):
                return "restricted"
        return "as required"

    # --- execution ---------------------------------------------------------------------------

    def after(self, state: OracleState, events: list[Event]) -> list[OracleState]:
        """Where enabled events lead to: each uncontrollable one with each of its values."""
        return [
            target
            for occurrence, target in self.successors(state)
            if occurrence.event in events
            and (not occurrence.event.controllable or occurrence.event in self.enabled(state))
        ]

    def moves(self, state: OracleState, taus: list[Event]) -> list[OracleState]:
        """Where internal transitions lead to; the controller does not take one that changes nothing."""
        return [target for target in self.after(state, taus) if target != state]

    def settle(self, state: OracleState) -> list[OracleState] | None:
        """The states that the controller's internal transitions go through, None if they never end.

        All enabled taus in source order, each at most once, and again until none was enabled.
        """
        path = [state]
        seen = set()
        while path[-1] not in seen:
            seen.add(path[-1])
            before = len(path)
            for tau in self.taus:
                path += self.moves(path[-1], [tau])
            if len(path) == before:
                return path
        return None

    @cached_property
    def taus(self) -> list[Event]:
        return [event for event in self.events if event.kind is EventKind.TAU]

    def properties(self) -> dict[str, bool]:
        """The controller properties: of one that settles after each event before the next.

        ``acyclic`` tells that no order of internal transitions goes round, so that confluence is a question.
        """
        others = [event for event in self.events if event not in self.taus]
        settled: dict[OracleState, OracleState | None] = {}
        edges: dict[OracleState, set[OracleState]] = {}
        starts = list(self.initials)
        while starts:
            start = starts.pop()
            if start in settled:
                continue
            path = self.settle(start)
            settled[start] = None if path is None else path[-1]
            if path is not None and path[-1] not in edges:
                starts += self.after(path[-1], self.sent(path[-1], others))
                edges[path[-1]] = set()
        for rest in edges:
            ends = {settled[start] for start in self.after(rest, self.sent(rest, others))}
            edges[rest] = {end for end in ends if end is not None}
        bounded = None not in settled.values()
        reaching = {rest for rest in edges if self.marked(rest)}
        while any(ends & reaching and rest not in reaching for rest, ends in edges.items()):
            reaching |= {rest for rest, ends in edges.items() if ends & reaching}
        possible = {}
        if self.robot.goals:
            kept = all(self._is_kept(goal, edges, others) for goal in self.robot.goals)
            possible = {"always possible": bounded and kept}
        return {
            "bounded response": bounded,
            "confluence": all(len(self._ends(start)) < 2 for start in settled),
            "nonblocking under control": bounded and reaching == set(edges),
            **possible,
            "acyclic": not any(self._goes_round(start) for start in settled),
        }

    def _is_kept(
        self, goal: Goal, edges: dict[OracleState, set[OracleState]], events: list[Event]
    ) -> bool:
        """Whether the controller can come to a goal, from each state at rest that asks for it."""
        found = {rest for rest in edges if self.holds(goal.condition, rest)}
        ways = {rest for rest in edges if goal.along is None or self.holds(goal.along, rest)}
        steps: dict[OracleState, set[OracleState]] = {rest: set() for rest in ways}
        for rest in ways:
            for start in self.after(rest, self.sent(rest, events)):
                path = self.settle(start) or []
                for state in path:
                    if self.holds(goal.condition, state):
                        found.add(rest)
                        break
                    if goal.along is not None and not self.holds(goal.along, state):
                        break
                else:
                    steps[rest] |= set(path[-1:])
        while any(rest not in found and steps[rest] & found for rest in ways):
            found |= {rest for rest in ways if steps[rest] & found}
        asked = {rest for rest in edges if goal.origin is None or self.holds(goal.origin, rest)}
        return asked <= found

    def sent(self, state: OracleState, events: list[Event]) -> list[Event]:
        """The events without the requests that another one is preferred to, now."""
        enabled = {
            e.key
            for e in self.enabled(state)
            if e.kind in SENT and not self._would_replace(e, state)
        }

        def held_back(event: Event) -> bool:
            return event.kind in SENT and any(
                event.key in preference.over and enabled & set(preference.preferred)
                for preference in self.robot.preferences
            )

        return [event for event in events if not held_back(event)]

    def _would_replace(self, event: Event, state: OracleState) -> bool:
        replaces = self.robot.communications[event.key].goals == "replace"
        return replaces and self.get(state, "phase", event.key) == "busy"

    def _wake(self, start: OracleState) -> set[OracleState]:
        """All that internal transitions in any order lead to."""
        found, todo = {start}, [start]
        while todo:
            for target in self.moves(todo.pop(), self.taus):
                if target not in found:
                    found.add(target)
                    todo.append(target)
        return found

    def _ends(self, start: OracleState) -> set[OracleState]:
        return {state for state in self._wake(start) if not self.moves(state, self.taus)}

    def _goes_round(self, start: OracleState) -> bool:
        left = self._wake(start)
        while True:
            ends = {s for s in left if not set(self.moves(s, self.taus)) & left}
            if not ends:
                return bool(left)
            left -= ends

    # --- documents ---------------------------------------------------------------------------

    def document(self, plant: bool = False) -> dict[str, Any]:
        """The transition system in the shape of ``explore --json``."""
        states, transitions = self.plant if plant else self.controlled
        number = {state: i for i, state in enumerate(states)}
        return {
            "version": 1,
            "robot": self.robot.name,
            "initial": 0,
            "states": [self._state_document(number[s], s) for s in states],
            "transitions": [
                {
                    "source": number[t.source],
                    "event": self.event_document(t.source, t.occurrence),
                    "controllable": t.occurrence.event.controllable,
                    "target": number[t.target],
                }
                for t in transitions
            ],
        }

    def _state_document(self, number: int, state: OracleState) -> dict[str, Any]:
        def those(what: str) -> dict[str, Any]:
            return {n: v for (w, n), v in zip(self.slots, state, strict=True) if w == what}

        lasting = {one.name for one in self.robot.lasting}
        places = those("at")
        return {
            "id": number,
            "components": {n: p.split(" ")[0] for n, p in places.items() if n not in lasting},
            "variables": those("var")
            | {n: places[n] == "holding" for n in lasting}
            | self._phases_of_performing(places),
            "communications": {
                self.name(Event(EventKind.REQUEST, key)): phase
                for key, phase in those("phase").items()
            },
            "marked": self.marked(state),
        }

    def _phases_of_performing(self, places: dict[str, str]) -> dict[str, bool]:
        return {
            f"{component.name}.{state.name}": places[component.name] == state.name
            for component in self.robot.components
            if component.behaviour is not None
            for state in component.behaviour.states
            if state.name.endswith((" performing", " waiting"))
        }

    def event_document(self, state: OracleState, occurrence: Occurrence) -> dict[str, Any]:
        event = occurrence.event
        if event.kind in (EventKind.TAU, EventKind.AFTER):
            here = self.get(state, "at", event.key)
            after = dict(zip(self.slots, self.step(state, occurrence), strict=True))
            there = after["at", event.key]
            return {
                "kind": event.kind.word,
                "name": event.key,
                "value": f"{here.split(' ')[0]}->{there.split(' ')[0]}",
                "index": event.index,
            }
        value: Any = None
        if occurrence.values:
            if [path for path, _ in occurrence.values] == [()]:
                value = occurrence.values[0][1]
            else:
                value = {path_text(path): v for path, v in occurrence.values}
        return {"kind": event.kind.word, "name": self.name(event), "value": value}

    def name(self, event: Event) -> str:
        """The bare name of a communication, qualified only where several have it."""
        if event.kind in (EventKind.TAU, EventKind.AFTER):
            return event.key
        communications: list[Communication] = list(self.robot.communications.values())
        bare = event.key.split(".")[1]
        same = [c for c in communications if c.name == bare]
        return bare if len(same) == 1 else event.key


def path_text(path: Path) -> str:
    """``position.x``, ``items[0].kind``."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text
