"""Small models for tests of the command line, each with a sentence that says what it is."""

from __future__ import annotations

GOOD = """\
robot Lamp {
    interface light use SetBool from std_srvs
    datatype object LightRequest { data: boolean }
    component Bulb {
        outgoing message dark with identifier: "/dark", timeout: 1 s, type: boolean
        service switch_light with request: LightRequest, response: none links light
        behaviour {
            variable is_dark: boolean
            variable lit: boolean
            on response from dark do is_dark := value
            initial marked state idle {
                on request to switch_light do lit := is_dark goto busy
            }
            state busy {
                on response from switch_light goto idle
                on error from switch_light goto idle
            }
        }
    }
    requirement switch_light needs dark.fresh and Bulb.lit != Bulb.is_dark
    provide switch_light with { data: Bulb.is_dark }
}
"""
"""Without errors and warnings; 16 states under control."""

WITH_ERRORS = """\
robot Broken {
    component Motor {
        incoming message go with type: none
        behaviour {
            initial marked state idle { on request to goo goto idle }
        }
    }
    requirement go needs Motor.idel
}
"""
"""Two unknown names, in lines 5 and 8."""

EMPTY_SUPERVISOR = """\
robot Doomed {
    component Alarm {
        outgoing message ring with type: none
        behaviour {
            initial marked state calm { on response from ring goto wild }
            state wild { on response from ring goto wild transition if false goto calm }
        }
    }
}
"""
"""The alarm may ring at any time, and nothing ever leads back to a marked state."""

NEVER = """\
robot Stuck {
    interface work use Empty from std_srvs
    component Worker {
        service work_hard with request: none, response: none links work
        behaviour {
            initial marked state idle { on request to work_hard goto busy }
            state busy { on response from work_hard goto idle }
        }
    }
}
"""
"""The error of the service is not handled, so the service may never be called."""

LIBRARY = """\
library Parts {
    component Button {
        outgoing message pressed with type: none
    }
}
"""

LARGE = (
    "robot Large {\n"
    + "".join(
        f"""\
    component Sensor{i} {{
        outgoing message level{i} with timeout: 1 s, type: integer(0..3)
        behaviour {{
            variable last: integer(0..3)
            initial marked state on {{ on response from level{i} do last := value }}
        }}
    }}
    component Valve{i} {{ incoming message open{i} with type: none }}
    requirement open{i} needs level{i}.fresh and Sensor{i}.last = 3
"""
        for i in range(4)
    )
    + "}\n"
)
"""8^4 states: small for synthesis, and more than a low limit."""

WIDE = """\
robot Wide {
    component Meter {
        outgoing message level with type: integer(RANGE)
        incoming message go with type: none
        behaviour {
            variable last: integer(RANGE)
            initial marked state on { on response from level do last := value }
        }
    }
    requirement go needs Meter.last > 5
}
"""
"""Takes what comes in, whatever RANGE is."""
