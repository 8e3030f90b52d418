#!/bin/sh
# pybag-sdk 0.13.0 reads other values than were recorded in ROS 2, without an error or a warning.
# 1. After an empty sequence of numbers of 8 bytes it goes on at a place that is a multiple of 8, where
#    the middleware writes nothing. Of a sensor_msgs/JointState with positions and efforts, but without
#    velocities, as many drivers send it, the efforts are lost.
# 2. It takes a bounded sequence for an array of that length: the number of its elements is taken for
#    the first, and the last is lost (float64[<=3] dimensions of shape_msgs/SolidPrimitive is one).
# What does not happen to fit becomes an error of struct. mcap-ros2-support 0.6.0 and rosbags 0.11.9
# read both as they were sent.
# Seen: "sent [1.5, 2.0] [] [3.0, 4.0]; read [1.5, 2.0] [] []" and "sent [0.5, 0.4, 0.3]; read
# [1.5e-323, 0.5, 0.4]".
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


def compare(definition, sent, *fields):
    """Print these fields of a message of these bytes, as both libraries read them."""
    with open("run.mcap", "wb") as file:
        writer = Writer(file)
        writer.start("ros2")
        schema = writer.register_schema("demo/msg/Sent", "ros2msg", definition)
        channel = writer.register_channel("/sent", "cdr", schema)
        writer.add_message(channel, 1, b"\0\1\0\0" + sent, 1)
        writer.finish()
    decoders = [DecoderFactory()]
    with open("run.mcap", "rb") as file:
        ((*_, right),) = make_reader(file, decoder_factories=decoders).iter_decoded_messages()
    with McapFileReader.from_file("run.mcap") as bag:
        (found,) = [message.data for message in bag.messages("/sent")]
    told = [" ".join(str(list(getattr(m, name))) for name in fields) for m in (right, found)]
    print("sent %s; read %s" % tuple(told))


JOINTS = b"float64[] position\nfloat64[] velocity\nfloat64[] effort\n"
joints = struct.pack("<I4x2dII2d", 2, 1.5, 2.0, 0, 2, 3.0, 4.0)
compare(JOINTS, joints, "position", "velocity", "effort")
compare(b"float64[<=3] dimensions\n", struct.pack("<I4x3d", 3, 0.5, 0.4, 0.3), "dimensions")
END
seen=$(venv/bin/python run.py)
echo "$seen"
[ "$seen" = "sent [1.5, 2.0] [] [3.0, 4.0]; read [1.5, 2.0] [] []
sent [0.5, 0.4, 0.3]; read [1.5e-323, 0.5, 0.4]" ]
