"""The lines that people and scripts write, and what becomes of them."""

from __future__ import annotations

import io
import random
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from decimal import Decimal
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from robosc import errors, limits
from robosc.emit.write.whole_file import write_whole
from robosc.expr.types import ArrayType, EnumType, ObjectType, StringType
from robosc.lazy_dataclasses import dataclass
from robosc.model.automata import RESTING
from robosc.plant import automaton, step
from robosc.runtime.core.places import places
from robosc.simulate.faults import InvalidLine, LineFault, Refused
from robosc.simulate.machines import machine
from robosc.simulate.machines.machine import Machine, label
from robosc.simulate.script import expectations
from robosc.simulate.script.expectations import condition
from robosc.simulate.values.event_data import Given, by_path, complete, completed
from robosc.simulate.values.literals import Raw, literal_text, parse_raw
from robosc.syntax.parser import read_bytes
from robosc.synthesis.formatting import event_text, part_text

# Reads an event as traces and explanations write it: ``battery.response(charge > 0.2)``.


def fired_by(machine: Machine, text: str) -> tuple[automaton.Event, Given] | None:
    """What a step of a trace lets happen; None if this is none, or time passes (``--execute``).

    A class gives the number or string that represents it, a test the outcome that is written.
    """
    if machine.time is not None:
        return None
    name, _, path = text.partition(": ")
    for choice in machine.choices():
        event, typed = choice.event, f"{label(choice.event)} ({path})"
        if not event.kind.of_component or event.name != name or choice.given is None:
            continue
        if text == event_text(event) or choice.text == typed:
            return event, choice.given
    found = step_written(machine.plant, text)
    if found is None and any(event_text(e) == text for e in machine.plant.events):
        raise Refused(f"{text} cannot happen now")
    if found is None:
        return None
    event, values = found
    return event, completed(machine.plant.robot, event, by_path(event, values), label(event))


def step_written(plant: automaton.Plant, text: str) -> tuple[automaton.Event, step.Values] | None:
    """The event with the values that read so in a trace; None if there is none."""
    for event in plant.events:
        head = f"{event_text(event)}("
        if event.parameters and text.startswith(head) and text.endswith(")"):
            for values in _values(event.parameters, text[len(head) : -1]):
                if step.is_consistent(values, step.missing_together(event)):
                    return event, values
    return None


def _values(parameters: Sequence[automaton.EventParameter], text: str) -> Iterator[step.Values]:
    """All readings of a text as values of parameters, in order, with commas between."""
    first, *rest = parameters
    for value in first.values:
        part = part_text(first, value)
        if not rest:
            if text == part:
                yield (value,)
        elif text.startswith(f"{part}, "):
            yield from ((value, *others) for others in _values(rest, text[len(part) + 2 :]))


MakeMachine = Callable[[Mapping[str, Any], Mapping[str, Any]], machine.Machine]
"""A machine in its initial state, with these parameters and values of persistent variables, by
name."""

WORDS: Mapping[str, tuple[str, str]] = {
    "show": ("show", "the state, what can happen, and what forbids commands"),
    "why": (
        "why COMMAND",
        "what holds a command back now, its guard, and all that is known about it",
    ),
    "wait": ("wait SECONDS", "advance the clock (with --execute)"),
    "every": ("every SECONDS EVENT", "send it now and again and again, until: stop EVENT"),
    "goto": ("goto CONDITION", "take a shortest path to a state: goto Motor.moving"),
    "random": ("random N [SEED]", "take N random steps; the same seed gives the same ones"),
    "undo": ("undo [N]", "undo the last N steps"),
    "restart": ("restart", "begin again"),
    "start": ("start NAME: VALUE", "restart with a value of a persistent variable: start next: 3"),
    "set": ("set NAME VALUE", "restart with a parameter, as in: set limit 0.5"),
    "expect": ("expect …", "CONDITION, enabled EVENT, disabled EVENT, sent …, data …, marked …"),
    "save": ("save FILE", "write all steps so far as a script"),
    "play": ("play FILE", "run the lines of a script"),
    "help": ("help", "this"),
    "quit": ("quit", "leave"),
}
"""Word to how it is used and what it does."""

_DIGITS = 9
"""Of seconds: sums of periods are times that people write."""
_USAGE = max(len(usage) for usage, _ in WORDS.values())
_HELP = "\n".join(
    [
        "An event by its number or name, with a value where it carries one; the beginning of a",
        "name does: distance 0.4, grab.error, pose x: 1.5, y: 2",
        "",
        *(f"  {usage:{_USAGE}}  {meaning}" for usage, meaning in WORDS.values()),
    ]
)


@dataclass
class _Repeated:
    """An event that happens every ``period`` seconds, next in ``due``."""

    event: automaton.Event
    given: Given
    period: float
    due: float


@dataclass(frozen=True)
class Done:
    """What a line did: what happened, in order, and what there is to say or to show."""

    happenings: tuple[machine.Happening, ...] = ()
    text: str = ""
    changed: bool = False
    show: bool = False
    quit: bool = False


class Session:
    """Does lines. A line that raises :class:`LineFault` has changed nothing, unless it is ``play``,
    ``random`` or ``goto``, which stay where they came to."""

    def __init__(self, make: MakeMachine, parameters: Mapping[str, Any] | None = None) -> None:
        self._make = make
        self._parameters = dict(parameters or {})
        self._starts: dict[str, Any] = {}
        self.machine = make(self._parameters, self._starts)
        self.history: list[str] = []
        """What was done, as lines that do it again; one for each step of the machine."""
        self.latest: tuple[machine.Happening, ...] = tuple(self.machine.beginning)
        """What happened in the last line that did anything."""
        self._playing = 0
        self._repeated: dict[str, _Repeated] = {}
        """By name, what happens again and again while time goes on."""

    def do(self, line: str, *, numbers: bool = True) -> Done:
        """Do one line; numbers stand for what is shown, if they may.

        Raises:
            LineFault: it was not done.
        """
        text = _without_comment(line)
        word, _, rest = text.partition(" ")
        if not text:
            return Done()
        if word == "stop" and self._repeated.pop(rest.strip(), None) is not None:
            return Done()  # also where 'stop' is a command
        if word in WORDS and (word != "start" or self.machine.plant.robot.persistent):
            # Without persistent variables, 'start' may be a communication.
            if rest.strip() and WORDS[word][0] == word:
                raise InvalidLine(f"'{word}' takes no arguments")
            action: Callable[[str], Done] = getattr(self, f"_{word}")
            return action(rest.strip())
        if word.isdecimal():
            if not numbers:
                raise InvalidLine("a number means something else in each state: write the event")
            return self._by_number(word, rest)
        try:
            return self._by_name(text)
        except InvalidLine:
            step = fired_by(self.machine, text)
            if step is None:
                raise
        return self._did(self._fire(*step))

    def fire(self, event: automaton.Event, raw: Raw) -> Done:
        """Let an event happen with a value as it is written or came as JSON."""
        given = complete(self.machine.plant.robot, event, raw, machine.label(event))
        return self._did(self._fire(event, given))

    def menu(self) -> list[machine.Choice]:
        """What can be fired by number, from 1: what the robot does before what is commanded."""
        return sorted(self.machine.choices(), key=lambda choice: choice.event.controllable)

    def event(self, text: str) -> automaton.Event:
        """The one event that a name means now. Raises LineFault."""
        found = machine.find_events(self.machine, text)
        if len(found) > 1:
            able = [e for e in found if self.machine.can(e, None)]
            if not able:
                raise Refused(
                    f"{errors.listing([machine.label(e) for e in found], 'or')} cannot happen now"
                )
            found = machine.without_timeouts(able)
        if len(found) > 1:
            raise InvalidLine(
                f"'{text}' can mean {errors.listing([machine.label(e) for e in found], 'or')}"
            )
        return found[0]

    # --- events ----------------------------------------------------------------------------------

    def _by_number(self, word: str, rest: str) -> Done:
        menu = self.menu()
        number = int(word) if len(word) < 9 else 0
        if not 1 <= number <= len(menu):
            raise InvalidLine(f"there is no number {word}; there are 1 to {len(menu)}")
        choice = menu[number - 1]
        if choice.given is None or rest.strip():
            return self.fire(choice.event, parse_raw(rest))
        return self._did(self._fire(choice.event, choice.given))

    def _by_name(self, text: str) -> Done:
        written = machine.event_and_value(text)
        if written is None:
            raise InvalidLine(f"cannot read '{text}' (help shows what can be written)")
        name, value = written
        try:
            event = self.event(name)
        except InvalidLine as fault:
            near = get_close_matches(name, WORDS, 1, 0.7)
            if near and "did you mean" not in str(fault) and "can mean" not in str(fault):
                raise InvalidLine(f"there is no '{name}'; did you mean '{near[0]}'?") from None
            raise
        return self.fire(event, parse_raw(value))

    def _fire(self, event: automaton.Event, given: Given) -> list[machine.Happening]:
        happenings = self.machine.fire(event, given)
        self.history.append(machine.typed_text(event, given))
        return happenings

    def _wait_for(self, seconds: float) -> list[machine.Happening]:
        happenings: list[machine.Happening] = []
        left, repeated = seconds, self._repeated
        while repeated and (due := min(one.due for one in repeated.values())) <= left:
            happenings += self._pass(due)
            left = round(left - due, _DIGITS)
            for one in repeated.values():
                if one.due == due:
                    happenings += self._fire(one.event, one.given)
                one.due = one.period if one.due == due else round(one.due - due, _DIGITS)
        if left or not happenings:
            happenings += self._pass(left)
        for one in repeated.values():
            one.due = round(one.due - left, _DIGITS)
        return happenings

    def _pass(self, seconds: float) -> list[machine.Happening]:
        happenings = self.machine.wait(seconds)
        self.history.append(f"wait {Decimal(repr(seconds)):f}")  # never 1e-05
        return happenings

    def _did(self, happenings: Iterable[machine.Happening], text: str = "") -> Done:
        self.latest = tuple(happenings)
        return Done(self.latest, text, changed=True)

    # --- the words -------------------------------------------------------------------------------

    def _show(self, rest: str) -> Done:
        return Done(show=True)

    def _help(self, rest: str) -> Done:
        return Done(text=_HELP)

    def _quit(self, rest: str) -> Done:
        return Done(quit=True)

    def _wait(self, rest: str) -> Done:
        return self._did(self._wait_for(_number(rest.removesuffix("s").strip(), "wait 0.5")))

    def _every(self, rest: str) -> Done:
        match = re.fullmatch(r"(\S+)(?:\s+s)?\s+(\S.*)", rest)
        example = "every 0.5 battery percentage: 0.9"
        if match is None:
            raise InvalidLine(f"write how often and what: {example}")
        period = _number(match[1].removesuffix("s"), example)
        if not period:
            raise InvalidLine("what happens all the time leaves no time: write more than 0 s")
        written = machine.event_and_value(match[2])
        if written is None:
            raise InvalidLine(f"cannot read '{match[2]}': {example}")
        name, value = written
        event = self.event(name)
        given = complete(self.machine.plant.robot, event, parse_raw(value), machine.label(event))
        if self.machine.time is None:
            raise InvalidLine("time does not matter for single events: every needs --execute")
        happenings = self._fire(event, given)
        self._repeated[name] = _Repeated(event, given, period, period)
        return self._did(happenings)

    def _goto(self, rest: str) -> Done:
        wanted = condition(rest, self.machine.plant.robot)
        path = self.machine.path(wanted)
        if path is None:
            raise Refused(f"no path leads from here to where {rest} holds")
        happenings: list[machine.Happening] = []
        for event, given in path:
            happenings += self._fire(event, given)
        return self._did(happenings, "" if path else "it holds already")

    def _random(self, rest: str) -> Done:
        match = re.fullmatch(r"(\d{1,9})(?:[ ,]+(?:seed *)?(\d{1,9}))?", rest)
        if match is None:
            raise InvalidLine("write how many steps, and the seed if you like: random 20 7")
        count, seed = int(match[1]), int(match[2] or 0)
        if count > limits.STEPS_IN_ONE_GO:
            raise InvalidLine(f"at most {limits.STEPS_IN_ONE_GO} steps in one go")
        rng = random.Random(seed)
        happenings: list[machine.Happening] = []
        for taken in range(count):
            step = self.machine.draw(rng)
            if step is None:
                return self._did(
                    happenings, f"after {errors.counted(taken, 'step')} nothing can happen any more"
                )
            happenings += self._wait_for(step) if isinstance(step, float) else self._fire(*step)
        return self._did(happenings, f"seed {seed}")

    def _undo(self, rest: str) -> Done:
        if rest and not re.fullmatch(r"\d{1,9}", rest):
            raise InvalidLine("write how many steps to undo: undo 3")
        count = int(rest or 1)
        if count > len(self.history):
            steps = len(self.history)
            many = "is 1 step" if steps == 1 else f"are {steps or 'no'} steps"
            raise Refused(f"there {many} to undo")
        self.machine.undo(count)
        del self.history[len(self.history) - count :]
        self.latest = ()
        return Done(changed=count > 0)

    def _restart(self, rest: str) -> Done:
        self.machine.restart()
        self.history.clear()
        self._repeated.clear()
        return self._did(self.machine.beginning)

    def _set(self, rest: str) -> Done:
        name = re.split(r"[\s=]", rest, maxsplit=1)[0]
        value = parse_raw(rest.removeprefix(name).lstrip().removeprefix("="))
        if not name or value is None or isinstance(value, dict):
            raise InvalidLine("write a parameter and its value: set rate 5")
        self._begin_with({**self._parameters, name: value}, self._starts)
        return self._did(self.machine.beginning, f"{name} is {literal_text(value)}; restarted")

    def _start(self, rest: str) -> Done:
        values = parse_raw(rest)
        if not isinstance(values, dict):
            raise InvalidLine("write persistent variables and their values: start next: 3")
        self._begin_with(self._parameters, {**self._starts, **values})
        return self._did(self.machine.beginning)

    def _begin_with(self, parameters: dict[str, Any], starts: dict[str, Any]) -> None:
        self.machine = self._make(parameters, starts)
        self._parameters, self._starts = parameters, starts
        self.history.clear()
        self._repeated.clear()

    def _expect(self, rest: str) -> Done:
        expectations.expect(rest, self.machine, self.latest)
        return Done()

    def _why(self, rest: str) -> Done:
        commands = self.machine.commands()
        found = [c for c in commands if machine.is_name(c.event, rest)]
        if not found:
            names = [machine.label(c.event) for c in commands]
            near = get_close_matches(rest, names, 1)
            hint = f"did you mean '{near[0]}'?" if near else f"there are {errors.listing(names)}"
            raise InvalidLine(f"there is no command '{rest}'; {hint}")
        return Done(text=self.about(found))

    def about(self, commands: Sequence[machine.CommandState]) -> str:
        """Text about commands: why each is enabled or not, its guard, and its requirements."""
        one = len(commands) == 1
        return "\n".join(self._about(command, one) for command in commands)

    def _about(self, command: machine.CommandState, one: bool) -> str:
        """Text about a command; ``one``: it stands for all its data, which its plant may divide."""
        event = command.event
        supervisor = self.machine.supervisor
        robot = supervisor.plant.robot
        waits_for = errors.listing(command.waits_for)
        enabled = f"enabled, but {waits_for} is preferred and sent" if waits_for else "enabled"
        title = machine.label(event) if one else event_text(event)
        lines = [title, *(f"  now: {reason}" for reason in command.reasons or [enabled])]
        alike = (event.key, event.kind)
        guards = [
            g for g in supervisor.guards
            if g.event == event or (one and (g.event.key, g.event.kind) == alike)
        ]  # fmt: skip
        for guard in guards:
            *parts, condition = supervisor.part_names.lines(guard.expr)
            lines += [f"  {part}" for part in parts]
            which = f"{event_text(guard.event)} " if len(guards) > 1 else ""
            lines.append(f"  {which}allowed where {condition} ({guard.status})")
        for index in dict.fromkeys(i for e in [event, *(g.event for g in guards)]
                                   for i in e.requirements):  # fmt: skip
            requirement = robot.requirements[index]
            span = requirement.span
            lines.append(f"  {span.source.path}:{span.line}: {requirement.text}")
        for explanation in supervisor.explanations:
            if explanation.event == event:
                lines.append(f"  {explanation.reason}")
                if explanation.remedy:
                    lines.append(f"  remedy: {explanation.remedy}")
        return "\n".join(lines)

    # --- scripts ---------------------------------------------------------------------------------

    def script(self) -> str:
        """All steps so far as a script, which ends in expecting the state that they led to."""
        robot = self.machine.plant.robot
        lines = [f"# {robot.name}"]
        lines += [f"set {name} {literal_text(value)}" for name, value in self._parameters.items()]
        lines += [f"start {name}: {literal_text(value)}" for name, value in self._starts.items()]
        lines += self.history
        state = self.machine.state
        lasting = {one.name for one in robot.lasting}
        for owner, name in places(state.components).items():
            is_resting = "!" if name == RESTING else ""
            known = f"{is_resting}{owner}" if owner in lasting else f"{owner}.{name}"
            lines.append(f"expect {known}")
        for component in robot.components:
            for variable in component.variables:
                if variable.in_state and not isinstance(variable.type, ArrayType | ObjectType):
                    value = state.variables[variable.key]
                    text = isinstance(variable.type, StringType)
                    enum = isinstance(variable.type, EnumType)
                    shown = value if enum else literal_text(value, quoted=text)
                    lines.append(f"expect {variable.written} = {shown}")
        return "\n".join(lines) + "\n"

    def _save(self, rest: str) -> Done:
        if not rest:
            raise InvalidLine("write the file's name: save my_run.sim")
        try:
            write_whole(Path(rest).expanduser(), self.script().encode())
        except (OSError, ValueError, RuntimeError) as error:
            raise InvalidLine(f"cannot write {rest}: {_reason(error)}") from None
        return Done(text=f"{rest} has {errors.counted(len(self.history), 'step')}")

    def _play(self, rest: str) -> Done:
        if not rest:
            raise InvalidLine("write the file's name: play my_run.sim")
        if self._playing >= limits.SCRIPTS_IN_SCRIPTS:
            raise InvalidLine(
                f"scripts play scripts more than {limits.SCRIPTS_IN_SCRIPTS} levels deep"
            )
        happenings: list[machine.Happening] = []
        self._playing += 1
        try:
            for number, line in enumerate(read_lines(rest), 1):
                try:
                    done = self.do(line, numbers=False)
                except LineFault as fault:
                    raise type(fault)(f"{rest}:{number}: {fault}") from None
                happenings += done.happenings
                if done.quit:
                    break
        finally:
            self._playing -= 1
        return Done(tuple(happenings), changed=True)


def read_lines(path: str) -> list[str]:
    """The lines of a script (``-``: standard input). Raises InvalidLine if there is no such
    text."""
    try:
        text = read_bytes(str(Path(path).expanduser()), "script").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidLine(f"{path} is not UTF-8 text") from None
    except (errors.UsageError, RuntimeError) as error:
        raise InvalidLine(str(error)) from None
    # Unlike str.splitlines: strings may hold other separators of lines.
    return [line.rstrip("\r\n") for line in io.StringIO(text, newline="\n")]


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


def _without_comment(line: str) -> str:
    """The line without what follows ``#`` or ``//``, unless that stands in a string."""
    match = re.match(r"""(?:"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|(?!\#|//).)*""", line, re.DOTALL)
    return match.group().strip() if match else ""


def _number(text: str, example: str) -> float:
    if not re.fullmatch(r"\d{1,9}(\.\d{1,18})?", text):
        raise InvalidLine(f"write a number of seconds: {example}")
    return float(text)


def code_of(fault: LineFault) -> int:
    """The exit code of a script that ends so: 2 for a line that means nothing."""
    return 2 if isinstance(fault, InvalidLine) else 1
