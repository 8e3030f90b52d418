"""Which command a message means that several commands may mean, or why that cannot be told."""

from __future__ import annotations

import ast
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import pytest
from emit.generated_code import supervisor_of
from ros2.launching import (
    AnyLaunchDescriptionSource,
    IncludeLaunchDescription,
    Node,
    PushRosNamespace,
    SetRemap,
    started,
)

from robosc import pipeline
from robosc.emit.package import ros1_target, ros2_target
from robosc.emit.package.config import Config
from robosc.emit.supervisor.command_recognition import CommandMatch, command_matches
from robosc.emit.write.writer import write
from robosc.errors import ModelError, UsageError

MODEL = """
robot Cart {
    interface twist use Twist from geometry_msgs
    datatype object Twist { linear: Vector  angular: Vector }
    datatype object Vector { x: double  z: double }
    component Sensor {
        outgoing message speed with type: double
        behaviour {
            variable wanted: double
            initial marked state on { on response from speed do wanted := value }
        }
    }
    component Motor {
        incoming message drive with identifier: "/vel", type: Twist links twist
        incoming message turn with identifier: "/vel", type: Twist links twist
        incoming message stop with identifier: "/vel", type: Twist links twist
        incoming message horn with type: none
    }
    %s
}
"""
EMITTERS = {
    "ros1": partial(ros1_target.emit, mode="supervisor"),
    "ros2": partial(ros2_target.emit, mode="supervisor"),
}
VEL = ("/vel", "geometry_msgs/Twist")
DRIVE = "provide drive with { linear: { x: Sensor.wanted }, angular: { z: 0.0 } }"
TURN = "provide turn with { linear: { x: Sensor.wanted }, angular: { z: 1.0 } }"
STOP = "provide stop with { linear: { x: 0.0 }, angular: { z: 0.0 } }"


def found(*provides: str) -> dict[tuple[str, str], tuple[CommandMatch, ...]]:
    return command_matches(supervisor_of(MODEL % "\n".join(provides)).plant.robot)


def test_a_topic_with_one_command_needs_nothing() -> None:
    assert found(DRIVE, TURN, STOP)["horn", "std_msgs/Empty"] == (CommandMatch("Motor.horn"),)


def test_constant_data_are_known_exactly_and_others_by_a_field() -> None:
    assert found(DRIVE, TURN, STOP)[VEL] == (
        CommandMatch("Motor.stop", exact=({"linear": {"x": 0.0}, "angular": {"z": 0.0}},)),
        CommandMatch("Motor.drive", field=(("angular", "z"), (0.0,))),
        CommandMatch("Motor.turn", field=(("angular", "z"), (1.0,))),
    )


def test_exact_data_go_first_in_the_node() -> None:
    """A stop has the field by which driving is known."""
    files = EMITTERS["ros2"](
        supervisor_of(MODEL % f"{DRIVE} {TURN} {STOP}"), "cart_supervisor"
    ).files
    node = files["cart_supervisor/node.py"].content
    assert node.index('"Motor.stop"') < node.index('"Motor.drive"')


def test_one_command_may_mean_all_the_rest() -> None:
    turn = "provide turn with { angular: { z: 1.0 } } if Sensor.on provide turn with {}"
    matches = {r.key: r for r in found(DRIVE, turn, "provide stop with { linear: { x: -1 } }")[VEL]}
    assert matches["Motor.drive"] == CommandMatch("Motor.drive")
    assert matches["Motor.turn"].exact == ({"angular": {"z": 1.0}}, {})
    assert matches["Motor.stop"].exact == ({"linear": {"x": -1}},)


def test_a_command_without_data_carries_the_defaults() -> None:
    """As in a package that commands by itself."""
    assert found(DRIVE, TURN)[VEL] == found(DRIVE, TURN, "provide stop with {}")[VEL]
    assert CommandMatch("Motor.stop", exact=({},)) in found(DRIVE, TURN)[VEL]


def test_a_stop_without_data_never_means_the_rest() -> None:
    """Else what is faster than all others would be the stop, which nothing forbids."""
    provides = [
        f"provide {name} with {{ linear: {{ x: {x} }} }}" for name, x in (("drive", 1), ("turn", 2))
    ]
    exact = {match.key: match.exact for match in found(*provides, "stop with stop")[VEL]}
    assert exact["Motor.stop"] == ({},)
    assert all(exact.values())


def test_a_stop_without_data_leaves_the_rest_to_another() -> None:
    matches = {
        m.key: m for m in found("provide turn with { angular: { z: 1.0 } }", "stop with stop")[VEL]
    }
    assert matches["Motor.stop"].exact == ({},)
    assert matches["Motor.drive"] == CommandMatch("Motor.drive")


@pytest.mark.parametrize(("one", "other"), [("/arm", "arm"), ("~arm", "~/arm")])
def test_a_topic_has_two_directions_however_its_name_is_written(one: str, other: str) -> None:
    text = f"""robot Cart {{ component Arm {{
        outgoing message place with identifier: "{one}", type: double
        incoming message move with identifier: "{other}", type: double
    }} provide move with 1.0 }}"""
    with pytest.raises(ModelError) as refused:
        command_matches(supervisor_of(text).plant.robot)
    assert [d.code for d in refused.value.diagnostics] == ["topic-both-ways"]


@pytest.mark.parametrize(
    ("provides", "fault"),
    [
        (
            [DRIVE, STOP, TURN.replace("1.0", "Sensor.wanted")],
            "cannot distinguish 'turn' from 'drive' on the topic '/vel': no field has",
        ),
        (
            [DRIVE, STOP],
            "cannot distinguish 'turn' from 'stop' on the topic '/vel': they can carry the",
        ),
        (
            [DRIVE, "provide turn with { linear: { x: 0 } }", STOP],
            "cannot distinguish 'stop' from 'turn' on the topic '/vel': they can carry the same data",
        ),
    ],
)
def test_what_cannot_be_told_apart_is_refused(provides: list[str], fault: str) -> None:
    with pytest.raises(ModelError) as refused:
        EMITTERS["ros2"](supervisor_of(MODEL % "\n".join(provides)), "cart_supervisor")
    (diagnostic,) = refused.value.diagnostics
    assert diagnostic.code == "commands-alike"
    assert fault in diagnostic.message


GUARDED = {
    "package": "wild", "executable": "wild.py", "name": "w", "namespace": "far",
    "arguments": '--say "a & b"',
}  # fmt: skip


@pytest.mark.parametrize("target", EMITTERS)
def test_the_configuration_tells_what_is_guarded(target: str) -> None:
    config = Config(supervisor=GUARDED)
    supervisor = supervisor_of(MODEL % f"{DRIVE} {TURN} {STOP}")
    files = EMITTERS[target](supervisor, "cart_supervisor", config).files
    if target == "ros2":
        launch = files["launch/cart_supervisor.launch.py"].content
        values = {n.value for n in ast.walk(ast.parse(launch)) if isinstance(n, ast.Constant)}
    else:
        launch = files["launch/cart_supervisor.launch"].content
        tree = ElementTree.fromstring(launch)
        values = {tag.get("default") for tag in tree.iter("arg")}
        values |= {tag.get("ns") for tag in tree.iter("node")}
    assert set(GUARDED.values()) <= values


@pytest.mark.parametrize("target", EMITTERS)
def test_a_launch_file_may_start_what_is_guarded(target: str, tmp_path: Path) -> None:
    config = Config(supervisor={"package": "wild", "launch_file": "wild.launch"})
    supervisor = supervisor_of(MODEL % f"{DRIVE} {TURN} {STOP}")
    package = EMITTERS[target](supervisor, "cart_supervisor", config)
    files = package.files
    if target == "ros2":
        pytest.importorskip("yaml")
        write(package, tmp_path)
        launch = tmp_path / "cart_supervisor" / "launch" / "cart_supervisor.launch.py"
        node, group = started(launch, lambda name: f"/share/{name}", ns="left")
        assert isinstance(node, Node)
        namespace, *remaps, include = group.actions
        assert namespace == PushRosNamespace("left")
        assert SetRemap(src="/vel", dst="/supervised/vel") in remaps
        source = AnyLaunchDescriptionSource("/share/wild/launch/wild.launch")
        assert include == IncludeLaunchDescription(source)
        assert [type(a) for a in started(launch, str, controller_package="")] == [Node]
    else:
        tree = ElementTree.fromstring(files["launch/cart_supervisor.launch"].content)
        (group,) = tree.iter("group")
        (include,) = group.iter("include")
        assert include.get("file") == "$(find wild)/launch/wild.launch"
        assert {r.get("to") for r in group.iter("remap")} >= {"/supervised/vel"}
        assert len(list(tree.iter("node"))) == 1


def test_a_key_of_the_section_that_is_not_known_is_refused() -> None:
    config = Config(supervisor={"node": "wild"})
    with pytest.raises(
        UsageError, match="must give texts for package, executable, name, namespace, arg"
    ):
        EMITTERS["ros1"](supervisor_of(MODEL % f"{DRIVE} {TURN} {STOP}"), "c", config)


def test_the_configuration_s_name_is_the_controller_s(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    (tmp_path / "robosc.yaml").write_text("package: my_cart\n")
    model = tmp_path / "cart.rscd"
    model.write_text(MODEL % f"{DRIVE} {TURN} {STOP}")
    modes: tuple[pipeline.Mode, ...] = ("controller", "supervisor")
    for mode in modes:
        pipeline.generate(model, output=pipeline.Output(folder=tmp_path / "src", mode=mode))
    assert {f.name for f in (tmp_path / "src").iterdir()} == {"my_cart", "cart_supervisor"}


def test_numbers_without_end_and_no_numbers() -> None:
    stop = "provide stop with { linear: { x: 1.0 / 0.0 } }"
    turn = "provide turn with { linear: { x: 0.0 / 0.0 } }"
    drive = 'incoming message drive with identifier: "/vel", type: Twist links twist'
    supervisor = supervisor_of((MODEL % f"{stop} {turn}").replace(drive, ""))
    matches = {r.key: r for r in command_matches(supervisor.plant.robot)[VEL]}
    assert matches["Motor.turn"] == CommandMatch("Motor.turn")
    node = EMITTERS["ros1"](supervisor, "c").files["src/c/node.py"].content
    assert '{"linear": {"x": float("inf")}}' in node
