"""The graph of ROS 1, as the master and the nodes tell it."""

from __future__ import annotations

import contextlib
import time
from collections import defaultdict
from functools import partial

from robosc.errors import UsageError
from robosc.new.frames import TOPICS, Frames
from robosc.new.survey import RosGraph, Spacing, pauses_of


def listen(seconds: float) -> tuple[RosGraph, dict[str, Spacing]]:
    """Return the graph, and the pauses of each topic that was heard several times.

    Raises:
        UsageError: there is no master.
        ModuleNotFoundError: this Python has no rospy.
    """
    import rosgraph
    import rospy
    import rosservice

    if not rosgraph.is_master_online():
        raise UsageError(f"no master on {rosgraph.get_master_uri()}: start the robot first")
    rospy.init_node("robosc_new", anonymous=True, disable_signals=True, disable_rosout=True)
    master = rosgraph.Master(rospy.get_name())
    published, subscribed, offered = (dict(part) for part in master.getSystemState())
    types = dict(master.getTopicTypes())
    for service in offered:
        with contextlib.suppress(OSError, rosservice.ROSServiceIOException):
            types[service] = rosservice.get_service_type(service) or ""
    arrivals = defaultdict[str, "list[float]"](list)

    def arrived(topic: str, message: object) -> None:
        arrivals[topic].append(time.monotonic())

    for topic in published:
        rospy.Subscriber(topic, rospy.AnyMsg, partial(arrived, topic))
    frames = Frames()
    for topic, is_static in TOPICS.items():
        if topic in published:
            _follow(frames, topic, is_static=is_static)
    time.sleep(seconds)
    rospy.signal_shutdown("everything was heard")
    chains = frames.chains()
    arrivals.update({chain.name: chain.arrivals for chain in chains})
    return RosGraph(published, subscribed, offered, {}, types, chains), pauses_of(arrivals)


def _follow(frames: Frames, topic: str, *, is_static: bool) -> None:
    import rospy

    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:  # its package is not installed here
        return
    rospy.Subscriber(
        topic, TFMessage, lambda m: frames.hear(m, time.monotonic(), is_static=is_static)
    )
