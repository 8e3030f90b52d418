"""Each clause of the semantics on a robot small enough to be worked out by hand.

The expected systems were written down from the documents, step by step; the oracle and the engine
must both give them. A state is written as its values in order (components, variables,
communications), a step as ``state --event--> state``.
"""

from __future__ import annotations

from synthesis.subject import Subject, steps

LINK = "interface link use Thing from some_robot_msgs\n"


def of_robot(subject: type[Subject], text: str) -> Subject:
    return subject("robot R {" + LINK + text + "}")


def plant(subject: type[Subject], text: str) -> list[str]:
    return steps(of_robot(subject, text).explore(plant=True))


def controlled(subject: type[Subject], text: str) -> list[str]:
    return steps(of_robot(subject, text).explore(plant=False))


def same(found: list[str], expected: str) -> None:
    assert found == sorted(line.strip() for line in expected.strip().splitlines())
