"""Listening to a controller of ROS 1."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
import xmlrpc.client
from collections.abc import Callable
from http.client import HTTPException
from typing import Any

from robosc.errors import UsageError
from robosc.view import listening, operating, server
from robosc.view.hub import Hub


class Ros1(listening.Listener):
    """Listens to one node, for as long as there is a master, and with the next one again.

    Raises:
        UsageError: ROS does not take its name.
        ModuleNotFoundError: this Python has no rospy.
    """

    def __init__(self, node: str, hub: Hub) -> None:
        import rosgraph.names
        import rospy  # noqa: F401  # not there: better now than in a thread

        if not rosgraph.names.is_legal_name(node) or node.startswith("~") or not node.strip("/"):
            raise UsageError(f"{node!r} is not the name of a node")
        name = rosgraph.names.ns_join(rosgraph.names.get_ros_namespace(), node)
        self.heard = listening.Heard(rosgraph.names.canonicalize_name(name), hub)
        self._subscribers: list[Any] = []
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}

    def start(self, page: str | None) -> None:
        self.heard.watch()
        arguments = (page,)
        threading.Thread(target=self._run, args=arguments, name="listener", daemon=True).start()

    def close(self) -> None:
        import rospy

        rospy.signal_shutdown("nobody watches any more")

    def publish(self, topic: str, data: Any) -> None:
        import rosgraph
        import roslib.message
        import rospy

        if not self._subscribers:
            raise server.Unable("there is no connection to ROS yet")
        try:
            types = dict(rosgraph.Master(rospy.get_name()).getTopicTypes())
        except (OSError, HTTPException, xmlrpc.client.Error) as error:
            raise server.Unable(f"the master does not answer: {error}") from None
        if topic not in types:
            raise server.Unable(operating.UNHEARD % topic)
        class_ = known_class(roslib.message.get_message_class, types[topic])
        message = filled(class_(), data)
        publisher = self._publishers.get(topic)
        if publisher is None:
            publisher = rospy.Publisher(topic, class_, queue_size=10, tcp_nodelay=True)
            self._publishers[topic] = publisher
        operating.awaited(topic, publisher.get_num_connections)
        publisher.publish(message)

    def _run(self, page: str | None) -> None:
        import rosgraph
        import rospy

        logging.getLogger("rosout").addHandler(logging.NullHandler())
        while not rosgraph.is_master_online():
            self.heard.otherwise = f"waiting for a master on {rosgraph.get_master_uri()}"
            time.sleep(listening.CHECK)
        # Signals are the server's; several viewers may watch one node.
        rospy.init_node("robosc_view", anonymous=True, disable_signals=True, disable_rosout=True)
        master = rosgraph.Master(rospy.get_name())
        while not rospy.is_shutdown():
            self._keep_registered(master)
            with contextlib.suppress(rospy.ROSException):  # it is shut down meanwhile
                self._tell_of(page)
            time.sleep(listening.CHECK)

    def _tell_of(self, page: str | None) -> None:
        import diagnostic_msgs.msg
        import rospy

        if page is not None:
            messages, stamp = diagnostic_msgs.msg, rospy.Time.now()
            told = listening.diagnosis(messages, self.heard.node, page, stamp, 0)
            self._publishers["/diagnostics"].publish(told)

    def _keep_registered(self, master: Any) -> None:
        """Subscribe, and again with another master, which does not know of this node."""
        import rosgraph
        import rospy

        topics: list[str] = []
        try:
            topics = [name for name, _ in master.getPublishedTopics("")]
            known = master.lookupNode(rospy.get_name()) is not None
        except rosgraph.MasterError:
            known = False
        except (OSError, HTTPException, xmlrpc.client.Error):  # what is on its port may be anything
            self.heard.otherwise = f"no master on {rosgraph.get_master_uri()}"
            return
        self.heard.waits(topics)
        if not known or not self._subscribers:
            self._subscribe()

    def _subscribe(self) -> None:
        import diagnostic_msgs.msg
        import rospy
        import std_msgs.msg

        for end in (*self._subscribers, *self._publishers.values()):
            with contextlib.suppress(OSError, rospy.ROSException):
                end.unregister()
        self._publishers = {
            "/diagnostics": rospy.Publisher(
                "/diagnostics", diagnostic_msgs.msg.DiagnosticArray, queue_size=1
            )
        }
        heard = self.heard
        self._subscribers = [
            rospy.Subscriber(
                f"{heard.node}/{topic}",
                std_msgs.msg.String,
                lambda message, listener=heard.topics[topic]: listener(message.data),
                tcp_nodelay=True,
            )
            for topic in self.TOPICS
        ]


def known_class(find: Callable[[str], Any], type_: str) -> Any:
    """Return what ``roslib`` finds of a type. Raises Unable: nothing."""
    class_ = find(type_)
    if class_ is None:
        raise server.Unable(f"this machine has no {type_}: source the workspace that has it")
    return class_


def filled(message: Any, data: Any) -> Any:
    """A message with these fields: by name, nested, or its only one.

    Raises:
        Unable: they do not fit.
    """
    import genpy

    try:
        genpy.message.fill_message_args(message, [data])
        message._check_types()
    except (genpy.MessageException, ValueError) as error:
        raise server.Unable(str(error)) from None
    return message
