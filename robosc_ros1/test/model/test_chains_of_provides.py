"""``provide a with A if E else with B …``: the first whose condition holds."""

from __future__ import annotations

from pathlib import Path

import pytest
from model.model_text import faults, resolve
from syntax_support import read

from robosc import pipeline

ROBOT = """
component Cart {
    outgoing message far with timeout: 1 s, type: double
    outgoing message all_of with timeout: 1 s, type: Spots links spots
    incoming message go with type: double
    behaviour {
        variable d: double
        variable s: Spots
        initial marked state rest {
            on response from far do d := value
            on response from all_of do s := value
            on request to go
        }
    }
}
datatype object Spots { x: array(double) }
interface spots use Spots from spot_msgs
"""


def test_it_means_that_those_before_do_not_hold() -> None:
    chain = resolve(
        f"{ROBOT} provide go with 1.0 if Cart.d > 2.0"
        " else with 0.5 if Cart.s.x[0] > 1.0 else with Cart.d"
    )
    apart = resolve(
        f"{ROBOT} provide go with 1.0 if Cart.d > 2.0"
        " provide go with 0.5 if !(Cart.d > 2.0) and Cart.s.x[0] > 1.0"
        " provide go with Cart.d if !(Cart.d > 2.0) and (!(Cart.s.x[0] > 1.0) else true)"
    )
    assert [p.data for p in chain.provides] == [p.data for p in apart.provides]
    assert chain.provides[:2] == apart.provides[:2]


def test_no_overlap_is_told(tmp_path: Path) -> None:
    path = tmp_path / "cart.rscd"
    text = f"{ROBOT} requirement go needs far.fresh and all_of.fresh stop with go"
    chain = "provide go with 1.0 if Cart.d > 2.0 else with 0.5 if Cart.d > 1.0 else with 0.0"
    path.write_text(f"robot R {{ {text} {chain} }}", encoding="utf-8")
    assert [d.code for d in pipeline.check(path).diagnostics if "provide" in d.code] == []
    apart = chain.replace("else with 0.5", "provide go with 0.5").replace("else with 0.0", "")
    path.write_text(f"robot R {{ {text} {apart} }}", encoding="utf-8")
    told = {d.code for d in pipeline.check(path).diagnostics}
    assert {"provide-overlap", "provide-missing"} <= told


@pytest.mark.parametrize(
    "statement",
    [
        "provide go with 1.0 else with 2.0",
        "provide go with 1.0 if Cart.d > 1.0 else with 2.0 else with 3.0 if Cart.rest",
        "provide go with 1.0 if Cart.d > 1.0 else 2.0",
        "provide go with 1.0 if Cart.d > 1.0 else with",
    ],
)
def test_faults(statement: str) -> None:
    assert [code for code, _ in faults(f"{ROBOT} {statement}")] != []


def test_errors_of_the_command_are_told_once() -> None:
    found = faults(f"{ROBOT} provide gone with 1.0 if Cart.d > 1.0 else with 2.0")
    assert [code for code, _ in found if code.startswith("unknown")] == ["unknown-communication"]


def test_else_in_a_condition_is_the_operator() -> None:
    text = "provide go with 1.0 if (Cart.d else 2.0) > 1.0 else with Cart.d else 3.0"
    node, diagnostics = read(f"robot R {{ {text} }}")
    assert not diagnostics
    assert node is not None
