"""What the templates of monitors see: what can be heard of a robot and its controller."""

from __future__ import annotations

from dataclasses import replace

from robosc import dotted
from robosc.emit.controller.assembly import controller_context
from robosc.emit.controller.template_data import ControllerContext
from robosc.emit.package.package_context import HeardView, PackageContext, TopicView
from robosc.emit.package.readme import InterfaceView, ReadmeContext
from robosc.emit.supervisor.command_recognition import command_matches
from robosc.emit.supervisor.commuting import not_commuting
from robosc.emit.supervisor.supervisor_package import with_commands
from robosc.expr.traversal import walk
from robosc.expr.tree import ReasonRef
from robosc.language.events import EventKind, Kind
from robosc.model.declarations.servers import shared_servers
from robosc.model.entities import Robot
from robosc.runtime.core.settings import parameter_name
from robosc.runtime.judge.sight import unknown_attributes
from robosc.supervisor import Supervisor

_MEANINGS = {
    "refuse_not_finite": "a command with a number that is infinite or not a number is a finding",
    "stop_command": "communication that may be requested at any time",
    "goal_timeout": "seconds after which the controller cancels a goal, which then ends by timeout",
    "server_lost_after": "seconds without status after which the controller gives a goal up",
}
"""What parameters mean to a monitor."""
_IDLE = (
    "allowed_publishers", "exit_on_stop", "goal_timeout", "on_mismatch", "operate",
    "server_lost_after",
)  # fmt: skip
"""Parameters of commands that a monitor does not send. (Rates and order are those of a shadow.)"""


def heard(base: PackageContext, supervisor: Supervisor, shows_results: bool) -> HeardView:
    """What can be heard of the commands of a robot, from the context of its controller.
    ``shows_results``: whoever listens gets the results of goals.

    Raises:
        ModelError: see :func:`.guarding.command_matches`.
    """
    robot = supervisor.plant.robot
    context = controller_context(supervisor, base.source)
    unseen = _unseen(robot, context, shows_results)
    return HeardView(
        commands=with_commands(base.publications, command_matches(robot, False)),
        actions=tuple(action for action in base.actions if action.key not in unseen),
        unseen=unseen,
        unjudged=_unjudged(context, unseen),
        by_data=_by_data(robot),
        orders=_orders(supervisor, unseen),
    )


def unheard(
    supervisor: Supervisor, source: str, shows_results: bool
) -> tuple[frozenset[str], bool]:
    """The keys of the communications that a monitor cannot hear, and of the commands that it does
    not judge; and whether it knows the whole state. The last argument is as in :func:`heard`."""
    robot = supervisor.plant.robot
    context = controller_context(supervisor, source)
    unseen = _unseen(robot, context, shows_results)
    hidden = frozenset((*unseen, *_unjudged(context, unseen), *_by_data(robot)))
    return hidden, not _unknown(context, unseen)


def _orders(supervisor: Supervisor, unseen: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """The groups of events whose order matters, as far as they can be heard."""
    groups = (tuple(k for k in keys if k not in unseen) for keys in not_commuting(supervisor))
    return tuple(keys for keys in groups if len(keys) > 1)


def monitor_context(
    base: PackageContext, supervisor: Supervisor, controller: str, shows_results: bool
) -> PackageContext:
    """The context of a monitor from that of a controller, whose node has the name ``controller``.

    Raises:
        ModelError: see :func:`heard`.
    """
    robot = supervisor.plant.robot
    found = heard(base, supervisor, shows_results)
    found = replace(
        found,
        commands=tuple(
            replace(v, name=name_for_others(v.name, controller)) for v in found.commands
        ),
        actions=tuple(replace(v, name=name_for_others(v.name, controller)) for v in found.actions),
    )
    deadlines = {
        f"timeout/{parameter_name(robot.display_names[c.key])}"
        for c in robot.communications.values()
        if c.kind is not Kind.OUTGOING
    }
    names = robot.display_names
    told = {f"goal_timeout/{parameter_name(names[key])}" for key in decides_on_reasons(robot)}
    if found.actions and shows_results:  # in ROS 2, the status is no sign of life
        told.add("server_lost_after")

    def is_shown(name: str) -> bool:
        return name in told or (name.partition("/")[0] not in _IDLE and name not in deadlines)

    return replace(
        base,
        title="Monitor",
        heard=found,
        subscriptions=tuple(
            replace(v, name=name_for_others(v.name, controller)) for v in base.subscriptions
        ),
        actions=found.actions,
        modules=_modules(base.subscriptions, base.publications, found.actions),
        parameters=tuple(
            replace(p, doc=_MEANINGS.get(p.name.replace(".", "/").partition("/")[0], p.doc))
            for p in base.parameters
            if is_shown(p.name.replace(".", "/"))
        ),
    )


def name_for_others(name: str, controller: str) -> str:
    """A name as other nodes than the controller have it: its private ones are below its own."""
    return f"{controller}/{name[1:].lstrip('/')}" if name.startswith("~") else name


def monitor_readme(
    readme: ReadmeContext, context: PackageContext, robot: Robot, controller: str
) -> ReadmeContext:
    """What people read about a monitor."""

    def shown(views: tuple[InterfaceView, ...]) -> tuple[InterfaceView, ...]:
        return tuple(replace(v, name=name_for_others(v.name, controller)) for v in views)

    names = robot.display_names
    hidden = [names[key] for key in context.heard.unseen]
    return replace(
        readme,
        subscribed=shown(readme.subscribed),
        published=shown(readme.published),
        heard=shown(tuple(a for a in readme.actions if a.communication not in hidden)),
        unseen=tuple(hidden),
        unjudged=tuple(names[key] for key in context.heard.unjudged),
    )


def _modules(*topics: tuple[TopicView, ...]) -> tuple[str, ...]:
    return tuple(sorted({dotted.around(view.type) for views in topics for view in views}))


def decides_on_reasons(robot: Robot) -> set[str]:
    """Return the keys of the actions of which the model reads why they failed."""
    read = (
        (transition.communication, expr)
        for _, transition in robot.transitions
        for expr in transition.expressions
    )
    return {key for key, expr in read if any(isinstance(p, ReasonRef) for p in walk(expr))}


def _unseen(robot: Robot, context: ControllerContext, shows_results: bool) -> tuple[str, ...]:
    """The services, what the controller serves, the actions that share a name, and those whose
    goals or results the model reads though nobody can hear them."""
    reads = {i.key for i in context.inputs if i.kind == EventKind.RESPONSE.value and i.read}
    reads |= {c.key for c in context.commands if c.read}
    shared = {c.key for together in shared_servers(robot) for c in together}
    hidden = shared | (set() if shows_results else reads)
    return tuple(
        c.key
        for c in robot.communications.values()
        if c.kind is Kind.SERVICE or c.sort.served or (c.kind is Kind.ACTION and c.key in hidden)
    )


def _by_data(robot: Robot) -> tuple[str, ...]:
    """The commands that their data decide on, where only those of the controller are known."""
    found = [] if robot.supervises else [r for r in robot.requirements if r.on_data]
    return tuple(dict.fromkeys(key for r in found for key in r.communications))


def _unknown(context: ControllerContext, unseen: tuple[str, ...]) -> frozenset[str]:
    """The attributes of a controller that a monitor does not know."""
    events = [(i.key, i.reaction.writes) for i in context.inputs]
    events += [(c.key, c.reaction.writes) for c in context.commands]
    steps = [(tau.reads, tau.writes) for tau in context.taus]
    steps += [(after.reads, after.writes) for after in context.afters]
    return unknown_attributes(unseen, events, steps)


def _unjudged(context: ControllerContext, unseen: tuple[str, ...]) -> tuple[str, ...]:
    unknown = _unknown(context, unseen)
    found = [c.key for c in context.commands if not unknown.isdisjoint(c.reads)]
    return tuple(dict.fromkeys([*found, *unseen]))
