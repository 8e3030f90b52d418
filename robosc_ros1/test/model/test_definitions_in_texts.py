"""Texts of definitions as packages and recordings have them, read as ROS's own tools read them."""

from __future__ import annotations

import pytest

from robosc.expr.types import Value
from robosc.model.ros import rosidl
from robosc.model.ros.interfaces import Default, Definition
from robosc.model.ros.recorded import definitions


def message(text: str) -> Definition:
    (found,) = rosidl.texts(text, "p", "Odd", "msg")
    return found


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("uint32 A=0000000000000010", 10),
        ("uint32 A=010", 10),
        ("uint32 A=0x10", 16),
        ("int8 A = -05 # five", -5),
        ("string A='it\\'s'", "it's"),
        ('string A="a \\"b\\""', 'a "b"'),
        ("string A=a \\n b", "a \\n b"),
        ("wstring A='w'", "w"),
        ("float32 A=010", 10.0),
    ],
)
def test_constants_of_ros_2(line: str, value: Value) -> None:
    assert message(line).constants == (("A", value),)


@pytest.mark.parametrize(
    ("line", "type_", "value"),
    [
        ('string a "say \\"no\\" # now"  # a comment', "string", 'say "no" # now'),
        ("string a 'it\\'s'", "string", "it's"),
        ("string<=22 a 'x'", "string", "x"),
        ("wstring<=22 a", "string", None),
        ("int32 a 007", "int32", 7),
        ("uint8[<=3] a [1, 2]", "uint8[]", (1, 2)),
        ("float64[2] a [1.0, 2.0]  # a comment", "float64[2]", (1.0, 2.0)),
        ("int32[] a []", "int32[]", ()),
        ("int32[] a", "int32[]", None),
        ("bool[2] a [true, 0]", "bool[2]", (True, False)),
        ("string[] a ['one, two', \"three\"]", "string[]", ("one, two", "three")),
        ("string[] a [one, two]", "string[]", ("one", "two")),
        ('string[] a [one, two]  # as in ["x"]', "string[]", ("one", "two")),
        ("string[] a [\"a]\", 'it\\'s']  # ['x']", "string[]", ("a]", "it's")),
        ("p/msg/Other a", "p/Other", None),
    ],
)
def test_fields_of_ros_2(line: str, type_: str, value: Default | None) -> None:
    (field,) = message(line).fields
    assert (str(field.type), field.default) == (type_, value)
    assert field.type.wide == line.startswith("wstring")


@pytest.mark.parametrize(
    ("line", "doubt"),
    [
        ("uint8 MOST=300", "line 1: 300 is not from 0 to 255"),
        ("int8 a -200", "line 1: -200 is not from -128 to 127"),
        ("int8[2] a [3, -200]", "line 1: -200 is not from -128 to 127"),
        ("uint8 lower=1", "line 1: the name lower must be of upper case"),
        ("uint8 Upper", "line 1: the name Upper must be of lower case"),
        ("uint8 a__b", "line 1: the name a__b must be of lower case"),
    ],
)
def test_what_rosidl_refuses_is_understood_and_doubted(line: str, doubt: str) -> None:
    (found,) = message(line).doubts
    assert found.startswith(doubt)
    assert message("uint8 MOST=255\nint8 a_1 -100\n").doubts == ()


IDL = """
#include "q/msg/Pose.idl"
module p { module msg {
    typedef q::msg::Pose Pose;
    typedef double Triple[3];
    enum Colour { RED, GREEN };
    module Odd_Constants { const short SIZE = 2; const string TEXT = "a" "b"; };
    struct Inner { short a, b; };
    struct Odd {
        double covariance[9], one;
        short rows[SIZE];
        @default (value="it's \\"so\\"") string name;
        @default (value="(1.5, 2.0)") sequence<double, 3> many;
        @default (value="(\\"a, b\\", \\"c\\")") string labels[2];
        sequence<Inner> inners;
        sequence<string<5>> words;
        wstring<7> wide;
        Triple triple; Pose pose; Colour colour; q::msg::Pose other;
        @verbatim (language="comment", text="struct Odd { int x; };") unsigned long long last;
    };
}; };
"""


def test_idl() -> None:
    found = rosidl.idl_structs(IDL, "p")
    assert {f.name: str(f.type) for f in found["Odd"].fields} == {
        "covariance": "float64[9]", "one": "float64", "rows": "int16[2]", "name": "string",
        "labels": "string[2]",
        "many": "float64[]", "inners": "p/Inner[]", "words": "string[]", "wide": "string",
        "triple": "float64[3]", "pose": "q/Pose", "colour": "uint32", "other": "q/Pose",
        "last": "uint64",
    }  # fmt: skip
    assert found["Odd"].constants == (("SIZE", 2), ("TEXT", "ab"))
    defaults = {f.name: f.default for f in found["Odd"].fields if f.default is not None}
    assert defaults == {"name": 'it\'s "so"', "many": (1.5, 2.0), "labels": ("a, b", "c")}
    assert [f.name for f in found["Inner"].fields] == ["a", "b"]


LINE = "=" * 80 + "\n"


@pytest.mark.parametrize(
    ("text", "type_", "schema", "fields"),
    [
        ("int8 a\r\np/B b\r\n" + LINE + "MSG: p/B\r\nint8 c\r\n", "p/A", "ros1msg",
         {"p/A": "a b", "p/B": "c"}),
        ("B b\n" + LINE + "MSG: p/B\nint8 c\n", "p/msg/A", "ros2msg", {"p/A": "b", "p/B": "c"}),
        ("", "std_msgs/msg/Empty", "ros2msg", {"std_msgs/Empty": ""}),
        # A service, as rosbag2 records its events.
        ("bool on\n---\nbool done\n", "p/srv/Set_Event", "ros2msg",
         {"p/SetRequest": "on", "p/SetResponse": "done", "p/Set_Event": "info request response"}),
        ("int8 a\n---\n---\nint8 b\n" + LINE + "SRV: p/srv/S\n---\n", "p/action/Go_FeedbackMessage",
         "ros2msg", {"p/GoGoal": "a", "p/GoResult": "", "p/GoFeedback": "b",
                     "p/Go_FeedbackMessage": "goal_id feedback", "p/SRequest": "", "p/SResponse": "",
                     "p/S_Event": "info request response"}),
        (LINE + "IDL: p/msg/A\nmodule p { struct A { double x; }; };\n" + LINE
         + "IDL: q/msg/B\nmodule q { struct B { double y; }; };\n", "p/msg/A", "ros2idl",
         {"p/A": "x", "q/B": "y"}),
    ],
)  # fmt: skip
def test_recorded_texts(text: str, type_: str, schema: str, fields: dict[str, str]) -> None:
    found = definitions(text, type_, schema)
    assert {name: " ".join(f.name for f in d.fields) for name, d in found.items()} == fields


def test_what_is_wrong_in_a_recorded_text_is_said_of_its_type() -> None:
    with pytest.raises(ValueError, match=r"the definition of p/B: line 2: 'int8' is neither"):
        definitions("int8 a\n" + LINE + "MSG: p/B\n\nint8\n", "p/msg/A", "ros2msg")
