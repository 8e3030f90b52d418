"""An event log as a source: any moment of it, for each browser another one.

The log holds events only. The states come from the model: a controller that is generated from it
follows the log as in ``robosc replay``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from copy import deepcopy
from functools import cached_property
from pathlib import Path
from typing import Any

from robosc.emit.package.model_document import model_document
from robosc.errors import UsageError
from robosc.language.events import EventKind
from robosc.model import entities
from robosc.runtime.core import model, telemetry, values
from robosc.runtime.core.places import places
from robosc.simulate.bags import bag_files, bag_run
from robosc.simulate.event_log import LogEntry, entry_of, read_log
from robosc.simulate.replay import Follower
from robosc.simulate.values.shortened_values import UnknownValue
from robosc.supervisor import Supervisor
from robosc.view import server, tally
from robosc.view.hub import Hub

# How the states, the numbers of variables and those in data went over a recording.


class Collector:
    """Series by name: a component's states, a variable, or an event with the path of a number.

    Of states and variables, places (from 1) where they change; of data, all places. ``owners`` are
    the components of communications.
    """

    def __init__(self, owners: Mapping[str, str]) -> None:
        self._owners = owners
        self._found: dict[str, tuple[str | None, list[int], list[Any]]] = {}

    def take(self, place: int, entry: LogEntry, controller: model.Controller | None) -> None:
        """An event, and the state after it; None where it is not known."""
        if controller is not None:
            self._change(place, places(controller.components()))
            self._change(place, dict(_numbers(controller.variables(), "")))
        if entry.outcome == "applied" and entry.name in self._owners:
            for path, value in _numbers(entry.value, " "):
                self._series(f"{entry.text}{path}", self._owners[entry.name], place, value)

    def documents(self) -> list[Any]:
        """``component`` is set for data: the one whose communication carries them."""
        return [
            {"name": name, "component": component, "places": places, "values": values}
            for name, (component, places, values) in self._found.items()
        ]

    def _change(self, place: int, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            found = self._found.get(name)
            if found is None or found[2][-1] != value:
                self._series(name, None, place, value)

    def _series(self, name: str, component: str | None, place: int, value: Any) -> None:
        _, places, values = self._found.setdefault(name, (component, [], []))
        places.append(place)
        values.append(value)


def _numbers(value: Any, before: str) -> Iterator[tuple[str, int | float]]:
    """The numbers of a value that JSON has, with their paths; lists are too many."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            for path, number in _numbers(part, before):
                yield f"{before}{name}{path}", number
    elif isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300:
        yield "", value


_STRIDE = 256
"""Events between two moments that are kept; from one of them all others are found."""
_SHOWN = 200

Json = dict[str, Any]


class _Moment:
    """A follower of the log, and what it counts on its way."""

    def __init__(self, follower: Follower) -> None:
        self.follower = follower
        self.shown: model.Controller | None = None
        self.tally = tally.Tally(follower.robot)
        self.stopped: str | None = None

    def fork(self) -> _Moment:
        other = _Moment(self.follower.fork())
        # Where the state is not known any more, the last one that was is not changed any more.
        other.shown = other.follower.controller or self.shown
        other.tally = deepcopy(self.tally)
        other.stopped = self.stopped
        return other

    def take(self, entry: LogEntry) -> None:
        runs = self.follower.runs
        self.follower.take(entry)
        if self.follower.runs > runs:
            self.tally = tally.Tally(self.follower.robot)
            self.stopped = None
            if entry.number == 1:  # which may leave the model itself
                self.shown = self.follower.initial
        self.shown = self.follower.controller or self.shown
        if entry.outcome == "stopped":
            self.stopped = str(entry.document.get("detail") or "no reason is given")
        self.tally.take(entry.kind, entry.name, entry.outcome)


class Recording:
    """A log that was read as a whole, with the state after each event.

    Raises UsageError: it cannot be read, or holds no events.
    """

    def __init__(self, supervisor: Supervisor, log: str, hub: Hub) -> None:
        self._entries = list(_entries(supervisor, log))
        if not self._entries:
            raise UsageError(f"{log} holds no events")
        self._moments: list[_Moment] = []
        self._departures: list[Json] = []
        self._follow(supervisor)
        source = supervisor.plant.robot.span.source.file_name
        self._supervisor = supervisor
        self.model: Json = model_document(supervisor, source)
        self.hello: Json = {"source": "log", "title": log, "count": len(self._entries)}
        hub.put("model", telemetry.dump(self.model))
        hub.put("hello", telemetry.dump(self.hello))

    def _follow(self, supervisor: Supervisor) -> None:
        """Keep a moment every _STRIDE events, and where the log leaves the model and until when."""
        moment = _Moment(Follower(supervisor))
        robot = supervisor.plant.robot
        names = robot.display_names
        self._series = Collector({names[c.key]: c.component for c in robot.communications.values()})
        lost: str | None = None
        for place, entry in enumerate(self._entries):
            if place % _STRIDE == 0:
                self._moments.append(moment.fork())
            moment.take(entry)
            self._series.take(place + 1, entry, moment.follower.controller)
            at, before, lost = place + 1, lost, moment.follower.lost
            if lost is not None and lost != before:
                self._departures.append({"at": at, "until": at, "reason": lost})
            elif lost is not None:
                self._departures[-1]["until"] = at

    @property
    def answers(self) -> server.Answers:
        return {
            "/moment": self.moment,
            "/overview": self.overview,
            "/search": self.search,
            "/events": self.events,
        }

    def overview(self, _: Any) -> Json:
        """Of each event when it was, in seconds since 1970, its sort as a letter, and the place of
        its name in ``names``. ``series`` are how states and numbers went. ``departures`` say where
        the log leaves the model: ``at`` an event, and the state is not known ``until`` another.
        """
        names: dict[str, int] = {}
        robot = self._supervisor.plant.robot
        name = [names.setdefault(e.name or e.kind, len(names)) for e in self._entries]
        return {
            "times": [_time(entry) for entry in self._entries],
            "sorts": "".join(_sort(entry, robot) for entry in self._entries),
            "names": list(names),
            "name": name,
            "departures": self._departures,
            "series": self._series.documents(),
        }

    def search(self, document: Any) -> Json:
        """The places of the events, from 1, that have a text in their name, value, outcome or
        detail. Raises Unable.
        """
        match document:
            case {"text": str(text)}:
                wanted = text.lower()
            case _:
                raise server.Unable("there is no text to search for")
        return {"hits": [place for place, t in enumerate(self._texts, 1) if wanted in t]}

    def events(self, document: Any) -> Json:
        """The events at some places. Raises Unable."""
        match document:
            case {"places": [*places]} if len(places) <= _SHOWN and all(map(self._has, places)):
                return {"events": [self._entries[place - 1].document for place in places]}
            case _:
                raise server.Unable(f"the log has events 1 to {len(self._entries)}")

    @property
    def documents(self) -> list[Json]:
        """All events."""
        return [entry.document for entry in self._entries]

    def states(self) -> Iterator[Json | None]:
        """The state after each event; None where none is known yet."""
        moment = _Moment(Follower(self._supervisor))
        for entry in self._entries:
            moment.take(entry)
            yield self._state(moment, entry)

    def _has(self, place: Any) -> bool:
        return isinstance(place, int) and 1 <= place <= len(self._entries)

    @cached_property
    def _texts(self) -> list[str]:
        """What is searched, by event."""
        return [_text(entry) for entry in self._entries]

    def moment(self, document: Any) -> Json:
        """The state after the first ``at`` events, and the last of these. Raises Unable."""
        match document:
            case {"at": int(at)} if self._has(at):
                pass
            case _:
                raise server.Unable(f"the log has events 1 to {len(self._entries)}")
        moment = self._moments[(at - 1) // _STRIDE].fork()
        for entry in self._entries[(at - 1) // _STRIDE * _STRIDE : at]:
            moment.take(entry)
        shown = self._entries[max(0, at - _SHOWN) : at]
        return {
            "state": self._state(moment, shown[-1]),
            "events": [entry.document for entry in shown],
        }

    def _state(self, moment: _Moment, last: LogEntry) -> Json | None:
        controller = moment.shown
        if controller is None:
            return None
        names = {c.key: c.name for c in controller.COMMUNICATIONS}
        snapshot = {
            "controller": controller,
            "lacks": {},
            "counts": {
                (c.key, c.kind): moment.tally.counts[names[c.key], c.kind]
                for c in controller.COMMANDS
            },
            "begun": None,  # a log may be the last part of what a node wrote
            "number": last.number,
            "clocks": {},  # a log does not say when they are due
            "stopped": moment.stopped,
            "counters": moment.tally.counters,
        }
        try:
            document = telemetry.state_document(snapshot, [], whole=False)
        except UnknownValue:  # the log does not say what is enabled
            return None
        state: Json = values.jsonable({**document, "time": _time(last)})
        return state


def _entries(supervisor: Supervisor, log: str) -> Iterator[LogEntry]:
    """The events of a log; those that a monitor makes of a bag."""
    if not bag_files.is_bag(log):
        yield from read_log(log)
        return
    settings = bag_run.settings_of(supervisor.plant.robot)
    with bag_files.opened_bag(Path(log)) as bag:
        run = bag_run.BagRun(supervisor, bag, settings, described=True)
        for line, entry in enumerate(run.entries(lambda *_: None), 1):
            yield entry_of(log, line, json.loads(telemetry.dump(telemetry.event_document(entry))))


def _time(entry: LogEntry) -> float:
    time = entry.document.get("time")
    return float(time) if isinstance(time, (int, float)) else 0.0


def _sort(entry: LogEntry, robot: entities.Robot) -> str:
    """``x`` for what did not go well, ``t`` for an internal transition, ``c`` for the controller,
    ``r`` for the robot."""
    if entry.outcome not in ("applied", "withheld"):
        return "x"
    if entry.kind == EventKind.TAU.word:
        return "t"
    return "c" if robot.decides(entry.kind, entry.name) else "r"


def _text(entry: LogEntry) -> str:
    """An event as the page writes it, in small letters."""
    detail = entry.document.get("detail") or ""
    return f"{entry.text} {_words(entry.value)} {entry.outcome} {detail}".lower()


def _words(value: Any) -> str:
    match value:
        case None:
            return ""
        case dict():
            return "{" + ", ".join(f"{key}: {_words(part)}" for key, part in value.items()) + "}"
        case list():
            return f"[{', '.join(map(_words, value))}]"
        case bool():
            return "true" if value else "false"
        case float():
            return f"{value:.6g}" if abs(value) < 1e5 else f"{value:.1f}"
    return str(value)
