"""Libraries: where they are found, what their names mean, prefixes."""

from __future__ import annotations

from pathlib import Path

import pytest

from robosc.errors import Diagnostic, Severity, render_all
from robosc.expr.tree import Binary, Literal
from robosc.expr.types import EnumType
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions

WHEELS = """library Wheels {
    component Wheel {
        incoming message turn with identifier: "turn", type: double
        outgoing message speed with identifier: "/speed", type: Pace
        outgoing message slip with type: none
        behaviour {
            variable pace: Pace
            initial marked state still { on request to turn goto turning }
            marked state turning {
                on response from speed do pace := value
                on response from slip if pace = quick goto still
            }
        }
    }
    datatype enum Pace from double to { value > 3 -> quick default -> calm }
}
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    folder = tmp_path / "robots" / "one"
    folder.mkdir(parents=True)
    return folder / "one.rscd"


def read(
    model: Path, text: str, library_path: tuple[str, ...] = ()
) -> tuple[Robot | None, tuple[Diagnostic, ...]]:
    model.write_text(f"robot One {{\n{text}\n}}\n")
    return load(str(model), library_path, MessageDefinitions.for_model(model, {}))


def robot_of(model: Path, text: str, library_path: tuple[str, ...] = ()) -> Robot:
    robot, diagnostics = read(model, text, library_path)
    assert robot is not None, render_all(diagnostics)
    return robot


def codes(diagnostics: tuple[Diagnostic, ...]) -> list[str]:
    return [d.code for d in diagnostics]


TWO = """
component Left from Wheels import Wheel with prefix: "/left"
component Right from Wheels import Wheel with prefix: "right/"
"""


def test_two_imports_of_one_component_have_topics_of_their_own(model: Path) -> None:
    (model.parent / "anything.rscd").write_text(WHEELS)
    robot = robot_of(model, TWO + "requirement Left.turn needs Right.still")
    assert {c.key: c.identifier for c in robot.communications.values()} == {
        "Left.turn": "/left/turn",
        "Left.speed": "/left/speed",
        "Left.slip": "/left/slip",
        "Right.turn": "right/turn",
        "Right.speed": "right/speed",
        "Right.slip": "right/slip",
    }
    assert robot.component("Right").library == "Wheels"
    right = robot.component("Right").behaviour
    assert right is not None
    assert right.states[0].transitions[0].communication == "Right.turn"
    assert right.variables[0].key == "Right.pace"
    assert robot.display_names["Left.turn"] == "Left.turn"


def test_a_bare_name_of_two_imports_is_ambiguous(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    _, diagnostics = read(model, TWO + "requirement turn needs Right.still")
    assert codes(diagnostics) == ["ambiguous-name"]
    assert diagnostics[0].hint == "write Left.turn or Right.turn"


def test_an_enum_of_the_library_is_compared_without_being_in_sight(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    robot = robot_of(
        model,
        TWO
        + "requirement Left.turn needs Right.pace = calm and Left.pace != Pace.quick\n"
        + "requirement Left.turn needs Right.pace = Left.pace",
    )
    condition = robot.requirements[0].condition
    assert isinstance(condition, Binary) and isinstance(condition.left, Binary)
    calm = condition.left.right
    assert isinstance(calm, Literal) and isinstance(calm.type, EnumType)
    assert (calm.type.origin, calm.type.name) == ("Wheels", "Pace")


def test_a_value_of_an_enum_is_named_with_its_library(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    robot = robot_of(model, TWO + "requirement Left.turn needs Right.pace = Wheels.Pace.calm")
    condition = robot.requirements[0].condition
    assert isinstance(condition, Binary) and isinstance(condition.right, Literal)
    assert (condition.right.value, str(condition.right.type)) == ("calm", "Pace")


@pytest.mark.parametrize(
    ("written", "message", "hint"),
    [
        ("Wheels.Pace.cal", "Wheels.Pace has no value 'cal'", "did you mean 'calm'?"),
        (
            "Wheels.calm",
            "library Wheels has no constant, parameter or condition 'calm'",
            "for the value of an enum write calm or Wheels.Pace.calm",
        ),
    ],
)
def test_names_that_a_library_does_not_have(
    model: Path, written: str, message: str, hint: str
) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    _, diagnostics = read(model, TWO + f"requirement Left.turn needs Right.pace = {written}")
    assert [(d.message, d.hint) for d in diagnostics if d.severity is Severity.ERROR] == [
        (message, hint)
    ]


def test_a_library_does_not_lend_its_types(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    text = TWO + "component Mine { outgoing message mine with type: Pace }"
    assert codes(read(model, text)[1]) == ["unknown-type"]


@pytest.mark.parametrize("place", [".", "../shared", "../libraries", "../../elsewhere"])
def test_where_libraries_are_found(model: Path, place: str) -> None:
    folder = (model.parent / place).resolve()
    folder.mkdir(exist_ok=True)
    (folder / "wheels.rsc").write_text("// the wheels\n/* of\nit */ " + WHEELS)
    assert robot_of(model, TWO, (str(model.parents[2] / "elsewhere"),))


def test_a_package_offers_its_libraries(model: Path) -> None:
    package = model.parent / "wheel_package"
    (package / "robosc" / "libraries").mkdir(parents=True)
    (package / "robosc" / "libraries" / "wheels.rscd").write_text(WHEELS)
    (package / "package.xml").write_text(
        "<package><name>wheel_package</name><version>1.0.0</version><description>Wheels."
        '</description><maintainer email="ada@example.org">Ada</maintainer><license>MIT</license>'
        '<export><robosc libraries="${prefix}/robosc/libraries"/></export></package>'
    )
    assert robot_of(model, TWO)


def test_one_library_in_two_places_with_one_content_is_fine(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    shared = model.parents[1] / "shared"
    shared.mkdir()
    (shared / "wheels.rscd").write_text(WHEELS)
    assert robot_of(model, TWO)
    (shared / "wheels.rscd").write_text(WHEELS.replace("> 3", "> 4"))
    assert codes(read(model, TWO)[1]) == ["library-clash", "library-clash"]


def test_an_error_in_a_library_is_told_once_at_its_place_with_the_import(model: Path) -> None:
    library = model.parent / "wheels.rscd"
    library.write_text(WHEELS.replace("goto still", "goto stil"))
    robot, diagnostics = read(model, TWO + "requirement Left.turn needs Right.stil")
    assert robot is None
    assert codes(diagnostics) == ["unknown-state"]
    (error,) = diagnostics
    assert error.span.source.path == str(library)
    assert error.notes[-1].span is not None
    assert error.notes[-1].span.source.path == str(model)


def test_a_library_that_does_not_parse_is_told_at_its_place(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS.replace("variable pace:", "variable pace"))
    assert codes(read(model, TWO)[1]) == ["syntax"]


def test_a_library_is_checked_on_its_own(tmp_path: Path) -> None:
    library = tmp_path / "wheels.rscd"
    library.write_text(WHEELS)
    robot, diagnostics = load(str(library), definitions=MessageDefinitions())
    assert robot is None
    assert not [d for d in diagnostics if d.severity is Severity.ERROR]
    library.write_text(WHEELS.replace("= quick", "= quik"))
    assert codes(load(str(library), definitions=MessageDefinitions())[1]) == ["unknown-name"]


def test_a_library_passes_on_what_it_imports_with_both_prefixes(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    (model.parent / "cars.rscd").write_text(
        'library Cars { component Front from Wheels import Wheel with prefix: "front" }'
    )
    robot = robot_of(model, 'component F from Cars import Front with prefix: "/car"')
    assert robot.communications["F.turn"].identifier == "/car/front/turn"


HANDS = """library Hands {
    component Finger { outgoing message touched with type: none
        behaviour { variable bent: boolean initial marked state free {} } }
    component Arm {
        incoming message lower with type: none
        behaviour {
            initial marked state high { on request to lower goto low }
            state low {
                on response from touched if !Finger.bent and Finger.free goto high
                transition if Arm.low goto high
            }
        }
    }
}
"""


def test_components_of_a_library_that_belong_together_share_a_prefix(model: Path) -> None:
    (model.parent / "hands.rscd").write_text(HANDS)
    robot = robot_of(
        model,
        """
        component LA from Hands import Arm with prefix: "/l"
        component LF from Hands import Finger with prefix: "/l"
        component RA from Hands import Arm with prefix: "/r"
        component RF from Hands import Finger with prefix: "/r"
        """,
    )
    behaviour = robot.component("RA").behaviour
    low = behaviour.states[1]
    assert low.transitions[0].communication == "RF.touched"
    assert "component='RF'" in str(low.transitions[0].guard)
    assert "component='RA'" in str(low.taus[0].guard)


def test_a_part_of_a_library_without_its_other_part_is_incomplete(model: Path) -> None:
    (model.parent / "hands.rscd").write_text(HANDS)
    _, diagnostics = read(model, "component A from Hands import Arm")
    assert codes(diagnostics) == ["import-incomplete"]
    assert diagnostics[0].hint == "add: component Finger from Hands import Finger"


def test_what_an_import_keeps_may_be_compared_though_it_is_not_finite(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(
        WHEELS.replace("variable pace: Pace", "variable pace: Pace variable raw: double")
    )
    robot, diagnostics = read(model, TWO + "requirement Left.turn needs Right.raw > 1")
    assert robot is not None, diagnostics
    behaviour = robot.component("Right").behaviour
    assert {v.name: v.in_state for v in behaviour.variables}["raw"]


def test_a_bad_prefix_is_marked(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    text = 'component Left from Wheels import Wheel with prefix: "/le ft"'
    assert codes(read(model, text)[1]) == ["ros-name"]


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("WHEELS", "did you mean 'Wheels'?"),
        ("Engines", "there are: EStop, Hands, Velocity, Wheels, Zones"),
    ],
)
def test_a_library_that_is_not_there_is_looked_for_by_name(
    model: Path, name: str, hint: str
) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS)
    (model.parent / "hands.rscd").write_text(HANDS)
    (error,) = read(model, f"component A from {name} import B")[1]
    assert error.code == "library-not-found"
    assert error.hint is not None
    assert error.hint.startswith(f"{hint}\nlooked in: ")


def test_one_library_imported_from_two_folders_is_one(model: Path) -> None:
    shared = model.parents[1] / "shared"
    shared.mkdir()
    (model.parent / "hands.rscd").write_text(HANDS)
    (shared / "hands.rscd").write_text(HANDS)
    (shared / "bodies.rscd").write_text(
        "library Bodies { component Side from Hands import Finger }"
    )
    robot = robot_of(
        model,
        "component A from Hands import Arm\ncomponent F from Bodies import Side",
    )
    behaviour = robot.component("A").behaviour
    assert behaviour.states[1].transitions[0].communication == "F.touched"
    (shared / "hands.rscd").write_text(HANDS + "// changed\n")
    assert "library-clash" in codes(
        read(model, "component F from Bodies import Side\ncomponent A from Hands import Arm")[1]
    )


def test_a_library_cannot_have_the_name_of_the_robot(model: Path) -> None:
    (model.parent / "wheels.rscd").write_text(WHEELS.replace("Wheels", "One"))
    assert codes(read(model, TWO.replace("Wheels", "One"))[1]) == ["library-clash"] * 2


def test_a_chain_of_libraries_ends_with_an_error_not_with_the_stack(model: Path) -> None:
    for i in range(60):
        text = f"library L{i} {{ component C from L{i + 1} import C }}"
        (model.parent / f"l{i}.rscd").write_text(text)
    assert codes(read(model, "component C from L0 import C")[1]) == ["too-deep"]


@pytest.mark.parametrize("start", ["robots/one", "robots", "robots/one/deep"])
def test_paths_are_relative_as_the_user_gave_them(
    model: Path, monkeypatch: pytest.MonkeyPatch, start: str
) -> None:
    root = model.parents[2]
    (root / "robots" / "shared").mkdir()
    (root / "robots" / "shared" / "wheels.rscd").write_text(WHEELS)
    (model.parent / "deep").mkdir()
    model.write_text(f"robot One {{ {TWO} }}")
    monkeypatch.chdir(root / start)
    relative = {"robots/one": "one.rscd", "robots": "one/one.rscd"}.get(start, "../one.rscd")
    robot, diagnostics = load(relative, definitions=MessageDefinitions())
    assert robot is not None, render_all(diagnostics)


STAMPS = """library Stamps {
    datatype object Vector { x: double }
    interface vector use Vector3 from geometry_msgs
    interface goal use GoalStatus from actionlib_msgs
}
"""


def test_the_interfaces_of_a_library_are_there_under_its_name(model: Path) -> None:
    library = model.parent / "Stamps.rscd"
    library.write_text(STAMPS)
    assert load(str(library), (), MessageDefinitions())[1] == ()  # who imports it may use them
    robot = robot_of(
        model,
        """
        component Pump {
            incoming message push with type: Stamps.Vector links Stamps.vector
            outgoing message state with timeout: 1 s, type: actionlib_msgs/GoalStatus
            behaviour {
                variable gone: boolean
                on response from state do gone := value.status = Stamps.goal.ABORTED
                initial marked state on_ {}
            }
        }
        requirement push needs state.fresh and !Pump.gone
        stop with push
        """,
    )
    binding = robot.communications["Pump.push"].binding
    assert (binding.package, binding.type) == ("geometry_msgs", "Vector3")


@pytest.mark.parametrize(
    ("linked", "marked", "hint"),
    [
        ("Stamps.vectr", "vectr", "did you mean 'vector'?"),
        ("Stmps.vector", "Stmps", "declare: interface vector use TYPE from PACKAGE"),
    ],
)
def test_interfaces_that_no_library_has(model: Path, linked: str, marked: str, hint: str) -> None:
    (model.parent / "Stamps.rscd").write_text(STAMPS)
    text = f"component Pump {{ incoming message push with type: Stamps.Vector links {linked} }}"
    (found,) = read(model, text)[1]
    assert (found.message, found.span.text) == (f"there is no interface '{linked}'", marked)
    assert found.hint == hint
