"""What each verb of the command line takes."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import get_args

from robosc import codes, pipeline
from robosc.emit.package.package import Mode


def _common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--library-path",
        metavar="DIR",
        action="append",
        default=[],
        type=Path,
        help="also look for libraries here (may be repeated)",
    )
    parser.add_argument(
        "--strict",
        action="store_true",
        help="treat a message definition that is not installed as an error",
    )


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print a JSON document")


def _explain_seconds(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--explain-seconds",
        metavar="N",
        type=_seconds,
        default=None,
        help="processor time for explanations (default: as much as synthesis took, 1 to 10)",
    )


def _robot(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="a .rscd file with a robot")


def _mode(parser: argparse.ArgumentParser, default: Mode = "controller") -> None:
    parser.add_argument(
        "--mode",
        choices=get_args(Mode),
        default=default,
        help="a controller, a supervisor that guards one, or a monitor that listens to one"
        f" (default: {default})",
    )


def _parameters(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--parameter",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="a parameter of the model or, with --execute, any of its node (may be repeated)",
    )


def check(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "models", metavar="MODEL", nargs="+", help="a .rscd file, or a folder with such files"
    )
    _json(parser)
    parser.add_argument(
        "--format",
        choices=["text", "json", "github", "sarif"],
        default="text",
        help="how to print: github annotates pull requests, sarif is for code scanners",
    )
    parser.add_argument(
        "--watch",
        action="store_true",
        help="check again whenever a model is saved, until Ctrl-C",
    )
    _explain_seconds(parser)
    _mode(parser)
    _common(parser)


def new(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="the name of the robot, as in Rover")
    origin = parser.add_mutually_exclusive_group()
    origin.add_argument(
        "--from-ros",
        action="store_true",
        help="from the nodes that run now, with how often their messages come",
    )
    origin.add_argument(
        "--from-bag",
        metavar="FILE",
        type=Path,
        help="from what was recorded: .bag, .mcap, .db3, or the folder of a bag of ROS 2",
    )


def explain(parser: argparse.ArgumentParser) -> None:
    code = parser.add_argument(
        "code", metavar="CODE", help="what stands in brackets in the message"
    )
    code.completer = lambda **_: sorted(codes.CODES)  # type: ignore[attr-defined]  # argcomplete's name


def synthesize(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    _json(parser)
    parser.add_argument(
        "--engine",
        choices=["auto", "explicit", "bdd"],
        type=lambda name: "explicit" if name == "dense" else name,  # as it was called
        default="auto",
    )
    parser.add_argument(
        "--max-states",
        metavar="N",
        type=_positive,
        default=None,
        help="most states that the explicit engine visits (default: 2^20)",
    )
    _explain_seconds(parser)
    _mode(parser)
    _common(parser)


def explore(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    _json(parser)
    parser.add_argument("--plant", action="store_true", help="without control")
    parser.add_argument(
        "--limit",
        metavar="N",
        type=_positive,
        default=100_000,
        help="refuse to print more states than this (default: 100000)",
    )
    _mode(parser)
    _common(parser)


def verify(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    _json(parser)
    _mode(parser)
    _common(parser)


def generate(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    parser.add_argument(
        "--target",
        choices=get_args(pipeline.Target),
        help="the version of ROS (default: the one that is sourced, else ros1)",
    )
    _mode(parser)
    parser.add_argument(
        "--output",
        metavar="DIR",
        type=Path,
        help="the folder that gets the package (default: that of robosc.yaml, or the current one)",
    )
    parser.add_argument("--package", metavar="NAME", help="name of the package")
    parser.add_argument(
        "--config",
        metavar="FILE",
        type=Path,
        help="options (default: robosc.yaml beside the model)",
    )
    parser.add_argument(
        "--force", action="store_true", help="replace files that robosc did not write"
    )
    parser.add_argument("--verbose", action="store_true", help="list the files that were written")
    parser.add_argument(
        "--diff",
        action="store_true",
        help="show what would be written, write nothing; exit 1 if anything would be changed",
    )
    _common(parser)


def export(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    parser.add_argument(
        "--format", choices=["cif", "dot", "svg", "json"], required=True, help="what to write"
    )
    parser.add_argument(
        "--supervisor", action="store_true", help="with cif: add the guards of the supervisor"
    )
    parser.add_argument(
        "--output", metavar="FILE", type=Path, help="write there (default: standard output)"
    )
    _mode(parser)
    _common(parser)


def format(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help="a .rscd file, or - for a pipe",
    )
    parser.add_argument(
        "--check", action="store_true", help="change nothing; exit 1 if a file would be changed"
    )


def simulate(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    parser.add_argument(
        "--execute",
        action="store_true",
        help="let the controller execute on a virtual clock; only the robot's events are typed",
    )
    _parameters(parser)
    parser.add_argument(
        "--script", metavar="FILE", help="run the lines of a file (-: standard input), and end"
    )
    parser.add_argument(
        "--junit",
        metavar="FILE",
        type=Path,
        help="with --script: write the results of its expectations as JUnit XML",
    )
    parser.add_argument(
        "--json", action="store_true", help="read and write JSON, a document per line"
    )
    _mode(parser)
    _common(parser)


def report(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    for name, what in (("logs", "event logs of its nodes"), ("bags", "bags of either ROS")):
        parser.add_argument(
            f"--{name}",
            metavar="PATH",
            nargs="+",
            action="extend",
            default=[],
            type=Path,
            help=f"{what}, for what the runs show of each requirement",
        )
    parser.add_argument(
        "--output",
        metavar="FILE",
        type=Path,
        help="write there, as .html, .md or .json (default: Markdown on standard output)",
    )
    _mode(parser)
    _common(parser)


def replay(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="the .rscd file of a robot")
    parser.add_argument(
        "log",
        metavar="LOG",
        help="the event log that a generated node has written (- for a pipe), or a bag of either"
        " ROS: .bag, .mcap, .db3 or the folder of a bag",
    )
    parser.add_argument(
        "--parameter",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="with a bag: a parameter of the model or of its node (may be repeated)",
    )
    parser.add_argument(
        "--start",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="with a bag: the value with which a persistent variable started (may be repeated)",
    )
    parser.add_argument(
        "--remap",
        metavar="FROM:=TO",
        action="append",
        default=[],
        help="with a bag: a name that was another one in the run; __ns and __name are those of"
        " the controller (may be repeated)",
    )
    parser.add_argument(
        "--junit", metavar="FILE", type=Path, help="with a bag: write the verdicts as JUnit XML"
    )
    _json(parser)
    _mode(parser)
    _common(parser)


def lsp(parser: argparse.ArgumentParser) -> None:
    # Some clients add it unasked; standard input and output is all that there is.
    parser.add_argument("--stdio", action="store_true", help=argparse.SUPPRESS)
    _common(parser)


def view(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "model", metavar="MODEL", nargs="?", help="a .rscd file with a robot, to be played"
    )
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--ros", metavar="NODE", help="watch a running controller, of either ROS")
    source.add_argument(
        "--log", metavar="FILE", help="look through an event log of MODEL's node, or a bag"
    )
    parser.add_argument(
        "--operate",
        metavar="COMPONENT",
        nargs="*",
        help="with --ros: let whoever has the printed address hold, release and step the commands,"
        " and send the messages of these components, which stand for persons",
    )
    parser.add_argument(
        "--export",
        metavar="FILE",
        type=Path,
        help="with --log: write the page with all of the log into one HTML file, and serve nothing",
    )
    source.add_argument(
        "--execute",
        action="store_true",
        help="let the controller execute, as time passes; only the robot's events are played",
    )
    _parameters(parser)
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen on (default: this machine only)"
    )
    parser.add_argument("--port", type=_port, default=None, help="port (default: 8642 if free)")
    _mode(parser)
    _common(parser)


def mcp(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="the .rscd file of a robot")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "--ros", metavar="NODE", help="command through this supervisor (or call this controller)"
    )
    source.add_argument(
        "--simulate", action="store_true", help="command a simulated robot, and play it"
    )
    parser.add_argument(
        "--http",
        metavar="PORT",
        type=_port,
        help="serve agents of this machine by HTTP, with a token that is printed (default: whoever"
        " starts this, on standard input and output)",
    )
    parser.add_argument(
        "--read-only", action="store_true", help="offer no commands, only what there is to know"
    )
    parser.add_argument(
        "--log", metavar="FILE", type=Path, help="append each call to this file (default: stderr)"
    )
    _parameters(parser)
    _mode(parser, "supervisor")
    _common(parser)


def _port(text: str) -> int:
    number = int(text) if text.isdecimal() and text.isascii() and len(text) < 6 else -1
    if not 0 <= number <= 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is not a port: 0 to 65535, 0 for any")
    return number


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds")
    return value


def _positive(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive integer")
    return value
