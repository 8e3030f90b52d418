#!/bin/sh
# pybag-sdk 0.13.0 reads a bounded sequence of ROS 2 as an array of fixed length: the number of its
# elements, which the recording has before them, is taken for the first, the last is missing, and what
# follows the sequence is read from the wrong place. It raises nothing as long as the message is long
# enough, and warns of nothing. mcap-ros2-support 0.6.0 reads it as it was sent. shape_msgs has such
# a sequence, float64[<=3] dimensions, in each SolidPrimitive, and so a collision object of MoveIt.
# Seen: "mcap_ros2 [0.5, 0.4, 0.3]; pybag [1.5e-323, 0.5, 0.4]".
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    mcap==1.6.0 mcap-ros2-support==0.6.0 pybag-sdk==0.13.0
cd "$folder"
cat > run.py <<'END'
import struct

from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from pybag.mcap_reader import McapFileReader

SENT = b"\0\1\0\0" + struct.pack("<I4x3d", 3, 0.5, 0.4, 0.3)
with open("run.mcap", "wb") as file:
    writer = Writer(file)
    writer.start("ros2")
    schema = writer.register_schema("demo/msg/Shape", "ros2msg", b"float64[<=3] dimensions")
    channel = writer.register_channel("/shape", "cdr", schema)
    writer.add_message(channel, 1, SENT, 1)
    writer.finish()
reader = make_reader(open("run.mcap", "rb"), decoder_factories=[DecoderFactory()])
(sent,) = [message for *_, message in reader.iter_decoded_messages()]
with McapFileReader.from_file("run.mcap") as bag:
    (read,) = [message.data for message in bag.messages("/shape")]
print("mcap_ros2 %s; pybag %s" % (list(sent.dimensions), list(read.dimensions)))
END
seen=$(venv/bin/python run.py)
echo "$seen"
[ "$seen" = "mcap_ros2 [0.5, 0.4, 0.3]; pybag [1.5e-323, 0.5, 0.4]" ]
