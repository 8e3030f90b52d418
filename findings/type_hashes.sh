#!/bin/sh
# Two libraries compute another hash of a type (RIHS01) than ROS 2's own generators wrote into the
# interface packages (the wheels ros-std-msgs 5.3.6 and ros-rcl-interfaces 2.0.3 of Jazzy):
# 1. rosbags 0.11.9 and zenoh-ros2-sdk 0.1.8 give the field type char an identifier of its own; for
#    rosidl it is uint8. Besides std_msgs/Char it is in service_msgs/ServiceEventInfo, and so in the
#    event of each service: the hash that rosbags computes for a bag is that of no type of ROS 2.
# 2. zenoh-ros2-sdk does not know bounded sequences but of strings ("IntegerRange[<=1]
#    integer_range"). It hears and publishes under keys that end in the hash of the type.
# Types without these have the right hash, std_msgs/UInt8 and rcl_interfaces/IntegerRange among them.
# Seen: "rosbags: Char differs, UInt8 equal" and "zenoh-ros2-sdk: Char differs, UInt8 equal,
# ParameterDescriptor differs, IntegerRange equal".
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
pip() { "$folder/venv/bin/pip" install --quiet --disable-pip-version-check "$@"; }
pip rosbags==0.11.9 zenoh-ros2-sdk==0.1.8
pip --no-deps ros-std-msgs==5.3.6 ros-rcl-interfaces==2.0.3
cat > "$folder/run.py" <<'END'
import json
import sys
from pathlib import Path

from rosbags.typesys import Stores, get_typestore
from zenoh_ros2_sdk.utils import compute_type_hash_from_msg

share = Path(sys.prefix) / "share"


def hash_of_ros(package, name):
    document = json.loads((share / package / "msg" / f"{name}.json").read_text())
    (own,) = (
        entry["hash_string"]
        for entry in document["type_hashes"]
        if entry["type_name"] == f"{package}/msg/{name}"
    )
    return own


def definition(package, name):
    return (share / package / "msg" / f"{name}.msg").read_text()


def told(package, name, found):
    return f"{name} {'equal' if found == hash_of_ros(package, name) else 'differs'}"


store = get_typestore(Stores.ROS2_JAZZY)
names = "Char", "UInt8"
found = [told("std_msgs", name, store.hash_rihs01(f"std_msgs/msg/{name}")) for name in names]
print("rosbags: " + ", ".join(found))

parts = {
    f"rcl_interfaces/msg/{name}": definition("rcl_interfaces", name)
    for name in ("FloatingPointRange", "IntegerRange")
}
found = []
for package, name, parts in (
    ("std_msgs", "Char", {}),
    ("std_msgs", "UInt8", {}),
    ("rcl_interfaces", "ParameterDescriptor", parts),
    ("rcl_interfaces", "IntegerRange", {}),
):
    whole = f"{package}/msg/{name}"
    hash_ = compute_type_hash_from_msg(whole, definition(package, name), parts)
    found.append(told(package, name, hash_))
print("zenoh-ros2-sdk: " + ", ".join(found))
END
seen=$("$folder/venv/bin/python" "$folder/run.py")
echo "$seen"
[ "$seen" = "rosbags: Char differs, UInt8 equal
zenoh-ros2-sdk: Char differs, UInt8 equal, ParameterDescriptor differs, IntegerRange equal" ]
