"""What was recorded: bags of ROS 1 (``.bag``) and of ROS 2 (``.mcap``, ``.db3``, their folders)."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Set
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from robosc.errors import UsageError
from robosc.model.ros.interfaces import Definition
from robosc.model.ros.recorded import definitions
from robosc.new import survey
from robosc.new.frames import TOPICS, Frames
from robosc.simulate.bags import bag_files, storage

_MEASURED = 60
"""Seconds from the beginning in which pauses are measured: bags may have many gigabytes."""

_COMMAND_TYPES = re.compile(r"geometry_msgs/Twist(Stamped)?|ackermann_msgs/\w+|\w+/JointTrajectory")
_COMMAND_NAMES = re.compile(r".*(/|_)(cmd|command|setpoint)s?(/|_|$).*")
_ROS_1_ACTION = re.compile(r"(?P<action>.+)/(goal|result|feedback) (?P<type>\S+)Action[A-Z][a-z]+")
_ROS_2_ACTION = re.compile(r"(?P<action>.+)/_action/feedback (?P<type>\S+)_FeedbackMessage")
_ROS_2_SERVICE = re.compile(r"(?P<service>.+)/_service_event (?P<type>\S+)_Event")

Nodes = Mapping[str, "list[str]"]


class Recorded(NamedTuple):
    """What a recording has: the graph, the pauses of each topic, the definitions of its messages,
    by names like ``geometry_msgs/Twist``, and what there is to know of it."""

    graph: survey.RosGraph
    pauses: dict[str, survey.Spacing]
    definitions: dict[str, Definition]
    notes: tuple[str, ...]


def read(path: Path) -> Recorded:
    """Return what a recording has.

    A bag does not tell who receives a topic, and that of ROS 2 not who sends it. What is a command
    is guessed from types and names.

    Raises:
        UsageError: it cannot be read.
    """
    with bag_files.opened_bag(path) as bag:
        channels = bag.storage.channels.values()
        topics = [_topic(channel) for channel in channels]
        frames = _frames(bag)
        told = {chain.name: chain.arrivals for chain in frames.chains()}
        pauses = survey.pauses_of(_arrivals(bag) | told)
        notes = (*bag.storage.missing, *bag.storage.notes)
    return Recorded(
        replace(_graph(topics), chains=frames.chains()), pauses, _definitions(channels), notes
    )


def _definitions(channels: Iterable[storage.Channel]) -> dict[str, Definition]:
    """All definitions that can be read."""
    found: dict[str, Definition] = {}
    for channel in channels:
        if channel.definition.strip():
            with suppress(ValueError):
                texts = definitions(channel.definition, channel.type, channel.schema)
                found = {**texts, **found}
    return found


def _arrivals(bag: bag_files.Bag) -> dict[str, list[float]]:
    """The seconds at which messages of each topic came, without those of latched topics."""
    arrivals = defaultdict[str, "list[float]"](list)
    for number, channel in bag.storage.channels.items():
        if not channel.latched:
            times = bag.storage.times(number)
            arrivals[channel.topic] += [time for time in times if time < _MEASURED]
    return {topic: sorted(times) for topic, times in arrivals.items()}


def _frames(bag: bag_files.Bag) -> Frames:
    """The frames of the beginning."""
    frames = Frames()
    with suppress(UsageError):  # messages in another form than their definition says
        there = [topic for topic in TOPICS if topic in bag.topics]
        for topic, time, _, message in bag.messages(there, lambda *_: None):
            if time > bag.start + _MEASURED:
                break
            frames.hear(message, time, is_static=TOPICS[topic])
    return frames


def _topic(channel: storage.Channel) -> tuple[str, str, str]:
    """Name, type as ``package/Type``, and the node that sent it: empty if that is not known."""
    package, _, rest = channel.type.partition("/")
    return channel.topic, f"{package}/{rest.rpartition('/')[2]}", channel.node


def _graph(topics: Collection[tuple[str, str, str]]) -> survey.RosGraph:
    names = {name for name, _, _ in topics}
    senders = defaultdict[str, "list[str]"](list)
    types: dict[str, str] = {}
    services: dict[str, list[str]] = {}
    for name, type_, node in topics:
        types[name] = type_
        if service := _ROS_2_SERVICE.fullmatch(f"{name} {type_}"):
            services[service["service"]] = [_unknown(service["service"])]
            types[service["service"]] = service["type"]
        elif "/_action/" not in name or _ROS_2_ACTION.fullmatch(f"{name} {type_}"):
            senders[name].append(node or _reporting(name, names) or _unknown(name))
    actions: dict[str, list[str]] = {}
    for name in list(senders):
        line = f"{name} {types[name]}"
        if found := _ROS_1_ACTION.fullmatch(line) or _ROS_2_ACTION.fullmatch(line):
            action = found["action"]
            server = senders.get(f"{action}/result") or senders.get(f"{action}/feedback")
            actions[action] = server or [_unknown(action)]
            types[action] = found["type"]
            if "/_action/" in name:
                del senders[name]
    commands = {
        name: [_unknown(name)]
        for name in senders
        if _COMMAND_TYPES.fullmatch(types[name]) or _COMMAND_NAMES.fullmatch(name)
    }
    commands |= {n: [_unknown(n)] for n in senders if _by_controller(senders, n)}
    publishers = {name: at for name, at in senders.items() if name not in commands}
    return survey.RosGraph(publishers, commands, services, actions, types)


def _by_controller(senders: Nodes, topic: str) -> bool:
    """Whether only generated controllers send a topic that is none of their own reports."""
    nodes = senders[topic]
    return all(
        f"{node}/model" in senders
        and f"{node}/state" in senders
        and not topic.startswith(f"{node}/")
        for node in nodes
    )


def _reporting(topic: str, names: Set[str]) -> str:
    """The generated controller whose report a topic seems to be, from its name alone."""
    node, _, _ = topic.rpartition("/")
    return node if names >= {f"{node}/{report}" for report in ("model", "state", "events")} else ""


def _unknown(name: str) -> str:
    """A component for a topic whose node is not known: that of its outermost namespace."""
    return survey.UNKNOWN_NODE + name.strip("/").split("/")[0]
