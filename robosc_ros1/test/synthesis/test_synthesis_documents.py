"""The JSON documents of synthesize and explore, as CLI users get them."""

from __future__ import annotations

import json
import random
from typing import Any

import families
import pytest
import steep_families
from random_models import random_model
from synthesis.explored import explore_document, spelled_out
from synthesis.plants import plant_of, supervisor_of

from robosc import report
from robosc.errors import StateSpaceError
from robosc.synthesis import explore
from robosc.synthesis.documents import explore_json, synthesize_document
from robosc.synthesis.verify.verification import verify

BODY = """
    datatype enum Colour from integer to { value = 1 -> red default -> blue }
    datatype object Thing { kind: Colour inner: Inner list: array(Inner) }
    datatype object Inner { good: boolean }
    component A {
        outgoing message seen with type: Thing links link
        service act with request: none, response: boolean links link
        behaviour {
            variable c: Colour = blue
            variable g: boolean
            variable h: boolean
            initial marked state idle {
                on request to act goto busy
                on response from seen do c := value.kind, g := value.inner.good,
                    h := value.list[0].good
            }
            state busy {
                on response from act if value goto done
                on response from act if !value goto idle
                on error from act goto idle
            }
            state done { transition goto idle }
        }
    }
    requirement act needs A.c = red and A.g and !A.h
"""


def document(plant: bool = False) -> dict[str, Any]:
    system = plant_of(BODY) if plant else supervisor_of(BODY)
    found = explore_document(explore(system))
    json.dumps(found)
    return found


def events(found: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    shown = [t["event"] for t in found["transitions"] if t["event"]["kind"] == kind]
    return [dict(e) for e in {json.dumps(e): e for e in shown}.values()]


def test_states() -> None:
    found = document()
    assert found["version"] == 1
    assert found["robot"] == "R"
    assert found["initial"] == 0
    assert found["states"][0] == {
        "id": 0,
        "components": {"A": "idle"},
        "variables": {"A.c": "blue", "A.g": False, "A.h": False},
        "communications": {"act": "idle"},
        "marked": True,
    }
    assert [state["id"] for state in found["states"]] == list(range(len(found["states"])))


def test_values_of_objects_are_told_by_path() -> None:
    seen = [e for e in events(document(), "response") if e["name"] == "seen"]
    assert seen[0] == {
        "kind": "response",
        "name": "seen",
        "value": {"kind": "red", "inner.good": False, "list[0].good": False},
    }
    assert {e["value"]["list[0].good"] for e in seen} == {False, True, None}
    assert len(seen) == 2 * 2 * 3


def test_values_of_basic_types_and_none() -> None:
    found = document()
    act = [e for e in events(found, "response") if e["name"] == "act"]
    assert [e["value"] for e in act] == [False, True]
    assert events(found, "request") == [{"kind": "request", "name": "act", "value": None}]
    assert events(found, "error") == [{"kind": "error", "name": "act", "value": None}]


def test_own_steps_tell_their_number_and_way() -> None:
    assert events(document(), "tau") == [
        {"kind": "tau", "name": "A", "index": 1, "value": "done->idle"}
    ]


def test_plant_has_more() -> None:
    assert len(document(plant=True)["transitions"]) > len(document()["transitions"])


def test_names_are_qualified_only_where_they_are_ambiguous() -> None:
    body = """
        component A { service act with request: none, response: none links link }
        component B { service other with request: none, response: none links link }
    """
    found = explore_document(explore(plant_of(body)))
    assert found["states"][0]["communications"] == {"act": "idle", "other": "idle"}


def test_limit() -> None:
    plant = plant_of(BODY)
    count = len(explore(plant).states)
    assert len(explore(plant, limit=count).states) == count
    with pytest.raises(StateSpaceError, match=str(count - 1)):
        explore(plant, limit=count - 1)


def test_graph_of_an_empty_supervisor_has_no_states() -> None:
    found = supervisor_of(
        "component A { behaviour { initial marked state s {} } } requirement never A.s"
    )
    assert explore(found).states == ()


def test_synthesize() -> None:
    found = synthesize_document(supervisor_of(BODY))
    json.dumps(found)
    assert list(found) == [
        "version", "robot", "engine", "seconds", "plant_states", "controlled_states",
        "controlled_transitions", "guards", "definitions", "explanations", "properties",
        "free_tests", "free_reasons",
    ]  # fmt: skip
    assert found["engine"] == "explicit"
    assert found["guards"] == [
        {
            "event": {"kind": "request", "name": "act", "value": None},
            "guard": "A.c = red and A.g and !A.h",
            "short": "A.c = red and A.g and !A.h",
            "status": "as required",
        },
        {
            "event": {"kind": "tau", "name": "A", "index": 1, "value": "done->idle"},
            "guard": "true",
            "short": "true",
            "status": "as required",
        },
    ]
    assert found["definitions"] == []
    assert found["explanations"] == []
    assert set(found["properties"]) == {
        "bounded response", "confluence", "nonblocking under control",
    }  # fmt: skip


def test_a_tau_of_a_whole_automaton_leads_from_nowhere_in_particular() -> None:
    supervisor = supervisor_of(
        "component A { behaviour { transition goto a initial marked state a {} state b {} } }"
        " component B { behaviour { transition goto only initial marked state only {} } }"
    )
    shown = [guard["event"]["value"] for guard in synthesize_document(supervisor)["guards"]]
    assert shown == [None, "only->only"]


def test_explanations_in_the_document() -> None:
    found = synthesize_document(
        supervisor_of(
            "component A { service s with request: none, response: none links link behaviour {"
            " initial marked state idle { on request to s goto busy }"
            " state busy { on response from s goto idle } } }"
        )
    )
    (why,) = found["explanations"]
    assert why["event"] == {"kind": "request", "name": "s", "value": None}
    assert why["trace"] == [
        {"kind": "request", "name": "s", "value": None},
        {"kind": "error", "name": "s", "value": None},
    ]
    assert why["remedy"] == "add 'on error from s goto idle' in state busy of A"


def in_order(document: dict[str, Any]) -> dict[str, Any]:
    return {**document, "transitions": sorted(document["transitions"], key=json.dumps)}


FLAGS = (
    "datatype object Flags { a: boolean b: boolean c: boolean }"
    " component Reader { outgoing message flags with type: Flags links link"
    " incoming message go with type: none behaviour { variable seen: boolean = false"
    " initial marked state s { on response from flags if value.a do seen := value.b goto t"
    " on response from flags if value.c goto t }"
    " marked state t { } } } requirement go needs Reader.seen"
)


def test_parts_that_do_not_matter_are_left_out() -> None:
    graph = explore(plant_of(FLAGS))
    printed = json.loads("".join(explore_json(graph)))
    assert in_order(spelled_out(graph.plant, printed)) == in_order(explore_document(graph))
    quiet = [t for t in printed["transitions"] if "any" in t]
    assert all(sorted(t["any"]) == ["a", "b", "c"] and t["values"] == 8 for t in quiet)
    assert {t["event"]["value"] for t in quiet} == {None}
    assert len(quiet) == len(graph.states) - 1
    lines = report.graph_text(graph).splitlines()
    assert sum("flags.response ->" in line for line in lines) == len(quiet)
    assert "left out" in lines[1]


@pytest.mark.parametrize("seed", range(20))
def test_what_is_printed_means_all_transitions(seed: int) -> None:
    graph = explore(plant_of(random_model(random.Random(seed), 1 + seed % 2)))
    printed = json.loads("".join(explore_json(graph)))
    assert in_order(spelled_out(graph.plant, printed)) == in_order(explore_document(graph))


@pytest.mark.parametrize("lines", [1, 3, 10_000])
def test_text_in_parts_is_the_document(lines: int) -> None:
    for text in (steep_families.restless(2), families.action_robot(1), steep_families.readings(3)):
        graph = explore(plant_of(text))
        printed = json.loads("".join(explore_json(graph, lines)))
        assert in_order(spelled_out(graph.plant, printed)) == in_order(explore_document(graph))
    none = explore(supervisor_of("component A { incoming message m with type: none }"))
    assert json.loads("".join(explore_json(none, lines))) == explore_document(none)


@pytest.mark.slow
def test_what_is_too_large_is_refused_before_it_is_walked() -> None:
    supervisor = supervisor_of(steep_families.gauges(300), "bdd")
    with pytest.raises(StateSpaceError, match="there are 90000 states, more than 80000"):
        explore(supervisor, 80_000)
    with pytest.raises(StateSpaceError, match="there are 54006190 transitions, more than 3000000"):
        explore(supervisor, 100_000)
    assert verify(supervisor).method == "symbolic"


def test_transitions_of_a_plant_are_bounded_on_the_way() -> None:
    with pytest.raises(StateSpaceError, match="more than 30000 transitions"):
        explore(plant_of(steep_families.gauges(30)), 1000)
