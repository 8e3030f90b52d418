"""What each name in a file means: definitions, references, renaming."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from lsp_support import open_text
from ros_support import EXAMPLES

from robosc.language.keywords import KEYWORDS
from robosc.lsp.analysis import Analysis, Workspace
from robosc.lsp.hover import definition_of, hover_text, keyword_hover
from robosc.lsp.rename import RenameError, applied, references, rename
from robosc.model.names.occurrences import Occurrence, SymbolKind
from robosc.model.ros.interfaces import Interface
from robosc.source import Source

LIBRARY = """\
library Base {
    component Wheel {
        incoming message turn with type: none
        outgoing message speed with type: Speed
        behaviour {
            variable v: Speed = slow
            initial marked state on {
                on response from speed do v := value
            }
        }
    }
    datatype enum Speed from double to { value > 1 -> fast default -> slow }
}
"""
ROBOT = """\
robot R {
    component Left from Base import Wheel with prefix: "/left"
    component Right from Base import Wheel with prefix: "/right"
    component Gear {
        outgoing message gear with type: Gear
        behaviour {
            variable g: Gear = slow
            initial marked state slow { on response from gear do g := value }
        }
    }
    requirement Left.turn needs Left.v = slow and Gear.g = slow
    requirement Right.turn needs Right.v = fast or Gear.slow
    datatype enum Gear from integer to { value > 3 -> quick default -> slow }
}
"""


NAMED = """\
robot N {
    parameter limit: double = 2.5
    component Left from Base import Hub with prefix: "/left", radius: 2 * 1, least: 3
    condition far = Left.size > limit
    requirement spin needs far and Left.least > 1
    provide spin with Left.radius
}
"""
HUB = """\
    component Hub {
        constant radius: double = 0.5
        parameter least: integer(0..9) = 2
        incoming message spin with type: double
        outgoing message grown with type: double
        behaviour {
            variable size: double = radius
            initial marked state on { on response from grown do size := value }
        }
    }
"""


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    (tmp_path / "base.rscd").write_text(LIBRARY)
    return Workspace(folders=[str(tmp_path)])


def named(analysis: Analysis, words: str, inside: int = 0) -> Occurrence:
    found = analysis.index.at(analysis.source.text.index(words) + inside)
    assert found is not None, words
    return found


def line_of(text: str, words: str) -> int:
    return text[: text.index(words)].count("\n") + 1


@pytest.mark.parametrize(
    ("words", "inside", "file", "line"),
    [
        ("slow and", 0, "base.rscd", "value > 1"),  # the other side of '=' decides
        ("slow\n    requirement R", 0, "robot.rscd", "value > 3"),
        ("Gear.slow", 5, "robot.rscd", "initial marked"),
        ("Gear = slow", 7, "robot.rscd", "value > 3"),
        ("fast or", 0, "base.rscd", "value > 1"),
        ("Left.turn", 0, "robot.rscd", "component Left"),
        ("Left.turn", 5, "base.rscd", "message turn"),
        ("Right.v", 6, "base.rscd", "variable v"),
        ("gear do", 0, "robot.rscd", "message gear"),
        ("Left from", 0, "base.rscd", "component Wheel"),
        ("Base import Wheel with prefix: \"/right", 0, "base.rscd", "library Base"),
        ("Wheel with", 0, "base.rscd", "component Wheel"),
    ],
)  # fmt: skip
def test_definition(
    workspace: Workspace, tmp_path: Path, words: str, inside: int, file: str, line: str
) -> None:
    analysis = open_text(workspace, tmp_path / "robot.rscd", ROBOT)
    assert not [d for d in analysis.diagnostics if d.severity.value == "error"]
    found = definition_of(analysis, named(analysis, words, inside))
    assert found is not None
    text = LIBRARY if file == "base.rscd" else ROBOT
    assert (Path(found.source.path).name, found.line) == (file, line_of(text, line))


DOCK = """\
robot D {
    component Base {
        outgoing message low with type: boolean
        incoming message go with type: none
        behaviour {
            initial marked state idle { on response from low goto dock.far }
            state dock {
                on response from low goto idle
                initial state near { on request to go goto far }
                state far { on request to go goto near }
            }
        }
    }
    requirement go needs Base.dock.far or Base.near or Base.dock
}
"""


@pytest.mark.parametrize(("name", "uses"), [("dock", 4), ("near", 3), ("far", 4)])
def test_states_in_states_are_renamed_wherever_they_are_named(
    workspace: Workspace, tmp_path: Path, name: str, uses: int
) -> None:
    path = tmp_path / "dock.rscd"
    analysis = open_text(workspace, path, DOCK)
    symbol = named(analysis, f"state {name}", 6).symbol
    (edits,) = rename(workspace, str(path), symbol, "other").values()
    assert len(edits) == uses
    assert applied(analysis.source, edits) == re.sub(rf"\b{name}\b", "other", DOCK)


def test_references_count_imports_as_one(workspace: Workspace, tmp_path: Path) -> None:
    """Both imports of a library's component have its variable."""
    robot = tmp_path / "robot.rscd"
    analysis = open_text(workspace, robot, ROBOT)
    found = references(workspace, str(robot), named(analysis, "Left.v", 5).symbol)
    counts = {Path(file).name: len(here) for file, here in found.items()}
    assert counts == {"base.rscd": 2, "robot.rscd": 2}


def test_rename_changes_every_file_and_nothing_else(workspace: Workspace, tmp_path: Path) -> None:
    robot = tmp_path / "robot.rscd"
    analysis = open_text(workspace, robot, ROBOT)
    edits = rename(workspace, str(robot), named(analysis, "slow and").symbol, "crawling")
    changed = {Path(f).name: applied(e[0].span.source, list(e)) for f, e in edits.items()}
    assert changed["base.rscd"] == LIBRARY.replace("slow", "crawling")
    assert changed["robot.rscd"] == ROBOT.replace("Left.v = slow", "Left.v = crawling")


@pytest.mark.parametrize("name", ["Gear", "2nd", "", "a b", "é"])
def test_names_that_cannot_be(workspace: Workspace, tmp_path: Path, name: str) -> None:
    robot = tmp_path / "robot.rscd"
    analysis = open_text(workspace, robot, ROBOT)
    with pytest.raises(RenameError):
        rename(workspace, str(robot), named(analysis, "Left from").symbol, name)


def test_keywords_are_escaped_only_where_they_must_be(workspace: Workspace, tmp_path: Path) -> None:
    robot = tmp_path / "robot.rscd"
    analysis = open_text(workspace, robot, ROBOT)
    symbol = named(analysis, "g: Gear").symbol
    edits = rename(workspace, str(robot), symbol, "value")
    assert {edit.text for edit in edits[str(robot)]} == {"^value"}
    edits = rename(workspace, str(robot), symbol, "state")
    assert {edit.text for edit in edits[str(robot)]} == {"state"}


@pytest.mark.parametrize("example", ["line_follower", "line_follower_first_edition"])
def test_every_renaming_of_an_example_keeps_its_meaning(example: str) -> None:
    """Each name of the line follower, to a name that is free."""
    path = str(EXAMPLES / example / "line_follower.rscd")
    workspace = Workspace()
    text = Path(path).read_text(encoding="utf-8")
    analysis = open_text(workspace, path, text)
    declared = [o for o in analysis.index.occurrences if o.declaration]
    # Properties have the names that the real messages give them, where these are installed.
    free = [o for o in declared if o.symbol.kind is not SymbolKind.PROPERTY]
    assert len(free) > 25
    for occurrence in free[::3]:
        edits = rename(workspace, path, occurrence.symbol, "brand_new_name")
        assert len(edits[path]) == len(list(analysis.index.of(occurrence.symbol)))


def test_names_in_broken_text_are_still_found(workspace: Workspace, tmp_path: Path) -> None:
    text = ROBOT.replace("Left.v = slow and", "Left.v = slow and and")
    analysis = open_text(workspace, tmp_path / "robot.rscd", text)
    assert definition_of(analysis, named(analysis, "Right.v", 6)) is not None


MESSAGES = """\
robot R {
    component Motor {
        incoming message go with type: Twist links twist
    }
    provide go with { linear: { x: 1.0 } }
    datatype object Twist { linear: Vector }
    datatype object Vector { x: double }
    interface twist use Twist from geometry_msgs
}
"""


def test_messages_are_shown_as_they_are(workspace: Workspace, tmp_path: Path) -> None:
    analysis = open_text(workspace, tmp_path / "motor.rscd", MESSAGES)
    if not isinstance(analysis.definitions.interface("geometry_msgs", "Twist", "msg"), Interface):
        pytest.skip("geometry_msgs is not installed")
    text = hover_text(analysis, named(analysis, "Twist from"), None)
    assert "Vector3  linear" in text
    text = hover_text(analysis, named(analysis, "go with"), None)
    assert "geometry_msgs/Vector3 angular" in text
    assert "float64 x" in hover_text(analysis, named(analysis, "x: 1.0"), None)
    found = definition_of(analysis, named(analysis, "x: double"))
    assert found is not None
    assert Path(found.source.path).name == "Vector3.msg" and found.text == "x"
    found = definition_of(analysis, named(analysis, "geometry_msgs"))
    assert found is not None and Path(found.source.path).name == "package.xml"


ACTION = """\
robot R {
    component Arm {
        action grip with request: Goal, response: Result, feedback: Progress links grip
        service lock with request: Lock, response: none links lock
        behaviour {
            variable last: double
            initial marked state open { on feedback from grip do last := value.part }
        }
    }
    provide grip with { force: 3 }
    provide lock with { engage: true }
    datatype object Goal { force: integer }
    datatype object Result { held: boolean }
    datatype object Progress { part: double }
    datatype object Lock { engage: boolean }
    interface grip use GripAction from arm_msgs
    interface lock use Lock from arm_msgs
}
"""


@pytest.mark.parametrize(
    ("words", "file", "text", "line"),
    [
        ("grip use", "Grip.action", "", 1),
        ("GripAction", "Grip.action", "", 1),
        ("lock use", "Lock.srv", "", 1),
        ("force: integer", "Grip.action", "force", 2),
        ("held: boolean", "Grip.action", "held", 4),
        ("part: double", "Grip.action", "part", 6),
        ("engage: boolean", "Lock.srv", "engage", 1),
        ("force: 3", "robot.rscd", "force", 12),
    ],
)
def test_definitions_in_services_and_actions(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: str,
    file: str,
    text: str,
    line: int,
) -> None:
    package = tmp_path / "arm_msgs"
    for name, lines in (
        ("action/Grip.action", "# newton\nint32 force\n---\nbool held\n---\nfloat64 part\n"),
        ("srv/Lock.srv", "bool engage\n---\n"),
        ("package.xml", "<package><name>arm_msgs</name></package>"),
    ):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(lines)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    analysis = open_text(Workspace(), tmp_path / "robot.rscd", ACTION)
    assert not [d for d in analysis.diagnostics if d.severity.value == "error"]
    found = definition_of(analysis, named(analysis, words))
    assert found is not None
    assert (Path(found.source.path).name, found.text, found.line) == (file, text, line)


def test_a_file_that_links_lead_to_twice_is_edited_once(tmp_path: Path) -> None:
    real = tmp_path / "real"
    real.mkdir()
    (tmp_path / "link").symlink_to(real)
    (real / "base.rscd").write_text(LIBRARY)
    (real / "robot.rscd").write_text(ROBOT)
    workspace = Workspace(folders=[str(tmp_path / "link")])
    analysis = open_text(workspace, real / "robot.rscd", ROBOT)
    edits = rename(
        workspace, str(real / "robot.rscd"), named(analysis, "slow and").symbol, "crawling"
    )
    assert sorted(Path(file).name for file in edits) == ["base.rscd", "robot.rscd"]


def test_only_libraries_change_what_others_say(workspace: Workspace, tmp_path: Path) -> None:
    """The rest is not read again at every key."""
    robot, library = tmp_path / "robot.rscd", tmp_path / "base.rscd"
    before = open_text(workspace, robot, ROBOT)
    open_text(workspace, tmp_path / "other.rscd", "robot Other {}")
    open_text(workspace, tmp_path / "other.rscd", "robot Another {}")
    assert workspace.is_known(str(robot)) and workspace.analysis(str(robot)) is before
    workspace.put(str(library), LIBRARY.replace("turn", "twist"))
    assert not workspace.is_known(str(robot))
    assert "unknown-communication" in {
        d.code for d in open_text(workspace, robot, ROBOT).diagnostics
    }
    workspace.close(str(library))
    assert not workspace.is_known(str(robot))
    assert not [
        d for d in open_text(workspace, robot, ROBOT).diagnostics if d.severity.value == "error"
    ]


WHOLE_MESSAGES = """\
robot R {
    component Arm {
        service lock with type: arm_msgs/Lock
        outgoing message held with type: arm_msgs/Held
        behaviour {
            variable last: double
            variable held: boolean
            initial marked state open {
                on response from held if value.hand.force > arm_msgs/Held.WEAK do held := true
                on response from lock do held := value.done
            }
        }
    }
    provide lock with { engage: Arm.held }
}
"""


@pytest.mark.parametrize(
    ("words", "inside", "file", "text", "line"),
    [
        ("Lock\n", 0, "Lock.srv", "", 1),
        ("hand.force", 0, "Held.msg", "hand", 2),
        ("hand.force", 5, "Hand.msg", "force", 1),
        ("WEAK", 0, "Held.msg", "WEAK", 1),
        ("done", 0, "Lock.srv", "done", 3),
        ("engage", 0, "Lock.srv", "engage", 1),
    ],
)
def test_definitions_of_types_that_ros_itself_defines(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: str,
    inside: int,
    file: str,
    text: str,
    line: int,
) -> None:
    package = tmp_path / "arm_msgs"
    for name, lines in (
        ("srv/Lock.srv", "bool engage\n---\nbool done\n"),
        ("msg/Held.msg", "float32 WEAK=0.5\nHand hand\n"),
        ("msg/Hand.msg", "float64 force\n"),
        ("package.xml", "<package><name>arm_msgs</name></package>"),
    ):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(lines)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    analysis = open_text(Workspace(), tmp_path / "robot.rscd", WHOLE_MESSAGES)
    assert not [d for d in analysis.diagnostics if d.severity.value == "error"]
    found = definition_of(analysis, named(analysis, words, inside))
    assert found is not None
    assert (Path(found.source.path).name, found.text, found.line) == (file, text, line)


def test_parameters_and_arguments_of_imports(workspace: Workspace, tmp_path: Path) -> None:
    base = tmp_path / "base.rscd"
    base.write_text(LIBRARY.replace("library Base {\n", f"library Base {{\n{HUB}", 1))
    analysis = open_text(workspace, tmp_path / "n.rscd", NAMED)
    limit = named(analysis, "limit\n")
    assert limit.symbol.kind is SymbolKind.PARAMETER
    assert "parameter of the node: double" in hover_text(analysis, limit, None)
    least = named(analysis, "least: 3")
    assert least.symbol.kind is SymbolKind.PARAMETER
    assert named(analysis, "Left.least", 6).symbol.key == least.symbol.key
    edits = rename(workspace, str(tmp_path / "n.rscd"), least.symbol, "fewest")
    text = applied(analysis.source, edits.pop(str(tmp_path / "n.rscd")))
    assert "radius: 2 * 1, fewest: 3" in text
    assert "far and Left.fewest > 1" in text
    ((file, (edit,)),) = edits.items()
    assert (file, edit.span.text) == (str(base), "least")
    left = named(analysis, "Left from").symbol
    found = references(workspace, str(tmp_path / "n.rscd"), left)
    assert {Path(file).name: len(here) for file, here in found.items()} == {"n.rscd": 4}


def test_hover_of_an_action_says_what_cancels_it(workspace: Workspace, tmp_path: Path) -> None:
    text = """robot Rover {
    interface drive use Drive from rover_msgs
    component Base {
        action go with request: none, response: none, feedback: none links drive
        incoming message beep with type: none
        behaviour { initial marked state still {} }
    }
    requirement { go, beep } needs Base.still
    requirement go needs Base.still to start
}
"""
    analysis = open_text(workspace, tmp_path / "rover.rscd", text)
    lines = hover_text(analysis, named(analysis, "go with"), None).splitlines()
    assert (
        "requirement { go, beep } needs Base.still  // line 8, also a reason to cancel it" in lines
    )
    assert "requirement go needs Base.still to start  // line 9" in lines
    lines = hover_text(analysis, named(analysis, "beep with"), None).splitlines()
    assert "requirement { go, beep } needs Base.still  // line 8" in lines


def test_hover_of_a_type_of_ros_shows_its_fields(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the package in front of it, too; comments do not push the fields of a long one away."""
    folder = tmp_path / "ros" / "p_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder.parent / "package.xml").write_text("<package><name>p_msgs</name></package>")
    (folder / "Short.msg").write_text("# metres\nfloat64 far\n")
    (folder / "Long.msg").write_text("# what it is\n\n" * 40 + "float64 far # metres\n")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    text = """robot R { component C {
        outgoing message short with identifier: "/s", type: p_msgs/Short
        outgoing message long with identifier: "/l", type: p_msgs/Long
    } }"""
    analysis = open_text(Workspace(), tmp_path / "robot.rscd", text)
    for words, inside in (("p_msgs/Short", 3), ("Short", 2)):
        shown = hover_text(analysis, named(analysis, words, inside), None)
        assert "`p_msgs/Short`" in shown and "# metres\nfloat64 far\n" in shown
    for words in ("p_msgs/Long", "Long"):
        shown = hover_text(analysis, named(analysis, words), None)
        assert "```\nfloat64 far # metres\n```" in shown


def test_hover_explains_every_keyword() -> None:
    for word, keyword in KEYWORDS.items():
        source = Source("model.rscd", f"x {word} y")
        found = keyword_hover(source, 2)
        assert found is not None
        text, span = found
        assert text == f"`{word}`: {keyword.meaning}" and span.text == word
        assert keyword.meaning.endswith("."), word


def test_what_only_looks_like_a_keyword_is_not_explained() -> None:
    source = Source("model.rscd", "// state\n'state' A.state ^state state")
    marked = [source.text.index(word) for word in ("state", "state'", "A.state", "^state")]
    marked[2] += 2
    assert [keyword_hover(source, offset) for offset in marked] == [None] * 4
    assert keyword_hover(source, len(source.text)) is not None


CALLED = """library Lib {
    function half(x: double): double = x / 2
    datatype enum Way from double to { value > 1 -> free default -> blocked }
    component Wheel {
        function spin(x: double): double = x
        incoming message turn with type: double
    }
}
"""
CALLS = """robot R {
    component Front from Lib import Wheel with prefix: "/f"
    component Gauge[1..2] {
        function twice(x: double): double = 2 * x + index
        incoming message say with identifier: "/say{index}", type: double
    }
    component Laser {
        function usable(x: double): double = x
        outgoing message scan with timeout: 1 s, type: double
        incoming message go with type: double
        behaviour {
            variable d: double
            variable w: Lib.Way
            initial marked state s { on response from scan do d := value, w := Lib.Way(value) }
        }
    }
    requirement go needs scan.fresh and Laser.usable(Laser.d) > 1 and Laser.w = Lib.Way.free
    provide go with Laser.usable(1) + Gauge[2].twice(3) + Lib.half(2) + Front.spin(2)
    for i in 1..2 { provide Gauge[i].say with Gauge[i].twice(Laser.usable(2)) }
    stop with nothing
}
"""


@pytest.mark.parametrize(
    ("file", "name", "uses"),
    [
        ("robot.rscd", "Front", 2),
        ("robot.rscd", "Gauge", 4),
        ("robot.rscd", "twice", 3),
        ("robot.rscd", "Laser", 6),
        ("robot.rscd", "usable", 4),
        ("Lib.rscd", "Lib", 6),
        ("Lib.rscd", "Way", 4),
        ("Lib.rscd", "half", 2),
        ("Lib.rscd", "spin", 2),
    ],
)
def test_what_is_called_is_renamed_with_what_stands_before(
    tmp_path: Path, file: str, name: str, uses: int
) -> None:
    texts = {"Lib.rscd": CALLED, "robot.rscd": CALLS}
    workspace = Workspace(folders=[str(tmp_path)])
    analyses = {}
    for one, text in texts.items():
        (tmp_path / one).write_text(text)
        analyses[one] = open_text(workspace, tmp_path / one, text)
    symbol = next(
        o.symbol for o in analyses[file].index.occurrences if o.declaration and o.span.text == name
    )
    edits = rename(workspace, str(tmp_path / file), symbol, "other")
    changed = {Path(f).name: applied(e[0].span.source, list(e)) for f, e in edits.items()}
    word = re.compile(rf"\b{name}\b")
    assert sum(map(len, edits.values())) == uses
    for one, text in texts.items():
        assert changed.get(one, text) == word.sub("other", text)
