"""Listening to a controller of ROS 2."""

from __future__ import annotations

import contextlib
import importlib
import sys
import threading
import time
import uuid
from typing import Any

from robosc.errors import UsageError
from robosc.view.hub import Hub
from robosc.view.listening import CHECK, Heard, Listener, diagnosis
from robosc.view.operating import awaited
from robosc.view.server import Unable

MATCHED = 0.5
"""Seconds until whoever hears a new publisher knows of it, too: before, it would lose a message."""


class Ros2(Listener):
    """Listens to one node; discovery finds it, and finds it again.

    Raises:
        UsageError: ROS does not take its name, or does not start here.
        ModuleNotFoundError: this Python has no rclpy.
    """

    def __init__(self, node: str, hub: Hub) -> None:
        import rclpy
        from rclpy.exceptions import InvalidTopicNameException
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions
        from rclpy.validate_full_topic_name import validate_full_topic_name

        name = "/" + node.strip("/")
        try:
            validate_full_topic_name(f"{name}/state")
        except InvalidTopicNameException:
            raise UsageError(f"{node!r} is not the name of a node") from None
        self._context = rclpy.Context()
        try:
            # Signals are the server's.
            rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
            self.node = self._make_node()
        except RuntimeError as error:
            raise UsageError(f"ROS 2 does not start: {error}") from error
        self.heard = Heard(name, hub)
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self._making = threading.Lock()
        self._subscribe()
        self.node.create_timer(CHECK, self._look_around)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._run, name="listener", daemon=True)

    def start(self, page: str | None) -> None:
        if page is not None:
            self._tell_of(page)
        self.heard.watch()
        self._thread.start()

    def _tell_of(self, page: str) -> None:
        from diagnostic_msgs import msg as messages

        publisher = self.node.create_publisher(messages.DiagnosticArray, "/diagnostics", 10)

        def tell() -> None:
            stamp = self.node.get_clock().now().to_msg()
            publisher.publish(diagnosis(messages, self.heard.node, page, stamp, bytes([0])))

        self.node.create_timer(CHECK, tell)

    def close(self) -> None:
        self._executor.shutdown(timeout_sec=1.0)
        self._thread.join(2.0)
        self.node.destroy_node()
        self._context.try_shutdown()

    def publish(self, topic: str, data: Any) -> None:
        # A graph that has grown a moment ago is not known whole, though the node's state is.
        types = awaited(topic, lambda: dict(self.node.get_topic_names_and_types()).get(topic))
        class_ = known_class(types[0].replace("/msg/", "/"), "msg")
        message = filled(class_, data)
        with self._making:
            known = self._publishers.get(topic)
            publisher = known or self._make_publisher(topic, class_)
            self._publishers[topic] = publisher
        awaited(topic, publisher.get_subscription_count)
        if known is None and self._may_lose(topic):
            time.sleep(MATCHED)
        publisher.publish(message)

    def _make_publisher(self, topic: str, class_: Any) -> Any:
        """One that offers what the first of those who hear the topic asks for."""
        from rclpy.qos import QoSProfile, ReliabilityPolicy

        profile = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
        for end in self.node.get_subscriptions_info_by_topic(topic)[:1]:
            asked = end.qos_profile
            profile.durability = asked.durability
            profile.deadline = asked.deadline
            profile.liveliness = asked.liveliness
            profile.liveliness_lease_duration = asked.liveliness_lease_duration
        return self.node.create_publisher(class_, topic, profile)

    def _may_lose(self, topic: str) -> bool:
        """Whether somebody hears a topic who does not ask again for what did not come."""
        from rclpy.qos import ReliabilityPolicy

        ends = self.node.get_subscriptions_info_by_topic(topic)
        return any(end.qos_profile.reliability != ReliabilityPolicy.RELIABLE for end in ends)

    def _make_node(self) -> Any:
        """A node that offers none of the services which nodes have by default.

        Several viewers may watch one node, so the name is unique.
        """
        import rclpy
        from rclpy.parameter import Parameter

        return rclpy.create_node(
            f"robosc_view_{uuid.uuid4().hex[:8]}",
            context=self._context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=[Parameter("start_type_description_service", value=False)],
        )

    def _subscribe(self) -> None:
        from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
        from std_msgs.msg import String

        if not hasattr(String, "get_fields_and_field_types"):
            raise UsageError(
                f"std_msgs is that of ROS 1 here ({sys.modules['std_msgs'].__file__}):"
                " start from a terminal in which only ROS 2 was sourced"
            )
        heard = self.heard
        reliable = ReliabilityPolicy.RELIABLE
        latched = QoSProfile(
            depth=1, reliability=reliable, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        each = QoSProfile(depth=1000, reliability=reliable)
        for topic in self.TOPICS:
            listener = heard.topics[topic]
            quality = latched if topic in ("model", "state") else each
            self.node.create_subscription(
                String,
                f"{heard.node}/{topic}",
                lambda message, listener=listener: listener(message.data),
                quality,
            )

    def _look_around(self) -> None:
        self.heard.waits(name for name, _ in self.node.get_topic_names_and_types())

    def _run(self) -> None:
        from rclpy.executors import ExternalShutdownException, ShutdownException

        with contextlib.suppress(ExternalShutdownException, ShutdownException):
            self._executor.spin()


def known_class(type_: str, kind: str) -> Any:
    """Return the class of a type (``package/Type``) of a kind: msg, srv, action.

    Raises:
        Unable: there is none here.
    """
    package, _, name = type_.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), name)
    except (ImportError, AttributeError):
        raise Unable(f"this machine has no {type_}: source the workspace that has it") from None


def filled(class_: Any, data: Any) -> Any:
    """A message with these fields: by name, nested, or its only one.

    Raises:
        Unable: they do not fit.
    """
    try:
        return _filled(class_, data)
    except (AssertionError, AttributeError, OverflowError, TypeError, ValueError) as error:
        name = "/".join((*class_.__module__.split(".")[:2], class_.__name__))
        raise Unable(f"this does not fit {name}: {error}") from None


def _filled(class_: Any, data: Any) -> Any:
    message = class_()
    if hasattr(message, "_check_fields"):  # since Jazzy only if asked; C aborts on what is wrong
        message._check_fields = True
    types = dict(zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True))
    if not isinstance(data, dict):
        if len(types) != 1:
            raise ValueError(f"it has the fields {', '.join(types)}")
        data = {next(iter(types)): data}
    for name, value in data.items():
        if name not in types:
            raise ValueError(f"it has no field {name!r}")
        setattr(message, name, _value(types[name], value))
    return message


def _value(kind: Any, value: Any) -> Any:
    """What JSON gives, as rclpy has it in a field of this type."""
    from rosidl_parser.definition import AbstractNestedType, BasicType, NamespacedType

    if isinstance(kind, AbstractNestedType):
        if not isinstance(value, list):
            raise ValueError(f"{value!r} is no list")
        return [_value(kind.value_type, part) for part in value]
    if isinstance(kind, NamespacedType):
        module = importlib.import_module(".".join(kind.namespaces))
        return _filled(getattr(module, kind.name), value)
    if isinstance(kind, BasicType) and kind.typename == "octet":
        return bytes([value])
    if isinstance(kind, BasicType) and kind.typename in ("float", "double") and type(value) is int:
        return float(value)
    return value
