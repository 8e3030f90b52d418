"""Pictures: what is drawn, and that graphviz can draw it."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
from xml.etree import ElementTree

import pytest
from nested_models import PARTS
from random_models import random_model
from synthesis.subject import robot_of

from robosc.emit.export.dot import dot_text, svg_text
from robosc.emit.export.export import exported
from robosc.errors import UsageError
from robosc.plant.build import lower

DOOR = """
robot House {
    component Door {
        incoming message go with type: none
        outgoing message moved with type: boolean
        behaviour {
            variable locked: boolean = true
            variable open: boolean
            on response from moved do open := value
            initial marked state shut {
                on request to go if !locked goto busy
                transition if   locked
                    and !open goto busy
            }
            state busy { on request to go goto shut }
        }
    }
    component Motor {}
    requirement go needs Door.open
}
"""

needs_graphviz = pytest.mark.skipif(shutil.which("dot") is None, reason="graphviz is not installed")


def statements(text: str) -> list[str]:
    return [line.strip() for line in text.splitlines()]


def test_automaton_as_it_is_drawn() -> None:
    text = dot_text(robot_of(DOOR))
    start, end = text.index('  subgraph "cluster Door"'), text.rindex("}")
    assert statements(text[start:end]) == [
        'subgraph "cluster Door" {',
        'label="Door"; color=gray;',
        '"Door.shut" [label="shut", peripheries=2];',
        '"Door.shut start" [shape=point, width=0.08, label=""];',
        '"Door.shut start" -> "Door.shut";',
        '"Door.busy" [label="busy", peripheries=1];',
        '"Door in every state" [label="in every state", shape=plaintext];',
        '"Door.shut" -> "Door.busy" [label="go.request\\n[!locked]\\n[locked and !open]",'
        " style=solid];",
        '"Door.busy" -> "Door.shut" [label="go.request", style=solid];',
        '"Door in every state" -> "Door in every state"'
        ' [label="moved.response\\nopen := value", style=dashed];',
        "}",
    ]


def test_controlled_system_is_drawn_while_it_is_small() -> None:
    text = exported(lower(robot_of(DOOR)), "dot")
    assert '"cluster controlled system: 4 states"' in text
    assert (
        '"state 0" [label="Door.shut\\nDoor.locked = true\\nDoor.open = false", peripheries=2];'
        in statements(text)
    )


SWITCH = """
robot Switch {
    component Lamp {
        outgoing message level with type: sensor_msgs/Range
        behaviour {
            initial marked state off {
                transition if level.heard goto lit
            }
            state lit {
                on response from level if value.range > 2.0 goto off
                initial state low { transition if level.heard goto high transition else goto off }
                state high { after 2 s goto low }
            }
        }
    }
}
"""


def test_arrows_have_the_words_of_the_model() -> None:
    text = exported(lower(robot_of(SWITCH)), "dot")
    assert '"Lamp.lit.low start" -> "Lamp.lit.low";' in statements(text)
    assert '"Lamp.lit.low" -> "Lamp.off" [label="[else]", style=solid];' in statements(text)
    labels = {word for label in re.findall(r'-> "state .*label="(.*?)"', text)
              for word in label.split("\\n")}  # fmt: skip
    assert labels == {
        "level.response(range > 2.0)", "level.response(!(range > 2.0))",
        "Lamp: off->lit.low", "Lamp: lit.low->lit.high", "Lamp: lit.high->lit.low",
    }  # fmt: skip


RETRYING = """
initial marked state idle { on response from near goto going }
state going performs go then goto idle {
    on error from go if last and !go.cancelling goto idle
    retry 2 times goto resting else goto idle
}
state resting { after 1 s goto going }
"""


def test_retries_are_told_by_their_count_alone() -> None:
    """That they are about goals that nobody cancelled goes without saying; what is written stays."""
    text = dot_text(robot_of(f"robot Test {{ {PARTS % RETRYING} }}"))
    (resting,) = re.findall(r'"P.going" -> "P.resting" \[label="(.*?)"', text)
    assert resting == r"go.error\n[!(P.last and !go.cancelling) and P.going.retries < 2]"
    (idle,) = re.findall(r'"P.going" -> "P.idle" \[label="(.*?)"', text)
    assert r"go.error\n[P.last and !go.cancelling]" in idle


COUNTER = """
robot Counter {
    component Counter {
        incoming message up with type: none
        behaviour {
            variable n: integer(0..LAST)
            initial marked state only { on request to up do n := n + 1 }
        }
    }
    requirement always Counter.n >= 0
}
"""


def test_controlled_system_of_many_states_is_left_out() -> None:
    assert "cluster controlled" in exported(lower(robot_of(COUNTER.replace("LAST", "39"))), "dot")
    assert "cluster controlled" not in exported(
        lower(robot_of(COUNTER.replace("LAST", "40"))), "dot"
    )


@needs_graphviz
def test_picture_shows_every_state() -> None:
    picture = ElementTree.fromstring(svg_text(dot_text(robot_of(DOOR))))
    texts = {element.text for element in picture.iter("{http://www.w3.org/2000/svg}text")}
    assert {"Door", "shut", "busy", "in every state", "go.request"} <= texts


@pytest.mark.slow
@needs_graphviz
def test_graphviz_reads_every_random_robot() -> None:
    for seed in range(40):
        text = exported(lower(robot_of(random_model(random.Random(seed), 2))), "dot")
        done = subprocess.run(["dot", "-Tcanon"], input=text, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, ""), text


def test_picture_without_graphviz_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(UsageError, match="apt install graphviz"):
        svg_text("digraph {}")
