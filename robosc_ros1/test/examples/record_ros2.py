"""Records topics of ROS 2 into a bag, as ``ros2 bag record --use-sim-time`` does; see
test_gallery_bags.py. Ends when its standard input does. When each topic and the clock have somebody
who publishes them to it, it says so on /recorder/ready.

    python record_ros2.py BAG TOPIC TYPE [TOPIC TYPE...]
"""

from __future__ import annotations

import importlib
import sys
import threading
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import Empty


def main() -> None:
    path, *words = sys.argv[1:]
    plugin = StoragePlugin.MCAP if path.endswith(".mcap") else StoragePlugin.SQLITE3
    store = get_typestore(Stores.ROS2_JAZZY)
    rclpy.init()
    simulated = [Parameter("use_sim_time", value=True)]
    node = rclpy.create_node("recorder", parameter_overrides=simulated)
    with Writer(Path(path).with_suffix(""), version=9, storage_plugin=plugin) as writer:
        kept: list[Any] = []
        ready: list[Any] = []
        for topic, type_ in zip(words[::2], words[1::2], strict=True):
            connection = writer.add_connection(topic, type_, typestore=store)

            def heard(raw: bytes, connection: Any = connection) -> None:
                if now := node.get_clock().now().nanoseconds:  # it begins with the clock
                    writer.write(connection, now, raw)

            package, _, name = type_.split("/")
            class_ = getattr(importlib.import_module(f"{package}.msg"), name)
            depth = QoSProfile(depth=1000)
            kept.append(node.create_subscription(class_, topic, heard, depth, raw=True))
        reader = threading.Thread(target=sys.stdin.read, daemon=True)
        reader.start()
        print("records", flush=True)
        executor = SingleThreadedExecutor()  # one that lets every topic have its turn
        executor.add_node(node)
        while reader.is_alive():
            executor.spin_once(timeout_sec=0.1)
            if not ready and all(end.get_publisher_count() for end in node.subscriptions):
                latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
                ready.append(node.create_publisher(Empty, "~/ready", latched))
                ready[0].publish(Empty())
    rclpy.shutdown()


main()
