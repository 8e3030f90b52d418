"""Parameters that ROS 1's parameter server, which speaks XML-RPC, cannot carry as they are."""

from __future__ import annotations

import xmlrpc.client

import yaml
from emit.generated_code import supervisor_of

from robosc.emit.package import ros1_target
from robosc.emit.package.config import Config
from robosc.runtime.core.settings import Parameter, read

MODEL = """\
robot Wide {
    parameter big: integer = 5000000000
    parameter low: integer = -3
    parameter small: integer(0..9) = 5
    parameter far: double = 3.0
    component A {
        outgoing message a with type: double
        incoming message b with type: none
        behaviour {
            variable v: double = 0.0
            initial marked state s { on response from a do v := value }
        }
    }
    requirement b needs A.v > big or A.v < low or A.v = small or A.v = far
}
"""


def files(config: Config) -> dict[str, str]:
    package = ros1_target.emit(supervisor_of(MODEL), "wide", config)
    return {path: file.content for path, file in package.files.items()}


def test_the_parameter_file_can_be_loaded() -> None:
    given = yaml.safe_load(files(Config(parameters={"far": 6000000000}))["config/wide.yaml"])
    (carried,), _ = xmlrpc.client.loads(xmlrpc.client.dumps((given,)))
    assert (carried["big"], carried["low"], carried["far"]) == ("5000000000", -3, 6e9)


def test_the_launch_file_gives_what_may_be_wide_as_text_or_double() -> None:
    launch = files(Config())["launch/wide.launch"]
    for name, type_ in (
        ("big", ' type="str"'),
        ("low", ' type="str"'),
        ("small", ""),
        ("far", ' type="double"'),
    ):
        assert f'<param name="{name}" value="$(arg {name})"{type_}\n' in launch


def test_the_node_reads_an_integer_that_is_text() -> None:
    big = Parameter("big", "integer", 1, "a number")
    for text, value in (
        ("5000000000", 5000000000),
        ("-9223372036854775808", -(2**63)),
        ("7", 7),  # as the launch file gives it
        (7, 7),
    ):
        settings, _ = read((), {"big": text}, (big,))
        assert settings.more == {"big": value}
