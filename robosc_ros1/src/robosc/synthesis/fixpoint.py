"""Supervisory control synthesis: what the controller may keep the robot in.

Of the states that the plant reaches, the supervisor keeps the largest set that is

*safe*
    no state violates a requirement on states, or is one in which a variable would leave its range;
*controllable*
    no uncontrollable event leads out of it;
*nonblocking*
    from each state a marked state can be reached inside it;
*always possible*
    what must remain possible can be reached inside it, from the states in which that is asked.

Such sets are closed under union, so there is a largest one; it is found by removing states until
nothing changes. P. J. Ramadge and W. M. Wonham, "Supervisory control of a class of discrete event
processes", SIAM J. Control and Optimization 25(1), 1987; for automata with variables L. Ouedraogo,
R. Kumar, R. Malik and K. Akesson, "Nonblocking and safe control of discrete-event systems modeled
as extended finite automata", IEEE Trans. Automation Science and Engineering 8(3), 2011; for several
things that must remain possible M. H. de Queiroz, J. E. R. Cury and W. M. Wonham, "Multitasking
supervisory control of discrete-event systems", Discrete Event Dynamic Systems 15(4), 2005.

The engines differ in how they hold sets: as numbers of states
(:mod:`robosc.synthesis.explicit`), or decision diagrams (:mod:`robosc.synthesis.bdd`).
"""

from __future__ import annotations

from typing import Protocol, TypeVar

States = TypeVar("States")


class SynthesisSets(Protocol[States]):
    """Sets of states of one plant. A function may change the first set that it gets."""

    def reachable(self) -> States:
        """Return the states that the plant reaches."""

    def safe(self, states: States) -> States:
        """Return those that violate no requirement and in which no variable leaves its range."""

    def controllable(self, states: States, before: States) -> States:
        """Return the largest subset that uncontrollable events do not leave.

        ``before`` is such a set of which ``states`` are what was left, or all that is reachable.
        """

    def nonblocking(self, states: States) -> States:
        """Return the states from which a marked state can be reached inside the set."""

    def reaching_goals(self, states: States) -> States:
        """Return the states of a nonblocking set from which, inside the set, what must remain
        possible there can be reached."""

    def same(self, states: States, subset: States) -> bool:
        """Whether a subset is the whole set."""

    def has_start(self, states: States) -> bool:
        """Whether all initial states are in the set."""


def supremal(sets: SynthesisSets[States]) -> tuple[States, bool]:
    """Return the largest set that is all of this, and whether the robot may start.

    If it may not, the fixpoint ends early: the set is then one that contains the largest one.
    """
    good = sets.reachable()
    good = sets.controllable(sets.safe(good), good)
    while sets.has_start(good):
        left = sets.nonblocking(good)
        if sets.same(good, left):
            left = sets.reaching_goals(good)
        if sets.same(good, left):
            return good, True
        good = sets.controllable(left, good)
    return good, False
