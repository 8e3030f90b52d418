"""Declarations with places to fill in, for completion: by the block in which they may stand.

``${1:Name}`` is the first place with what stands in it at first, ``$0`` where the cursor ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from textwrap import indent


@dataclass(frozen=True, slots=True)
class Snippet:
    """``label`` is what is offered, ``text`` what is inserted."""

    label: str
    meaning: str
    text: str


def _component(label: str, meaning: str, name: str, declaration: str, behaviour: str) -> Snippet:
    """A component with one declaration."""
    head, body = indent(declaration, " " * 4), indent(behaviour, " " * 8)
    text = f"component ${{1:{name}}} {{\n{head}\n\n    behaviour {{\n{body}\n    }}\n}}"
    return Snippet(label, meaning, text)


_ROBOT = Snippet(
    "robot { … }", "A robot: components, requirements, data", "robot ${1:Name} {\n    $0\n}"
)
_SENSOR = _component(
    "component … outgoing message",
    "A component that sends, and remembers the last value",
    "Sensor",
    'outgoing message ${2:measured} with identifier: "/${2:measured}", type: ${3:double}',
    """\
variable last: ${3:double}

initial marked state sensing {
    on response from ${2:measured} do last := value
}""",
)
_SERVER = _component(
    "component … service",
    "A component with a service, errors handled",
    "Server",
    "service ${2:call} with request: ${3:none}, response: ${4:none} links ${5:interface}",
    """\
initial marked state idle {
    on request to ${2:call} goto busy
}

state busy {
    on response from ${2:call} goto idle
    on error from ${2:call} goto idle
}""",
)
_ACTION_SERVER = _component(
    "component … action",
    "A component with an action, errors and cancels handled",
    "Server",
    """\
action ${2:task} with request: ${3:none}, response: ${4:none}, feedback: ${5:none}
    links ${6:interface}""",
    """\
initial marked state idle {
    on request to ${2:task} goto busy
}

state busy {
    on response from ${2:task} goto idle
    on error from ${2:task} goto idle
    on cancelled from ${2:task} goto idle
}""",
)
_CALLER = _component(
    "component … outgoing service",
    "A component that calls the controller, and is answered",
    "Orders",
    'outgoing service ${2:order} with identifier: "/${2:order}", type: ${3:std_srvs/Trigger}',
    """\
initial marked state idle {
    on request from ${2:order} goto asked
}

state asked {
    on response to ${2:order} goto idle
}""",
)
_GOALS = _component(
    "component … outgoing action",
    "A component that sends the controller goals, cancels them, and is answered",
    "Orders",
    """\
outgoing action ${2:order} with request: ${3:none}, response: ${4:none}, feedback: ${5:none}
    links ${6:interface}""",
    """\
initial marked state idle {
    on request from ${2:order} goto running
}

state running {
    on response to ${2:order} goto idle
    on cancel from ${2:order} goto ending
}

state ending {
    on error to ${2:order} goto idle
}""",
)
_COMPONENT = Snippet(
    "component { … }",
    "A component with its states",
    """\
component ${1:Name} {
    $0

    behaviour {
        initial marked state ${2:idle} {
        }
    }
}""",
)
_OBJECT = Snippet(
    "datatype object { … }",
    "The fields of a message that the model uses",
    "datatype object ${1:Name} {\n    ${2:field}: ${3:double}\n}",
)
_ENUM = Snippet(
    "datatype enum { … }",
    "A finite set of values, to which a message is converted",
    """\
datatype enum ${1:Name} from ${2:double} to {
    value > ${3:0} -> ${4:high}
    default -> ${5:low}
}""",
)
_NEEDS = Snippet(
    "requirement … needs",
    "A command that is sent only while a condition holds",
    "requirement ${1:command} needs ${2:Component}.${3:state}",
)
_DISABLES = Snippet(
    "requirement … disables",
    "A condition under which a command is not sent",
    "requirement ${1:Component}.${2:state} disables ${3:command}",
)
_PROVIDE = Snippet(
    "provide … with",
    "The data of a command",
    "provide ${1:command} with { ${2:field}: ${3:0.0} }",
)
_OUTGOING = Snippet(
    "outgoing message … with",
    "What the component sends",
    'outgoing message ${1:measured} with identifier: "/${1:measured}", type: ${2:double}',
)
_INCOMING = Snippet(
    "incoming message … with",
    "A command that the component receives",
    'incoming message ${1:move} with identifier: "/${1:move}", type: ${2:none}',
)
_SERVICE = Snippet(
    "service … with",
    "A service that the controller calls",
    "service ${1:call} with request: ${2:none}, response: ${3:none} links ${4:interface}",
)
_SERVED = Snippet(
    "outgoing service … with",
    "A service that the component calls and the controller serves",
    'outgoing service ${1:order} with identifier: "/${1:order}", type: ${2:std_srvs/Trigger}',
)
_ACTION = Snippet(
    "action … with",
    "An action whose goals the controller sends",
    "action ${1:task} with request: ${2:none}, response: ${3:none}, feedback: ${4:none}"
    " links ${5:interface}",
)

_DECLARATIONS = (_COMPONENT, _SENSOR, _SERVER, _ACTION_SERVER, _CALLER, _GOALS, _OBJECT, _ENUM)
_STATEMENTS = (_NEEDS, _DISABLES, _PROVIDE)

SNIPPETS: Mapping[str, tuple[Snippet, ...]] = {
    "file": (_ROBOT,),
    "robot": (*_DECLARATIONS, *_STATEMENTS),
    "library": _DECLARATIONS,
    "for": _STATEMENTS,
    "component": (_OUTGOING, _INCOMING, _SERVICE, _ACTION, _SERVED, *_STATEMENTS),
}
