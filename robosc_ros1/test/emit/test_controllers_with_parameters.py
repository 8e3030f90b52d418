"""Generated controllers of models that declare parameters."""

from __future__ import annotations

from typing import Any

import pytest
from emit.generated_code import controller_class, controller_source, supervisor_of
from emit.golden_packages import model_path
from emit.scripted_controllers import scripts_of, tells_apart

from robosc import pipeline
from robosc.emit.package import ros1_target, ros2_target
from robosc.emit.package.config import Config, declared_communications, declared_parameters
from robosc.errors import UsageError
from robosc.runtime.core.settings import ParameterError, Settings, read
from robosc.supervisor import Supervisor

DEFAULTS = {
    "wanted": 20.5, "steps": 2, "season": "winter", "greeting": "warm", "limit": 90,
    "Sensor/silence": 5.0, "Heater/eager": False, "Heater/pause": 60.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def thermostat() -> Supervisor:
    """Parameters of all types, in all places."""
    return pipeline.synthesize(pipeline.load(model_path("thermostat")).robot)


def settings_of(controller: Any, **given: Any) -> Settings:
    named = {name.replace("__", "/"): value for name, value in given.items()}
    return read(controller.COMMUNICATIONS, named, controller.PARAMETERS)[0]


def configured(supervisor: Supervisor, **given: Any) -> Any:
    controller = controller_class(supervisor)[0]()
    controller.configure(settings_of(controller, **given).more)
    return controller


def test_it_has_the_defaults_until_it_is_told_others(thermostat: Supervisor) -> None:
    controller = controller_class(thermostat)[0]()
    assert controller.parameters() == DEFAULTS
    assert configured(thermostat).parameters() == DEFAULTS
    changed = configured(thermostat, wanted=18, Heater__eager=True)
    assert changed.parameters() == {**DEFAULTS, "wanted": 18.0, "Heater/eager": True}
    assert changed.copy().parameters() == changed.parameters()


def test_conditions_data_and_enums_follow_them(thermostat: Supervisor) -> None:
    cold, mild = configured(thermostat, wanted=30, steps=3), configured(thermostat, steps=1)
    for controller in (cold, mild):
        controller.on_response_of_reading(20.0)
    assert (cold.can_request_heat(), mild.can_request_heat()) == (True, False)
    assert (cold.can_request_say(), mild.can_request_say()) == (True, False)
    assert cold.data_for_heat() == {"data": pytest.approx(10 / 3)}
    assert cold.data_for_say() == {"data": "warm!"}
    message = type("Message", (), {"data": 19.0})()
    assert cold.read_response_of_outside(message) == "winter"
    assert mild.read_response_of_outside(message) == "summer"
    cold.request_heat()
    assert cold.heater_level == 3


def test_durations_are_those_of_their_parameters(thermostat: Supervisor) -> None:
    controller = controller_class(thermostat)[0]()
    (after,) = controller.AFTERS
    settings = settings_of(controller, Sensor__silence=0.25, Heater__pause=3)
    assert settings.timeout_of("Sensor.reading") == 0.25
    assert settings.seconds(after.delay) == 3.0
    assert "timeout/reading" not in {p.name for p in controller.PARAMETERS}


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("wanted", "warm", "a number, not 'warm'"),
        ("wanted", "1e3", "a number (in YAML with a point: 1.0e3), not '1e3'"),
        ("wanted", True, "a number, not True"),
        ("wanted", float("nan"), "a number, not nan"),
        ("steps", 4, "an integer of at most 3, not 4"),
        ("steps", 0, "an integer of at least 1, not 0"),
        ("steps", 2.0, "an integer, not 2.0"),
        ("steps", "1e3", "an integer, not '1e3'"),
        ("limit", "ninety", "an integer, not 'ninety'"),
        ("limit", False, "an integer, not False"),
        ("season", "spring", "one of winter, summer, not 'spring'"),
        ("season", 3, "a string (in quotes), not 3"),
        ("greeting", 5, "a string (in quotes), not 5"),
        ("Heater__eager", 1, "true or false, not 1"),
        ("Heater__eager", "true", "true or false, not 'true'"),
        ("Heater__pause", 0, "a number of at least 0.001, not 0"),
    ],
)
def test_a_wrong_value_is_refused_by_name(
    thermostat: Supervisor, name: str, value: Any, told: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        settings_of(controller_class(thermostat)[0](), **{name: value})
    assert str(caught.value) == f"parameter ~{name.replace('__', '/')} must be {told}"


def test_every_type_is_declared_as_the_controller_has_it(thermostat: Supervisor) -> None:
    controller = controller_class(thermostat)[0]()
    robot = thermostat.plant.robot
    told = [parameter._replace(attribute="") for parameter in controller.PARAMETERS]
    assert told == declared_parameters(robot)
    communications = declared_communications(robot)
    assert [c.timeout for c in communications] == [c.timeout for c in controller.COMMUNICATIONS]


@pytest.mark.parametrize("emitter", [ros1_target.emit, ros2_target.emit])
def test_the_options_of_the_generator_give_other_defaults(
    thermostat: Supervisor, emitter: Any
) -> None:
    package = emitter(thermostat, "some_controller", Config(parameters={"wanted": 18.0}))
    texts = {path.rpartition("/")[2]: file.content for path, file in package.files.items()}
    assert "wanted: 18.0" in texts["some_controller.yaml"]
    assert "DEFAULTS = {'wanted': 18.0}" in texts["node.py"].replace('"', "'")
    with pytest.raises(UsageError, match="~steps must be an integer of at most 3, not 9"):
        emitter(thermostat, "some_controller", Config(parameters={"steps": 9}))


def test_names_that_python_or_launch_files_have_are_kept_apart() -> None:
    supervisor = supervisor_of(
        "robot R { parameter class: double = 1.0 parameter name: string = 'x'"
        " parameter ^value: integer = 3 parameter copy: boolean = true"
        " component Level { incoming message go with type: double"
        " incoming message call with type: string } parameter level: double = 2.0"
        " requirement go needs copy and ^value > 2 provide go with class * level"
        " provide call with name }"
    )
    controller = configured(supervisor, name="y")
    assert controller.can_request_go()
    assert controller.data_for_go() == {"data": 2.0}
    assert controller.data_for_call() == {"data": "y"}
    launch = (
        ros1_target.emit(supervisor, "r_controller").files["launch/r_controller.launch"].content
    )
    assert '<param name="name" value="$(arg name_)"' in launch


@pytest.mark.slow
def test_the_test_of_a_package_knows_them() -> None:
    text = model_path("thermostat").read_text(encoding="utf-8")
    supervisor = supervisor_of(text)
    scripts = scripts_of(supervisor)
    assert tells_apart(supervisor, scripts, controller_source(supervisor)) == []
    other = supervisor_of(text.replace("wanted: double = 20.5", "wanted: double = 15.0"))
    assert tells_apart(supervisor, scripts, controller_source(other)) != []
