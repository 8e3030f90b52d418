"""What a session looks like to people."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from robosc import dotted, errors
from robosc.expr.types import Value
from robosc.language.events import ACTIVE
from robosc.lazy_dataclasses import dataclass
from robosc.runtime.core.places import places, stage_of
from robosc.simulate.machines.machine import CommandState, Happening, Machine, label
from robosc.simulate.script.session import Session
from robosc.simulate.values.literals import literal_text

_MOST_SHOWN = 60
_PAINT = re.compile("\x1b\\[[0-9;]*m")
_COLUMNS = re.compile(r" *(?:\S+ {2,})*")
"""What stands before the last column of a line."""


@dataclass(frozen=True)
class Style:
    """Paints, or not: bold, dim, and the colours of lamps."""

    color: bool = False

    def __call__(self, code: str, text: str) -> str:
        return f"\x1b[{code}m{text}\x1b[0m" if self.color and text else text


BOLD, DIM, GREEN, RED, CYAN = "1", "2", "32", "31", "36"


def session_text(session: Session, style: Style) -> str:
    """The state, what can happen, and what cannot and why."""
    return "\n".join(_session_lines(session, style)) + "\n"


def _session_lines(session: Session, style: Style) -> Iterator[str]:
    machine = session.machine
    facts = [] if machine.time is None else [f"t = {machine.time:.3f} s"]
    facts += ["marked"] if machine.state.marked(machine.plant.robot) else []
    facts += [style(RED, f"safe stop: {machine.stopped}")] if machine.stopped else []
    yield ", ".join([style(BOLD, machine.plant.robot.name), *facts])
    yield from _state_lines(machine, style)
    menu = session.menu()
    width = len(str(len(menu)))
    data = {id(c.event): c.data for c in machine.commands()}
    asked = "enabled commands" if machine.time is None else "the guarded controller may ask for"
    for title, controllable in (("uncontrollable events", False), (asked, True)):
        entries = [(n, c) for n, c in enumerate(menu, 1) if c.event.controllable is controllable]
        if not entries and (controllable or not menu):
            continue
        yield style(BOLD, title)
        for number, choice in entries:
            hint = f" {style(DIM, f'[{choice.hint}]')}" if choice.hint else ""
            sent = _shown_data(data.get(id(choice.event)))
            yield f"  {style(CYAN, f'{number:{width}}')}  {choice.text}{hint}{sent}"
    yield from _command_lines(machine, style)


_LONGEST = 60
"""Characters of an object or an array in a line that shows the state."""


def _short(value: Value | None) -> str:
    text = "nothing" if value is None else literal_text(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _state_lines(machine: Machine, style: Style) -> Iterator[str]:
    state = machine.state
    robot = machine.plant.robot
    width = max((len(name) for name in state.components), default=0)
    shown = places(state.components)
    place = max((len(name) for name in shown.values()), default=0)
    for component, name in shown.items():
        stage = stage_of(state.components[component])
        variables = [stage] if stage else []
        variables += [
            f"{dotted.inside(key)} = {_short(value)}"
            for key, value in state.variables.items()
            if key.startswith(f"{component}.")
        ]
        line = f"  {component:{width}}  {style(GREEN, name)}{' ' * (place - len(name))}"
        yield f"{line}  {', '.join(variables)}".rstrip()
    phases = [
        f"{robot.display_names[key]} {style(GREEN, phase) if phase in ACTIVE else phase}"
        for key, phase in state.phases.items()
    ]
    if phases:
        yield f"  {', '.join(phases)}"


def _command_lines(machine: Machine, style: Style) -> Iterator[str]:
    commands = machine.commands()
    executing = machine.time is not None
    enabled = [c for c in commands if c.enabled]
    if executing and enabled:
        guards = machine.plant.robot.supervises
        yield style(BOLD, "enabled commands" if guards else "the controller commands")
        for command in enabled:
            times = "once" if command.count == 1 else f"{command.count} times"
            sent = style(DIM, f"  sent {times}") if command.count else ""
            told = _shown_data(command.data)
            if command.waits_for:
                told = style(DIM, f"  waits for {errors.listing(command.waits_for)}")
            yield f"  {label(command.event)}{told}{sent}"
    disabled = [c for c in commands if not c.enabled]
    if disabled:
        yield style(BOLD, "disabled commands")
        width = max(len(label(c.event)) for c in disabled)
        for command in disabled:
            yield from _reason_lines(command, width, style)


def _reason_lines(command: CommandState, width: int, style: Style) -> Iterator[str]:
    name = label(command.event)
    for reason in command.reasons:
        place = style(DIM, f"  ({reason.place})") if reason.place else ""
        kind = "synthesis: " if reason.kind == "synthesis" else ""
        yield f"  {style(RED, f'{name:{width}}')}  {kind}{reason.text}{place}"
        name = ""


def _shown_data(data: dict[str, Any] | None) -> str:
    return f"  {_value_text(data)}" if data else ""


def _value_text(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {_value_text(v)}" for k, v in value.items()) + "}"
    return literal_text(value)


def happening_text(happening: Happening, style: Style) -> str:
    """``0.100 s  ! move.request {linear: {x: 0.4}}``; ``!`` marks what the controller does."""
    h = happening
    time = "" if h.time is None else style(DIM, f"{h.time:9.3f} s  ")
    sign = "!" if h.controllable else " "
    if h.kind in ("tau", "after"):
        text = f"{h.name}: {h.value}"
    else:
        text = f"{h.name}.{h.kind}" if h.name else h.kind
        if h.value is not None:
            text += f" {_value_text(h.value)}"
    if h.outcome != "applied":
        text += " " + style(RED, h.outcome)
    if h.detail:
        text += f": {h.detail}"
    return f"{time}{sign} {style(GREEN, text) if h.controllable else text}"


def happenings_text(happenings: Sequence[Happening], style: Style) -> str:
    """One line for each, and one for a command that only repeats itself; of very many, the last."""
    lines: list[str] = []
    for _, run in groupby(happenings, lambda h: (h.kind, h.name, h.value, h.outcome, h.detail)):
        same = list(run)
        text = happening_text(same[0], style)
        if len(same) > 2:
            until = "" if same[-1].time is None else f", until {same[-1].time:.3f} s"
            lines.append(text + style(DIM, f"  {len(same)} times{until}"))
        else:
            lines += [happening_text(h, style) for h in same]
    left_out = len(lines) - _MOST_SHOWN
    if left_out > 0:
        lines = [f"… {left_out} lines before these", *lines[-_MOST_SHOWN:]]
    return "".join(f"{line}\n" for line in lines)


def fitted(text: str, width: int) -> str:
    """The text with lines no longer than ``width``, broken between words.

    What goes on in the next line stands below the last column of its own.
    """
    return "".join(f"{part}\n" for line in text.splitlines() for part in _fitted(line, width))


def _fitted(line: str, width: int) -> Iterator[str]:
    plain = _PAINT.sub("", line)
    columns = _COLUMNS.match(plain)
    indent = " " * min(columns.end() if columns else 0, width // 2)
    done, used = "", 0
    for word in re.findall(r" *[^ ]*", line):
        length = len(_PAINT.sub("", word))
        if used + length > width and done.strip():
            yield done
            done, used = indent, len(indent)
            word = word.lstrip(" ")
            length = len(_PAINT.sub("", word))
        done, used = done + word, used + length
    yield done
