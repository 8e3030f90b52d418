#!/bin/sh
# rclpy 7.1.6 (Jazzy; the parser of parameters is rcl's): the last value of a parameter does not win
# where it has another type. rcl keeps one value of each type for a name in a section (/** in a file,
# and -p on the command line are the same section) and gives the first there is of: boolean, integer,
# double, string. So "-p limit:=2.5" changes nothing where a file says "limit: 3", or where
# "-p limit:=3" stood before it, and nothing is reported. The other way round it does win. It also
# wins where it names the node: "-p finding:limit:=2.5" is another section.
# Seen: "file 3, then 2.5: 3; file 2.5, then 3: 3; 3, then 2.5: 3; file true, then off-road: True;
# file 3, then finding:2.5: 2.5", in one line.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check empy==3.3.4
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    "ros-jazzy-rclpy[fastrtps]==7.1.6" ros-jazzy-std-msgs==5.3.6
cat > "$folder/run.py" <<'END'
import rclpy


def limit(file, *given):
    arguments = ["--ros-args"]
    if file:
        with open("given.yaml", "w") as stream:
            stream.write(f"/**:\n  ros__parameters:\n    limit: {file}\n")
        arguments += ["--params-file", "given.yaml"]
    for words in given:
        arguments += ["-p", words]
    context = rclpy.Context()
    rclpy.init(args=arguments, context=context)
    node = rclpy.create_node(
        "finding", context=context, automatically_declare_parameters_from_overrides=True
    )
    value = node.get_parameter("limit").value
    node.destroy_node()
    rclpy.shutdown(context=context)
    return value


print(
    f"file 3, then 2.5: {limit('3', 'limit:=2.5')};"
    f" file 2.5, then 3: {limit('2.5', 'limit:=3')};"
    f" 3, then 2.5: {limit('', 'limit:=3', 'limit:=2.5')};"
    f" file true, then off-road: {limit('true', 'limit:=off-road')};"
    f" file 3, then finding:2.5: {limit('3', 'finding:limit:=2.5')}"
)
END
cd "$folder"
seen=$(ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$folder/venv/bin/python" run.py)
echo "$seen"
[ "$seen" = "file 3, then 2.5: 3; file 2.5, then 3: 3; 3, then 2.5: 3; file true, then off-road: True; file 3, then finding:2.5: 2.5" ]
