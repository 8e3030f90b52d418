#!/bin/sh
# Three readers of ROS 2 recordings give three answers for a byte and a char above 127. Both are
# unsigned in ROS 2 (octet and uint8 of IDL; rclpy gives a byte as bytes of length one): 200 in the
# recording. In ROS 1 a byte is signed. rosbags 0.11.9 takes the byte for one of ROS 1, -56, in single
# fields and in arrays, as of std_msgs/Byte and ByteMultiArray; mcap-ros2-support 0.6.0 takes the char
# for one of C, -56, and its writer refuses 200; pybag-sdk 0.13.0 takes the char for a text, and raises
# UnicodeDecodeError. None of them warns.
# Seen: "rosbags -56 200; mcap_ros2 200 -56; pybag 200 UnicodeDecodeError".
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    rosbags==0.11.9 mcap==1.6.0 mcap-ros2-support==0.6.0 \
    pybag-sdk==0.13.0
cd "$folder"
cat > run.py <<'END'
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from pybag.mcap_reader import McapFileReader
from rosbags.highlevel import AnyReader


def recorded(kind):
    """The bag of one message with the value 200."""
    with open("%s.mcap" % kind, "wb") as file:
        writer = Writer(file)
        writer.start("ros2")
        schema = writer.register_schema("demo/msg/One", "ros2msg", ("%s value" % kind).encode())
        channel = writer.register_channel("/one", "cdr", schema)
        writer.add_message(channel, 1, bytes([0, 1, 0, 0, 200]), 1)
        writer.finish()
    return Path(file.name)


def rosbags(path):
    with AnyReader([path]) as bag:
        return [bag.deserialize(raw, c.msgtype).value for c, _, raw in bag.messages()]


def mcap_ros2(path):
    reader = make_reader(path.open("rb"), decoder_factories=[DecoderFactory()])
    return [message.value for *_, message in reader.iter_decoded_messages()]


def pybag(path):
    with McapFileReader.from_file(path) as bag:
        return [m.data.value for m in bag.messages("/one")]


def told(read, path):
    try:
        (value,) = read(path)
    except Exception as error:
        return type(error).__name__
    return str(value[0] if isinstance(value, bytes) else value)


paths = [recorded("byte"), recorded("char")]
for read in (rosbags, mcap_ros2, pybag):
    print(read.__name__, *[told(read, path) for path in paths], end="; " * (read is not pybag))
END
seen=$(venv/bin/python run.py)
echo "$seen"
[ "$seen" = "rosbags -56 200; mcap_ros2 200 -56; pybag 200 UnicodeDecodeError" ]
