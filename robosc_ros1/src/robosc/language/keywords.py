"""The table of keywords: role, meaning, and the blocks in which each starts a declaration.

Keywords are contextual: where a name is expected, any word is a name. Only the reserved words
always need the escape ``^``. The lexer, the grammar, error recovery, the formatter, the language
server and the highlighting of editors read this table.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from functools import cache

from robosc.language.attributes import ATTRIBUTES
from robosc.language.events import words_of_events
from robosc.language.operators import symbols
from robosc.lazy_dataclasses import dataclass


class Role(Enum):
    """The role of a keyword in the syntax."""

    DECLARATION = "declaration"
    MODIFIER = "modifier"
    CLAUSE = "clause"
    EVENT = "event"
    LABEL = "label"
    OPERATOR = "operator"
    TYPE = "type"
    CONSTANT = "constant"
    VALUE = "value"


@dataclass(frozen=True, slots=True)
class Keyword:
    """One keyword.

    ``blocks`` are the kinds of block in which it starts a declaration.
    """

    word: str
    roles: tuple[Role, ...]
    blocks: tuple[str, ...] = ()

    @property
    def meaning(self) -> str:
        said = _MEANINGS.get(self.word, "")
        label = next((a.meaning for a in ATTRIBUTES if a.name == self.word), None)
        if label is None:
            return said
        return f"{said[:-1]}; as a label, {label}." if said else f"{label[0].upper()}{label[1:]}."

    @property
    def reserved(self) -> bool:
        """Whether a name with this spelling always needs the escape ``^``."""
        return not {Role.OPERATOR, Role.CONSTANT, Role.VALUE}.isdisjoint(self.roles)


_FILES = ("robot", "library")
NOTHING = "nothing"
"""What ``stop with`` names where no message stops the robot, unless a message has this name."""

_STATEMENTS = ("robot", "component", "for")
_TRANSITIONS = ("behaviour", "state")


def _table() -> Iterator[Keyword]:
    declaration, modifier, clause = (Role.DECLARATION,), (Role.MODIFIER,), (Role.CLAUSE,)
    for word in _FILES:
        yield Keyword(word, declaration, ("file",))
    yield Keyword("component", declaration, _FILES)
    yield Keyword("incoming", modifier, ("component",))
    yield Keyword("outgoing", modifier, ("component",))
    yield Keyword("service", declaration, ("component",))
    yield Keyword("action", declaration, ("component",))
    yield Keyword("behaviour", declaration, ("component",))
    yield Keyword("requirement", declaration, _STATEMENTS)
    yield Keyword("provide", declaration, _STATEMENTS)
    yield Keyword("datatype", declaration, _FILES)
    yield Keyword("interface", declaration, _FILES)
    yield Keyword("constant", declaration, (*_FILES, "component"))
    yield Keyword("parameter", declaration, (*_FILES, "component"))
    yield Keyword("condition", declaration, (*_FILES, "component", "for"))
    yield Keyword("function", declaration, (*_FILES, "component"))
    yield Keyword("prefer", declaration, _STATEMENTS)
    yield Keyword("assume", declaration, ("robot", "for"))
    yield Keyword("stop", (Role.DECLARATION, Role.LABEL), ("robot",))
    yield Keyword("for", clause, ("robot", "for"))
    yield Keyword("variable", declaration, ("behaviour",))
    yield Keyword("persistent", modifier, ("behaviour",))
    yield Keyword("initial", modifier, _TRANSITIONS)
    yield Keyword("marked", modifier, _TRANSITIONS)
    yield Keyword("state", declaration, _TRANSITIONS)
    yield Keyword("on", clause, _TRANSITIONS)
    yield Keyword("transition", clause, _TRANSITIONS)
    yield Keyword("after", clause, ("state",))
    yield Keyword("retry", clause, ("state",))
    yield Keyword("default", clause, ("enum",))
    for word in ("object", "enum", "message", "transform"):
        yield Keyword(word, declaration)
    for word in (
        "if",
        "do",
        "goto",
        "needs",
        "disables",
        "never",
        "always",
        "possible",
        "while",
        "with",
        "links",
        "performs",
        "meanwhile",
        "then",
        "times",
        "every",
    ):
        yield Keyword(word, clause)
    for word in ("with", "links", "start", "use", "import", "over", "except", "in"):
        yield Keyword(word, clause)
    for word in ("from", "to"):
        yield Keyword(word, (Role.CLAUSE, Role.LABEL))
    events = words_of_events()
    labels = (*(a.name for a in ATTRIBUTES if a.name not in ("from", "to", "stop")), "prefix")
    for word in dict.fromkeys((*events, *labels)):
        roles = ((Role.EVENT, events), (Role.LABEL, labels))
        yield Keyword(word, tuple(role for role, words in roles if word in words))
    for word in ("string", "boolean", "integer", "double", "none", "array", "duration"):
        yield Keyword(word, (Role.TYPE,))
    for word in symbols(words=True):
        # Where an operand may stand, 'else' is a name.
        yield Keyword(word, (Role.CLAUSE if word == "else" else Role.OPERATOR,))
    for word in ("true", "false"):
        yield Keyword(word, (Role.CONSTANT,))
    yield Keyword("value", (Role.VALUE,))


_MEANINGS = {
    "robot": "The model of one robot: its components, what must never happen, and the data of its"
    " commands.",
    "library": "Components, with what they require, and datatypes that several robots import.",
    "component": "A part of the robot: its communications, and how it behaves.",
    "requirement": "What must hold: a condition that a command needs, one that disables it, or one"
    " that is never or always true.",
    "provide": "The data that a command is sent with, perhaps only under a condition.",
    "prefer": "While the first command is enabled the second one is not sent.",
    "assume": "What the robot does not do: synthesis leaves it out, the node treats it as a fault.",
    "for": "Writes its statements once for each number of a range.",
    "constant": "A name for a value that is known when the model is read.",
    "parameter": "A value that the generated node reads from its ROS parameter when it starts.",
    "condition": "A name for a condition.",
    "function": "A name for an expression over its arguments: `function half(x: double): double ="
    " x / 2`.",
    "datatype": "Declares an object, the fields of a message, or an enum, which converts data.",
    "interface": "A name for a real message, service or action definition of a ROS package.",
    "object": "The fields of a message that the model uses.",
    "enum": "Maps data of messages to finitely many values: the first rule that holds decides.",
    "incoming": "A message that the component receives: a command of the controller.",
    "outgoing": "A message that the component sends: the controller reacts to it. Or a service that"
    " it calls: the controller answers it.",
    "message": "A topic: outgoing if the component sends it, incoming if it receives it.",
    "transform": "The pose of one frame in another, from what the robot sends to `/tf` and"
    " `/tf_static`.",
    "service": "A ROS service of the component, which the controller calls; with `outgoing`, one of"
    " the controller, which the component calls.",
    "action": "A ROS action of the component, whose goals the controller sends and cancels.",
    "behaviour": "The variables and states of a component, and what makes them change.",
    "variable": "What a component remembers besides its state.",
    "persistent": "The variable keeps its value over the end of the node.",
    "initial": "The state in which the component starts.",
    "marked": "A state in which the component may rest: one must remain reachable for ever.",
    "state": "A state of the component, with the transitions that leave it, or states in it.",
    "on": "What an event does: `on response from scan do near := value goto seen`.",
    "transition": "An internal transition, which the controller takes as soon as it is possible.",
    "after": "What happens when the component has been in the state for that long.",
    "retry": "What a state that performs a service or action does after an error: how often it"
    " tries again, and what follows then.",
    "performs": "What a state does: it sends the command, and goes on as `then` says when that is"
    " done.",
    "meanwhile": "The state asks although another action of its component is still under way.",
    "then": "What follows when the command that the state performs is done.",
    "times": "How often a state tries again after errors in a row.",
    "every": "How long a state waits after an error before it tries again.",
    "default": "The value of an enum if none of the rules holds.",
    "if": "A condition: without it, nothing of the declaration applies.",
    "do": "Assignments, all at the same time, from the values before the event.",
    "goto": "The state in which the component is afterwards.",
    "needs": "The commands on the left are sent only while the condition on the right holds.",
    "disables": "The commands on the right are not sent while the condition on the left holds.",
    "never": "The supervisor keeps away from all states in which the condition holds.",
    "always": "The supervisor keeps away from all states in which the condition does not hold.",
    "possible": "From every state under control, one in which the condition holds can be reached.",
    "while": "What holds on the way to the state that must remain possible.",
    "with": "Introduces attributes: topic and types, data, or what an import sets.",
    "links": "The interface that carries the communication in ROS.",
    "from": "Where something comes from: a communication, a library, a package, or a type.",
    "to": "The communication to which a request goes; in an enum, what its rules convert to.",
    "start": "`to start` ends a requirement that is no reason to cancel a running action.",
    "use": "The message, service or action type of an interface.",
    "import": "The component of the library that is imported.",
    "stop": "The message that is sent at a safe stop and when the node ends.",
    "except": "What is left out of a group: `all except halt`.",
    "over": "The commands that are not sent while a preferred one is enabled.",
    "in": "`E in { a, b }` is true if E equals one of them; in `for` and `any` the range.",
    "request": "A command to the component: sending a message, calling a service, starting an"
    " action. Of an outgoing service or action, the call of the component.",
    "response": "What the component sends: a message, the answer of a service, the result of an"
    " action. Of an outgoing service or action, the answer of the controller.",
    "feedback": "What an action reports while it runs; of an outgoing action, the controller does.",
    "error": "A service or action failed, was aborted, or missed its deadline. Of an outgoing"
    " service or action: the controller answers that it failed.",
    "cancel": "A running goal of an action is cancelled; it goes on until its server has ended it."
    " Of an outgoing action, the component cancels it.",
    "cancelled": "The server of an action has ended the goal that was cancelled.",
    "timeout": "No message was received for the time that its `timeout:` gives.",
    "prefix": "Is put before all ROS names of the imported component.",
    "string": "Text; it can be sent and compared with literals.",
    "boolean": "`true` or `false`.",
    "integer": "A whole number; with a range, as in `integer(0..9)`, it can decide.",
    "double": "A floating-point number.",
    "none": "Nothing: the communication carries no data.",
    "duration": "A time span, of a constant or a parameter: `500 ms`, `2 s`.",
    "array": "Several values of one type, in the properties of objects.",
    "and": "True if both sides are.",
    "or": "True if one of the sides is, or both.",
    "else": "`E else F` is F where E is undefined or not a number; as the last guard of an event:"
    " none of those before it holds.",
    "true": "The boolean value that holds.",
    "false": "The boolean value that does not hold.",
    "value": "What was received with the event; in an enum, what it converts.",
}


KEYWORDS: dict[str, Keyword] = {keyword.word: keyword for keyword in _table()}

RESERVED = frozenset(word for word, keyword in KEYWORDS.items() if keyword.reserved)
"""The keywords that are never a name unless escaped; for all others the context decides."""


UNITS = {"ms": 0.001, "s": 1.0, "min": 60.0, "h": 3600.0}
"""The units of durations, in seconds. They only follow numbers and are not keywords."""

FOREIGN_UNITS = {
    **dict.fromkeys(("msec", "msecs", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("m", "mins", "minute", "minutes"), "min"),
    **dict.fromkeys(("hr", "hrs", "hour", "hours"), "h"),
}
"""Units of time in other languages, and what they are here."""


def words_of(role: Role) -> tuple[str, ...]:
    """Return the keywords with a role, in the order of the table."""
    return tuple(word for word, keyword in KEYWORDS.items() if role in keyword.roles)


@cache
def starts_of(block: str) -> tuple[str, ...]:
    """Return the keywords that start declarations in a kind of block, in the order of messages."""
    return tuple(word for word, keyword in KEYWORDS.items() if block in keyword.blocks)


BASIC_TYPES = frozenset(words_of(Role.TYPE)) - {"duration"}
"""The words that, unescaped, always mean the built-in type where a type is expected.

``duration`` is not among them: older models may have a datatype of that name.
"""


def escape(name: str) -> str:
    """Return a name as written in a model, with the escape ``^`` if it is reserved."""
    return f"^{name}" if name in RESERVED else name


FOREIGN_TYPES = {
    "float": "double",
    "real": "double",
    "int": "integer",
    "uint": "integer",
    "bool": "boolean",
    "str": "string",
    "empty": "none",
    "void": "none",
}
"""Names of the basic types in ROS and other languages, without the number of bits."""
