"""An object where a number is needed: the hint names the one field that fits."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ros_support import Completed

MODEL = """
robot R {
    datatype object Wrapped { data: double }
    datatype object Point { x: double y: double }
    component Gas {
        outgoing message gas with type: Wrapped
        outgoing message place with type: Point
        behaviour {
            variable level: double
            initial marked state on {
                on response from gas do level := value
                on response from place do level := value
            }
        }
    }
}
"""


def test_the_only_field_that_fits_is_named(
    robosc: Callable[..., Completed], tmp_path: Path
) -> None:
    (tmp_path / "r.rscd").write_text(MODEL, encoding="utf-8")
    told = robosc("check", "r.rscd").stderr
    assert "^^^^^ write 'value.data'\n" in told
    assert told.count("type-mismatch") == 2
    assert "value.x" not in told
