"""What conflicts where no controller exists, or where a command never happens.

Requirements, goals (``requirement possible``), assumptions, and what the robot may do that the
controller does not choose: that a call fails, that a message falls silent, that the robot cancels
its goal, and that an end comes where no component has a transition for it. With these alone there
is no controller, or the command never happens, and without any one member it is otherwise. Another
such set may be smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import TypeVar

from robosc import limits
from robosc.errors import Diagnostic, Note
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model.declarations.state_variables import select_state_variables
from robosc.model.diagnostics import Muted
from robosc.plant.acceptance import handled
from robosc.plant.automaton import Event, Plant
from robosc.plant.build import lower
from robosc.source import Span
from robosc.supervisor import Explanation, Supervisor
from robosc.synthesis.decomposition import independent_parts
from robosc.synthesis.explain.smallest_conflict import smallest_conflict
from robosc.synthesis.formatting import event_text, quoted

_Item = TypeVar("_Item")

_STATED = ("requirement", "goal", "assumption")
_AVOIDABLE = {
    EventKind.ERROR: "{} may fail",
    EventKind.TIMEOUT: "{} may fall silent",
    EventKind.RECALL: "{} may be cancelled",
}
"""Events that a robot could do without, and what is told of them."""

Identity = tuple[EventKind, str, int]
Solve = Callable[[Plant], Collection[Identity] | None]
"""Which commands the supervisor of an independent part allows in some state; None: it is empty."""


@dataclass(frozen=True, slots=True)
class _Member:
    """A requirement, a goal, an assumption (by index), or an event (by the communication's key)."""

    kind: str
    key: int | str
    span: Span
    text: str

    @property
    def own(self) -> tuple[str, int | str]:
        return self.kind, self.key


def with_conflicts(supervisor: Supervisor, states: int, solve: Solve) -> Supervisor:
    """Return the supervisor with what conflicts in its explanations, and as notes.

    ``states`` are those of the plant's independent parts together. A plant for which looking for
    conflicts would take long is left as it is.
    """
    explanations = supervisor.explanations
    asked = [n for n, e in enumerate(explanations) if _is_asked_for(supervisor, e)]
    members = list(_members(supervisor.plant))
    work = states + limits.CONFLICT_EVENT * len(supervisor.plant.events)
    if not members or len(asked) * len(members) * work > limits.CONFLICT_WORK:
        return supervisor
    finder = _Finder(supervisor.plant, members, solve)
    new = {n: finder.explained(explanations[n]) for n in asked}
    told = [(explanations[n].diagnostic, e.diagnostic.notes) for n, e in new.items()]
    return replace(
        supervisor,
        explanations=tuple(new.get(n, e) for n, e in enumerate(explanations)),
        diagnostics=tuple(_with_notes(diagnostic, told) for diagnostic in supervisor.diagnostics),
    )


def _with_notes(
    diagnostic: Diagnostic, told: Iterable[tuple[Diagnostic, tuple[Note, ...]]]
) -> Diagnostic:
    """Return the diagnostic of an explanation with its new notes, any other as it is.

    The diagnostics of copies have one place; one that stands for several commands says more.
    """
    for explained, notes in told:
        alike = replace(diagnostic, message=explained.message) == explained
        if alike and diagnostic.message.startswith(explained.message):
            return replace(diagnostic, notes=notes)
    return diagnostic


def _is_asked_for(supervisor: Supervisor, explanation: Explanation) -> bool:
    if explanation.event is None:
        return supervisor.empty
    is_request = explanation.event.kind is EventKind.REQUEST and not explanation.event.known
    return is_request and explanation.diagnostic.code == "never-allowed"


class _Finder:
    def __init__(self, plant: Plant, members: Sequence[_Member], solve: Solve) -> None:
        self.members = members
        stated = [n for n, member in enumerate(members) if member.kind in _STATED]
        self.stated = frozenset(stated)
        self.parts = cache(lambda kept: independent_parts(_stating(plant, self._of(kept)), 1))
        self.allowed = cache(
            lambda kept, number, events: solve(
                _having(self.parts(kept)[number], {member.own for member in self._of(events)})
            )
        )

    def _of(self, numbers: frozenset[int]) -> list[_Member]:
        return [self.members[number] for number in sorted(numbers)]

    def explained(self, explanation: Explanation) -> Explanation:
        members = self._of(self._conflict(explanation.event))
        diagnostic = explanation.diagnostic
        notes = (*diagnostic.notes, *_notes(explanation, members))
        return replace(
            explanation,
            conflict=tuple((member.text, member.span) for member in members),
            diagnostic=replace(diagnostic, notes=notes),
        )

    def _failing(self, event: Event | None, kept: frozenset[int]) -> Iterator[frozenset[int]]:
        """Yield the events of each part that has no controller, or in which a command never
        happens. Of a command only its own part is solved: the others have a controller, and what is
        left out of them changes nothing in it.
        """
        stated, events = kept & self.stated, kept - self.stated
        for number, part in enumerate(self.parts(stated)):
            present = {(own.kind.value, own.key) for own in part.events}
            if event is None or event.identity in (own.identity for own in part.events):
                own = frozenset(n for n in events if self.members[n].own in present)
                allowed = self.allowed(stated, number, own)
                if allowed is None or (event is not None and event.identity not in allowed):
                    yield own

    def _conflict(self, event: Event | None) -> frozenset[int]:
        """Return the numbers of the members of a conflict.

        Fewer requirements and goals never forbid more, so a smallest set of them is found while all
        events and assumptions are there. Without one of these there may be less to rule out, or one
        way less or more: each is a member if there would be no conflict without it. An event of a
        part without a conflict is none.
        """

        def fails(kept: frozenset[int]) -> bool:
            return any(True for _ in self._failing(event, kept))

        chosen = [n for n in sorted(self.stated) if self.members[n].kind != "assumption"]
        given = frozenset(range(len(self.members))).difference(chosen)
        conflicting = frozenset(smallest_conflict(chosen, lambda kept: fails(kept | given)))
        near = frozenset().union(*self._failing(event, conflicting | given))
        asked = near | (given & self.stated)
        return conflicting.union(n for n in asked if not fails(conflicting | (given - {n})))


def _members(plant: Plant) -> Iterator[_Member]:
    """Yield all that may be left out, in model order."""
    for number, requirement in enumerate(plant.robot.requirements):
        yield _Member("requirement", number, requirement.span, requirement.text)
    for number, goal in enumerate(plant.robot.goals):
        yield _Member("goal", number, goal.span, goal.text)
    for number, assumption in enumerate(plant.robot.assumptions):
        yield _Member("assumption", number, assumption.span, assumption.text)
    for event in plant.events:
        if event.kind in _AVOIDABLE:
            text = _AVOIDABLE[event.kind].format(event.name)
            yield _Member(event.kind.value, event.key, event.span, text)
        elif _is_end(plant, event):
            text = f"{event.kind.word} from {event.name} is not handled everywhere"
            yield _Member(event.kind.value, event.key, event.span, text)


def _is_end(plant: Plant, event: Event) -> bool:
    """Whether an event ends a call, which matters also where no component takes it."""
    if event.kind is EventKind.RESPONSE:
        return plant.robot.communications[event.key].kind in (Kind.SERVICE, Kind.ACTION)
    return event.kind is EventKind.CANCELLED


def _stating(plant: Plant, members: Sequence[_Member]) -> Plant:
    """Return the plant with no other requirements, goals and assumptions, and what they read."""
    kept = {member.own for member in members}
    robot = plant.robot
    fewer = replace(
        robot,
        requirements=_kept("requirement", robot.requirements, kept),
        goals=_kept("goal", robot.goals, kept),
        assumptions=_kept("assumption", robot.assumptions, kept),
    )
    return lower(select_state_variables(fewer, Muted()))


def _having(plant: Plant, kept: Collection[tuple[str, int | str]]) -> Plant:
    """Return the plant with no other events of those that may be left out."""
    events = []
    for event in plant.events:
        if (event.kind.value, event.key) in kept:
            events.append(event)
        elif event.kind not in _AVOIDABLE:
            events.append(handled(event, plant.variables) if _is_end(plant, event) else event)
    return replace(plant, events=tuple(events))


def _kept(kind: str, items: Sequence[_Item], kept: set[tuple[str, int | str]]) -> tuple[_Item, ...]:
    return tuple(item for number, item in enumerate(items) if (kind, number) in kept)


def _notes(explanation: Explanation, conflict: Sequence[_Member]) -> Iterator[Note]:
    """Yield what the explanation does not tell by itself."""
    match conflict:
        case [one]:
            told = {note.span for note in explanation.diagnostic.notes}
            # The trace has the events.
            if one.kind in _STATED and one.span not in told:
                event = explanation.event
                what = "there is no controller"
                if event is not None:
                    what = f"{event_text(event)} never happens"
                yield Note(f"because of {quoted(one.text)} alone, {what}", one.span)
        case [first, *others]:
            together = f"{len(conflict)} things conflict, and no fewer of them do"
            if all(one.kind == "goal" for one in conflict):
                together = (
                    f"{len(conflict)} goals cannot remain possible together; without any one of"
                    " them the others can"
                )
            yield Note(f"{together}: {quoted(first.text)}", first.span)
            yield from (Note(f"and {quoted(one.text)}", one.span) for one in others)
