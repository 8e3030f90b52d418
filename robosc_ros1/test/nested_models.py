"""Random behaviours with states in states, and the same behaviours unfolded by hand."""

from __future__ import annotations

import random
from collections.abc import Container
from dataclasses import dataclass, field
from itertools import product

PARTS = """
    interface link use Work from some_package
    component P {
        outgoing message near with type: boolean
        action go with request: none, response: boolean, feedback: none links link
        behaviour {
            variable last: boolean
            variable tries: integer(0..2)
            %s
        }
    }
"""
EVENTS = {
    "response from near": ("value", "!value", "last"),
    "response from go": ("value", "last and !value"),
    "error from go": ("last", "tries = 1"),
    "cancel from go": ("last",),
    "request to go": ("last", "tries < 2"),
}
AFTER = ("", "last", "tries < 2")
"""The guards of transitions after a delay."""
EFFECTS = ("last := true", "last := !last", "tries := 1")


@dataclass(frozen=True)
class Reaction:
    """``on EVENT if GUARD do EFFECT goto TARGET``; empty parts are left out."""

    event: str
    guard: str
    effects: tuple[str, ...]
    target: str

    def text(self, target: str) -> str:
        guard = f" if {self.guard}" if self.guard else ""
        effects = f" do {', '.join(self.effects)}" if self.effects else ""
        head = self.event if self.event.startswith("after") else f"on {self.event}"
        return f"{head}{guard}{effects}" + (f" goto {target}" if target else "")


@dataclass
class Place:
    """A state, or the whole automaton; the first state in it is the initial one."""

    path: str
    marked: bool = False
    reactions: list[Reaction] = field(default_factory=list)
    states: list[Place] = field(default_factory=list)

    def all(self) -> list[Place]:
        return [self, *(place for state in self.states for place in state.all())]

    @property
    def first(self) -> Place:
        return self.states[0].first if self.states else self


def random_place(draw: random.Random, path: str, depth: int) -> Place:
    place = Place(path, draw.random() < 0.5)
    if depth < 3 and (not path or draw.random() < 0.6):
        names = "ab" if depth else "pqr"
        prefix = f"{path}." if path else ""
        place.states = [random_place(draw, prefix + name, depth + 1) for name in names]
    return place


def random_behaviour(draw: random.Random) -> Place:
    whole = random_place(draw, "", 0)
    paths = [place.path for place in whole.all() if place.path]
    for place in whole.all():
        for event, guards in EVENTS.items():
            if draw.random() < 0.4:
                guard = draw.choice(("", *guards))
                found = [guard, f"!({guard})"] if guard and draw.random() < 0.4 else [guard]
                for one in found:
                    effects = [e for e in EFFECTS if draw.random() < 0.3]
                    assigned = {effect.split()[0]: effect for effect in effects}
                    target = draw.choice(paths) if draw.random() < 0.5 else ""
                    place.reactions.append(Reaction(event, one, tuple(assigned.values()), target))
        if place is not whole and draw.random() < 0.3:
            event = f"after {draw.randrange(1, 9)} s"
            ends = draw.choice(("", *paths))
            place.reactions.append(Reaction(event, draw.choice(AFTER), ("last := true",), ends))
    return whole


def as_written(target: str, inside: str, paths: Container[str]) -> str:
    """The name of a state where it is the nearest one of that name, else its path."""
    name = target.rpartition(".")[2]
    steps = inside.split(".")
    around = [".".join(steps[:n]) for n in range(len(steps), 0, -1)]
    nearest = next((f"{a}.{name}" for a in around if f"{a}.{name}" in paths), name)
    return name if nearest == target else target


def nested_text(place: Place, paths: Container[str]) -> str:
    lines = [r.text(r.target and as_written(r.target, place.path, paths)) for r in place.reactions]
    for number, state in enumerate(place.states):
        words = ["initial"] * (number == 0) + ["marked"] * state.marked + ["state"]
        name = state.path.rpartition(".")[2]
        lines.append(f"{' '.join(words)} {name} {{ {nested_text(state, paths)} }}")
    return "\n".join(lines)


def flat_text(whole: Place) -> str:
    """The same by hand: one state for each state without states in it, and nothing around them."""
    places = {place.path: place for place in whole.all()}
    lines = []
    for leaf in (place for place in whole.all() if not place.states):
        steps = leaf.path.split(".")
        levels = [places[".".join(steps[:n])] for n in range(len(steps), -1, -1)]
        marked = any(level.marked and level.first is leaf for level in levels[:-1])
        head = ["initial"] * (whole.first is leaf) + ["marked"] * marked + ["state"]
        lines_ = [line for event in EVENTS for line in unfolded(event, levels, places)]
        for reaction in (r for level in levels for r in level.reactions):
            if reaction.event.startswith("after"):
                target = reaction.target and flat(places[reaction.target].first)
                lines_.append(reaction.text(target))
        body = "\n".join(lines_)
        lines.append(f"{' '.join(head)} {flat(leaf)} {{ {body} }}")
    return "\n".join(lines)


def flat(place: Place) -> str:
    return place.path.replace(".", "_")


def unfolded(event: str, levels: list[Place], places: dict[str, Place]) -> list[str]:
    """What a state does on an event: each combination of what its levels do, with its condition."""
    own = [[r for r in level.reactions if r.event == event] for level in levels]
    own = [reactions for reactions in own if reactions]
    if event.startswith("request"):
        return [r.text(flat(places[r.target].first) if r.target else "") for r in (*own[:1], [])[0]]
    found = []
    for chosen in product(*([*reactions, None] for reactions in own)):
        guards: list[str] = []
        taken: list[Reaction] = []
        if any(c is None and not all(r.guard for r in o) for o, c in zip(own, chosen, strict=True)):
            continue  # one without a guard is taken in any case
        for reactions, one in zip(own, chosen, strict=True):
            if one is None:
                guards += [f"!({other.guard})" for other in reactions]
            else:
                guards += [f"({one.guard})"] if one.guard else []
                taken += [one] if not taken or not one.target else []
        effects = {e.split()[0]: e for one in reversed(taken) for e in one.effects}
        target = next((one.target for one in taken if one.target), "")
        if taken:
            joined = Reaction(event, " and ".join(guards), tuple(effects.values()), target)
            found.append(joined.text(flat(places[target].first) if target else ""))
    return found
