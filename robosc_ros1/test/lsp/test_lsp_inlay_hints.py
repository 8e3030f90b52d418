"""The types of ROS that a text does not name."""

from __future__ import annotations

from lsp_support import open_text

from robosc.lsp.analysis import Workspace
from robosc.lsp.hover import inlay_hints

MODEL = """\
robot R {
    component Gate[1..2] {
        outgoing message level with type: double
        outgoing message shut with type: std_msgs/Bool
        incoming message open with identifier: "/open", type: none
        incoming message faulty with type: nothing
    }
}
"""


def test_the_messages_behind_basic_types() -> None:
    analysis = open_text(Workspace([]), "/r.rscd", MODEL)
    found = {text: span.text for span, text in inlay_hints(analysis, 0, len(MODEL))}
    assert found == {
        "std_msgs/Float32": "outgoing message level with type: double",
        "std_msgs/Empty": 'incoming message open with identifier: "/open", type: none',
    }


def test_only_those_that_are_asked_for() -> None:
    analysis = open_text(Workspace([]), "/r.rscd", MODEL)
    found = inlay_hints(analysis, 0, MODEL.index("outgoing message shut"))
    assert [text for _, text in found] == ["std_msgs/Float32"]
