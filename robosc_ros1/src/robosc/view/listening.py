"""A running controller of ROS 1 as a source: its topics ``~model``, ``~state`` and ``~events``.

This node only listens: it publishes nothing, offers nothing, calls nothing but the master. Whoever
sees the controller's topics can follow it, and it can come and go while this waits for it.
"""

from __future__ import annotations

import contextlib
import json
import logging
import threading
import time
from typing import Any

from robosc.errors import UsageError
from robosc.runtime.report import dump
from robosc.view.hub import Hub

__all__ = ["Listener"]

_SILENT = 3.0
"""Seconds without a state, which comes once per second at least, after which the node is gone."""
_CHECK = 0.5


class Listener:
    """Listens to one node.

    Raises:
        UsageError: ROS does not take its name.
        ModuleNotFoundError: this Python has no rospy.
    """

    def __init__(self, node: str, hub: Hub) -> None:
        import rosgraph.names
        import rospy  # noqa: F401  # not there: better now than in a thread

        self._node = rosgraph.names.ns_join(rosgraph.names.get_ros_namespace(), node)
        if not rosgraph.names.is_legal_name(node) or node.startswith("~"):
            raise UsageError(f"{node!r} is no name of a node")
        self._hub = hub
        self._heard = float("-inf")
        self._subscribers: list[Any] = []
        hub.put("hello", dump({"source": "ros", "title": self._node}))
        self._say(False, f"waiting for {self._node}")

    def start(self) -> None:
        threading.Thread(target=self._run, name="listener", daemon=True).start()

    def close(self) -> None:
        """Leave the master without a trace."""
        import rospy

        rospy.signal_shutdown("nobody watches any more")

    def _run(self) -> None:
        import rosgraph
        import rospy

        logging.getLogger("rosout").addHandler(logging.NullHandler())
        while not rosgraph.is_master_online():
            self._say(False, f"waiting for a master on {rosgraph.get_master_uri()}")
            time.sleep(_CHECK)
        # Signals are the server's; several viewers may watch one node.
        rospy.init_node("robosc_view", anonymous=True, disable_signals=True, disable_rosout=True)
        master = rosgraph.Master(rospy.get_name())
        while not rospy.is_shutdown():
            self._keep_registered(master)
            time.sleep(_CHECK)

    def _keep_registered(self, master: Any) -> None:
        """Subscribe, and again with another master; tell how things stand."""
        import rosgraph
        import rospy

        try:
            known = master.lookupNode(rospy.get_name()) is not None
        except rosgraph.MasterError:
            known = False
        except OSError:
            self._tell(f"no master on {rosgraph.get_master_uri()}")
            return
        if not known or not self._subscribers:
            self._subscribe()
        self._tell(f"waiting for {self._node}")

    def _subscribe(self) -> None:
        import rospy
        import std_msgs.msg

        for subscriber in self._subscribers:
            with contextlib.suppress(OSError, rospy.ROSException):
                subscriber.unregister()
        topics = {"model": self._on_model, "state": self._on_state, "events": self._on_event}
        self._subscribers = [
            rospy.Subscriber(
                f"{self._node}/{topic}", std_msgs.msg.String, listener, tcp_nodelay=True
            )
            for topic, listener in topics.items()
        ]

    def _tell(self, otherwise: str) -> None:
        silence = time.monotonic() - self._heard
        if silence < _SILENT:
            self._say(True, "live")
        elif silence == float("inf"):
            self._say(False, otherwise)
        else:
            self._say(False, f"silent for {silence:.0f} s; {otherwise}")

    def _say(self, good: bool, text: str) -> None:
        self._hub.put("status", dump({"good": good, "text": text}))

    # --- what is heard ---------------------------------------------------------------------------

    def _on_model(self, message: Any) -> None:
        text = _document(message.data, "components")
        if text is not None:
            self._hub.put("model", text)

    def _on_state(self, message: Any) -> None:
        text = _document(message.data, "commands")
        if text is not None:
            if time.monotonic() - self._heard > _SILENT:
                self._say(True, "live")
            self._heard = time.monotonic()
            self._hub.put("state", text)

    def _on_event(self, message: Any) -> None:
        text = _document(message.data, "outcome")
        if text is not None:
            self._hub.add([text])


def _document(text: str, field: str) -> str | None:
    """The same document on one line, as a stream needs it; None if it is not what it should be."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(document, dict) or document.get("version") != 1 or field not in document:
        return None
    return dump(document)
