"""Files with options beside a model: what they set, and what they may not hold."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from emit.golden_packages import model_path
from ros_support import Completed

from robosc import pipeline
from robosc.emit.package import ros1_target, ros2_target
from robosc.emit.package.config import Config
from robosc.emit.package.original_config import load_config
from robosc.errors import UsageError


def test_without_files_there_are_defaults(tmp_path: Path) -> None:
    assert load_config(tmp_path / "model.rscd") == Config()


def test_own_options(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    (tmp_path / "robosc.yaml").write_text(
        "package: my_robot\n"
        "version: 2.0.1\n"
        "maintainer: Ada\n"
        "email: ada@example.org\n"
        "license: MIT\n"
        "output: {ros1: ../ws/src, ROS2: ../ws2/src}\n"
        "parameters:\n"
        "  rate: 20\n"
        "  timeout: {grab: 2.5}\n"
    )
    config = load_config(tmp_path / "model.rscd")
    assert (config.package, config.version, config.maintainer) == ("my_robot", "2.0.1", "Ada")
    assert (config.email, config.licence) == ("ada@example.org", "MIT")
    assert config.output["ros1"] == tmp_path / "../ws/src"
    assert config.output["ros2"] == tmp_path / "../ws2/src"
    assert config.parameters == {"rate": 20, "timeout/grab": 2.5}


def test_the_file_of_the_original_and_own_options_before_it(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    (tmp_path / "controller-config.json").write_text(
        '{"output": {"ros1ControllerNodeLocation": "there", "ros2SupervisorNodeLocation": "guard"},'
        ' "supervisor": {"controller": {"run": {"packageName": "p", "executable": "e"}}}}'
    )
    config = load_config(tmp_path / "model.rscd")
    # The state is published unless somebody says no.
    assert config.parameters == {"legacy_state_topic": "/state", "event_log": ""}
    assert config.locations == {
        ("ros1", "controller"): tmp_path / "there",
        ("ros2", "supervisor"): tmp_path / "guard",
    }
    assert config.supervisor == {"package": "p", "executable": "e"}
    (tmp_path / "robosc.yaml").write_text(
        "parameters: {legacy_state_topic: /other}\noutput: {ros1: here}\n"
    )
    config = load_config(tmp_path / "model.rscd")
    assert config.parameters["legacy_state_topic"] == "/other"
    assert config.output["ros1"] == tmp_path / "here"
    assert config.locations == {("ros2", "supervisor"): tmp_path / "guard"}


def test_the_file_of_the_original_may_lie_below_the_model(tmp_path: Path) -> None:
    for folder in ("b", "a/deep", ".hidden"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "controller-config.json").write_text(
            json.dumps({"output": {"ros1ControllerNodeLocation": folder}})
        )
    # Folders in it are relative to the model all the same.
    config = load_config(tmp_path / "model.rscd")
    assert config.locations == {("ros1", "controller"): tmp_path / "a" / "deep"}


def test_a_faulty_file_further_down_is_a_warning(tmp_path: Path) -> None:
    file = tmp_path / "vendor" / "controller-config.json"
    file.parent.mkdir()
    file.write_text('{"output": ')
    config = load_config(tmp_path / "model.rscd")
    assert config.warnings == (f"{file}:1:12: Expecting value; this file is ignored",)
    assert (config.parameters, config.locations) == ({}, {})


def test_what_the_original_does_not_know_is_a_warning(tmp_path: Path) -> None:
    file = tmp_path / "controller-config.json"
    file.write_text(
        '{"writeEvents": true, "zzz": 1, "output": {"ros1ControllerLocation": "x"},'
        ' "supervisor": {"controler": {}, "controller": {"run": {"package": "p"}}}}'
    )
    config = load_config(tmp_path / "model.rscd")
    assert config.warnings == (
        f"{file}: unknown key 'writeEvents'; did you mean writeEventsToLog?",
        f"{file}: unknown key 'zzz'; known keys: publishStateInformation, writeEventsToLog, output,"
        " supervisor",
        f"{file}: unknown key 'ros1ControllerLocation' in output;"
        " did you mean ros1ControllerNodeLocation?",
        f"{file}: unknown key 'controler' in supervisor; did you mean controller?",
        f"{file}: unknown key 'package' in supervisor.controller.run; did you mean packageName?",
    )
    assert (config.locations, config.supervisor) == ({}, {})


@pytest.fixture
def limited_digits() -> Iterator[None]:
    """Python reads and prints no longer integers than at first; the command line does, and stays so."""
    before = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(4300)
    yield
    sys.set_int_max_str_digits(before)


@pytest.mark.usefixtures("limited_digits")
@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("robosc.yaml", "pakage: x", "unknown key 'pakage'; did you mean package?"),
        ("robosc.yaml", "zzz: x", "unknown key 'zzz'; known keys: package, output"),
        ("robosc.yaml", "version: 1", "version must be a text like 1.2.3, not 1"),
        ("robosc.yaml", "email: me", "email must be an address with a dotted domain, not 'me'"),
        ("robosc.yaml", "output: {ros3: x}", "output must be a folder, or folders for ros1"),
        ("robosc.yaml", "- a", "must hold keys and values"),
        ("robosc.yaml", "a: [", "while parsing"),
        ("controller-config.json", '{"a": }', "controller-config.json:1:7: Expecting value"),
        ("controller-config.json", '{"writeEventsToLog": 1}', "must be true or false, not 1"),
        ("controller-config.json", '{"output": "there"}', "output must be an object, not 'there'"),
        (
            "controller-config.json",
            '{"output": {"ros2ControllerNodeLocation": 1}}',
            "output.ros2ControllerNodeLocation must be a text, not 1",
        ),
        (
            "controller-config.json",
            '{"supervisor": {"controller": {"run": []}}}',
            "supervisor.controller.run must be an object, not []",
        ),
        ("controller-config.json", "[]", "must hold keys and values"),
        pytest.param("controller-config.json", "[" * 100000, "nested too deeply", id="deep JSON"),
        ("controller-config.json", "", "controller-config.json:1:1: Expecting value"),
        pytest.param("robosc.yaml", "[" * 5000, "nested too deeply", id="deep YAML"),
        ("robosc.yaml", "version: " + "1" * 5000, "Exceeds the limit"),
        ("robosc.yaml", "version: 0x" + "f" * 5000, "not an integer of too many digits"),
        ("robosc.yaml", "version: 2026-02-30", "robosc.yaml: day "),
        ("robosc.yaml", "parameters: [rate]", "parameters must be names of parameters"),
        ("robosc.yaml", "1: x", "unknown key 1; known keys"),
        (
            "robosc.yaml",
            "version: 1.2.3\nversion: 1.2.4",
            "robosc.yaml:2:1: duplicate key 'version'",
        ),
        ("robosc.yaml", "parameters: {rate: 1,\n  rate: 2}", ":2:3: duplicate key 'rate'"),
        ("robosc.yaml", "parameters: {a: [{b: 1, b: 2}]}", "duplicate key 'b'"),
        ("robosc.yaml", "supervisor: x", "supervisor must be a section, not 'x'"),
    ],
)
def test_faulty_files_are_refused(tmp_path: Path, name: str, text: str, complaint: str) -> None:
    if name.endswith("yaml"):
        pytest.importorskip("yaml")
    (tmp_path / name).write_text(text)
    with pytest.raises(UsageError) as caught:
        load_config(tmp_path / "model.rscd")
    assert complaint in str(caught.value)
    assert name in str(caught.value)


@pytest.mark.parametrize(
    ("parameters", "complaint"),
    [
        ({"rate": "fast"}, "~rate must be a number"),
        ({"rate": 10**400}, "~rate must be a number that a double can hold, not 1000"),
        ({"order": "any"}, "~order must be one of"),
        ({"rat": 3}, "unknown parameter ~rat; did you mean ~rate?"),
        ({"rat": 3, "order": "any"}, "~order must be one of"),
        ({"rat": 3, "order": "any"}, "unknown parameter ~rat; did you mean ~rate?"),
        ({"stop_command": "kindel"}, "~stop_command must name"),
        ({"qos/kindle/depth": 0}, "~qos/kindle/depth must be an integer of at least 1, not 0"),
        ({"qos/kindle/reliable": True}, "did you mean ~qos/kindle/reliability?"),
    ],
)
def test_parameters_must_fit_the_robot(parameters: dict[str, object], complaint: str) -> None:
    robot = pipeline.load(model_path("lantern")).robot
    with pytest.raises(UsageError) as caught:
        Config(parameters=parameters).checked(robot)
    assert complaint in str(caught.value)
    assert Config(parameters={"rate": 5, "stop_command": "snuff"}).checked(robot)


def test_messages_on_one_topic_have_one_quality_of_service() -> None:
    supervisor = pipeline.synthesize(pipeline.load(model_path("gauntlet")).robot)
    config = Config(parameters={"qos/shout/depth": 3, "qos/up/reliability": "reliable"})
    package = ros2_target.emit(supervisor, "gauntlet_controller", config)
    told = package.files["config/gauntlet_controller.yaml"].content
    assert "# length of the queue of say, shout (at least 1)\n    qos.say.depth: 3\n" in told
    assert 'qos.up.reliability: "reliable"' in told
    assert "qos.shout" not in told
    # A file that serves both targets means nothing to ROS 1.
    first = ros1_target.emit(supervisor, "gauntlet_controller", config)
    assert "qos" not in first.files["config/gauntlet_controller.yaml"].content
    with pytest.raises(UsageError) as caught:
        Config(parameters={"qos/say/depth": 3, "qos/shout/depth": 4}).checked(
            supervisor.plant.robot
        )
    assert "~qos/say/depth and ~qos/shout/depth must be the same" in str(caught.value)


def test_texts_come_through_to_the_parameter_file() -> None:
    yaml = pytest.importorskip("yaml")
    supervisor = pipeline.synthesize(pipeline.load(model_path("lantern")).robot)
    text = 'C:\\log "today"/größer'
    package = ros2_target.emit(supervisor, "lantern", Config(parameters={"event_log": text}))
    document = yaml.safe_load(package.files["config/lantern.yaml"].content)
    assert document["/**"]["ros__parameters"]["event_log"] == text


def test_generate_obeys_the_file_beside_the_model(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    model = tmp_path / "lantern.rscd"
    model.write_text(model_path("lantern").read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "robosc.yaml").write_text(
        "package: my_lantern\noutput: ws\nmaintainer: A & B\nversion: 3.2.1\n"
        "parameters: {rate: 25, stop_command: snuff}\n"
    )
    for target in ("ros1", "ros2"):
        done = pipeline.generate(model, output=pipeline.Output(target=target, force=True))
        assert done.files.folder == tmp_path / "ws" / "my_lantern"
        package = (done.files.folder / "package.xml").read_text(encoding="utf-8")
        assert "A &amp; B" in package
        assert "<version>3.2.1</version>" in package
        config = (done.files.folder / "config" / "my_lantern.yaml").read_text(encoding="utf-8")
        assert f"{'rate/default' if target == 'ros1' else 'rate'}: 25" in config
        assert 'stop_command: "snuff"' in config
    (tmp_path / "other.yaml").write_text("package: other\n")
    done = pipeline.generate(
        model, output=pipeline.Output(folder=tmp_path, config=tmp_path / "other.yaml")
    )
    assert done.files.folder == tmp_path / "other"


def test_a_file_that_is_named_must_be_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot read"):
        load_config(tmp_path / "model.rscd", tmp_path / "none.yaml")


def test_generate_obeys_the_file_of_the_original(
    robosc: Callable[..., Completed], tmp_path: Path
) -> None:
    (tmp_path / "models").mkdir()
    text = model_path("lantern").read_text(encoding="utf-8")
    (tmp_path / "models" / "lantern.rscd").write_text(text, encoding="utf-8")
    options = {
        "publishStateInformation": True,
        "writeEventsToLog": True,
        "output": {
            "ros1ControllerNodeLocation": "../one/src/steered",
            "ros2ControllerNodeLocation": "../two/src/steered",
        },
    }
    file = tmp_path / "models" / "controller-config.json"
    file.write_text("\ufeff" + json.dumps(options), encoding="utf-8")
    for target, place in (("ros1", "one"), ("ros2", "two")):
        done = robosc("generate", "models/lantern.rscd", "--target", target)
        assert done.returncode == 0, done.stderr
        # The folder becomes the package.
        package = tmp_path / place / "src" / "steered"
        assert "<name>lantern_controller</name>" in (package / "package.xml").read_text()
        assert "lantern_controller lantern_controller.launch" in done.stdout
        told = (package / "config" / "lantern_controller.yaml").read_text(encoding="utf-8")
        assert 'legacy_state_topic: "/state"\n' in told
        assert 'event_log: "~/.ros/log/lantern_controller.jsonl"\n' in told
    # What is typed goes before what is written down.
    done = robosc("generate", "models/lantern.rscd", "--output", "three", "--package", "other")
    told = (tmp_path / "three" / "other" / "config" / "other.yaml").read_text(encoding="utf-8")
    assert 'event_log: "~/.ros/log/other.jsonl"\n' in told
    file.write_text('{"writeEventToLog": true}', encoding="utf-8")
    done = robosc("generate", "models/lantern.rscd")
    assert done.returncode == 0
    assert done.stderr.endswith(
        "\nwarning: models/controller-config.json: unknown key 'writeEventToLog';"
        " did you mean writeEventsToLog?\n"
    )


def test_a_folder_below_the_home_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "robosc.yaml").write_text("output: ~/ws/src")
    assert load_config(tmp_path / "model.rscd").output["ros1"] == tmp_path / "home" / "ws" / "src"
