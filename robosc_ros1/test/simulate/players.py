"""Sessions over the line follower and over random models."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from emit.generated_code import supervisor_of
from ros_support import EXAMPLES

from robosc.simulate.script.session import Done, Session
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor

MODEL = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"

SEVERAL_TYPES = """\
robot Types {
    interface pose use Pose from nowhere_msgs
    datatype object Pose { position: Point tags: array(integer(0..2)) label: string }
    datatype object Point { x: double side: Side }
    datatype enum Side from integer to { value < 0 -> left value > 0 -> right default -> middle }
    component Sensor {
        outgoing message pose with type: Pose links pose
        outgoing message level with type: integer(0..3)
        incoming message go with type: double
        behaviour {
            variable side: Side
            variable tag: integer(0..2)
            variable level: integer(0..3)
            variable x: double
            on response from pose do
                side := value.position.side, tag := value.tags[0], x := value.position.x
            on response from level do level := value
            initial marked state quiet { transition if level = 3 goto loud }
            marked state loud { transition if level < 3 goto quiet }
        }
    }
    requirement go needs Sensor.side = left and Sensor.tag = 1
    provide go with Sensor.x * 2
}
"""
"""An object with an enum and an array in it, a range, internal transitions of a component, data-only values."""


def line_follower() -> Supervisor:
    return supervisor_of(MODEL.read_text(), str(MODEL))


def session(
    supervisor: Supervisor, *, execute: bool = False, parameters: Mapping[str, Any] | None = None
) -> Session:
    return Session(machine_maker(supervisor, execute=execute), parameters)


def play(player: Session, *lines: str) -> Done:
    """Do lines; what the last one did."""
    done = Done()
    for line in lines:
        done = player.do(line)
    return done


def sent(done: Done) -> list[str]:
    return [h.name for h in done.happenings if h.kind == "request" and h.outcome == "applied"]
