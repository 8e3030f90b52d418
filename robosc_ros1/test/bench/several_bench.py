"""What several of a kind cost: reading a model of many copies, generating, synthesis of forty.

Targets: reading and generating are linear in the number of copies (at most 1.5 times the time for
each from 250 to 1,000), and the supervisor of 40 stations and a vehicle takes at most 10 s of processor time.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from robosc.emit.package import ros1_target
from robosc.expr.tree import TRUE
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.pipeline import collector_at_rest, synthesize
from robosc.plant.build import lower
from robosc.source import Source
from robosc.supervisor import Guard, Supervisor

STATIONS = """\
robot Line {{
    component Vehicle {{
        incoming message drive with type: none
        outgoing message arrived with type: none
        behaviour {{
            initial marked state standing {{ on request to drive goto driving }}
            state driving {{ on response from arrived goto standing }}
        }}
    }}
    component Station[1..{count}] {{
        outgoing message button with type: none
        service serve with request: none, response: none links empty
        behaviour {{
            initial marked state idle {{ on response from button goto waiting }}
            state waiting {{ on request to serve goto served }}
            state served {{
                on response from serve goto idle
                on error from serve goto waiting
            }}
        }}
    }}
    requirement drive needs !any(s.served for s in Station)
    for i in 1..{count} {{
        requirement Station[i].serve needs Vehicle.standing
    }}
    interface empty use Empty from std_srvs
}}
"""
BEFORE = STATIONS.replace("for i in 1..", "for i in 2..").replace(
    "needs Vehicle.standing", "needs !any(s.waiting for s in Station[1..i-1])"
)
"""Each station comes after all that stand before it."""
COPIES = (250, 500, 1_000)
GROWTH = 1.5
SYNTHESIS = 10.0


def robot_of(count: int, model: str = STATIONS) -> Robot:
    source = Source("line.rscd", model.format(count=count))
    with collector_at_rest():
        robot, _ = load(source, definitions=MessageDefinitions())
    assert robot is not None
    return robot


def supervisor_as_required(robot: Robot) -> Supervisor:
    """The supervisor where synthesis forbids no more than the requirements; its counts are not it."""
    plant = lower(robot)
    required = [(e, e.requirement or TRUE) for e in plant.events if e.controllable]
    guards = tuple(Guard(event, expr, expr, "as required") for event, expr in required)
    return Supervisor(plant, "none", 0.0, 1, 1, 1, guards, (), (), step_bound=1)


def seconds(work: Callable[[], object]) -> float:
    """Of the processor."""
    start = time.process_time()
    work()
    return time.process_time() - start


def main(arguments: list[str]) -> int:
    robot_of(2)  # what is read once for all
    print("ms for each copy of a station: to read it; the same where each looks at all before it;")
    print("to generate its code")
    reading, generating = {}, {}
    for count in COPIES:
        reading[count] = min(seconds(lambda n=count: robot_of(n)) for _ in range(3)) / count
        before = seconds(lambda n=count: robot_of(n, BEFORE)) / count
        supervisor = supervisor_as_required(robot_of(count))
        generating[count] = seconds(lambda s=supervisor: ros1_target.emit(s, "line")) / count
        times = reading[count], before, generating[count]
        print(f"  {count:6,} " + " ".join(f"{1000 * time:6.3f}" for time in times))
    robot = robot_of(40)
    synthesis = seconds(lambda: synthesize(robot))
    print(f"synthesis of 40 stations and a vehicle: {synthesis:.1f} s (target {SYNTHESIS:g})")
    grown = any(each[COPIES[-1]] > GROWTH * each[COPIES[0]] for each in (reading, generating))
    return int(grown or synthesis > SYNTHESIS)
