"""Advice for a syntax error: what the token that was found suggests."""

from __future__ import annotations

import re
from difflib import get_close_matches

from robosc.errors import listing
from robosc.language.attributes import ATTRIBUTES, attributes_of
from robosc.language.functions import FUNCTIONS
from robosc.language.keywords import FOREIGN_TYPES, UNITS, Role, words_of
from robosc.language.tokens import Tokens, is_word, pattern
from robosc.remedies import Change, Hint, Remedy, meant, write, write_one
from robosc.syntax.recovery.habits import familiar

_QUOTED = re.compile(r"'(\w+)")
_ADVICE: dict[str, Hint] = {
    "not": write("!", " for 'not'"),
    **{
        word: write(f"^{word}", " if this is a name")
        for word in (*words_of(Role.OPERATOR), *words_of(Role.CONSTANT))
    },
    ".": "a number begins with a digit, as in 0.5",
    "in": "write the values in braces: x in { a, b }",
    "between": "write a <= x and x <= b",
}
_LABELS = frozenset(attribute.name for attribute in ATTRIBUTES)
_BEFORE_ATTRIBUTES = {"with", "{", "}"}.union(*(a.communications for a in ATTRIBUTES))
_NAMING = "write 'condition NAME = …', or 'constant NAME: type = …'"
_DECLARED_ELSEWHERE: dict[str, Hint] = {
    **dict.fromkeys(("let", "define", "def", "macro"), _NAMING),
    "var": "a component's behaviour has variables: 'variable NAME: type'",
    **dict.fromkeys(("if", "when", "while"), "write 'requirement COMMAND needs CONDITION'"),
    **dict.fromkeys(("never", "always"), "write 'requirement never CONDITION'"),
    **dict.fromkeys(("publish", "send", "call", "invoke", "command"), write("provide")),
    **dict.fromkeys(("rule", "constraint", "must"), write("requirement")),
    **dict.fromkeys(("assert", "invariant", "ensure"), write("requirement always")),
    **dict.fromkeys(("priority", "prioritize"), "write 'prefer COMMAND over COMMAND'"),
    **dict.fromkeys(
        ("sensor", "actuator", "device", "part", "class", "module", "node"), write("component")
    ),
}
"""Words with which other languages begin declarations, each with a hint."""

_ROBOTS = ("node", "model", "system", "machine", "controller", "plant")
_IMPORTS = ("import", "include", "from", "use", "using")
_IMPORTING = "a library is named where it is used: 'component NAME from LIBRARY import COMPONENT'"
_INITIAL = ("start", "begin", "entry", "default", "first")
_FINAL = ("final", "end", "accepting", "terminal", "rest", "idle")

_DIRECTIONS = {
    **dict.fromkeys(
        ("publish", "publishes", "publisher", "pub", "advertise"),
        ("incoming", "what the controller publishes comes into the part"),
    ),
    **dict.fromkeys(
        ("subscribe", "subscribes", "subscriber", "sub", "subscription"),
        ("outgoing", "what the controller subscribes to goes out of the part"),
    ),
}
"""Words of ROS for communications: the direction that is meant, and why."""

_CALLS = {
    **dict.fromkeys(("client", "server", "service_client", "service_server", "srv"), "service"),
    **dict.fromkeys(("action_client", "action_server", "goal"), "action"),
}
"""Words of ROS for what the controller calls."""

_IDENTIFIERS = ("topic", "name", "ros_name", "path", "address", "id")
_OUTSIDE = "the controller {} it: only what it receives or requests has a timeout"
_PUBLISHED = "what the robot publishes is an 'outgoing message'"
_MEASURES = ("m", "cm", "mm", "km", "deg", "degrees", "rad", "Hz", "kg", "V", "A", "N", "rpm")
_EVENTS = {
    "outgoing": ("response from {}",),
    "incoming": ("request to {}",),
    "service": ("request to {}", "response from {}", "error from {}"),
    "action": ("request to {}", "response from {}", "feedback from {}"),
}
_NUMBER = pattern("NUMBER")
_GLUED = re.compile(rf"([0-9.]+)({'|'.join(UNITS)})")
_TYPE_OF_ROS = pattern("(?: NAME (?: '.' | ':' ':' ) )+ NAME")
_COMMUNICATION = pattern(
    "(?: outgoing | incoming ) message | outgoing transform | service | action"
)
_ON_NAME = "write 'response from NAME' for what the part sends, 'request to NAME' for a command"


def advice(tokens: Tokens, at: int, message: str) -> tuple[Hint | None, int, int]:
    """A hint for the token that was found instead of what was expected, or None, and the tokens
    that it is about."""
    token = tokens.text(at)
    if not token:
        return None, at, at + 1
    for about_several in (_hyphenated, _unquoted, _type_of_ros, _split, _when, familiar):
        if advised := about_several(tokens, at, message):
            return advised
    for about_one in (_expected_here, _of_other_languages, _attributes):
        if hint := about_one(tokens, at, token, message):
            return hint, at, at + 1
    cutoff = 0.6 if len(token) > 3 else 0.7
    words = _QUOTED.findall(message) if len(token) < 30 else []
    near = get_close_matches(token, words, 1, cutoff)
    return (meant(near[0]) if near and near[0] != token else None), at, at + 1


def _touches(tokens: Tokens, at: int) -> bool:
    """Whether nothing stands between a token and the one before it."""
    return 0 < at < len(tokens) and tokens.ends[at - 1] == tokens.starts[at]


def _hyphenated(tokens: Tokens, at: int, message: str) -> tuple[Hint, int, int] | None:
    """A name with a hyphen, which breaks off there."""
    if tokens.text(at) != "-" or not at or not is_word(tokens.kinds[at - 1]):
        return None
    end = at
    while tokens.text(end) == "-" and _touches(tokens, end) and _touches(tokens, end + 1):
        end += 2
    if end == at:
        return None
    name = "".join(tokens.texts(at - 1, end)).replace("-", "_")
    return write(name, ": a name has no '-'"), at - 1, end


def _unquoted(tokens: Tokens, at: int, message: str) -> tuple[Hint, int, int] | None:
    """A name of ROS without its quotes."""
    if not message.startswith("expected a string") or tokens.text(at) in (",", "}", "{"):
        return None
    end = at + 1
    while _touches(tokens, end) and tokens.text(end) not in (",", "}"):
        end += 1
    text = f'"{tokens.span(at, end).text}"'
    return Remedy(f"write {text}, in quotes", Change.REPLACE, (text,)), at, end


def _type_of_ros(tokens: Tokens, at: int, message: str) -> tuple[Hint, int, int] | None:
    """A type of ROS as C++ and Python spell it."""
    found = _TYPE_OF_ROS.match(tokens.kinds, at)
    if not found or not message.startswith(("expected a type", "expected a ROS type")):
        return None
    package, *_, name = (tokens.text(a) for a in range(at, found.end()) if is_word(tokens.kinds[a]))
    return write(f"{package}/{name}"), at, found.end()


def _split(tokens: Tokens, at: int, message: str) -> tuple[Hint, int, int] | None:
    """One word or number that was written as two: ``go to``, ``0,35``."""
    if tokens.text(at) == "go" and tokens.text(at + 1) == "to" and "'goto'" in message:
        return write("goto"), at, at + 2
    parts = list(tokens.texts(at - 1, at + 2)) if at else []
    is_number = all(_NUMBER.match(tokens.kinds, a) for a in (at - 1, at + 1))
    if parts[1:2] == [","] and is_number and _touches(tokens, at) and _touches(tokens, at + 1):
        return write(f"{parts[0]}.{parts[2]}", ", with a point"), at - 1, at + 2
    return None


def is_communication(tokens: Tokens, name: str) -> bool:
    """Whether a communication of this name is declared somewhere in a text."""
    return any(tokens.text(m.end()) == name for m in _COMMUNICATION.finditer(tokens.kinds))


def _when(tokens: Tokens, at: int, message: str) -> tuple[Hint, int, int] | None:
    """``when scan do …`` in a state."""
    if tokens.text(at) not in ("when", "upon", "event") or "'on'" not in message:
        return None
    if not is_communication(tokens, tokens.text(at + 1)):
        return write("on"), at, at + 1
    events = _event(tokens, tokens.text(at + 1))
    assert isinstance(events, Remedy)
    return write_one([f"on {event}" for event in events.parts]), at, at + 2


def _expected_here(tokens: Tokens, at: int, token: str, message: str) -> Hint | None:
    """What is meant where just this is expected."""
    if token == "=" and message.startswith("expected ':='"):
        return write(":=", " to assign")
    if message.startswith("expected ':' after the property name"):
        if token == "=":
            return write(":")
        if token == ".":
            return f"write '{tokens.text(at - 1)}: {{ {tokens.text(at + 1)}: … }}'"
    if token == ":" and message.startswith("expected an operator, or ']'"):
        return write("..")
    if message.startswith("expected ':='") and token in ("+", "-") and tokens.text(at + 1) == "=":
        return f"write '{tokens.text(at - 1)} := {tokens.text(at - 1)} {token} …'"
    if message.startswith("expected 'needs'"):
        if token == ",":
            return "write several in braces: { …, … }"
        if token in ("if", "when", "requires", "only"):
            return write("needs")
        if token == "unless":
            return "write 'requirement CONDITION disables COMMAND'"
    if message.startswith("expected a duration") and (glued := _GLUED.fullmatch(token)):
        return write(f"{glued[1]} {glued[2]}", ", with a blank")
    if message.startswith("expected a duration") and token[0].isdigit():
        return f"a duration has a unit: {', '.join(UNITS)}"
    if message.startswith("expected '=' after the name of the condition"):
        return "write 'condition NAME = …': a condition has no type"
    if message.startswith("expected ':' after the name of the constant"):
        return "write 'constant NAME: type = …'"
    if message.startswith("expected ':' after the name of the variable"):
        return _untyped(tokens, at)
    if message.startswith(("expected a type", "expected a ROS type")) and token[0] in "\"'":
        return write(token[1:-1], ", without quotes")
    if message.endswith("after 'on'") and is_word(tokens.kinds[at]):
        return _event(tokens, token)
    if "'variable'" in message:
        return _variable(tokens, at, token)
    return None


def _declared(name: str, type_: str, follows: str = "") -> Hint:
    initial = " = …" if follows in (":=", "=") else ""
    return f"write 'variable {name}: {FOREIGN_TYPES.get(type_, type_)}{initial}'"


def _untyped(tokens: Tokens, at: int) -> Hint | None:
    """``variable front double``, ``variable double := 1`` and ``variable front := 1``."""
    name, token = tokens.text(at - 1), tokens.text(at)
    if is_word(tokens.kinds[at]):
        return _declared(name, token, tokens.text(at + 1))
    if token not in (":=", "="):
        return None
    if name in words_of(Role.TYPE) or name in FOREIGN_TYPES:
        return _declared("NAME", name, token)
    return _declared(name, _type_of(tokens.text(at + 1)), token)


def _type_of(value: str) -> str:
    """The type of a variable that begins with a value."""
    if value in ("true", "false"):
        return "boolean"
    return "string" if value[:1] in ("'", '"') else "double"


def _variable(tokens: Tokens, at: int, token: str) -> Hint | None:
    """``double front := 1``, ``front: double``, ``front := 1`` where a variable is meant."""
    follows = tokens.text(at + 1)
    if token in words_of(Role.TYPE) or token in FOREIGN_TYPES:
        if follows in (":=", "="):
            return _declared("NAME", token, follows)
        if is_word(tokens.kinds[at + 1 : at + 2]):
            return _declared(follows, token, tokens.text(at + 2))
    if follows == ":" and is_word(tokens.kinds[at]):
        return write(f"variable {token}")
    if follows == ":=" and is_word(tokens.kinds[at]):
        return _declared(token, _type_of(tokens.text(at + 2)), follows)
    return None


def _event(tokens: Tokens, name: str) -> Hint | None:
    """``on button goto b``: which events the communication of this name has."""
    for match in _COMMUNICATION.finditer(tokens.kinds):
        if tokens.text(match.end()) == name:
            events = [e.format(name) for e in _EVENTS[tokens.text(match.start())]]
            return write(events[0]) if len(events) == 1 else write_one(events)
    return None if get_close_matches(name, words_of(Role.EVENT), 1, 0.6) else _ON_NAME


def _of_other_languages(tokens: Tokens, at: int, token: str, message: str) -> Hint | None:
    """What is written so in other languages, in ROS, or in physics."""
    if "'robot'" in message and token in _ROBOTS:
        return write("robot")
    if "'robot'" in message or "'component'" in message:
        if token in _IMPORTS:
            return _IMPORTING
        if "'requirement'" in message and tokens.text(at + 1) in ("needs", "disables"):
            return write(f"requirement {token}")
        if token in _DECLARED_ELSEWHERE:
            return _DECLARED_ELSEWHERE[token]
    if "'state'" in message and tokens.text(at + 1) == "state":
        if token in _INITIAL and "'variable'" in message:
            return write("initial")
        if token in _FINAL:
            return write("marked")
    if token == "-" and tokens.text(at + 1) == "-" and _touches(tokens, at + 1):
        return "a comment begins with '//'"
    if "'incoming message'" in message and token in _DIRECTIONS:
        direction, why = _DIRECTIONS[token]
        noun = "" if tokens.text(at + 1) == "message" else " message"
        return write(f"{direction}{noun}", f": {why}")
    if "'service'" in message and token in _CALLS:
        return write(_CALLS[token])
    if token == "->" and "'goto'" in message:
        return write("goto")
    if token == "," and tokens.begins_line(at + 1):
        return Remedy("no separator stands between declarations", Change.REMOVE)
    if at and _NUMBER.match(tokens.kinds, at - 1) and token in _MEASURES:
        return Remedy("numbers have no unit: leave it out", Change.REMOVE)
    if token == "not" and tokens.text(at + 1) == "in":
        return "write !(x in { a, b })"
    if token in _ADVICE:
        return _ADVICE[token]
    if at and (function := tokens.text(at - 1)) in FUNCTIONS and token != "(":
        return f"write {function}(…)"
    return None


def _attributes(tokens: Tokens, at: int, token: str, message: str) -> Hint | None:
    """Attributes of communications without a sign, by another name, or in another order."""
    unnamed = message.startswith("expected 'with' and '")
    colon = tokens.text(at + 1) == ":"
    if f"'{token}:'" in message or (unnamed and token in _LABELS):
        if not colon:
            return write(f"{token}:", " with its colon")
        missing = "'with'" if unnamed else "a ','"
        return f"{missing} is missing before it"
    if colon and token in _IDENTIFIERS and "'identifier:'" in message:
        return write("identifier")
    return _unknown_attribute(tokens, at + (token == ","))


def _unknown_attribute(tokens: Tokens, at: int) -> str | None:
    """The hint for an attribute that its communication cannot have here; None for another token."""
    name = tokens.text(at)
    if name not in _LABELS:
        return None
    start = at
    while start > 3 and tokens.text(start) not in _BEFORE_ATTRIBUTES:
        start -= 1
    kind = tokens.text(start - 2)
    if kind == "message":
        kind = tokens.text(start - 3)
    elif tokens.text(start - 3) == "outgoing":
        kind = f"outgoing {kind}"
    if tokens.text(start) != "with" or not (attributes := attributes_of(kind)):
        return None
    if name == "timeout" and all(name != attribute.name for attribute in attributes):
        outside = _OUTSIDE.format("serves" if kind.startswith("outgoing ") else "sends")
        return f"{outside}; {_PUBLISHED}" if kind == "incoming" else outside
    names = [attribute.name for attribute in attributes]
    if name in names or name == "type":
        return None if tokens.text(at - 1) == "," else "a ',' is missing before it"
    return f"there is no '{name}:' here, but " + listing((f"'{n}:'" for n in names), "or")
