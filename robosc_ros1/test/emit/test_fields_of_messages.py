"""What a package's own test knows of real messages: the fields that the model reads or sends."""

from __future__ import annotations

from pathlib import Path

from robosc.emit.package.plant_data import plant_data
from robosc.errors import render_all
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.source import Source

MODEL = """
robot R {
    component Arm {
        outgoing message pose with type: p_msgs/Pose
        outgoing message near with type: Near
        service move with type: p_msgs/Move
        behaviour {
            variable x: double
            variable close: Near
            initial marked state on {
                on response from pose do x := value.point.x
                on response from near do close := value
                on response from move if value.done goto on
            }
        }
    }
    requirement move needs Arm.close = yes
    provide move with { way: [{ y: Arm.x }] }
    datatype enum Near from p_msgs/Pose to { value.ranges[0] < 1.0 -> yes default -> no }
}
"""


def test_only_used_fields_are_known(tmp_path: Path) -> None:
    for name, text in (
        ("msg/Point.msg", "float64 x\nfloat64 y\nfloat64 z\n"),
        ("msg/Pose.msg", "uint32 number\nPoint point\nfloat32[] ranges\nPoint[] corners\n"),
        ("srv/Move.srv", "Point[] way\nuint8 speed\n---\nbool done\nstring message\n"),
        ("package.xml", "<package><name>p_msgs</name></package>"),
    ):
        file = tmp_path / "p_msgs" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    definitions = MessageDefinitions.for_model(tmp_path / "m.rscd", {})
    robot, diagnostics = load(Source("m.rscd", MODEL), definitions=definitions)
    assert robot is not None, render_all(diagnostics)
    plant = plant_data(robot)
    types = {c["name"]: c for c in plant["communications"]}
    part = ["object", [["point", ["object", [["x", ["double"]]]]]]]
    assert types["pose"]["response"] == part
    assert plant["enums"]["R.Near"]["from"] == ["object", [["ranges", ["array", ["double"]]]]]
    assert types["move"]["request"] == [
        "object",
        [["way", ["array", ["object", [["y", ["double"]]]]]]],
    ]
    assert types["move"]["response"] == ["object", [["done", ["boolean"]]]]
    (provide,) = plant["provides"]
    ((name, data),) = provide["data"]["fields"]
    assert name == "way" and list(data) == ["elements"]
