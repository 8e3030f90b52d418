"""Pictures for graphviz: each component's automaton, and the controlled state space when small.

Drawn as is usual for automata: an arrow without origin enters the initial state, marked states have
a double line, uncontrollable events are dashed. Labels use the words of the model.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence

from robosc import dotted
from robosc.emit.export.pictured_transitions import as_written, pictured
from robosc.errors import UsageError, counted
from robosc.lazy_dataclasses import dataclass
from robosc.model.automata import Behaviour, Transition
from robosc.model.entities import Component, Robot
from robosc.plant import automaton
from robosc.runtime.core.places import place_of, stage_of
from robosc.synthesis import explore, formatting, listing

_EVERY_STATE = "in every state"


def dot_text(robot: Robot, controlled: explore.Graph | None = None) -> str:
    """One graph with a cluster per automaton, and one for the controlled states if given."""
    lines = [
        f"digraph {_quoted(robot.name)} {{",
        "  rankdir=LR; compound=true; fontname=Helvetica;",
        "  node [shape=box, style=rounded, fontname=Helvetica, fontsize=11];",
        "  edge [fontname=Helvetica, fontsize=9];",
    ]
    for component in robot.components:
        if component.states:
            lines += _cluster(component.name, _automaton(robot, component, component.behaviour))
    if controlled is not None:
        title = f"controlled system: {counted(len(controlled.states), 'state')}"
        lines += _cluster(title, _states(controlled))
    return "\n".join([*lines, "}"]) + "\n"


def svg_text(dot: str) -> str:
    """The picture of a DOT text, laid out by graphviz.

    Raises:
        UsageError: graphviz is not installed, or fails.
    """
    program = shutil.which("dot")
    if program is None:
        raise UsageError("svg needs graphviz (apt install graphviz); --format dot works without it")
    done = subprocess.run([program, "-Tsvg"], input=dot, capture_output=True, text=True)
    if done.returncode != 0:
        raise UsageError(f"graphviz cannot draw this: {done.stderr.strip()}")
    return done.stdout


@dataclass(frozen=True, slots=True)
class _Arrow:
    source: str
    target: str
    label: str
    controllable: bool
    box: str = ""
    """The box of states that it leaves, if it leaves all in it."""


def _cluster(name: str, body: Iterable[str], title: str = "") -> list[str]:
    return [
        f"  subgraph {_quoted(f'cluster {name}')} {{",
        f"    label={_quoted(title or name)}; color=gray;",
        *(f"    {line}" for line in body),
        "  }",
    ]


def _node(name: str, label: str, marked: bool) -> str:
    lines = 2 if marked else 1
    return f"{_quoted(name)} [label={_quoted(label)}, peripheries={lines}];"


def _start(name: str) -> Iterator[str]:
    origin = _quoted(f"{name} start")
    yield f'{origin} [shape=point, width=0.08, label=""];'
    yield f"{origin} -> {_quoted(name)};"


def _arrows(arrows: Sequence[_Arrow]) -> Iterator[str]:
    """Arrows with the same ends become one, its label with a line for each."""
    groups: dict[tuple[str, str, bool, str], list[str]] = {}
    for arrow in arrows:
        key = arrow.source, arrow.target, arrow.controllable, arrow.box
        groups.setdefault(key, []).append(arrow.label)
    for (source, target, controllable, box), labels in groups.items():
        style = "solid" if controllable else "dashed"
        label = _quoted("\n".join(dict.fromkeys(labels)))
        tail = f", ltail={_quoted(box)}" if box else ""
        yield f"{_quoted(source)} -> {_quoted(target)} [label={label}, style={style}{tail}];"


# --- components ----------------------------------------------------------------------------------


def _automaton(robot: Robot, component: Component, behaviour: Behaviour) -> Iterator[str]:
    def place(state: str) -> str:
        return f"{component.name}.{state}"

    everywhere = f"{component.name} {_EVERY_STATE}"
    boxes = {outer.name for outer in behaviour.composites if outer.performs is None}
    begins = {t.goto for _, t in pictured(behaviour) if t.named in boxes}
    begins |= {place_of(s.name) for s in behaviour.states if s.initial}
    yield from _states_in(robot, component.name, behaviour, begins, "")
    if behaviour.transitions:
        yield f"{_quoted(everywhere)} [label={_quoted(_EVERY_STATE)}, shape=plaintext];"
    arrows = []
    for state, transition in sorted(pictured(behaviour), key=lambda item: item[0] is None):
        label = "\n".join(_label(robot, transition))
        sources = [everywhere]
        box = ""
        if state is not None:
            found = (s.name for s in behaviour.states if s.is_in(state))
            inside = list(dict.fromkeys(map(place_of, found)))
            if transition.goto not in (None, *inside) and inside != [state]:
                box = f"cluster {place(state)}"
            sources = [place(name) for name in (inside[:1] if box else inside)]
        for source in sources:
            target = source if transition.goto is None else place(transition.goto)
            arrows.append(_Arrow(source, target, label, transition.event.controllable, box))
    yield from _arrows(arrows)


def _states_in(
    robot: Robot, component: str, behaviour: Behaviour, begins: set[str | None], inside: str
) -> Iterator[str]:
    """The states that stand in one with a path, and no deeper; "" stands for all.

    ``begins`` are those in which a box of states, or the whole, begins.
    """
    boxes = {outer.name: outer.performs for outer in behaviour.composites}
    prefix = f"{inside}." if inside else ""
    paths = (s.name for s in behaviour.states if s.is_in(inside or None))
    heads = (prefix + dotted.first(place_of(path).removeprefix(prefix)) for path in paths)
    for path in dict.fromkeys(heads):
        name = f"{component}.{path}"
        title = path.removeprefix(prefix)
        performed = boxes.get(path)
        if path in boxes and performed is None:
            body = _states_in(robot, component, behaviour, begins, path)
            yield from _cluster(name, body, title)
            continue
        state = next(s for s in behaviour.states if place_of(s.name) == path)
        if performed is not None:
            title += f"\nperforms {robot.display_names[performed]}"
        yield _node(name, title, state.marked)
        if path in begins:
            yield from _start(name)


def _label(robot: Robot, transition: Transition) -> Iterator[str]:
    if not transition.event.of_component:
        yield f"{robot.display_names[transition.communication]}.{transition.event.word}"
    if transition.delay is not None:
        yield f"after {as_written(transition.delay, robot)}"
    if transition.guard is not None:
        yield f"[{as_written(transition.guard, robot)}]"
    yield from (f"{a.variable} := {as_written(a.value, robot)}" for a in transition.assignments)


# --- the controlled system -----------------------------------------------------------------------


def _states(graph: explore.Graph) -> Iterator[str]:
    plant = graph.plant
    for number, state in enumerate(graph.states):
        label = "\n".join(_state_lines(plant, state)) or "the only state"
        yield _node(f"state {number}", label, plant.is_marked(state))
    yield from _start("state 0")
    arrows = []
    for one in listing.listed(graph):
        ends = f"state {one.source}", f"state {one.target}"
        arrows.append(_Arrow(*ends, formatting.step_text(one.step), one.step.event.controllable))
    yield from _arrows(arrows)


def _state_lines(plant: automaton.Plant, state: automaton.PlantState) -> Iterator[str]:
    for variable, index in zip(plant.variables, state, strict=True):
        value = variable.values[index]
        if variable.labels is not None:
            yield variable.labels[index]
        elif variable.kind is automaton.VariableKind.LOCATION:
            yield f"{variable.name}.{place_of(str(value))}"
            if stage_of(str(value)):
                yield f"{variable.name}.{value}"
        elif variable.kind in (automaton.VariableKind.DATA, automaton.VariableKind.TEST):
            yield f"{variable.name} = {_value(value)}"
        elif index:
            yield f"{plant.robot.display_names[variable.name]} {value}"


def _value(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{path} = {_value(part)}" for path, part in value.items())
    if value is None:
        return "nothing"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
