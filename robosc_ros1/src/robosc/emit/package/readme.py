"""What people read about a generated package: its parameters and its README."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from robosc.emit.controller import guard_methods, python
from robosc.emit.export.pictured_transitions import pictured
from robosc.emit.package.config import Config, declared_communications, declared_parameters
from robosc.language.events import Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata, entities
from robosc.plant.model_text import to_dsl
from robosc.runtime.core import model, places, settings
from robosc.runtime.core.launch_arguments import AT_LAUNCH, described, launch_arguments
from robosc.supervisor import Supervisor
from robosc.synthesis.formatting import event_text


@dataclass(frozen=True)
class ParameterView:
    """A private parameter; ``default`` as YAML, ``argument`` its name as a launch argument.

    One that only the parameter file sets has no such name.

    ``wide`` says that it may be more than an integer of 32 bits can be. ``example`` is a value of
    one that must be given; ``in_file`` says whether the parameter file sets it.
    """

    name: str
    argument: str
    type: str
    default: str
    doc: str
    wide: bool = False
    in_file: bool = True
    example: Any = None


def parameter_views(
    robot: entities.Robot, config: Config, more: Iterable[model.Parameter] = ()
) -> tuple[ParameterView, ...]:
    """All parameters of the robot's node, with the defaults of the configuration.

    ``more`` are those that only one version of ROS has.
    """
    views = []
    own = declared_parameters(robot)
    known = (*own, *settings.declared(declared_communications(robot)), *more)
    at_launch = [p for p in known if p in own or p.name in AT_LAUNCH]
    arguments = {p.name: argument for argument, p in launch_arguments(at_launch).items()}
    for p in known:
        default = yaml_text(config.parameters.get(p.name, p.default))
        is_number = p.type in ("integer", "number")
        wide = p in own and is_number and not _is_narrow(p.minimum, p.maximum)
        missing = p.required and p.name not in config.parameters
        example = p.default if missing else None
        views.append(
            ParameterView(
                p.name,
                arguments.get(p.name, ""),
                p.type,
                default,
                described(p),
                wide=wide,
                in_file=not missing,
                example=example,
            )
        )
    return tuple(views)


def _is_narrow(low: float | None, high: float | None) -> bool:
    return low is not None and high is not None and low >= -(2**31) and high < 2**31


def yaml_text(value: object) -> str:
    """A value as YAML 1.1 reads it, which wants a point in a number with an exponent."""
    if isinstance(value, Mapping):
        parts = (f"{json.dumps(name)}: {yaml_text(part)}" for name, part in value.items())
        return "{" + ", ".join(parts) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(yaml_text, value)) + "]"
    text = json.dumps(value)
    if isinstance(value, float) and "e" in text and "." not in text:
        return text.replace("e", ".0e")
    return text


@dataclass(frozen=True)
class InterfaceView:
    """A topic, service or action with its ROS type and the model's names for it."""

    name: str
    type: str
    communication: str
    place: str


@dataclass(frozen=True)
class GuardView:
    event: str
    guard: str
    status: str
    requirements: tuple[str, ...]


@dataclass(frozen=True)
class PartView:
    """What guards have in common, by its name."""

    name: str
    condition: str


@dataclass(frozen=True)
class DiagramView:
    """A component's automaton as lines of a mermaid state diagram."""

    component: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class ReadmeContext:
    package: str
    robot: str
    source: str
    subscribed: tuple[InterfaceView, ...]
    published: tuple[InterfaceView, ...]
    services: tuple[InterfaceView, ...]
    actions: tuple[InterfaceView, ...]
    served: tuple[InterfaceView, ...]
    served_actions: tuple[InterfaceView, ...]
    parameters: tuple[ParameterView, ...]
    parts: tuple[PartView, ...]
    guards: tuple[GuardView, ...]
    diagrams: tuple[DiagramView, ...]
    unseen: tuple[str, ...] = ()
    """The names of what a monitor cannot hear, and of the commands that it does not judge."""
    unjudged: tuple[str, ...] = ()
    heard: tuple[InterfaceView, ...] = ()
    """The actions that a monitor hears."""


def readme_context(
    supervisor: Supervisor,
    package: str,
    parameters: tuple[ParameterView, ...],
    spelling: Callable[[entities.Communication], tuple[str, str]],
) -> ReadmeContext:
    """``spelling`` gives a communication's name and type as the target's tools spell them."""
    robot = supervisor.plant.robot

    def interfaces(kind: Kind) -> tuple[InterfaceView, ...]:
        return tuple(
            InterfaceView(*spelling(c), robot.display_names[c.key], c.span.place)
            for c in robot.communications.values()
            if c.kind is kind
        )

    return ReadmeContext(
        package=package,
        robot=robot.name,
        source=robot.span.source.file_name,
        subscribed=interfaces(Kind.OUTGOING),
        published=interfaces(Kind.INCOMING),
        services=interfaces(Kind.SERVICE),
        actions=interfaces(Kind.ACTION),
        served=interfaces(Kind.SERVED_SERVICE),
        served_actions=interfaces(Kind.SERVED_ACTION),
        parameters=parameters,
        parts=tuple(
            PartView(part.name, part.text(robot)) for part in supervisor.part_names.definitions
        ),
        guards=tuple(_guards(supervisor)),
        diagrams=tuple(_diagrams(robot)),
    )


def _guards(supervisor: Supervisor) -> list[GuardView]:
    robot = supervisor.plant.robot
    views = []
    for guard in guard_methods.whole_guards(supervisor):
        event = guard.event
        name = event_text(event) if event.kind.of_component else f"{event.name} {event.kind.word}"
        texts = tuple(
            f"{robot.requirements[i].text} ({robot.requirements[i].span.place})"
            for i in event.requirements
        )
        text = to_dsl(supervisor.part_names.of_guard(guard.expr), robot)
        views.append(GuardView(name, text, guard.status, texts))
    return views


def _diagrams(robot: entities.Robot) -> list[DiagramView]:
    """Component automata in mermaid's syntax; what leaves every state is drawn from each."""
    views = []
    for component in robot.components:
        behaviour = component.behaviour
        if not behaviour.states:
            continue
        initial = next(places.place_of(s.name) for s in behaviour.states if s.initial)
        # Names in diagrams have no dots.
        names = dict.fromkeys(places.place_of(s.name) for s in behaviour.states)
        ids = {name: name.replace(".", "__") for name in names}
        lines = [f'state "{name}" as {word}' for name, word in ids.items() if name != word]
        lines += [f"[*] --> {ids[initial]}"]
        lines += [
            f"{ids[name]} --> {ids[t.goto or name]} : {_label(t, robot)}"
            for name in names
            for place, t in pictured(behaviour)
            if place is None or automata.is_in(name, place)
        ]
        views.append(DiagramView(component.name, tuple(dict.fromkeys(lines))))
    return views


def _label(transition: automata.Transition, robot: entities.Robot) -> str:
    if not transition.event.of_component:
        name = robot.display_names[transition.communication]
        guarded = " [guarded]" if transition.guard is not None else ""
        return f"{transition.event.word} {name}{guarded}"
    if transition.delay is not None:
        delay = python.duration(transition.delay)
        return f"after {delay if isinstance(delay, str) else f'{delay:g} s'}"
    return "transition" + (" [guarded]" if transition.guard is not None else "")
