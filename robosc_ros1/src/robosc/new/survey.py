"""What runs in a ROS graph, seen as parts of a robot that a controller could use."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import pairwise
from statistics import median

from robosc.lazy_dataclasses import dataclass
from robosc.new.frames import RobotFrame

Nodes = Mapping[str, Collection[str]]
"""The nodes at each topic, service or action."""

UNKNOWN_NODE = "?"
"""Begins what stands for a node that was not recorded; names of nodes begin with a slash."""

_INFRASTRUCTURE = frozenset({
    "/rosout", "/rosout_agg", "/clock", "/tf", "/tf_static", "/parameter_events", "/diagnostics",
    "/events/write_split",
})  # fmt: skip
_OF_EVERY_NODE = frozenset({
    "roscpp", "rosgraph_msgs", "rcl_interfaces", "lifecycle_msgs", "type_description_interfaces",
    "dynamic_reconfigure",
})  # fmt: skip
"""Packages of the services that nodes have without being asked."""
_TOOLS = ("robosc_view", "robosc_new")
"""How the names of robosc's own nodes begin, which only listen or operate."""
_REPORTS = frozenset({"blocked", "events", "findings", "model", "operate", "state", "values"})
"""What generated nodes publish or hear below their names."""
_PARTS_OF_ACTIONS = ("goal", "cancel", "status", "feedback", "result")


@dataclass(frozen=True, slots=True)
class RosGraph:
    """What a master or discovery tells: nodes at topics, services and actions, and their types.

    Types are spelled ``package/Type``, whichever the version of ROS.
    """

    publishers: Nodes
    subscribers: Nodes
    services: Nodes
    actions: Nodes
    types: Mapping[str, str]
    chains: tuple[RobotFrame, ...] = ()


@dataclass(frozen=True, slots=True)
class Offer:
    """A topic, service or action with its type, and the ``node`` that has it.

    ``others`` are nodes at the other end of a topic.
    """

    name: str
    type: str
    node: str
    others: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Spacing:
    """Seconds between two messages of a topic: what is usual, and the longest."""

    usual: float
    longest: float


@dataclass(frozen=True, slots=True)
class Survey:
    """``outgoing`` topics come from the robot, ``incoming`` ones go to it. ``declared`` are the
    types that the model has to declare."""

    outgoing: tuple[Offer, ...]
    incoming: tuple[Offer, ...]
    services: tuple[Offer, ...]
    actions: tuple[Offer, ...]
    declared: frozenset[str] = frozenset()
    chains: tuple[RobotFrame, ...] = ()


def survey(graph: RosGraph) -> Survey:
    """Return what the nodes of the robot offer, without ROS's own and without controllers.

    A controller that robosc has generated is no part of the robot: what it publishes is what the
    robot's nodes subscribe to. Neither is ``robosc view``, nor what listens to reports.
    """
    controllers = _controllers(graph.publishers)
    others = controllers | {node for node in _all_nodes(graph) if _is_tool(node)}
    publishers = _without(graph.publishers, others)
    subscribers = _without(graph.subscribers, others)
    actions = {**_actions_of_topics(graph), **graph.actions}
    hidden = {f"{action}/{part}" for action in actions for part in _PARTS_OF_ACTIONS}
    topics = [
        name
        for name in sorted({*publishers, *subscribers})
        if name not in _INFRASTRUCTURE | hidden
        and not _is_report(name, controllers)
        and "/" in graph.types.get(name, "")  # the master may know no type
    ]
    return Survey(
        tuple(_offers(graph, publishers, [t for t in topics if t in publishers], subscribers)),
        tuple(_offers(graph, subscribers, [t for t in topics if t not in publishers])),
        tuple(_offers(graph, _without(graph.services, controllers), _services(graph))),
        tuple(_offers(graph, _without(actions, controllers), sorted(actions))),
        chains=graph.chains,
    )


def pauses_of(arrivals: Mapping[str, Sequence[float]]) -> dict[str, Spacing]:
    """Return the pauses between messages of each topic with three or more."""
    pauses = {
        topic: [later - earlier for earlier, later in pairwise(times)]
        for topic, times in arrivals.items()
        if len(times) > 2
    }
    return {topic: Spacing(median(between), max(between)) for topic, between in pauses.items()}


def _offers(
    graph: RosGraph, nodes: Nodes, names: Iterable[str], others: Nodes | None = None
) -> Iterable[Offer]:
    for name in names:
        if name in nodes:
            at_other_end = tuple(sorted((others or {}).get(name, ())))
            type_ = graph.types.get(name) or graph.types[f"{name}/goal"].removesuffix("ActionGoal")
            yield Offer(name, type_, min(nodes[name]), at_other_end)


def _controllers(publishers: Nodes) -> set[str]:
    """The nodes that robosc has generated: each publishes its model and its state."""
    return {
        node
        for node in {node for nodes in publishers.values() for node in nodes}
        if all(node in publishers.get(f"{node}/{topic}", ()) for topic in ("model", "state"))
    }


def _all_nodes(graph: RosGraph) -> set[str]:
    ends = (*graph.publishers.values(), *graph.subscribers.values())
    return {node for nodes in ends for node in nodes}


def _is_tool(node: str) -> bool:
    return node.rpartition("/")[2].startswith(_TOOLS)


def _is_report(topic: str, controllers: Collection[str]) -> bool:
    """Whether a topic is one of a generated node's own, whoever listens there."""
    return any(
        topic.startswith(f"{node}/") and topic[len(node) + 1 :].partition("/")[0] in _REPORTS
        for node in controllers
    )


def _without(nodes: Nodes, controllers: Collection[str]) -> dict[str, list[str]]:
    rest = {name: [n for n in at if n not in controllers] for name, at in nodes.items()}
    return {name: at for name, at in rest.items() if at}


def _actions_of_topics(graph: RosGraph) -> dict[str, Collection[str]]:
    """The actions of ROS 1, which are five topics each; their servers receive the goals."""
    ends = "/goal"
    return {
        goal.removesuffix(ends): graph.subscribers[goal]
        for goal in graph.subscribers
        if goal.endswith(ends)
        and graph.types.get(goal, "").endswith("ActionGoal")
        and f"{goal.removesuffix(ends)}/result" in graph.publishers
    }


def _services(graph: RosGraph) -> Sequence[str]:
    return sorted(
        name
        for name in graph.services
        if graph.types.get(name, "").partition("/")[0] not in {"", *_OF_EVERY_NODE}
    )
