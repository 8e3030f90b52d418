"""What numbers are compared with, for the plots of viewers."""

from __future__ import annotations

from pathlib import Path

from runtime.schemas import validate

from robosc import pipeline
from robosc.emit.package.model_document import model_document

MODEL = """
robot Cart {
    component Gauge {
        outgoing message distance with type: Distance
        outgoing message level with type: integer(0..9)
        outgoing message place with type: Place links place
        behaviour {
            variable last: Distance
            variable fill: integer(0..9)
            variable x: double
            variable near: boolean
            on response from distance do last := value
            on response from level if value != 9 do fill := value
            on response from place do x := value.inner.x, near := Way(value.inner.y) = close
            initial marked state on { transition if fill >= 8 goto full }
            marked state full {}
        }
    }
    component Drive {
        incoming message go with type: none
        incoming message halt with type: none
    }
    condition low = 2 > Gauge.fill
    requirement go needs Gauge.last = far and !low and Gauge.fill * 2 < 14
    requirement halt needs Gauge.x > -0.5 or Gauge.near
    datatype object Place { inner: Inner }
    datatype object Inner { x: double y: double }
    datatype enum Distance from double to { value > 1.5 -> far value > 0.5 -> near default -> touching }
    datatype enum Way from double to { value < 3 -> close default -> away }
    interface place use Place from some_msgs
}
"""


def test_thresholds_are_told_by_what_is_compared(tmp_path: Path) -> None:
    path = tmp_path / "cart.rscd"
    path.write_text(MODEL, encoding="utf-8")
    document = model_document(pipeline.supervise(pipeline.load(path).robot), path.name)
    assert document["thresholds"] == {
        "Gauge.fill": [2.0, 8.0],
        "Gauge.x": [-0.5],
        "distance.response": [0.5, 1.5],
        "level.response": [9.0],
        "place.response inner y": [3.0],
    }
    validate(document, "model")


def test_classes_of_very_many_comparisons_are_left_out(tmp_path: Path) -> None:
    """The outcomes of all comparisons for each class would take the square of their number."""
    path = tmp_path / "cart.rscd"
    for count, told in ((499, True), (500, False)):
        many = " or ".join(f"Gauge.x > {number}.5" for number in range(count))
        text = MODEL.replace("needs Gauge.x > -0.5 or Gauge.near", f"needs {many}")
        path.write_text(text, encoding="utf-8")
        document = model_document(pipeline.supervise(pipeline.load(path).robot), path.name)
        (x,) = [v for c in document["components"] for v in c["variables"] if v["name"] == "x"]
        assert ("classes" in x, "comparisons" in x) == (told, told)
        validate(document, "model")
