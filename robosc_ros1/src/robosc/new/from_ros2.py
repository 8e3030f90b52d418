"""The graph of ROS 2, as discovery tells it."""

from __future__ import annotations

import importlib
import time
import uuid
from collections import defaultdict
from dataclasses import replace
from functools import partial
from typing import Any

from robosc.errors import UsageError
from robosc.new.frames import TOPICS, Frames
from robosc.new.survey import RosGraph, Spacing, pauses_of

_DISCOVERY = 2.0
"""Seconds in which no further node appears: then those of the graph are known."""
_LONGEST_DISCOVERY = 15.0
"""Seconds: so long may the first one take, or all where they come one after the other."""


def listen(seconds: float) -> tuple[RosGraph, dict[str, Spacing]]:
    """Return the graph, and the pauses of each topic that was heard several times.

    Raises:
        UsageError: ROS 2 does not start.
        ModuleNotFoundError: this Python has no rclpy.
    """
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    context = rclpy.Context()
    try:
        rclpy.init(context=context)
    except RuntimeError as error:
        raise UsageError(f"ROS 2 does not start: {error}") from error
    own = f"robosc_new_{uuid.uuid4().hex[:8]}"
    node = rclpy.create_node(
        own, context=context, use_global_arguments=False, start_parameter_services=False
    )
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    _discover(node, executor)
    graph = _graph(node, f"/{own}")
    arrivals = defaultdict[str, "list[float]"](list)
    for topic in graph.publishers:
        _subscribe(node, topic, graph.types[topic], arrivals)
    frames = Frames()
    for topic, is_static in TOPICS.items():
        if topic in graph.publishers:
            _follow(node, frames, topic, is_static=is_static)
    _spin(executor, seconds)
    executor.shutdown()
    node.destroy_node()
    context.try_shutdown()
    chains = frames.chains()
    arrivals.update({chain.name: chain.arrivals for chain in chains})
    return replace(graph, chains=chains), pauses_of(arrivals)


def _discover(node: Any, executor: Any) -> None:
    end = time.monotonic() + _LONGEST_DISCOVERY
    known: set[tuple[str, str]] = set()
    while time.monotonic() < end:
        before = known
        _spin(executor, _DISCOVERY)
        known = set(node.get_node_names_and_namespaces())
        if known == before and len(known) > 1:  # its own is one of them
            return


def _spin(executor: Any, seconds: float) -> None:
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        executor.spin_once(timeout_sec=left)


def _graph(node: Any, own: str) -> RosGraph:
    from rclpy.action import get_action_server_names_and_types_by_node

    types: dict[str, str] = {}
    kinds: list[dict[str, list[str]]] = []
    ends = (
        node.get_publisher_names_and_types_by_node,
        node.get_subscriber_names_and_types_by_node,
        node.get_service_names_and_types_by_node,
        partial(get_action_server_names_and_types_by_node, node),
    )
    nodes = [(n, ns) for n, ns in node.get_node_names_and_namespaces() if f"{ns}/{n}"[1:] != own]
    for end in ends:
        found = defaultdict[str, "list[str]"](list)
        for name, namespace in nodes:
            try:
                at_node = end(name, namespace)
            except RuntimeError:  # rclpy's, for a node that has ended meanwhile
                continue
            for topic, (type_, *_) in at_node:
                if "/_action/" not in topic:
                    found[topic].append(f"{namespace.rstrip('/')}/{name}")
                    package, _, rest = type_.partition("/")
                    types[topic] = f"{package}/{rest.rpartition('/')[2]}"
        kinds.append(dict(found))
    publishers, subscribers, services, actions = kinds
    return RosGraph(publishers, subscribers, services, actions, types)


def _follow(node: Any, frames: Frames, topic: str, *, is_static: bool) -> None:
    from rclpy.qos import DurabilityPolicy, QoSProfile

    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:  # its package is not installed here
        return

    def heard(message: object) -> None:
        frames.hear(message, time.monotonic(), is_static=is_static)

    durability = DurabilityPolicy.TRANSIENT_LOCAL if is_static else DurabilityPolicy.VOLATILE
    node.create_subscription(TFMessage, topic, heard, QoSProfile(depth=100, durability=durability))


def _subscribe(node: Any, topic: str, type_: str, arrivals: dict[str, list[float]]) -> None:
    from rclpy.qos import qos_profile_sensor_data

    package, _, name = type_.partition("/")
    try:
        message = getattr(importlib.import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError):  # its package is not installed here
        return

    def arrived(message: object) -> None:
        arrivals[topic].append(time.monotonic())

    node.create_subscription(message, topic, arrived, qos_profile_sensor_data, raw=True)
