"""A state that performs a command has its own name everywhere; stages and counts stand beside it."""

from __future__ import annotations

import json
import re

from simulate.players import play, session
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.emit.export.dot import dot_text
from robosc.emit.package.model_document import model_document
from robosc.report import graph_text, supervisor_text
from robosc.synthesis.documents import explore_json
from robosc.synthesis.explore import explore

MODEL = """
robot Grip {
    component Job {
        service close with request: none, response: boolean links tried
        service light with request: none, response: none links reset
        incoming message home with type: none
        outgoing message far with type: boolean
        behaviour {
            initial marked state ready { on response from far if value goto fetching }
            state fetching {
                on response from far if !value goto ready
                initial state closing performs close then goto leaving {
                    on response from close if !value goto stuck
                    retry 2 times every 1 s else goto stuck
                }
                state leaving performs home then goto ready
            }
            marked state stuck { transition if Lamp.off goto ready }
        }
    }
    component Lamp {
        behaviour { initial marked state on_ { on request to light goto off } marked state off {} }
    }
    requirement light needs Job.fetching.closing.performing and Job.fetching.closing.retries = 1
    interface reset use Empty from std_srvs
    interface tried use Work from some_package
}
"""
"""Once closing was tried in vain, and is under way again, the lamp may go out."""
INNER = re.compile(r"closing[._ ](due|under_way)|closing_retries")


def test_what_explore_tells() -> None:
    supervisor = pipeline.supervise(robot_of(MODEL))
    document = json.loads("".join(explore_json(explore(supervisor))))
    assert {s["components"]["Job"] for s in document["states"]} == {
        "ready", "fetching.closing", "fetching.leaving", "stuck",
    }  # fmt: skip
    seen = {
        (v["Job.fetching.closing performing"], v["Job.fetching.closing waiting"],
         v["Job.fetching.closing retries"])
        for v in (s["variables"] for s in document["states"])
    }  # fmt: skip
    # The count begins anew where the state around is entered, not where it is left.
    assert {(False, False, 0), (True, False, 0), (False, True, 1), (True, False, 2)} <= seen
    waits = [t for t in document["transitions"] if t["event"]["kind"] == "after"]
    assert {t["event"]["value"] for t in waits} == {"fetching.closing->fetching.closing"}
    (light,) = {
        (s["components"]["Job"], s["variables"]["Job.fetching.closing retries"])
        for t in document["transitions"]
        if t["event"]["name"] == "light" and t["event"]["kind"] == "request"
        for s in [document["states"][t["source"]]]
    }
    assert light == ("fetching.closing", 1)


def test_texts_and_pictures_have_the_names_of_the_model() -> None:
    supervisor = pipeline.supervise(robot_of(MODEL))
    guard = "Job.fetching.closing.performing and Job.fetching.closing.retries = 1"
    graph = explore(supervisor)
    dot = dot_text(supervisor.plant.robot, graph)
    for text in (supervisor_text(supervisor), graph_text(graph), dot):
        assert not INNER.search(text)
    assert guard in supervisor_text(supervisor)
    assert "Job.fetching.closing, Job.fetching.closing performing" in graph_text(graph)
    assert '[label="closing\\nperforms close", peripheries=1]' in dot
    # What the performing does by itself is not drawn; what follows it is.
    closing = '"Job.fetching.closing"'
    assert f"{closing} -> {closing}" not in dot
    assert f'{closing} -> "Job.fetching.leaving"' in dot
    assert f'{closing} -> "Job.stuck" [label="close.response' in dot


def test_internal_transitions_are_told_by_where_they_lead() -> None:
    twice = MODEL.replace(
        "transition if Lamp.off goto ready",
        "transition if Lamp.off goto ready\n transition if Lamp.on_ goto ready",
    )
    text = supervisor_text(pipeline.supervise(robot_of(MODEL)))
    assert "\nJob: stuck->ready  as required" in text
    text = supervisor_text(pipeline.supervise(robot_of(twice)))
    assert re.findall(r"Job: stuck->ready \(line \d+\)", text) == [
        "Job: stuck->ready (line 18)", "Job: stuck->ready (line 19)",
    ]  # fmt: skip


def test_what_blocks_a_command_is_told_with_its_stage() -> None:
    player = session(pipeline.supervise(robot_of(MODEL)))
    play(player, "far true", "close.request")
    told = [c.reasons[-1].text for c in player.machine.commands() if c.event.name == "close"]
    assert told == ["blocked by Job in fetching.closing (performing)"]
    running = session(pipeline.supervise(robot_of(MODEL)), execute=True)
    play(running, "far true", "close.error")
    told = [c.reasons[-1].text for c in running.machine.commands() if c.event.name == "close"]
    assert told == ["blocked by Job in fetching.closing (waiting)"]


def test_the_document_of_the_model_has_its_states() -> None:
    document = json.loads(json.dumps(model_document(pipeline.supervise(robot_of(MODEL)), "m.rscd")))
    job = document["components"][0]
    assert [(s["name"], s.get("performs")) for s in job["states"]] == [
        ("ready", None), ("fetching.closing", "close"), ("fetching.leaving", "home"), ("stuck", None),
    ]  # fmt: skip
    leaving = [t for t in job["transitions"] if t.get("box") == "fetching"]
    assert [t["from"] for t in leaving] == ["fetching.closing", "fetching.leaving"]
    (entering,) = (t for t in job["transitions"] if t.get("into") == "fetching")
    assert (entering["from"], entering["to"]) == ("ready", "fetching.closing")
    assert not INNER.search(json.dumps(document))
