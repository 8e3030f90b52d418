"""What judging a recording takes, against rosbags, which only unpacks the same messages."""

from __future__ import annotations

import random
import time
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from emit.generated_code import supervisor_of

from robosc.simulate.bags.judgement import judge
from robosc.supervisor import Supervisor

__all__ = ["main"]

MOST = 2.0
"""What judging may take of what unpacking takes, in one run."""
COUNT = 50_000
ROBOT = """
robot Rig {
    component Laser {
        outgoing message scan with identifier: "/scan", timeout: 0.5 s, type: sensor_msgs/LaserScan
        behaviour {
            variable ahead: double
            initial marked state on {
                on response from scan do ahead := min(r for r in value.ranges[-25..25]) else 0.0
            }
        }
    }
    component Odometry {
        outgoing message odom with identifier: "/odom", type: nav_msgs/Odometry
        behaviour {
            variable speed: double
            initial marked state on { on response from odom do speed := value.twist.twist.linear.x }
        }
    }
    component Battery {
        outgoing message battery with identifier: "/battery", timeout: 3 s,
            type: sensor_msgs/BatteryState
        behaviour {
            variable charge: double
            initial marked state on { on response from battery do charge := value.percentage }
        }
    }
    component Button {
        outgoing message button with identifier: "/button", type: std_msgs/Bool
        behaviour {
            initial marked state released { on response from button if value.data goto pressed }
            marked state pressed { on response from button if !value.data goto released }
        }
    }
    component Motor {
        incoming message move with identifier: "/cmd_vel", type: geometry_msgs/Twist
    }
    requirement move needs scan.fresh and Laser.ahead > 0.4 and Odometry.speed < 1.0 and Battery.charge > 0.2 and Button.released
}
"""
KINDS = {
    "a robot's": ("/scan", "/odom", "/odom", "/scan", "/odom", "/odom", "/scan", "/odom", "/battery", "/button"),
    "a robot's and its controller's": ("/scan", "/odom", "/cmd_vel", "/odom", "/battery", "/odom", "/cmd_vel", "/button"),
    "scans": ("/scan",),
    "small": ("/button",),
}  # fmt: skip
TYPES = {
    "/scan": "sensor_msgs/msg/LaserScan", "/odom": "nav_msgs/msg/Odometry",
    "/cmd_vel": "geometry_msgs/msg/Twist", "/battery": "sensor_msgs/msg/BatteryState", "/button": "std_msgs/msg/Bool",
}  # fmt: skip
FORMATS = ("bag", "mcap", "db3")


def main(arguments: list[str] | None = None) -> int:
    supervisor, missed = supervisor_of(ROBOT), False
    for kind, topics in KINDS.items():
        for format_ in FORMATS:
            with TemporaryDirectory() as folder:
                path = written(Path(folder) / f"run.{format_}", topics)
                pairs = [(judging(supervisor, path), unpacking(path)) for _ in range(3)]
            ratio, taken = median(own / theirs for own, theirs in pairs), min(pairs)[0]
            print(
                f"  {kind} messages, {format_}: {taken:.1f} us each, {ratio:.2f} of unpacking"
                f"  (at most {MOST:g})",
                flush=True,
            )
            missed = missed or ratio > MOST
    return int(missed)


def written(path: Path, topics: tuple[str, ...]) -> Path:
    import numpy
    from simulate.recorded_runs import START, BagWriter

    chance = random.Random(1)
    far = numpy.linspace(0.5, 5.0, 360, dtype=numpy.float32)
    bag = BagWriter(path, {})
    for number in range(COUNT):
        topic = topics[number % len(topics)]
        drawn = chance.random()
        data: dict[str, Any] = {
            "/scan": {"ranges": far + numpy.float32(drawn)},
            "/odom": {"twist": {"twist": {"linear": {"x": 0.9 * drawn}}}},
            "/battery": {"percentage": 0.3 + 0.6 * drawn},
            "/button": {"data": number // 1000 % 10 == 0},  # forbids one command of ten
            "/cmd_vel": {"linear": {"x": 0.2}},
        }[topic]
        bag.write(topic, TYPES[topic], START + number * 0.01, data)
    bag.close()
    return bag.path


def judging(supervisor: Supervisor, path: Path) -> float:
    """Microseconds of processor time per message."""
    start = time.process_time()
    judge(supervisor, path, (), lambda *_: None)
    return (time.process_time() - start) / COUNT * 1e6


def unpacking(path: Path) -> float:
    from rosbags.highlevel import AnyReader

    start = time.process_time()
    with AnyReader([path if path.suffix == ".bag" or path.is_dir() else path.parent]) as bag:
        for connection, _, raw in bag.messages():
            bag.deserialize(raw, connection.msgtype)
    return (time.process_time() - start) / COUNT * 1e6
