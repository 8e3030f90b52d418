"""What a remedy adds to an indexed component means each copy itself, and mends all of them."""

from __future__ import annotations

import pytest
from model.model_text import resolve

from robosc import pipeline

DOORS = """
interface link use Work from some_package
component Door[1..2] {
    incoming message open with identifier: "/open{index}", type: none
    service shut with identifier: "/shut{index}", request: none, response: none links link
    outgoing message near with identifier: "/near{index}", type: none
    behaviour {
        variable n: integer(0..2)
        initial marked state closed { on request to open goto opened on request to shut goto asked }
        marked state opened { after 5 s AFTERdo n := n + 1 goto closed on request to shut }
        state asked { ERROR on response from shut goto closed on response from near NEARdo n := n + 1 }
    }
}
requirement Door[1].open needs Door[2].n < 2
requirement Door[2].open needs Door[1].n < 2
"""
WIDEN = "or widen the range of Door.n"
REMEDIES = {
    "ERROR": ("on error from shut goto closed", "add '{}' in state asked of Door"),
    "AFTER": ("if Door.n <= 1 ", f"add '{{}}' to 'after …' in state opened of Door, {WIDEN}"),
    "NEAR": (
        "if Door.n <= 1 ",
        f"add '{{}}' to 'on response from near' in state asked of Door, {WIDEN}",
    ),
}


def remedies(without: str) -> set[str]:
    text = DOORS
    for place, (added, _) in REMEDIES.items():
        text = text.replace(place, "" if place == without else added)
    return {str(e.remedy) for e in pipeline.synthesize(resolve(text)).explanations}


@pytest.mark.parametrize("lacking", REMEDIES)
def test_a_remedy_is_for_all_copies(lacking: str) -> None:
    added, remedy = REMEDIES[lacking]
    assert remedies(lacking) == {remedy.format(added.strip())}


def test_what_the_remedies_say_mends_all() -> None:
    assert remedies("") == set()
