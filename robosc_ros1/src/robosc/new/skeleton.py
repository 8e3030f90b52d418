"""The text of a model to begin with."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from robosc.language.keywords import RESERVED, escape
from robosc.model.ros.interfaces import Definition, Folder
from robosc.new.declared_types import DeclaredTypes
from robosc.new.frames import RobotFrame
from robosc.new.survey import UNKNOWN_NODE, Offer, Spacing, Survey

_HEAD = """\
// Made from {origin}: all that a controller could read and command. Go through it and decide
// what it needs; the comments say where.
robot {name} {{
"""

_PERMITTED = """\
    // As it stands, no command is sent until the node's parameter is set: permitted:=true
    parameter permitted: boolean = false
"""

_FRAMES = """
    component {name} {{    // what is told on /tf and /tf_static
"""

_SERVICE = """\
            initial marked state idle {{
                on request to {name} goto busy
            }}
            state busy {{
                on response from {name} goto idle
                on error from {name} goto idle    // nothing answers, or it fails
"""

_UNSTEADY = 5
"""A topic whose longest pause is so many times the usual one: its timeout may be too long."""

_ABSENT = """
    // Left out, since the definitions of these types are not on this machine: install their
    // packages, or source the workspace that has them, and make the model again.
"""

_MISNAMED = """
    // Left out, since ROS 1 or ROS 2 does not allow these names:
"""

_DECLARED = """
    // Types whose packages are not on this machine, as they were recorded. With the package, write
    // type: PACKAGE/TYPE instead.
"""

_CANCELLED = "                on cancelled from {name} goto idle\n"


def small(name: str) -> str:
    """The text of a small model, with comments for somebody who has seen none."""
    file = Path(__file__).with_name("small.rscd")
    return file.read_text(encoding="utf-8").replace("NAME", name)


def from_survey(
    name: str,
    survey: Survey,
    pauses: Mapping[str, Spacing],
    origin: str,
    absent: Sequence[Offer] = (),
    recorded: Mapping[str, Definition] | None = None,
    notes: Sequence[str] = (),
    misnamed: Sequence[str] = (),
) -> str:
    """The text of a model with all that was found.

    ``pauses`` are those of each topic that was heard; ``origin`` says where all comes from;
    ``absent`` has types that are not defined on this machine, and is only named in a comment, as
    are ``notes`` and what is ``misnamed``. Those whose package is not there, but that were
    ``recorded``, are declared.
    """
    names = _Names(name)
    types = _Types(names, recorded or {}, survey.declared)
    outgoing = [(offer, names.communication(offer.name)) for offer in survey.outgoing]
    incoming = [(offer, names.communication(offer.name)) for offer in survey.incoming]
    lines = [_HEAD.format(name=escape(name), origin=_printable(origin))]
    if incoming or survey.services or survey.actions:
        lines.append(_PERMITTED)
    nodes = dict.fromkeys(offer.node for offer, _ in (*outgoing, *incoming))
    for node in nodes:
        lines.append(f"\n    component {names.component(node)} {{    // {_whose(node)}\n")
        for offer, short in outgoing:
            if offer.node == node:
                lines += _outgoing(types, offer, short, pauses.get(offer.name))
        for offer, short in incoming:
            if offer.node == node:
                lines += _incoming(types, offer, short)
        lines.append("    }\n")
    chains = [(chain, names.communication(chain.target)) for chain in survey.chains]
    if chains:
        lines.append(_FRAMES.format(name=names.component("Frames")))
        for chain, short in chains:
            lines += _transform(chain, short, pauses.get(chain.name))
        lines.append("    }\n")
    commands = [short for _, short in incoming]
    for kind, offers in (("service", survey.services), ("action", survey.actions)):
        for offer in offers:
            short = names.communication(offer.name)
            commands.append(short)
            lines += _called(types, kind, offer, short, names.component(short))
    heard = [(offer.name, short) for offer, short in outgoing]
    heard += [(chain.name, short) for chain, short in chains]
    fresh = [f"{short}.fresh" for name, short in heard if name in pauses]
    lines += _requirements(commands, fresh)
    if types.declared.lines:
        lines += [_DECLARED, *types.declared.lines]
    if notes:
        lines.append("\n    // Of the recording:\n")
        lines += (f"    //   {_printable(note)}\n" for note in notes)
    if absent:
        lines.append(_ABSENT)
        lines += (
            f"    //   {_printable(offer.name)}: {_printable(offer.type)}\n" for offer in absent
        )
    if misnamed:
        lines.append(_MISNAMED)
        lines += (f"    //   {_printable(repr(one))}\n" for one in misnamed)
    return "".join(lines) + "}\n"


class _Types:
    """How the types of offers are written: those of ROS by their names, others are declared."""

    def __init__(
        self, names: _Names, recorded: Mapping[str, Definition], declared: Collection[str]
    ) -> None:
        self._declared = declared
        self.declared = DeclaredTypes(recorded, names.identifier)

    def of(self, offer: Offer, folder: Folder) -> str:
        if offer.type in self._declared:
            return self.declared.attributes(offer.type, folder)
        return f"type: {offer.type}"


def _message(types: _Types, offer: Offer, short: str, timeout: str = "") -> str:
    type_ = types.of(offer, "msg")
    return f'message {short} with identifier: "{offer.name}",{timeout} {type_}'


def _whose(node: str) -> str:
    if node.startswith(UNKNOWN_NODE):
        return f"its node is not known; the topics below /{node.removeprefix(UNKNOWN_NODE)}"
    return f"node {node}"


def _outgoing(types: _Types, offer: Offer, short: str, pauses: Spacing | None) -> Iterator[str]:
    if offer.others:
        others = ", ".join(offer.others)
        yield f"        // {others} receives it; if the controller is to send it: incoming\n"
    if pauses is None:
        yield "        // came less than three times: does it come rarely? else give it a timeout\n"
        yield f"        outgoing {_message(types, offer, short)}\n"
    else:
        unsteady = pauses.longest > _UNSTEADY * pauses.usual
        question = ": is a shorter timeout right, or none?" if unsteady else ""
        usual, longest = f"{pauses.usual:.3g}", f"{pauses.longest:.3g}"
        yield f"        // usually every {usual} s, at the longest after {longest} s{question}\n"
        timeout = f" timeout: {_timeout(pauses.longest)},"
        yield f"        outgoing {_message(types, offer, short, timeout)}\n"


def _transform(chain: RobotFrame, short: str, pauses: Spacing | None) -> Iterator[str]:
    yield f"        // where the robot is; frames: {_printable(', '.join(chain.frames))}\n"
    frames = f"from: {_quoted(chain.source)}, to: {_quoted(chain.target)}"
    timeout = "" if pauses is None else f", timeout: {_timeout(pauses.longest)}"
    yield f"        outgoing transform {short} with {frames}{timeout}\n"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _incoming(types: _Types, offer: Offer, short: str) -> Iterator[str]:
    if offer.node.startswith(UNKNOWN_NODE):
        yield "        // a command by its type or name? if it is data of the robot: outgoing\n"
    yield f"        incoming {_message(types, offer, short)}\n"


def _timeout(longest: float) -> str:
    """Three times the longest pause that was measured, rounded up, as a duration."""
    tenths = math.ceil(round(max(3 * longest, 0.1) * 10, 6))
    return f"{tenths // 10} s" if tenths % 10 == 0 else f"{tenths / 10:.1f} s"


def _called(types: _Types, kind: str, offer: Offer, short: str, component: str) -> Iterator[str]:
    yield f"\n    component {component} {{    // {_whose(offer.node)}\n"
    type_ = types.of(offer, "srv" if kind == "service" else "action")
    yield f'        {kind} {short} with identifier: "{offer.name}", {type_}\n\n'
    yield "        behaviour {\n" + _SERVICE.format(name=short)
    if kind == "action":
        yield _CANCELLED.format(name=short)
    yield "            }\n        }\n    }\n"


def _requirements(commands: Iterable[str], fresh: Iterable[str]) -> Iterator[str]:
    guard = " and ".join(("permitted", *fresh))
    for command in commands:
        yield f"\n    // when may it be sent? and with which data: provide {command} with {{ … }}\n"
        yield f"    requirement {command} needs {guard}\n"


def _printable(text: str) -> str:
    """Text that can stand in a comment of one line, whatever is in it."""
    return "".join(c if c.isprintable() else "?" for c in text)


class _Names:
    """Identifiers for names of ROS, each given once."""

    def __init__(self, robot: str) -> None:
        self._taken = {robot, "permitted"}

    def communication(self, name: str) -> str:
        """``/door/position``: ``position``, or ``door_position`` if that is taken."""
        parts = [re.sub(r"\W", "_", part) for part in name.strip("/").split("/")]
        return self._free("_".join(parts[-count:]) for count in range(1, len(parts) + 1))

    def component(self, name: str) -> str:
        """``/arm/drive_17_1234``: ``Drive``; anonymous nodes have such ends."""
        base = re.sub(r"(_\d+)+$", "", name.strip("/").split("/")[-1])
        words = "".join(word[:1].upper() + word[1:] for word in re.split(r"[\W_]+", base))
        return self._free((words,))

    def identifier(self, name: str) -> str:
        """A name of ROS as it is, or with a number if that is taken."""
        return self._free((name,))

    def _free(self, candidates: Iterable[str]) -> str:
        usable = [c if re.match(r"[A-Za-z_]", c) else f"x{c}" for c in candidates]
        usable += [f"{usable[-1]}_{number}" for number in range(2, 1000)]
        name = next(c for c in usable if c not in self._taken and c not in RESERVED)
        self._taken.add(name)
        return escape(name)
