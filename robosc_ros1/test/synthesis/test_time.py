"""Silence and waiting in the plant: messages with a timeout, and ``after``."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from random_models import random_model
from synthesis.differential import differences
from synthesis.oracle import Oracle
from synthesis.subject import SUBJECTS, Subject, robot_of, steps
from synthesis.test_oracle_differential import SMALL, engines

from robosc import pipeline
from robosc.expr.tree import Literal
from robosc.expr.types import DoubleType
from robosc.language.events import EventKind, Kind
from robosc.model.automata import Behaviour, State, Transition
from robosc.model.entities import Component, Preference, Robot

subjects = pytest.mark.parametrize("subject", SUBJECTS, ids=lambda s: s.__name__)
SECOND = Literal(1.0, DoubleType())


def plant(subject: type[Subject], text: str) -> list[str]:
    return steps(subject("robot R {" + text + "}").explore(plant=True))


def same(found: list[str], expected: str) -> None:
    assert found == sorted(line.strip() for line in expected.strip().splitlines())


@subjects
def test_a_message_is_silent_until_it_comes_and_after_its_timeout(subject: type[Subject]) -> None:
    same(
        plant(subject, "component A { outgoing message m with timeout: 500 ms, type: none }"),
        """
        silent --m.response--> fresh
        fresh --m.response--> fresh
        fresh --m.timeout--> silent
        """,
    )


@subjects
def test_components_react_to_silence_and_requirements_read_it(subject: type[Subject]) -> None:
    text = """
        component A {
            outgoing message m with timeout: 0.5 s, type: none
            incoming message go with type: none
            behaviour {
                initial marked state seeing { on timeout from m goto blind }
                marked state blind { on response from m goto seeing }
            }
        }
        requirement go needs m.fresh
    """
    found = steps(subject("robot R {" + text + "}").explore(plant=False))
    same(
        found,
        """
        seeing silent --m.response--> seeing fresh
        seeing fresh --m.response--> seeing fresh
        seeing fresh --m.timeout--> blind silent
        seeing fresh --go.request--> seeing fresh
        blind silent --m.response--> seeing fresh
        """,
    )


@subjects
def test_time_passes_wherever_it_is_waited_for(subject: type[Subject]) -> None:
    text = """
        component A {
            outgoing message m with type: boolean
            behaviour {
                variable ready: boolean
                variable rounds: integer(0..1)
                on response from m do ready := value
                initial marked state one {
                    after 2 s if ready do rounds := 1 - rounds goto two
                    after 1 min goto one
                }
                marked state two { on response from m goto one }
            }
        }
        requirement never A.rounds = 1 and A.one and false
    """
    found = [line for line in plant(subject, text) if "A.after" in line or "A: " in line]
    same(
        found,
        """
        one false 0 --A.after2(one->one)--> one false 0
        one true 0 --A.after1(one->two)--> two true 1
        one true 0 --A.after2(one->one)--> one true 0
        one false 1 --A.after2(one->one)--> one false 1
        one true 1 --A.after1(one->two)--> two true 0
        one true 1 --A.after2(one->one)--> one true 1
        """,
    )


def with_time(robot: Robot, rng: random.Random) -> Robot:
    """The robot with timeouts, reactions to them and states that are left after some time."""
    watched = [
        c.key
        for c in robot.communications.values()
        if c.kind is Kind.OUTGOING and rng.random() < 0.7
    ]
    commands = [c.key for c in robot.communications.values() if c.kind is not Kind.OUTGOING]
    rng.shuffle(commands)
    order = [(a, b) for n, a in enumerate(commands) for b in commands[n + 1 :]]
    return replace(
        robot,
        components=tuple(_component(c, watched, rng) for c in robot.components),
        preferences=tuple(
            Preference((a,), (b,), span=robot.span) for a, b in order if rng.random() < 0.3
        ),
    )


def _component(component: Component, watched: list[str], rng: random.Random) -> Component:
    communications = tuple(
        replace(c, timeout=SECOND) if c.key in watched else c for c in component.communications
    )
    behaviour = component.behaviour
    if behaviour is not None:
        behaviour = _behaviour(component.name, behaviour, watched, rng)
    return replace(component, communications=communications, behaviour=behaviour)


def _behaviour(
    name: str, behaviour: Behaviour, watched: list[str], rng: random.Random
) -> Behaviour:
    targets: list[str | None] = [None, *(s.name for s in behaviour.states)]
    index = 0

    def reaction(event: EventKind, key: str) -> Transition:
        guard = None
        if event is EventKind.AFTER and rng.random() < 0.4:
            taus = (*behaviour.taus, *(tau for s in behaviour.states for tau in s.taus))
            guards = [t.guard for t in taus if t.guard is not None]
            guard = rng.choice(guards) if guards else None
        return Transition(event, key, guard, (), rng.choice(targets), span=behaviour.span)

    def state(old: State) -> State:
        nonlocal index
        more = tuple(reaction(EventKind.TIMEOUT, k) for k in watched if rng.random() < 0.3)
        afters = []
        while rng.random() < 0.3:
            index += 1
            delayed = reaction(EventKind.AFTER, name)
            afters.append(replace(delayed, index=index, delay=SECOND))
        return replace(old, transitions=(*old.transitions, *more, *afters))

    everywhere = tuple(reaction(EventKind.TIMEOUT, k) for k in watched if rng.random() < 0.2)
    return replace(
        behaviour,
        states=tuple(map(state, behaviour.states)),
        transitions=(*behaviour.transitions, *everywhere),
    )


@pytest.mark.timeout(0)
@pytest.mark.slow
@engines
def test_random_robots_with_time(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    seen = set()
    for seed in range(first, first + (12 if count is None else count)):
        rng = random.Random(seed)
        robot = with_time(robot_of(random_model(rng, 1 + seed % 2)), rng)
        oracle = Oracle(robot)
        if count is None and not oracle.has_at_most(SMALL):
            continue
        found = differences(robot, oracle, engine)
        assert not found, "\n".join([f"seed {seed}, engine {engine}", *found[:20]])
        seen |= {event.kind for event in oracle.events}
    assert {EventKind.TIMEOUT, EventKind.AFTER} <= seen


def test_a_preferred_command_can_keep_the_other_from_ever_coming_home() -> None:
    """Synthesis may wait with ``stay``; the controller sends it as long as it is enabled."""
    text = """
        robot R {
            component A {
                incoming message stay with type: none
                incoming message home with type: none
                behaviour {
                    initial state away { on request to stay on request to home goto there }
                    marked state there { on request to home goto there }
                }
            }
            prefer stay over home
        }
    """
    robot = robot_of(text)
    found = dict(pipeline.synthesize(robot).properties)
    assert found["nonblocking under control"] is False
    assert Oracle(robot).properties()["nonblocking under control"] is False
    unordered = replace(robot, preferences=())
    assert dict(pipeline.synthesize(unordered).properties)["nonblocking under control"] is True
