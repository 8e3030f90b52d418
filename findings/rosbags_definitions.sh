#!/bin/sh
# rosbags 0.11.9 does not parse definitions that ROS takes: genmsg and rosidl read files with CRLF,
# genmsg constants in lower case, and IDL of rosidl begins with its includes.
# With spaces around its =, a constant in lower case becomes a field: of messages with one, all that
# follows is read from the wrong place.
# Seen: "CRLF: TypesysError, lower case: TypesysError, with spaces: fields left data, include:
# TypesysError", in one line.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check rosbags==0.11.9
cat > "$folder/run.py" <<'END'
from rosbags.typesys import get_types_from_idl, get_types_from_msg

IDL = """#include "geometry_msgs/msg/Vector3.idl"

module p { module msg { struct A { geometry_msgs::msg::Vector3 a; }; }; };
"""

def outcome(read, *arguments):
    try:
        read(*arguments)
    except Exception as error:
        return type(error).__name__
    return "read"

types = get_types_from_msg("uint8 left = 0\nfloat32 data\n", "p/msg/A")
names = " ".join(name for name, _ in types["p/msg/A"][1])
print(
    "CRLF: " + outcome(get_types_from_msg, "# a\r\nfloat32 data\r\n", "p/msg/A"),
    "lower case: " + outcome(get_types_from_msg, "uint8 left=0\nfloat32 data\n", "p/msg/A"),
    f"with spaces: fields {names}",
    "include: " + outcome(get_types_from_idl, IDL),
    sep=", ",
)
END
seen=$("$folder/venv/bin/python" "$folder/run.py")
echo "$seen"
[ "$seen" = "CRLF: TypesysError, lower case: TypesysError, with spaces: fields left data, include: TypesysError" ]
