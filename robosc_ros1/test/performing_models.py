"""Random behaviours with states that perform commands, and the same behaviours unfolded by hand."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from itertools import product

PARTS = """
    interface link use Work from some_package
    component P {
        outgoing message near with type: boolean
        action go with request: none, response: boolean, feedback: none links link
        action far with request: none, response: boolean, feedback: none links link
        service ask with request: none, response: boolean links link
        outgoing service task with request: none, response: none links link
        incoming message say with type: none
        behaviour {
            variable last: boolean
            variable tries: integer(0..2)
            %s
        }
    }
    component Calls {
        behaviour { initial marked state taking { on request from task } }
    }
"""
_ACTION = ("response", "error", "cancelled", "cancel")
ENDS = {"go": _ACTION, "far": _ACTION, "ask": ("response", "error")}
ACTIONS = ("go", "far")
ANSWERS = {"task": "response to task", "task.error": "error to task"}


@dataclass(frozen=True)
class Reaction:
    """``on EVENT if GUARD do EFFECTS goto TARGET``; empty parts are left out."""

    event: str
    guard: str = ""
    effects: tuple[str, ...] = ()
    target: str = ""

    def text(self) -> str:
        head = self.event if self.event.startswith("after") else f"on {self.event}"
        guard = f" if {self.guard}" if self.guard else ""
        effects = f" do {', '.join(self.effects)}" if self.effects else ""
        return head + guard + effects + (f" goto {self.target}" if self.target else "")


@dataclass
class Performer:
    """A state: ``performs`` a command if that has a name, else only what is in its braces."""

    path: str
    marked: bool = False
    performs: str = ""
    meanwhile: bool = False
    then: Reaction = Reaction("")
    retry: bool = False
    times: int = 0
    every: int = 0
    via: str = ""
    finally_: Reaction = Reaction("")
    reactions: list[Reaction] = field(default_factory=list)
    inner: list[Performer] = field(default_factory=list)

    @property
    def count(self) -> str:
        return f"{self.path.replace('.', '_')}_retries"

    @property
    def name(self) -> str:
        return self.path.rpartition(".")[2]

    @property
    def sends(self) -> str:
        return ANSWERS.get(self.performs, f"request to {self.performs}")

    @property
    def is_awaited(self) -> bool:
        """Whether what it performs is done when it is answered, and not when it is sent."""
        return self.performs in ENDS

    def is_own(self, reaction: Reaction) -> bool:
        """Whether a reaction in its braces is to what it performs."""
        if self.performs in ANSWERS:
            return reaction.event == self.sends
        return bool(self.performs) and reaction.event.endswith(f" {self.performs}")

    @property
    def stages(self) -> list[str]:
        if not self.performs:
            return [self.path]
        stages = ["due"] + ["performing"] * self.is_awaited + ["waiting"] * bool(self.every)
        return [f"{self.path} {stage}" for stage in stages]


def random_machine(draw: random.Random) -> list[Performer]:
    """States of a behaviour; two of them may have states in them."""
    whole: list[Performer] = []
    for name in "pqr":
        outer = Performer(name, draw.random() < 0.6)
        if draw.random() < 0.4:
            outer.inner = [Performer(f"{name}.{inner}", draw.random() < 0.3) for inner in "ab"]
        whole.append(outer)
    every = [state for outer in whole for state in (outer, *outer.inner)]
    paths = [state.path for state in every]
    for state in every:
        state.reactions = [
            Reaction("response from near", "value", ("last := value",), draw.choice(paths)),
            Reaction("response from near", "!value", ("tries := 1",)),
        ][: draw.randrange(3)]
        if draw.random() < 0.3:
            target = draw.choice(("", *paths))
            state.reactions.append(Reaction("after 9 s", "last", ("last := false",), target))
        if not state.inner and draw.random() < 0.8:
            _perform(draw, state, paths)
        if state.performs not in ANSWERS and draw.random() < 0.2:
            event, target = draw.choice(list(ANSWERS.values())), draw.choice(("", *paths))
            state.reactions.append(Reaction(event, "last", ("tries := 1",), target))
    return whole


def _perform(draw: random.Random, state: Performer, paths: list[str]) -> None:
    def target() -> str:
        return draw.choice(("", *paths))

    state.performs = draw.choice(
        ("go", "go", "far", "far", "ask", "ask", "say", "task", "task.error")
    )
    state.meanwhile = draw.random() < 0.2
    done = (("last := value",), ()) if state.is_awaited else ()
    state.then = Reaction("", effects=draw.choice(((), *done)), target=target())
    for end in ENDS.get(state.performs, ()):
        if draw.random() < 0.4:
            event = f"{end} from {state.performs}"
            guard = draw.choice(("", "last", "tries = 1"))
            state.reactions.append(Reaction(event, guard, ("tries := 2",), target()))
    if draw.random() < 0.3:
        state.reactions.append(Reaction(state.sends, "last", ("tries := 0",)))
    if state.is_awaited and draw.random() < 0.7:
        state.retry = True
        state.every = draw.choice((0, 5))
        state.via = draw.choice(("", "", *(p for p in paths if p != state.path)))
        state.times = draw.randrange(3)
        if state.times:
            state.finally_ = Reaction("", effects=("last := true",), target=target())


def performing_text(states: list[Performer]) -> str:
    lines = []
    for number, state in enumerate(states):
        words = ["initial"] * (number == 0) + ["marked"] * state.marked + ["state", state.name]
        if state.performs:
            words += ["performs", state.performs, *["meanwhile"] * state.meanwhile]
            words += ["then", _clauses(state.then)]
        inside = [reaction.text() for reaction in state.reactions]
        if state.retry:
            times = f" {state.times} times" if state.times else ""
            every = f" every {state.every} s" if state.every else ""
            via = f" goto {state.via}" if state.via else ""
            end = f" else {_clauses(state.finally_)}" if state.times else ""
            inside.append(f"retry{times}{every}{via}{end}")
        body = "\n".join((*inside, performing_text(state.inner) if state.inner else ""))
        lines.append(f"{' '.join(words)} {{\n{body}\n}}")
    return "\n".join(lines)


def _clauses(reaction: Reaction) -> str:
    return reaction.text().removeprefix("on ")


# --- unfolded by hand -----------------------------------------------------------------------------


def flat(path: str) -> str:
    return path.replace(".", "_").replace(" ", "_")


class Unfolded:
    """The same behaviour as one state for each stage, with nothing around it."""

    def __init__(self, states: list[Performer]) -> None:
        self.top = states
        self.states = {s.path: s for outer in states for s in (outer, *outer.inner)}
        self.stages = [stage for s in self.states.values() if not s.inner for stage in s.stages]
        self.counted = [s for s in self.states.values() if s.times]

    def first(self, path: str) -> str:
        state = self.states[path]
        return self.first(state.inner[0].path) if state.inner else state.stages[0]

    def requirements(self) -> list[str]:
        """That a goal is cancelled where no state performs it, and that actions wait for others."""
        found = []
        performed = {s.performs for s in self.states.values()}
        for action in (a for a in ACTIONS if a in performed):
            here = [flat(s.path) for s in self.states.values() if s.performs == action]
            keeps = (f"P.{p}_performing or P.{p}_due and {action}.idle" for p in here)
            found.append(f"requirement {action} needs {' or '.join(keeps)}")
            for other in ENDS:
                waits = [
                    f"P.{flat(s.path)}_due"
                    for s in self.states.values()
                    if s.performs == other != action and not s.meanwhile
                ]
                if waits:
                    where = f"({' or '.join(waits)}) and !{action}.idle"
                    found.append(f"requirement {where} disables {other} to start")
        return found

    def text(self) -> str:
        lines = [f"variable {s.count}: integer(0..{s.times})" for s in self.counted]
        for stage in self.stages:
            owner = stage.partition(" ")[0]
            around = [owner[:1]] if "." in owner else []
            lines += self._state(stage, self.states[owner], [self.states[p] for p in around])
        return "\n".join(lines)

    def _state(self, stage: str, state: Performer, around: list[Performer]) -> list[str]:
        marked = state.marked or any(o.marked and o.inner[0] is state for o in around)
        begins = stage == self.first(self.top[0].path)
        marked = marked and not stage.endswith("performing")
        head = ["initial"] * begins + ["marked"] * marked + ["state", flat(stage)]
        mine = [r for r in state.reactions if state.is_own(r)]
        rest = [r for r in state.reactions if r not in mine]
        levels = [self._performed(stage, state, mine), rest, *(o.reactions for o in around)]
        body = [self._line(stage, r) for level in levels for r in level if "after" in r.event]
        events = dict.fromkeys(r.event for level in levels for r in level)
        for event in (e for e in events if "after" not in e):
            body += self._combined(stage, event, levels)
        return [f"{' '.join(head)} {{", *body, "}"]

    def _performed(self, stage: str, state: Performer, mine: list[Reaction]) -> list[Reaction]:
        if not state.performs:
            return []
        command, path = state.performs, state.path
        then = Reaction("", "", state.then.effects, state.then.target or path)
        if stage.endswith("waiting"):
            return [Reaction(f"after {state.every} s", "", (), state.via or f"{path} due")]
        if stage.endswith("due"):
            goal = Reaction("", "", (), f"{path} performing")
            return self._mixed(state.sends, mine, [goal if state.is_awaited else then])
        found = self._mixed(f"response from {command}", mine, [then])
        if state.times:
            zero = (f"{state.count} := 0",)
            found = [Reaction(r.event, r.guard, (*r.effects, *zero), r.target) for r in found]
        again = state.via or f"{path} due"
        errors = [Reaction("", "", (), again if state.retry else f"{path} due")]
        if state.retry and state.every:
            errors = [Reaction("", "", (), f"{path} waiting")]
        if state.times:
            last = state.finally_
            up = (f"{state.count} := {state.count} + 1",)
            end = (*last.effects, f"{state.count} := 0")
            errors = [
                Reaction("", f"{state.count} < {state.times}", up, errors[0].target),
                Reaction("", f"{state.count} >= {state.times}", end, last.target or path),
            ]
        if command in ACTIONS:
            errors = [
                Reaction(
                    "",
                    " and ".join(filter(None, (f"!{command}.cancelling", e.guard))),
                    e.effects,
                    e.target,
                )
                for e in errors
            ]
            errors.append(Reaction("", f"{command}.cancelling", (), f"{path} due"))
            found += self._mixed(
                f"cancelled from {command}", mine, [Reaction("", "", (), f"{path} due")]
            )
            found += self._mixed(f"cancel from {command}", mine, [])
        return found + self._mixed(f"error from {command}", mine, errors)

    @staticmethod
    def _mixed(event: str, mine: list[Reaction], performed: list[Reaction]) -> list[Reaction]:
        """What stands in the braces, and what is done without: one after the other, as guards."""
        own = [r for r in mine if r.event == event]
        found = []
        for r in own:
            if r.target or not performed:
                found.append(r)
                continue
            for p in performed:
                guard = " and ".join(filter(None, (r.guard, p.guard)))
                assigned = {e.split()[0] for e in r.effects}
                more = tuple(e for e in p.effects if e.split()[0] not in assigned)
                found.append(Reaction(event, guard, (*r.effects, *more), p.target))
        if all(r.guard for r in own):
            none = [f"!({r.guard})" for r in own]
            for p in performed:
                guard = " and ".join((*none, *filter(None, (p.guard,))))
                found.append(Reaction(event, guard, p.effects, p.target))
        return found

    def _combined(self, stage: str, event: str, levels: list[list[Reaction]]) -> list[str]:
        own = [[r for r in level if r.event == event] for level in levels]
        own = [reactions for reactions in own if reactions]
        if event.startswith("request") or event in ANSWERS.values():
            return [self._line(stage, r) for r in own[0]]
        found = []
        for chosen in product(*([*reactions, None] for reactions in own)):
            guards: list[str] = []
            effects: dict[str, str] = {}
            target = ""
            taken = False
            for reactions, one in zip(own, chosen, strict=True):
                candidates = [r for r in reactions if not (taken and r.target)]
                if one is None:
                    if any(not r.guard for r in candidates):
                        break
                    guards += [f"!({r.guard})" for r in candidates]
                    continue
                if one not in candidates:
                    break
                guards += [one.guard] if one.guard else []
                for effect in one.effects:
                    effects.setdefault(effect.split()[0], effect)
                target = target or one.target
                taken = True
            else:
                if taken:
                    guard = " and ".join(f"({g})" for g in guards)
                    both = Reaction(event, guard, tuple(effects.values()), target)
                    found.append(self._line(stage, both))
        return found

    def _line(self, stage: str, reaction: Reaction) -> str:
        target = reaction.target
        leaf = target if target in self.stages else self.first(target) if target else ""
        effects = list(reaction.effects)
        for state in self.counted:
            if leaf and self._restarts(state, stage, target, leaf):
                effects = [e for e in effects if e.split()[0] != state.count]
                effects.append(f"{state.count} := 0")
        return Reaction(
            reaction.event, reaction.guard, tuple(dict.fromkeys(effects)), flat(leaf)
        ).text()

    def _restarts(self, state: Performer, stage: str, target: str, leaf: str) -> bool:
        """Whether the count of a state begins anew, as the text of the language says."""
        around = state.path[:1] if "." in state.path else ""
        if around:
            return stage[:1] != around and leaf[:1] == around
        scope = [path for path in (state.path, state.via) if path]
        if not any(leaf == path or leaf.startswith((f"{path}.", f"{path} ")) for path in scope):
            return True
        return stage.startswith(f"{state.path} ") and target == state.path
