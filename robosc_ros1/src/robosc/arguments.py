"""What each verb of the command line takes."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias, get_args

from robosc import codes, pipeline
from robosc.emit.package.package import Mode

_Parser: TypeAlias = "argparse.ArgumentParser | argparse._MutuallyExclusiveGroup"


def _flag(parser: _Parser, name: str, text: str) -> None:
    parser.add_argument(name, action="store_true", help=text)


def _path(parser: _Parser, name: str, text: str, metavar: str = "FILE") -> None:
    parser.add_argument(name, metavar=metavar, type=Path, help=text)


def _several(
    parser: _Parser,
    name: str,
    text: str,
    metavar: str = "NAME=VALUE",
    kind: Callable[[str], object] = str,
) -> None:
    text = f"{text} (may be repeated)"
    parser.add_argument(name, metavar=metavar, action="append", default=[], type=kind, help=text)


def _number(
    parser: _Parser, name: str, kind: Callable[[str], float], text: str, default: int | None = None
) -> None:
    parser.add_argument(name, metavar="N", type=kind, default=default, help=text)


def _folder(text: str) -> Path:
    if not Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {text}")
    return Path(text)


def _common(parser: argparse.ArgumentParser, folder: Callable[[str], Path] = _folder) -> None:
    _several(parser, "--library-path", "also look for libraries here", "DIR", folder)
    _flag(parser, "--strict", "treat a message definition that is not installed as an error")


def _json(parser: argparse.ArgumentParser) -> None:
    _flag(parser, "--json", "print a JSON document")


def _explain_seconds(parser: argparse.ArgumentParser) -> None:
    text = "processor time for explanations (default: as much as synthesis took, 1 to 10)"
    _number(parser, "--explain-seconds", _seconds, text)


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


def _on_models(parser: argparse.ArgumentParser) -> None:
    _mode(parser)
    _common(parser)


def _parameters(parser: argparse.ArgumentParser) -> None:
    _several(parser, "--parameter", "a parameter of the model or, with --execute, any of its node")


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
    _flag(parser, "--watch", "check again whenever a model is saved, until Ctrl-C")
    _explain_seconds(parser)
    _on_models(parser)


def new(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="the name of the robot, as in Rover")
    origin = parser.add_mutually_exclusive_group()
    _flag(origin, "--from-ros", "from the nodes that run now, with how often their messages come")
    _path(
        origin,
        "--from-bag",
        "from what was recorded: .bag, .mcap, .db3, or the folder of a bag of ROS 2",
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
    text = "most states that the explicit engine visits (default: 2^20)"
    _number(parser, "--max-states", _positive, text)
    _explain_seconds(parser)
    _on_models(parser)


def explore(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    _json(parser)
    _flag(parser, "--plant", "without control")
    text = "refuse to print more states than this (default: 100000)"
    _number(parser, "--limit", _positive, text, 100_000)
    _on_models(parser)


def verify(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    _json(parser)
    _on_models(parser)


def generate(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    parser.add_argument(
        "--target",
        choices=get_args(pipeline.Target),
        help="the version of ROS (default: the one that is sourced, else ros1)",
    )
    _mode(parser)
    _path(
        parser,
        "--output",
        "the folder that gets the package (default: that of robosc.yaml, or the current one)",
        "DIR",
    )
    parser.add_argument("--package", metavar="NAME", help="name of the package")
    _path(parser, "--config", "options (default: robosc.yaml beside the model)")
    _flag(parser, "--force", "replace files that robosc did not write")
    _flag(parser, "--verbose", "list the files that were written")
    _flag(
        parser,
        "--diff",
        "show what would be written, write nothing; exit 1 if anything would be changed",
    )
    _common(parser)


def export(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    parser.add_argument(
        "--format", choices=["cif", "dot", "svg", "json"], required=True, help="what to write"
    )
    _flag(parser, "--supervisor", "with cif: add the guards of the supervisor")
    _path(parser, "--output", "write there (default: standard output)")
    _on_models(parser)


def format(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", metavar="FILE", nargs="+", help="a .rscd file, or - for a pipe")
    _flag(parser, "--check", "change nothing; exit 1 if a file would be changed")


def simulate(parser: argparse.ArgumentParser) -> None:
    _robot(parser)
    _flag(
        parser,
        "--execute",
        "let the controller execute on a virtual clock; only the robot's events are typed",
    )
    _parameters(parser)
    parser.add_argument(
        "--script", metavar="FILE", help="run the lines of a file (-: standard input), and end"
    )
    _path(parser, "--junit", "with --script: write the results of its expectations as JUnit XML")
    _flag(parser, "--json", "read and write JSON, a document per line")
    _on_models(parser)


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
    _path(
        parser,
        "--output",
        "write there, as .html, .md or .json (default: Markdown on standard output)",
    )
    _on_models(parser)


def replay(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="the .rscd file of a robot")
    parser.add_argument(
        "log",
        metavar="LOG",
        help="the event log that a generated node has written (- for a pipe), or a bag of either"
        " ROS: .bag, .mcap, .db3 or the folder of a bag",
    )
    _several(parser, "--parameter", "with a bag: a parameter of the model or of its node")
    _several(parser, "--start", "with a bag: the value with which a persistent variable started")
    _several(
        parser,
        "--remap",
        "with a bag: a name that was another one in the run; __ns and __name are those of"
        " the controller",
        "FROM:=TO",
    )
    _path(parser, "--junit", "with a bag: write the verdicts as JUnit XML")
    _json(parser)
    _on_models(parser)


def lsp(parser: argparse.ArgumentParser) -> None:
    # Some clients add it unasked; standard input and output is all that there is.
    parser.add_argument("--stdio", action="store_true", help=argparse.SUPPRESS)
    _common(parser, Path)  # of an editor's settings, which serve many models


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
    _path(
        parser,
        "--export",
        "with --log: write the page with all of the log into one HTML file, and serve nothing",
    )
    _flag(
        source,
        "--execute",
        "let the controller execute, as time passes; only the robot's events are played",
    )
    _parameters(parser)
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen on (default: this machine only)"
    )
    parser.add_argument("--port", type=_port, default=None, help="port (default: 8642 if free)")
    _on_models(parser)


def mcp(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="the .rscd file of a robot")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "--ros", metavar="NODE", help="command through this supervisor (or call this controller)"
    )
    _flag(source, "--simulate", "command a simulated robot, and play it")
    parser.add_argument(
        "--http",
        metavar="PORT",
        type=_port,
        help="serve agents of this machine by HTTP, with a token that is printed (default: whoever"
        " starts this, on standard input and output)",
    )
    _flag(parser, "--read-only", "offer no commands, only what there is to know")
    _path(parser, "--log", "append each call to this file (default: stderr)")
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
