"""Listening to a controller of ROS 2."""

from __future__ import annotations

import contextlib
import threading
import uuid
from typing import Any

from robosc.errors import UsageError
from robosc.view.hub import Hub
from robosc.view.listening import CHECK, Heard


class Ros2:
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
            self._node = self._make_node()
        except RuntimeError as error:
            raise UsageError(f"ROS 2 does not start: {error}") from error
        self._heard = Heard(name, hub)
        self._subscribe()
        self._node.create_timer(CHECK, self._look_around)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._run, name="listener", daemon=True)

    def start(self) -> None:
        self._heard.watch()
        self._thread.start()

    def close(self) -> None:
        self._executor.shutdown(timeout_sec=1.0)
        self._thread.join(2.0)
        self._node.destroy_node()
        self._context.try_shutdown()

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

        heard = self._heard
        reliable = ReliabilityPolicy.RELIABLE
        latched = QoSProfile(
            depth=1, reliability=reliable, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        each = QoSProfile(depth=1000, reliability=reliable)
        for topic, listener, quality in (
            ("model", heard.model, latched),
            ("state", heard.state, latched),
            ("events", heard.event, each),
        ):
            self._node.create_subscription(
                String,
                f"{heard.node}/{topic}",
                lambda message, listener=listener: listener(message.data),
                quality,
            )

    def _look_around(self) -> None:
        self._heard.waits(name for name, _ in self._node.get_topic_names_and_types())

    def _run(self) -> None:
        from rclpy.executors import ExternalShutdownException, ShutdownException

        with contextlib.suppress(ExternalShutdownException, ShutdownException):
            self._executor.spin()
