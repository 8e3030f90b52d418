"""One small model for each section of the language, for all verbs and modes."""

from __future__ import annotations

_BASE = """
    component Base {
        incoming message drive with identifier: "/v", type: double
        incoming message halt with identifier: "/v", type: double
    }
    provide drive with 0.2
    provide halt with 0.0
    stop with halt
"""
_GOAL = "interface goal use Go from some_msgs interface ask use Ask from some_msgs"

CONSTRUCTS = {
    "messages": """
        component Eye {
            outgoing message near with type: boolean
            behaviour {
                variable seen: boolean
                initial marked state on { on response from near do seen := value }
            }
        }
        requirement drive needs !Eye.seen
        requirement halt needs Eye.seen
    """,
    "numbers decide": """
        component Battery {
            outgoing message battery with timeout: 1 s, type: double
            behaviour {
                variable charge: double = 1.0
                initial marked state on { on response from battery do charge := value }
            }
        }
        requirement drive needs battery.fresh and Battery.charge > 0.2
        prefer drive over halt
    """,
    "strings and enums": """
        datatype enum Way from integer to { value = 1 -> left value = 2 -> right default -> ahead }
        component Eye {
            outgoing message way with timeout: 1 s, type: integer
            outgoing message name with type: string
            behaviour {
                variable way: Way
                variable name: string
                initial marked state on {
                    on response from way do way := Way(value)
                    on response from name do name := value
                }
            }
        }
        requirement drive needs Eye.way in { left, right } and Eye.name != "stop"
    """,
    "time": """
        component Eye {
            outgoing message scan with timeout: 1 s, type: none
            behaviour {
                initial marked state off { on response from scan goto on }
                marked state on { on timeout from scan goto off after 2 s goto off }
            }
        }
        condition steady = Eye.on for 300 ms
        requirement drive needs scan.fresh and steady
    """,
    "names for values": """
        constant most: double = 2.0
        parameter limit: double = 0.5
        condition slow = Eye.speed < limit
        function half(x: double): double = x / most
        component Eye {
            outgoing message speed with timeout: 1 s, type: double
            behaviour {
                variable speed: double
                initial marked state on { on response from speed do speed := half(value) }
            }
        }
        requirement drive needs slow and speed.fresh
    """,
    "what stays": """
        component Tour {
            outgoing message arrived with timeout: 1 s, type: none
            behaviour {
                persistent variable next: integer(0..2) = 0
                persistent variable asked: boolean = true
                initial marked state on {
                    on response from arrived if next < 2 do next := next + 1
                    on request to halt do asked := false
                }
            }
        }
        requirement drive needs Tour.next < 2 and arrived.fresh
        requirement halt needs Tour.asked
    """,
    "transforms": """
        component Eye {
            outgoing transform dock with from: "base", to: "dock", timeout: 1 s, max_age: 1 s
            outgoing transform pose with to: "/base", from: "map", rate: 5 Hz
            behaviour {
                variable away: double
                variable turned: double
                initial marked state on {
                    on response from dock do away := abs(value.transform.translation.x)
                    on response from pose do turned := yaw(value.transform.rotation)
                }
            }
        }
        requirement drive needs dock.fresh and Eye.away > 0.5
        requirement halt needs Eye.away < 2.0 or pose.heard
    """,
    "arrays": """
        datatype object Scan { ranges: array(double) step: double }
        interface scans use Scan from some_msgs
        component Eye {
            outgoing message scan with timeout: 1 s, type: Scan links scans
            behaviour {
                variable front: double
                variable rays: array(double)
                initial marked state on {
                    on response from scan
                        do front := min(r for r in value.ranges[0..3] if r > 0.1) else 0.0,
                            rays := value.ranges
                }
            }
        }
        requirement drive needs scan.fresh and Eye.front > 0.4
        requirement halt needs count(r < 1.0 for r in Eye.rays) < 3
    """,
    "several of a kind": """
        component Station[1..3] {
            outgoing message call with identifier: "/call_{index}", type: none
            incoming message ring with identifier: "/ring_{index}", type: none
            behaviour {
                initial marked state idle { on response from call goto waiting }
                marked state waiting { on request to ring goto idle }
            }
        }
        requirement drive needs !any(s.waiting for s in Station)
        for i in 1..2 { prefer Station[i].ring over Station[i+1].ring }
    """,
    "data of commands": """
        component Base2 {
            incoming message move with identifier: "/move", type: double
            behaviour {
                initial marked state slow { on request to move if value > 0.5 goto fast }
                marked state fast { on request to move if value <= 0.5 goto slow }
            }
        }
        provide move with 0.7 if Base2.slow
        provide move with 0.3
        requirement move needs value < 1.0
    """,
    "services and actions": _GOAL
    + """
        component Arm {
            outgoing message tired with timeout: 1 s, type: boolean
            action go with within: 60 s, expect: value, request: none, response: boolean,
                feedback: integer links goal
            service open with request: none, response: boolean links ask
            behaviour {
                variable is_tired: boolean
                on response from tired do is_tired := value
                initial marked state idle { on request to go goto busy on request to open goto opening }
                state busy {
                    on response from go goto idle
                    on error from go if reason = refused goto idle
                    on error from go else goto idle
                    on cancelled from go goto idle
                }
                state opening { on response, error from open goto idle }
            }
        }
        requirement go needs !Arm.is_tired and tired.fresh
        requirement open needs go.idle to start
    """,
    "replaced goals": _GOAL
    + """
        component Arm {
            outgoing message x with timeout: 1 s, type: double
            action go with goals: replace, request: double, response: none, feedback: none links goal
            behaviour {
                variable to_: double
                initial marked state here { on response from x do to_ := value }
            }
        }
        provide go with Arm.to_
        requirement go needs x.fresh
    """,
    "groups": """
        component Stop {
            outgoing message stop with timeout: 1 s, type: boolean
            behaviour {
                variable down: boolean = true
                initial marked state on { on response from stop do down := value }
            }
            condition released = stop.fresh and !down
            requirement all except halt needs Stop.released
        }
        prefer halt over all
        requirement halt needs Stop.down
    """,
    "states that perform": _GOAL
    + """
        component Mission {
            outgoing message low with type: boolean
            action go with request: none, response: none, feedback: none links goal
            action dock with request: none, response: none, feedback: none links goal
            service lamp with request: none, response: none links ask
            behaviour {
                variable is_low: boolean
                on response from low do is_low := value
                initial marked state working {
                    initial marked state driving performs go then {
                        transition if is_low goto docking
                        retry 2 times every 1 s else goto docking
                    }
                    state docking performs dock then goto shining { retry goto docking }
                    state shining performs lamp meanwhile then goto driving
                }
            }
        }
    """,
    "heard and ages": """
        component Eye {
            outgoing message lamp with type: boolean
            behaviour {
                variable lit: boolean
                initial marked state on { on response from lamp do lit := value }
            }
        }
        requirement drive needs lamp.heard and !Eye.lit
    """,
    "titles and first data that hold": """
        parameter far: double(0.1..2.0) = 0.5
        datatype object Spot { x: double y: double }
        interface spot use Point from geometry_msgs
        function spot(x: double): Spot = { x: x, y: far }
        component Gate[1..2] {
            incoming message at with type: Spot links spot
            behaviour {
                initial marked state closed if index = 1 { on request to at goto opened }
                initial marked state opened if index > 1 { on request to at goto closed }
            }
        }
        component Eye {
            outgoing message near with type: double, timeout: 1 s
            behaviour {
                variable d: double
                initial marked state on { on response from near do d := value }
            }
        }
        requirement "SR-1 only what is seen" {
            drive needs near.fresh and far < 3.0
            halt needs Gate[1].closed or Gate[1].opened
        }
        assume "A-1 sensor" near needs value >= 0.0
        prefer "P-1 drive first" drive over halt
        provide Gate[1].at with spot(1.0) if Eye.d > far else with spot(2.0) if Eye.d > 0.2
            else with { x: 3.0 }
        provide Gate[2].at with spot(4.0)
    """,
    "always possible": """
        component Eye {
            outgoing message near with type: none
            behaviour {
                initial marked state far { on response from near goto close }
                marked state close { transition goto away }
                marked state away { on request to halt goto far }
            }
        }
        requirement possible Eye.far from Eye.away while !Eye.close
        requirement never Eye.close and Eye.far
    """,
    "assumptions": """
        component Eye {
            outgoing message level with type: integer(0..3)
            behaviour {
                variable level: integer(0..3)
                initial marked state on { on response from level do level := value }
            }
        }
        assume level needs value != 3
        assume never Eye.level = 2 and Eye.on
        requirement drive needs Eye.level < 3
    """,
    "served calls": _GOAL
    + """
        component Fleet {
            outgoing action order with request: integer, response: none, feedback: integer links goal
            outgoing service reset with request: none, response: none links ask
            behaviour {
                variable number: integer
                initial marked state free {
                    on request from order if value > 0 do number := value goto busy
                    on request from reset goto resetting
                }
                state resetting { on response to reset goto free }
                state busy { on response to order goto free on cancel from order goto over }
                state over { on error to order goto free }
            }
        }
        provide order.feedback with Fleet.number
        requirement drive needs !order.busy
    """,
}
"""What each construct adds to a base that drives and halts."""

WHOLE = {
    "libraries": """
        component Emergency from EStop import Button with prefix: "/left"
        component Wheel from Velocity import Base with prefix: "/right"
        stop with Wheel.halt
        provide Wheel.drive with { linear: { x: Velocity.limited(1.0, Wheel.most) } }
    """,
    "commands judged by their data": """
        component Eye {
            outgoing message near with timeout: 1 s, type: boolean
            behaviour {
                variable seen: boolean
                initial marked state on { on response from near do seen := value }
            }
        }
        component Base { incoming message drive with identifier: "/v", type: double }
        requirement drive needs value <= 0.5 and near.fresh and (Eye.seen => value <= 0.0)
        stop with drive
    """,
    "commands corrected": """
        datatype object Speeds { linear: Axes angular: Axes }
        datatype object Axes { x: double z: double }
        interface speeds use Twist from geometry_msgs
        component Eye {
            outgoing message limit with timeout: 1 s, type: double
            behaviour {
                variable limit: double
                initial marked state on { on response from limit do limit := value }
            }
        }
        component Base { incoming message drive with identifier: "/v", type: Speeds links speeds }
        provide drive with { linear: { x: min(value.linear.x, 0.1) } } if limit.fresh and Eye.limit < 1.0
        provide drive with { linear: { x: min(value.linear.x, 0.5) } }
        stop with drive
    """,
}
"""Whole models: of libraries, and of what mostly supervisors say."""


def model(construct: str) -> str:
    """The text of a model."""
    if construct in WHOLE:
        return f"robot Small {{ {WHOLE[construct]} }}"
    return f"robot Small {{ {_BASE} {CONSTRUCTS[construct]} }}"
