#!/bin/sh
# rosbags 0.11.9 reads no message of a ROS 2 bag whose metadata.yaml states another quality of service
# than its storage file, as the bags in rosbag2's own repository do, and raises nothing.
# Seen: "in the file 20, in the folder 0".
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check rosbags==0.11.9
cat > "$folder/run.py" <<'END'
import pathlib, sys
from rosbags.rosbag2 import Reader, Writer
from rosbags.typesys import Stores, get_typestore

folder = pathlib.Path(sys.argv[1], "bag")
store = get_typestore(Stores.ROS2_JAZZY)
with Writer(folder, version=9) as writer:
    connection = writer.add_connection("/a", "std_msgs/msg/Bool", typestore=store)
    for number in range(20):
        raw = store.serialize_cdr(store.types["std_msgs/msg/Bool"](True), "std_msgs/msg/Bool")
        writer.write(connection, number * 10**9, raw)
metadata = folder / "metadata.yaml"
profile = """offered_qos_profiles:
      - {history: keep_last, depth: 3, reliability: best_effort, durability: volatile,
         deadline: {sec: 0, nsec: 0}, lifespan: {sec: 0, nsec: 0}, liveliness: automatic,
         liveliness_lease_duration: {sec: 0, nsec: 0}, avoid_ros_namespace_conventions: false}"""
text = metadata.read_text()
assert "offered_qos_profiles: []" in text
metadata.write_text(text.replace("offered_qos_profiles: []", profile))

def count(path):
    with Reader(path) as reader:
        return len(list(reader.messages()))

print(f"in the file {count(next(folder.glob('*.db3')))}, in the folder {count(folder)}")
END
seen=$("$folder/venv/bin/python" "$folder/run.py" "$folder")
echo "$seen"
[ "$seen" = "in the file 20, in the folder 0" ]
