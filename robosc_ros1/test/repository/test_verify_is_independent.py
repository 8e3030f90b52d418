"""What verification shares with the engines is what its documentation says, and no more."""

from __future__ import annotations

from functools import cache

from repository.test_imports import MODULES, loaded, module_name

VERIFY = "synthesis.verify."
SHARED = {
    "synthesis.bdd.manager",  # the BDD library
    "synthesis.bdd.memory",  # the manager's limit
    "synthesis.bdd.order",  # the order of the variables, which no result depends on
    "synthesis.bdd.rounds",  # its direction
    "synthesis.bdd.sources",  # what it brings together
    "synthesis.time_limit",  # how long verification may take
    "synthesis.formatting",  # texts of events
}


@cache
def needs() -> dict[str, set[str]]:
    return {module_name(file): loaded(file) for file in MODULES}


def test_verification_uses_only_what_it_says_of_synthesis() -> None:
    """Also by way of other modules; what verify imports when it is called is counted, too."""
    found: set[str] = set()
    left = {name for name in needs() if name.startswith(VERIFY)}
    while left:
        found |= left
        left = {m for n in left for m in needs()[n] & needs().keys() if m.startswith("synthesis.")}
        left -= found
    assert {name for name in found if not name.startswith(VERIFY)} == SHARED


def test_engines_do_not_take_the_effect_of_an_event_from_its_definition() -> None:
    for name, modules in needs().items():
        if name.startswith(("synthesis.dense.", "synthesis.bdd.")):
            assert not modules & {
                "plant.step.outcome",
                "plant.step.taken_edge",
                "plant.step.lookup",
            }, name
