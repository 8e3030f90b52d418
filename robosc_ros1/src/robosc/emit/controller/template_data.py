"""What the template of ``controller.py`` places: texts in their order, nothing left to decide."""

from __future__ import annotations

from robosc.lazy_dataclasses import dataclass


@dataclass(frozen=True)
class EnumView:
    """A conversion function with its arguments and statements."""

    function: str
    name: str
    arguments: tuple[str, ...]
    body: tuple[str, ...]


@dataclass(frozen=True)
class AttributeView:
    """An attribute of the controller with its initial value and a comment."""

    name: str
    initial: str
    comment: str


@dataclass(frozen=True)
class ComponentView:
    name: str
    place: str
    attributes: tuple[AttributeView, ...]


@dataclass(frozen=True)
class ReactionView:
    """What an event does: the statements, and the attributes that they may change."""

    body: tuple[str, ...]
    writes: tuple[str, ...]


@dataclass(frozen=True)
class InputView:
    """An uncontrollable event; ``read`` is the expression that takes its value from ``message``."""

    key: str
    kind: str
    place: str
    description: str
    read: str | None
    read_lines: tuple[tuple[str, str], ...]
    reader: str | None
    applier: str
    reaction: ReactionView
    expects: str | None = None
    """The method that tells whether the event is what the model expects."""
    expected: str = ""
    """The expression that this method returns."""


@dataclass(frozen=True)
class PartnerView:
    """A component that synchronises on a command, and under which condition it can take part."""

    component: str
    condition: str
    method: str


@dataclass(frozen=True)
class CommandView:
    """A controllable event of a communication; conditions are Python source."""

    key: str
    kind: str
    place: str
    description: str
    permission: str
    """What the guard decides, such as "drive may be requested"."""
    read: str | None
    """How the data of another controller are taken from ``message``, as in :class:`InputView`; its
    conditions and what it does then read ``value``."""
    read_lines: tuple[tuple[str, str], ...]
    reader: str | None
    corrector: str | None
    corrector_body: tuple[str, ...]
    guard: str
    guard_notes: tuple[str, ...]
    guard_text: str
    synchronisation: str | None
    synchronisation_text: str
    during: tuple[str, ...]
    """It is possible in these phases, given by attributes; empty: in all except ``unless``."""
    unless: tuple[str, ...]
    data: str | None
    data_body: tuple[str, ...]
    applier: str | None
    reaction: ReactionView
    reads: tuple[str, ...]
    """The attributes that decide whether it is allowed, its own phase apart."""
    requirements: tuple[int, ...]
    reason: str | None
    """Why synthesis forbids more than the requirements do, if it does."""
    partners: tuple[PartnerView, ...]
    """The components that synchronise on it."""
    yields_to: tuple[int, ...] = ()
    """Indexes of the commands that are preferred to it."""


@dataclass(frozen=True)
class RefusalView:
    """The data of the error to calls of ``key``, and of those that are refused."""

    key: str
    data: str
    data_body: tuple[str, ...]


@dataclass(frozen=True)
class TauView:
    """An internal transition; ``body`` are the statements of its method."""

    component: str
    number: int
    step: str
    place: str
    body: tuple[str, ...]
    reads: tuple[str, ...]
    writes: tuple[str, ...]


@dataclass(frozen=True)
class AfterView:
    """A transition that waits; ``body`` are the statements of its method.

    ``delay`` is Python source, ``waits`` how people read it.
    """

    component: str
    number: int
    step: str
    place: str
    state: str
    delay: str
    waits: str
    location: str
    entries: str
    body: tuple[str, ...]
    reads: tuple[str, ...]
    writes: tuple[str, ...]


@dataclass(frozen=True)
class ConjunctView:
    """A part of a requirement: what is told while ``unmet`` holds, the values beside it, and the
    numbers with which it compares them."""

    failure: str
    unmet: str
    values: tuple[tuple[str, str], ...]
    limits: str


@dataclass(frozen=True)
class RequirementView:
    """``failures`` is the method that tells which ``parts`` do not hold; None if there are none.
    ``on_data``: its methods read the data of a command, ``value``."""

    text: str
    place: str
    method: str
    on_data: bool
    condition: str
    failures: str | None
    parts: tuple[ConjunctView, ...]


@dataclass(frozen=True)
class LastingView:
    """A condition that must have held for some time: the method for what it is about, and the
    attributes of its automaton."""

    name: str
    place: str
    method: str
    condition: str
    location: str
    entries: str


@dataclass(frozen=True)
class GuardPartView:
    """What several guards have in common: a method of its own."""

    method: str
    text: str
    condition: str


@dataclass(frozen=True, kw_only=True)
class ControllerContext:
    """All that ``common/node/controller.py.jinja`` sees."""

    robot: str
    source: str
    class_name: str
    step_bound: int
    stages: tuple[str, ...]
    enums: tuple[EnumView, ...]
    components: tuple[ComponentView, ...]
    phases: tuple[AttributeView, ...]
    locations: tuple[tuple[str, str], ...]
    variables: tuple[tuple[str, str], ...]
    communications: tuple[str, ...]
    inputs: tuple[InputView, ...]
    commands: tuple[CommandView, ...]
    taus: tuple[TauView, ...]
    afters: tuple[AfterView, ...]
    requirements: tuple[RequirementView, ...]
    guard_parts: tuple[GuardPartView, ...] = ()
    refusals: tuple[RefusalView, ...] = ()
    lasting: tuple[LastingView, ...] = ()
    parameters: tuple[AttributeView, ...] = ()
    persistent: tuple[tuple[str, str, str], ...] = ()
    """The persistent variables: key, attribute, and the values of the type as a text."""
    parameter_rows: tuple[str, ...] = ()
    """The entries of the table of parameters, as arguments."""
    imports: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """What the module imports of the modules of the runtime."""
    runtime: str = "._runtime"
    """The package of those modules."""
