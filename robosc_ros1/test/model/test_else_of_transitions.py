"""``else`` as the guard of the last transition for an event."""

from __future__ import annotations

import random
import re

import pytest
from emit.generated_code import supervisor_of
from quick import quick_first
from random_models import random_model
from simulate.players import play, session

from robosc.model.resolve import load
from robosc.source import Source

EXCLUDED = re.compile(
    r"(?P<head>on (?P<event>\w+ (?:from|to) \w+)) if !\((?P<guard>.*)\)(?P<rest>(?: do .*| goto \w+)?)"
)
"""A transition whose guard is the negation of another one, as random models have them."""

UNDEFINED = """\
robot Rover {
    datatype object Scan { ranges: array(double) }
    datatype object Result { code: integer }
    component Laser {
        outgoing message scan with type: Scan links scan
        action dock with request: none, response: Result, feedback: none links dock
        behaviour {
            variable last: Scan
            on response from scan do last := value
            on error from dock if value.code = 3 goto tilted
            on error from dock if value.code = 4 goto calm
            on error from dock else goto stuck
            initial marked state calm {
                on response from scan if value.ranges[2] < 0.5 goto near
                on response from scan else goto calm
            }
            marked state near {
                on response from scan if value.ranges[2] < 0.5 goto near
                on response from scan else goto calm
            }
            marked state tilted { on response from scan goto calm }
            marked state stuck { on response from scan if last.ranges[1] > 1 goto calm
                on response from scan if last.ranges[1] < 0 goto near
                on response from scan else goto tilted }
        }
    }
    interface scan use LaserScan from nowhere_msgs
    interface dock use Dock from nowhere_msgs
}
"""


@pytest.mark.parametrize("seeds", quick_first([range(30), range(30, 120)], 1))
def test_it_is_the_negation_of_the_guards_before_it(seeds: range) -> None:
    compared = 0
    for seed in seeds:
        text = random_model(random.Random(seed), 2)
        robot, _ = load(Source("model.rscd", text))
        lines = text.split("\n")
        for number, line in enumerate(lines):
            found = EXCLUDED.fullmatch(line.strip())
            if found and f"{found['event']} if {found['guard']}" in lines[number - 1]:
                lines[number] = f"{found['head']} else{found['rest']}"
        written, diagnostics = load(Source("model.rscd", "\n".join(lines)))
        if lines != text.split("\n"):
            compared += 1
            assert written == robot, seed
            assert not [d for d in diagnostics if d.severity.value == "error"]
    assert compared > len(seeds) / 6


def test_it_covers_what_the_guards_before_it_leave() -> None:
    """Synthesis would report transitions that can be taken together."""
    player = session(supervisor_of(UNDEFINED))
    for line, state in (
        ("scan.response ranges: []", "calm"),
        ("scan.response ranges: [1, 2, 0.1]", "near"),
        ("scan.response ranges: [1, 2, NaN]", "calm"),
        ("dock.error code: 3", "tilted"),
        ("scan.response ranges: [1]", "calm"),
        ("dock.error code: 4", "calm"),
        ("dock.error code: 5", "stuck"),
        ("scan.response ranges: [1, 7]", "tilted"),
        ("scan.response ranges: [1, 7]", "calm"),
        ("dock.error", "stuck"),
        ("scan.response ranges: []", "calm"),
    ):
        if line.startswith("dock"):
            play(player, "dock.request")
        play(player, line, f"expect Laser.{state}")


@pytest.mark.parametrize("levels", [2, 3, 7])
def test_of_many_alternatives(levels: int) -> None:
    guarded = "".join(
        f"on response from level if value = {level} goto s{level}\n" for level in range(levels)
    )
    states = "".join(
        f"marked state s{level} {{ on response from level goto none }}\n" for level in range(levels)
    )
    text = f"""robot R {{ component C {{
        outgoing message level with type: integer(0..9)
        behaviour {{ initial marked state none {{
            {guarded} on response from level else goto other }}
            {states} marked state other {{ on response from level goto none }} }} }} }}"""
    player = session(supervisor_of(text))
    for level in range(10):
        state = f"s{level}" if level < levels else "other"
        play(player, f"level.response {level}", f"expect C.{state}", "level.response 0")
