#!/bin/sh
# Two readers of YAML disagree about which words are texts. PyYAML 6.0.3 writes the texts y, 1e3,
# nan, inf and 0x1p3 without quotes, since none of them is anything else for itself. rclpy 7.1.6
# (Jazzy; the parser of parameters is rcl's, in C) reads y as true and the others as doubles. So a
# parameter file that is written by PyYAML, as launch_ros writes one for each dictionary of
# parameters and for ParameterValue(text, value_type=str), changes the type of a text, and a node
# that declares a string does not start, or gets another value. JSON is read as it was written.
# Seen: "PyYAML: True 1000.0 nan inf 8.0, JSON: y 1e3 nan inf 0x1p3 as str", in one line.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check empy==3.3.4 PyYAML==6.0.3
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    "ros-jazzy-rclpy[fastrtps]==7.1.6" ros-jazzy-std-msgs==5.3.6
cat > "$folder/run.py" <<'END'
import json
import sys

import rclpy
import yaml

TEXTS = ("y", "1e3", "nan", "inf", "0x1p3")
names = [f"text_{number}" for number in range(len(TEXTS))]
document = {"/**": {"ros__parameters": dict(zip(names, TEXTS))}}
with open("given.yaml", "w") as file:
    file.write(yaml.safe_dump(document) if sys.argv[1] == "PyYAML" else json.dumps(document))
rclpy.init(args=["--ros-args", "--params-file", "given.yaml"])
node = rclpy.create_node("finding", automatically_declare_parameters_from_overrides=True)
values = [node.get_parameter(name).value for name in names]
texts = " as str" if all(isinstance(value, str) for value in values) else ""
print(f"{sys.argv[1]}: {' '.join(map(str, values))}{texts}")
rclpy.shutdown()
END
cd "$folder"
run() { ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$folder/venv/bin/python" run.py "$1"; }
seen="$(run PyYAML), $(run JSON)"
echo "$seen"
[ "$seen" = "PyYAML: True 1000.0 nan inf 8.0, JSON: y 1e3 nan inf 0x1p3 as str" ]
