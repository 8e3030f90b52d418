"""What is offered at a place, in a model that is whole but for what is being typed there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from lsp_support import cursor, open_text
from pyparsing import ParserElement
from ros_support import EXAMPLES

from robosc.language.tokens import tokenize
from robosc.lsp.analysis import Workspace
from robosc.lsp.completion.complete import NAMES, OPERANDS, complete
from robosc.lsp.completion.snippets import SNIPPETS
from robosc.model.ros.interfaces import Interface
from robosc.source import Source
from robosc.syntax.elements import expectations
from robosc.syntax.parser import parse

MODEL = """\
robot R {
    component Eye {
        outgoing message seen with identifier: "/seen", type: Sight
        outgoing message shape with type: Shape links shape
        behaviour {
            variable last: Sight = nothing
            variable bright: boolean = false
            initial marked state open {
                on response from seen do last := value
            }
            state shut {}
        }
    }
    component Wheel {
        incoming message drive with type: Twist links twist
        action turn with request: none, response: Shape, feedback: none links turn
    }
    requirement drive needs Eye.open
    provide drive with { linear: { x: 0.5 } } if Eye.bright
    datatype object Twist { linear: Vector }
    datatype object Vector { x: double }
    datatype object Shape { orientation: Turn }
    datatype object Turn { w: double }
    datatype enum Sight from double to {
        value > 1 -> far
        default -> nothing
    }
    interface twist use Twist from geometry_msgs
    interface shape use Pose from geometry_msgs
    interface turn use Turn from some_package
}
"""


def offered(tmp_path: Path, old: str, new: str) -> list[str]:
    """The labels at the mark in ``new``, typed in place of ``old``."""
    workspace = Workspace()
    path = tmp_path / "model.rscd"
    open_text(workspace, path, MODEL)
    assert old in MODEL
    text, offset = cursor(MODEL.replace(old, new, 1))
    open_text(workspace, path, text)
    return [candidate.label for candidate in complete(workspace, str(path), offset)]


REQUIREMENT = "requirement drive needs Eye.open"
REACTION = "on response from seen do last := value"


@pytest.mark.parametrize(
    ("old", "new", "first"),
    [
        (REQUIREMENT, "requirement |", ["drive", "turn"]),
        (REQUIREMENT, "requirement dr|", ["drive", "turn"]),
        (REQUIREMENT, "requirement drive |", ["disables", "needs", "except"]),
        (REQUIREMENT, "prefer |", ["drive", "turn", "all"]),
        (REQUIREMENT, "prefer drive |", ["except", "over"]),
        (REQUIREMENT, "prefer drive over |", ["drive", "turn", "all"]),
        (REQUIREMENT, "stop |", ["with"]),
        (REQUIREMENT, "stop with |", ["drive", "turn", "nothing"]),
        (REQUIREMENT, "requirement drive needs Eye.|", ["bright", "last", "open", "shut"]),
        (REQUIREMENT, "requirement drive needs Eye.last = |", ["far", "nothing"]),
        (REQUIREMENT, "requirement { drive, | } needs Eye.open", ["drive", "turn"]),
        (REQUIREMENT, "requirement Eye.open disables |", ["drive", "turn", "all"]),
        (REQUIREMENT, "interface x use Twist from |", ["geometry_msgs"]),
        (REACTION, "on request |", ["to"]),
        (REACTION, "on response from |", ["seen", "shape", "turn"]),
        (REACTION, "on feedback from |", ["turn"]),
        (REACTION, "on response, error from |", ["seen", "shape", "turn"]),
        (REACTION, "on response, |", ["cancel from", "cancelled from", "error from"]),
        (REACTION, "on response from { seen, | }", ["seen", "shape", "turn"]),
        (REACTION, "on error, feedback from { | } goto open", ["turn"]),
        (REACTION, "on response, error from shape if value.|", ["orientation"]),
        (REACTION, "on response from { seen } |", ["do", "goto", "if"]),
        (REACTION, "on response from seen goto |", ["open", "shut"]),
        (REACTION, "on response from seen do |", ["bright", "last"]),
        (REACTION, "on response from seen do last := |", ["far", "nothing", "value"]),
        (REACTION, "on response from seen if value = |", ["far", "nothing", "value"]),
        (REACTION, "on response from shape if value.|", ["orientation"]),
        (REACTION, "on response from shape if value.orientation.|", ["w"]),
        (REACTION, "on error from turn if value.orientation.|", ["w"]),
        (REACTION, "on response from seen |", ["do", "goto", "if"]),
        ("variable bright: boolean = false", "variable bright: |", ["Sight"]),
        ("variable bright: boolean = false", "variable bright: boolean = |", ["false", "true"]),
        ("type: Twist links twist", "type: Twist links |", ["shape", "turn", "twist"]),
        ("feedback: none links turn", "|", ["feedback:"]),
        ("provide drive with { linear", "provide |\n    provide drive with { linear", ["drive"]),
        ("provide drive with {", "provide drive |", ["with"]),
        ("{ linear: { x: 0.5 } }", "{ | }", ["linear"]),
        ("{ x: 0.5 }", "{ | }", ["x"]),
        ("{ x: 0.5 }", "|", ["{ }"]),
        ("value > 1 -> far", "value > 1 -> |", ["far", "nothing"]),
        ("component Wheel {", "component Wheel {\n |", ["action", "behaviour"]),
        ("component Eye {", "component Eye {\n requirement drive needs |", ["bright", "Eye"]),
        ("component Eye {", "component Eye {\n requirement { | } needs open", ["drive", "turn"]),
        ("component Eye {", "component Eye {\n provide drive with { | }", ["linear"]),
        ("component Eye {", "component Eye {\n prefer drive |", ["except", "over"]),
        ("robot R {", "robot R {\n function half(x: |", ["Sight"]),
        (
            REQUIREMENT,
            "function ahead(x: double): boolean = x > 1 requirement drive needs ah|",
            ["ahead"],
        ),
        ("robot R {", "robot R {\n |", ["assume", "component", "condition", "constant"]),
        ("robot R {", "// |\nrobot R {", []),
        ('"/seen"', '"/se|"', []),
    ],
)
def test_what_comes_first(tmp_path: Path, old: str, new: str, first: list[str]) -> None:
    found = offered(tmp_path, old, new)
    assert found[: len(first)] == first or (not first and not found)
    assert first or not found


WHAT_IS_NEW = (
    "a name",
    "a title",
    "a string",
    "a number",
    "a whole number",
    "a rate",
    "a requirement such as",
    "'",
)
"""How the texts of the grammar begin for which there is nothing to offer but quoted keywords."""


def test_all_that_the_grammar_expects_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No text in the table that the grammar does not have, and none of the grammar that it lacks."""
    seen: set[str] = set()

    def noted(rule: ParserElement, kinds: str) -> tuple[tuple[str, ...], list[Any] | None]:
        expected, whole = expectations(rule, kinds)
        seen.update(text.partition(" after ")[0] for text in expected)
        return expected, whole

    monkeypatch.setattr("robosc.syntax.elements.expectations", noted)
    examples = sorted(EXAMPLES.glob("*/*.rscd"))
    for text in (
        MODEL,
        CART,
        "robot R { assume a needs b }",
        *(file.read_text(encoding="utf-8") for file in examples),
    ):
        workspace, path = Workspace(), str(tmp_path / "model.rscd")
        open_text(workspace, path, text)
        for start in tokenize(Source(path, text)).starts:
            complete(workspace, path, start)
    known = (*NAMES, *OPERANDS)
    assert [text for text in known if not any(what.startswith(text) for what in seen)] == []
    assert [what for what in seen - {""} if not what.startswith((*known, *WHAT_IS_NEW))] == []


def test_a_list_of_data_is_no_list_of_attributes(tmp_path: Path) -> None:
    typed = "component Eye {\n constant here: Vector = { x: 1.0, |"
    assert "x" in offered(tmp_path, "component Eye {", typed)


def test_outgoing_messages_are_no_commands(tmp_path: Path) -> None:
    assert "seen" not in offered(tmp_path, REQUIREMENT, "requirement |")


def test_fields_of_the_real_message(tmp_path: Path) -> None:
    definitions = Workspace().definitions(str(tmp_path / "model.rscd"))
    if not isinstance(definitions.interface("geometry_msgs", "Twist", "msg"), Interface):
        pytest.skip("geometry_msgs is not installed")
    assert offered(tmp_path, "{ x: double }", "{ x: double | }") == ["y", "z"]
    found = offered(tmp_path, "interface turn use Turn", "interface turn use |")
    assert {"Twist", "Bool", "SetBool"} <= set(found)


def test_libraries_and_their_components(tmp_path: Path) -> None:
    (tmp_path / "base.rscd").write_text("library Base { component Arm {} component Leg {} }")
    assert offered(tmp_path, "robot R {", "robot R {\n component A from |") == [
        "Base",
        "EStop",
        "Velocity",
        "Zones",
    ]
    found = offered(tmp_path, "robot R {", "robot R {\n component A from Base import |")
    assert found[:2] == ["Arm", "Leg"]


TRACKS = """library Tracks {
    parameter grip: double = 0.5
    datatype enum Grip from double to { value > grip -> good default -> poor }
    component Track {
        constant radius: double = 0.1
        parameter wait: duration = 1 s
        condition still = on_
        incoming message turn with type: double
        behaviour { initial marked state on_ {} }
    }
}
"""
CART = """robot Cart {
    parameter limit: double = 2.5
    constant pause: duration = 2 s
    condition calm = Left.still
    component Left from Tracks import Track with prefix: "/left", radius: 0.2
    component Eye {
        parameter least: integer(0..9) = 3
        outgoing message seen with timeout: pause, type: double
        behaviour {
            variable v: double
            initial marked state open { on response from seen do v := value after pause goto open }
        }
    }
    component Hand {
        action grip with within: pause, expect: value > limit, request: none, response: double
    }
    requirement turn needs Eye.v > limit
    datatype enum Sight from double to { value > limit -> far default -> near }
}
"""


@pytest.mark.parametrize(
    ("old", "new", "some"),
    [
        ("needs Eye.v > limit", "needs |", ["limit", "pause", "calm", "Eye", "Left", "Tracks"]),
        ("needs Eye.v > limit", "needs Eye.|", ["least", "v", "open"]),
        ("needs Eye.v > limit", "needs Left.|", ["radius", "wait", "still", "on_"]),
        ("needs Eye.v > limit", "needs Tracks.|", ["grip", "Grip"]),
        ('prefix: "/left", radius: 0.2', "|", ["prefix:", "radius:", "wait:"]),
        ("radius: 0.2", "radius: 0.2, |", ["wait:"]),
        ("timeout: pause", "timeout: |", ["pause"]),
        ("within: pause", "within: |", ["pause"]),
        ("within: pause, expect", "|, expect", ["identifier:", "timeout:", "within:", "request:"]),
        ("expect: value > limit", "expect: |", ["value", "limit", "true"]),
        ("expect: value > limit", "expect: value > |", ["value", "limit"]),
        ("after pause", "after |", ["pause"]),
        ("limit: double = 2.5", "limit: |", ["double", "duration", "Sight"]),
        ("value > limit ->", "value > |", ["limit", "pause"]),
        ("goto open }", "if | goto open }", ["least", "limit", "v"]),
    ],
)
def test_constants_parameters_and_conditions(
    tmp_path: Path, old: str, new: str, some: list[str]
) -> None:
    (tmp_path / "tracks.rscd").write_text(TRACKS)
    workspace = Workspace(folders=[str(tmp_path)])
    path = tmp_path / "cart.rscd"
    open_text(workspace, path, CART)
    assert old in CART
    text, offset = cursor(CART.replace(old, new, 1))
    open_text(workspace, path, text)
    found = [candidate.label for candidate in complete(workspace, str(path), offset)]
    assert set(some) <= set(found), found
    if old == "radius: 0.2":
        assert not {"prefix:", "radius:"} & set(found)


SEEN = 'outgoing message seen with identifier: "/seen", type: Sight'


def test_types_of_ros_are_offered_by_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder, name in (("msg", "Scan"), ("msg", "Point"), ("srv", "Arm"), ("action", "Go")):
        file = tmp_path / "ros" / "p_msgs" / folder / f"{name}.{folder}"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("")
    (tmp_path / "ros" / "p_msgs" / "package.xml").write_text(
        "<package><name>p_msgs</name></package>"
    )
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    assert "p_msgs" in offered(tmp_path, SEEN, "outgoing message seen with type: |")
    assert offered(tmp_path, SEEN, "outgoing message seen with type: p_msgs/|") == ["Point", "Scan"]
    assert "type:" in offered(tmp_path, SEEN, "service arm with |")
    assert offered(tmp_path, SEEN, "service arm with type: p_msgs/|") == ["Arm"]
    assert offered(tmp_path, SEEN, "action go with type: p_msgs/|") == ["Go"]
    assert "p_msgs" in offered(tmp_path, SEEN, "action go with type: |")


def test_fields_of_a_real_message_are_offered_behind_value(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "ros" / "p_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Scan.msg").write_text("float32[] ranges\nPoint end\n")
    (folder / "Point.msg").write_text("float64 x\n")
    (folder.parent / "package.xml").write_text("<package><name>p_msgs</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    model = MODEL.replace("type: Sight", "type: p_msgs/Scan")
    workspace = Workspace()
    path = tmp_path / "model.rscd"
    open_text(workspace, path, model)
    for typed, wanted in (("value.|", ["end", "ranges"]), ("value.end.|", ["x"])):
        text, offset = cursor(model.replace("last := value", f"last := {typed}"))
        open_text(workspace, path, text)
        found = [candidate.label for candidate in complete(workspace, str(path), offset)]
        assert found == wanted


AGGREGATES = """\
robot R {
    component Eye {
        outgoing message seen with type: Found
        incoming message go with type: Found
        behaviour {
            variable near: boolean
            variable last: Found
            initial marked state s {
                on response from seen do near := any(d.good for d in value.all[1..3]), last := value
            }
        }
    }
    component Station[1..3] {
        outgoing message call with type: none
        behaviour {
            variable held: boolean
            initial marked state idle { on response from call goto waiting }
            state waiting {}
        }
    }
    requirement go needs any(s.held for s in Station if s.waiting)
    provide go with { all: [{ good: true, spots: [{ x: 1 }, { y: max(2, 3), x: 4 }] }] }
    datatype object Found { all: array(Seen) }
    datatype object Seen { good: boolean spots: array(Spot) }
    datatype object Spot { x: integer y: integer }
}
"""
HELD = "any(s.held for s in Station if s.waiting)"
GOOD = "any(d.good for d in value.all[1..3])"


@pytest.mark.parametrize(
    ("old", "new", "first"),
    [
        ("d.good for", "d.| for", ["good", "spots"]),
        ("d.good for", "d.go| for", ["good", "spots"]),
        ("d.good for", "| for", ["d"]),
        (GOOD, "any(d.good for d in value.all if d.|)", ["good", "spots"]),
        (GOOD, "any(d.|\n for d in value.all)", ["good", "spots"]),
        (GOOD, "any(d.good for d in value.|)", ["all"]),
        (GOOD, "any(d.spots[0].| for d in last.all)", ["x", "y"]),
        (GOOD, "any(a.| for a in value.all[0].spots)", ["x", "y"]),
        (GOOD, "any(any(a.| for a in d.spots) for d in value.all)", ["x", "y"]),
        (GOOD, "any((d.good and d.|) for d in Eye.last.all)", ["good", "spots"]),
        (GOOD, "any(d.| for i, d in value.all)", ["good", "spots"]),
        (GOOD, "any(d.| for d in [e for i, e in value.all if e.good])", ["good", "spots"]),
        (GOOD, "any(s.x > 1 for s in [e.spots[i].| for i, e in value.all])", ["x", "y"]),
        (GOOD, "any(i.| for i, d in value.all)", []),
        (GOOD, "any(e.| for d in value.all)", []),
        (GOOD, "any(d.| for d in d.all)", []),
        (GOOD, "any(d.good for d in value.all) and d.|", []),
        (HELD, "any(s.| for s in Station)", ["held", "idle", "waiting"]),
        (HELD, "any(s.held for s in Station if s.|)", ["held", "idle", "waiting"]),
        (HELD, "any(s.held for s in Station[1..2] if s.|", ["held", "idle", "waiting"]),
        (HELD, "any(s.held for s in [Station[1], Station[2]] if s.|)", ["held", "idle", "waiting"]),
        ("{ x: 1 }", "{ | }", ["x", "y"]),
        ("y: max(2, 3)", "|", ["x", "y"]),
        ("y: max(2, 3), x", "y: max(2, 3), |", ["x", "y"]),
        ("{ x: 1 }", "|", ["{ }"]),
    ],
)
def test_elements_of_arrays(tmp_path: Path, old: str, new: str, first: list[str]) -> None:
    workspace, path = Workspace(), str(tmp_path / "model.rscd")
    open_text(workspace, path, AGGREGATES)
    assert old in AGGREGATES
    text, offset = cursor(AGGREGATES.replace(old, new, 1))
    open_text(workspace, path, text)
    labels = [c.label for c in complete(workspace, path, offset)]
    assert labels[: len(first)] == first if first else not labels


SEVERAL = """\
robot R {
    component Station[2..12] {
        outgoing message call with type: none
        incoming message go with type: none
        behaviour {
            variable held: boolean
            initial marked state idle { on response from call goto waiting }
            state waiting { on request to go goto idle }
        }
    }
    component Gate {}
    for i in 3..12 {
        requirement Station[i].go needs Station[i-1].idle
    }
    requirement Station[2].go needs Station[3].idle
}
"""
ROW, FIRST = "needs Station[i-1].idle", "needs Station[3].idle"


@pytest.mark.parametrize(
    ("old", "new", "first"),
    [
        (FIRST, "needs Station[|", [*map(str, range(2, 13))]),
        (FIRST, "needs Station[3].|", ["held", "idle", "waiting"]),
        (ROW, "needs Station[|", ["i", "2", "3"]),
        (ROW, "needs Station[i - 1].|", ["held", "idle", "waiting"]),
        ("Station[i].go", "|", ["Station[i].go", "always"]),
        ("Station[2].go", "|", ["Station[2].go", "always"]),
        ("goto waiting", "goto |", ["idle", "waiting"]),
        ("from call", "from |", ["call"]),
        ("to go goto idle", "to go if Station[|", ["index", "2"]),
    ],
)
def test_one_of_several(tmp_path: Path, old: str, new: str, first: list[str]) -> None:
    """Copies are offered once, by the index that one would write."""
    workspace, path = Workspace(), str(tmp_path / "model.rscd")
    open_text(workspace, path, SEVERAL)
    assert old in SEVERAL
    text, offset = cursor(SEVERAL.replace(old, new, 1))
    open_text(workspace, path, text)
    assert [c.label for c in complete(workspace, path, offset)][: len(first)] == first


def test_a_long_text_is_not_read_again_for_each_key(tmp_path: Path) -> None:
    """What is offered comes from the text as it was when somebody last had to read it."""
    workspace, path = Workspace(), str(tmp_path / "model.rscd")
    long = MODEL + "// " + "." * 30_000 + "\n"
    open_text(workspace, path, long)
    text, offset = cursor(long.replace(REQUIREMENT, "requirement drive needs Eye.|", 1))
    workspace.put(path, text)
    found = [candidate.label for candidate in complete(workspace, path, offset)]
    assert found == ["bright", "last", "open", "shut"]
    assert not workspace.is_known(path)
    assert workspace.analysis(path) is workspace.recent(path)


AROUND = {
    "file": "|",
    "robot": "robot R {\n    |\n}\n",
    "library": "library L {\n    |\n}\n",
    "for": "robot R {\n    for i in 1..2 {\n        |\n    }\n}\n",
    "component": "robot R {\n    component C {\n        |\n    }\n}\n",
}


@pytest.mark.parametrize("block", AROUND)
def test_snippets_are_offered_in_their_block_and_are_read(tmp_path: Path, block: str) -> None:
    text, offset = cursor(AROUND[block])
    workspace = Workspace()
    path = tmp_path / "model.rscd"
    workspace.put(str(path), text)
    offered = {c.label: c for c in complete(workspace, str(path), offset) if c.kind == "snippet"}
    assert list(offered) == sorted((s.label for s in SNIPPETS[block]), key=str.casefold)
    for snippet in SNIPPETS[block]:
        body = offered[snippet.label].text
        assert body is not None and re.search(r"\$\{1:|\$0", body)
        filled = re.sub(r"\$\{\d+:([^}]*)\}", r"\1", body).replace("$0", "")
        _, diagnostics = parse(Source("model.rscd", text[:offset] + filled + text[offset:]))
        assert not diagnostics, (snippet.label, diagnostics)


DATA_MODEL = """\
robot R {
    component Eye from Eyes import Eye with prefix: "/left"
    component Base {
        outgoing message battery with timeout: 2 s, type: sensor_msgs/BatteryState
        outgoing message goal with timeout: 1 s, type: geometry_msgs/PoseStamped
        incoming message go with type: geometry_msgs/PoseStamped
        behaviour {
            variable place: geometry_msgs/PoseStamped
            variable full: boolean
            initial marked state s {
                on response from goal do place := value
                on response from battery do full := value.present
            }
        }
    }
    requirement go needs Base.full
    provide go with Base.place
}
"""
EYES = """\
library Eyes {
    datatype enum Sight from double to { value > 1 -> far default -> near }
    component Eye { outgoing message seen with identifier: "seen", type: Sight }
}
"""


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("value.present", "value.power_supply_status = sensor_msgs/BatteryState.|",
         "POWER_SUPPLY_STATUS_FULL"),
        ("with Base.place", "with Base.place.pose.|", "orientation"),
        ("value.present", "place.pose.position.|", "x"),
        ("needs Base.full", "needs Base.full and battery.|", "fresh"),
        ("needs Base.full", "needs Base.full and Base.battery.|", "silent"),
        ("needs Base.full", "needs Eyes.Sight.|", "near"),
    ],
)  # fmt: skip
def test_members_of_data(tmp_path: Path, old: str, new: str, wanted: str) -> None:
    (tmp_path / "eyes.rscd").write_text(EYES)
    workspace, path = Workspace(), tmp_path / "r.rscd"
    open_text(workspace, path, DATA_MODEL)
    text, offset = cursor(DATA_MODEL.replace(old, new))
    open_text(workspace, path, text)
    assert wanted in [candidate.label for candidate in complete(workspace, str(path), offset)]


MISSION = """\
robot M {
    component Job {
        service go with type: std_srvs/Trigger
        incoming message ring with type: none
        behaviour {
            initial marked state idle { transition goto work }
            state work {
                initial state legs {
                    initial state going performs go then goto ringing {
                        retry 2 times every 1 s else goto idle
                    }
                    state ringing performs ring then goto idle
                }
            }
        }
    }
    requirement ring needs Job.idle
}
"""


@pytest.mark.parametrize(
    ("typed", "labels"),
    [
        ("Job.work.|", ["legs"]),
        ("Job.work.legs.|", ["going", "ringing"]),
        ("Job.legs.|", ["going", "ringing"]),
        ("Job.going.|", ["due", "performing", "retries", "waiting"]),
        ("Job.work.legs.ringing.|", ["due"]),
        ("Job.idle.|", []),
    ],
)
def test_what_stands_in_a_state(tmp_path: Path, typed: str, labels: list[str]) -> None:
    workspace, path = Workspace(), tmp_path / "mission.rscd"
    open_text(workspace, path, MISSION)
    text, offset = cursor(MISSION.replace("Job.idle", typed, 1))
    open_text(workspace, path, text)
    assert [found.label for found in complete(workspace, str(path), offset)] == labels
