"""A large model that a person might have written, for measuring the front end.

Robots repeat themselves, so the model is a row of stations. Each has a sensor, a machine that works
on request, a light and a drive, tied together by requirements and provided data. Every component
costs :data:`LINES_PER_COMPONENT` lines, with the statements that go with it.
"""

from __future__ import annotations

__all__ = ["LINES_PER_COMPONENT", "large_model"]

LINES_PER_COMPONENT = 20

_SHARED = """\
    interface velocity use Twist from geometry_msgs
    interface switch use SetBool from std_srvs
    interface station use TestAction from actionlib

    datatype object Vector {
        x: double
        y: double
        z: double
    }

    datatype object Velocity {
        linear: Vector
        angular: Vector
    }

    datatype object Switch {
        data: boolean
    }

    datatype object Switched {
        success: boolean
    }

    datatype enum Distance from double to {
        value < 0.5 -> touching
        value >= 0.5 and value < 2 -> near
        default -> free
    }
"""

_SENSOR = """\
    // Station @: what stands in front of it, and how full it is
    component Sensor@ {
        outgoing message distance_@ with identifier: "/s@/distance", type: Distance
        outgoing message level_@ with identifier: "/s@/level", type: integer(0..9)
        outgoing message full_@ with identifier: "/s@/full", type: none

        behaviour {
            variable current: Distance = free
            variable level: integer(0..9) = 0

            initial marked state sensing {
                on response from distance_@ do current := value
                on response from level_@ if value >= 0 do level := value
                on response from full_@ do level := 9, current := touching
            }
        }
    }

    // The statements of the station follow its components.

"""

_MACHINE = """\
    component Machine@ {
        action start_@ with identifier: "/s@/start",
            request: none, response: none, feedback: none links station
        behaviour {
            initial marked state idle {
                on request to start_@ goto working
            }

            state working {
                on feedback from start_@ goto working
                on response from start_@ goto idle
                on error from start_@ goto idle
                on cancelled from start_@ goto idle
            }
        }
    }

    requirement start_@ needs Sensor@.current != touching
    requirement Sensor@.level * 2 + 1 > 15 or Sensor@.current = free disables start_@

"""

_LIGHT = """\
    component Light@ {
        service switch_@ with request: Switch, response: Switched links switch
        behaviour {
            variable lit: boolean = false
            initial marked state off {
                on request to switch_@ goto waiting
            }
            state waiting {
                on response from switch_@ do lit := value.success goto lighting
                on error from switch_@ goto off
            }
            marked state lighting {
                on request to switch_@ goto waiting
            }
        }
    }
    provide switch_@ with { data: true } if Light@.off
    provide switch_@ with { data: false } if !Light@.off and Sensor@.level = 0
    requirement switch_@ needs !(Light@.lit and Machine@.working)

"""

_DRIVE = """\
    component Drive@ {
        incoming message move_@ with identifier: "/s@/velocity", type: Velocity links velocity
        incoming message halt_@ with identifier: "/s@/velocity", type: Velocity links velocity
    }

    provide move_@ with {
        linear: { x: 0.4 },
        angular: { z: Sensor@.level / 10 - 0.5 }
    }
    provide halt_@ with {
        linear: { x: 0.0 },
        angular: { z: 0.0 }
    }

    // The drive works on its own way only, and rests while the machine turns
    // or something stands in front of it.
    requirement { move_@, start_@ } needs Sensor@.current = near or Light@.lit
    requirement Machine@.working or Sensor@.current = touching disables move_@
    requirement halt_@ needs Machine@.working => Sensor@.level >= 1

"""


def large_model(components: int) -> str:
    """A valid model with that many components; it need not be synthesisable."""
    kinds = (_SENSOR, _MACHINE, _LIGHT, _DRIVE)
    parts = [kinds[i % 4].replace("@", str(i // 4)) for i in range(components)]
    return "robot Plant {\n" + "".join(parts) + _SHARED + "}\n"
