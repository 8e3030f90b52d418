"""What people write who know ROS, Python, C++ or state charts: advice about several tokens."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from robosc.language.keywords import FOREIGN_UNITS
from robosc.language.tokens import Tokens, is_word, pattern
from robosc.remedies import Change, Hint, Remedy, write

Advised: TypeAlias = tuple[Hint, int, int]
"""A hint, and the tokens that it is about."""

_NUMBER = pattern("NUMBER")
_IF = ("if", "when", "while", "where", "provided")
_OF_STATE_CHARTS = ("entry", "exit", "enter", "entering", "leave", "during")
_EVENTS = {
    "response": ("message", "msg", "receive", "received", "data", "result", "success", "succeeded",
                 "done", "reply", "answer", "callback"),
    "request": ("call", "send", "publish", "command", "goal"),
    "error": ("failure", "fail", "failed", "abort", "aborted", "exception", "fault"),
    "feedback": ("progress", "status", "update"),
    "cancelled": ("preempt", "preempted", "canceled"),
}  # fmt: skip
_EVENT_OF = {word: event for event, words in _EVENTS.items() for word in words}
_QUALITY = ("qos", "queue_size", "queue", "latch", "latched", "reliability", "durability", "depth")
_GOES = ("next", "enter", "become", "switch", "to", "then")
_SENDS = ("publish", "send", "call", "pub", "emit", "trigger", "request", "command")
_SETS = ("set", "let", "var", "assign", "store")
_WAITS = ("wait", "sleep", "delay", "pause")
_EITHER_WAY = ("input", "output", "in", "out", "topic")
_STD_SRVS = ("SetBool", "Trigger", "Empty")

_NO_CONDITIONAL = "no conditional expression: write two transitions, 'on … if …' and 'on … else …'"
_NO_BRACES = "no braces: 'do' stands before what is assigned, 'goto' before a state"
_ENTERING = "what is done on entering a state stands at the transitions to it: on … do … goto …"

FOREIGN_WORDS = frozenset((*_OF_STATE_CHARTS, *_EITHER_WAY, *_GOES, *_SENDS, *_SETS, "assert"))
"""Words that mean something elsewhere, and are no misspelt keywords."""


def familiar(tokens: Tokens, at: int, message: str) -> Advised | None:
    """Advice for what is written so elsewhere; None if it is nothing that is known."""
    for advise in _ALL:
        if advised := advise(tokens, at, message):
            return advised
    return None


def _is_word_at(tokens: Tokens, at: int) -> bool:
    return 0 <= at < len(tokens) and is_word(tokens.kinds[at])


def _is_number_at(tokens: Tokens, at: int) -> bool:
    return 0 <= at < len(tokens) and _NUMBER.match(tokens.kinds, at) is not None


def _before(tokens: Tokens, at: int, count: int = 1) -> str:
    """The text of the token ``count`` tokens before one; empty if there is none."""
    return tokens.text(at - count) if at >= count else ""


def _left_out(tokens: Tokens, start: int, end: int) -> Advised:
    words = tokens.span(start, end).text
    return Remedy(f"leave '{words}' out", Change.REMOVE), start, end


def _word(word: str, tokens: Tokens, at: int) -> Advised:
    """A word in place of a sign, which may touch the word before it."""
    touches = at > 0 and tokens.ends[at - 1] == tokens.starts[at]
    return Remedy(f"write '{word}'", Change.REPLACE, (" " * touches + word,)), at, at + 1


def _superfluous(tokens: Tokens, at: int, message: str) -> Advised | None:
    """``move()``, ``needs if``, ``then goto``, ``goto state busy``, ``requirement safe:``."""
    token, following, before = tokens.text(at), tokens.text(at + 1), _before(tokens, at)
    if token == "(" and following == ")" and _is_word_at(tokens, at - 1):
        return _left_out(tokens, at, at + 2)
    if before in (*_IF, "that", "only") and _before(tokens, at, 2) == "needs":
        return _left_out(tokens, at - 1, at)
    if token == "then" and following in ("goto", "do") and "'goto'" in message:
        return _left_out(tokens, at, at + 1)
    if before == "state" and _before(tokens, at, 2) == "goto" and _is_word_at(tokens, at):
        return _left_out(tokens, at - 1, at)
    if before == "," and token == "}" and message.startswith("expected a property name"):
        return _left_out(tokens, at - 1, at)
    if message.startswith("expected a communication or a condition after 'requirement'"):
        if token == ":":
            return _left_out(tokens, at, at + 1)
        if following == ":":
            return write(f'"{token}"'), at, at + 2
    return None


def _missing(tokens: Tokens, at: int, message: str) -> Advised | None:
    """A keyword or sign that is left out, or is another one elsewhere."""
    token, following = tokens.text(at), tokens.text(at + 1)
    if message.startswith("expected 'with' after 'stop'") and _is_word_at(tokens, at):
        return write(f"with {token}"), at, at + 1
    if message.startswith("expected 'over'") and token in (",", ">", "to", "before", "then"):
        return _word("over", tokens, at)
    if message.startswith("expected 'with' and the data"):
        if token == "{":
            return write("with {"), at, at + 1
        if token in (":", "=", ":="):
            return _word("with", tokens, at)
    if message.startswith("expected ',' or '}'") and _is_word_at(tokens, at) and following == ":":
        return "a ',' is missing before it", at, at + 1
    if message.startswith("expected 'message'") and _is_word_at(tokens, at):
        noun = f"message {token}" if following == "with" else "message"
        return write(noun), at, at + 1
    if "'requirement'" in message and _is_word_at(tokens, at):
        only_if = following == "only" and tokens.text(at + 2) in _IF
        if only_if or following == "requires":
            return (
                write(f"requirement {token} needs"),
                at,
                at + (2 if following == "requires" else 3),
            )
        if following == "with" and "'provide'" in message:
            return write(f"provide {token}"), at, at + 1
    return None


def _in_declarations(tokens: Tokens, at: int, message: str) -> Advised | None:
    """Words, names and attributes of ROS in the declaration of a communication."""
    token, following = tokens.text(at), tokens.text(at + 1)
    if "'incoming message'" in message and token in _EITHER_WAY:
        noun = "" if following == "message" else " message"
        ways = (f"incoming{noun}", f"outgoing{noun}")
        text = f"write '{ways[0]}' if the part receives it, '{ways[1]}' if it sends it"
        return Remedy(text, Change.REPLACE, ways), at, at + 1
    if message.startswith("expected a name for") and token == "/":
        return "a name has no '/': the name in ROS stands behind 'identifier:'", at, at + 1
    if message.startswith("expected a ROS type") and token[:1].isupper() and following != "/":
        if token in _STD_SRVS:
            return write(f"std_srvs/{token}"), at, at + 1
        return f"write its package before it: PACKAGE/{token}", at, at + 1
    if message.startswith("expected the name of") and token[:1] in ("'", '"'):
        return write(token[1:-1], ", without quotes"), at, at + 1
    if token in _QUALITY and following == ":" and "'type:'" in message:
        return "quality of service is a parameter of the generated node: see its README", at, at + 1
    return None


def _measured(tokens: Tokens, at: int, message: str) -> Advised | None:
    """``35%``, ``0.5 sec`` and ``10 Hz`` as a time."""
    token, following = tokens.text(at), tokens.text(at + 1)
    if message.startswith("expected a value after '%'") and _is_number_at(tokens, at - 2):
        return write(f"{float(_before(tokens, at, 2)) / 100:g}"), at - 2, at
    if message.startswith("expected a duration") and _is_number_at(tokens, at):
        if following in FOREIGN_UNITS:
            return write(f"{token} {FOREIGN_UNITS[following]}"), at, at + 2
        if following == "Hz" and float(token):
            return write(f"{1 / float(token):g} s", ", the time between two"), at, at + 2
    return None


def _in_conditions(tokens: Tokens, at: int, message: str) -> Advised | None:
    """``Light is off``, ``value->ranges``, ``x > 1 for 2 s`` and ``provide … when``."""
    token, before = tokens.text(at), _before(tokens, at)
    if token == "is" and _is_word_at(tokens, at - 1):
        negated = tokens.text(at + 1) == "not"
        end = at + 2 + negated
        what = tokens.text(end - 1)
        is_value = what in ("true", "false") or _is_number_at(tokens, end - 1)
        if is_value or _before(tokens, at, 2) == ".":
            return write("!=" if negated else "="), at, end - 1
        if _is_word_at(tokens, end - 1):
            return write(f"{'!' * negated}{before}.{what}"), at - 1, end
    if token == "->" and before == "value":
        return write("."), at, at + 1
    if message.startswith("expected a name for the index") and _is_number_at(tokens, at):
        return "name the condition: 'condition NAME = … for 2 s'", at, at + 1
    if "'if'" in message and "'on'" not in message:
        if token in _IF:
            return write("if"), at, at + 1
        if token == "unless":
            return "write 'if !(…)'", at, at + 1
    return None


def _at_events(tokens: Tokens, at: int, message: str) -> Advised | None:
    """``on success grab``, ``on request grab``, ``on timeout 3 s``, ``on entry``, ``when scan``."""
    token = tokens.text(at)
    if message.endswith("after 'on'"):
        if token in _OF_STATE_CHARTS:
            return _ENTERING, at, at + 1
        if token in _EVENT_OF:
            return _event(tokens, at)
    opens = tokens.text(at + 1) in (":", "{", "/")
    if opens and token in _OF_STATE_CHARTS and "'state'" in message:
        return _ENTERING, at, at + 1
    if message.startswith("expected 'from' or 'to'"):
        if _before(tokens, at) == "timeout" and _is_number_at(tokens, at):
            return write("after"), at - 2, at
        if _before(tokens, at) == "timeout" and token in ("goto", "do", "if"):
            hint = "write 'timeout from NAME', or 'after 3 s' for the time in a state"
            return hint, at - 1, at
        if _is_word_at(tokens, at):
            to = "to" if _before(tokens, at) in ("request", "cancel") else "from"
            return write(f"{to} {token}"), at, at + 1
    if token == "timeout" and _is_number_at(tokens, at + 1) and "'after'" in message:
        return write("after"), at, at + 1
    return None


def _event(tokens: Tokens, at: int) -> Advised:
    """``success lamp`` and ``failure of lamp``, behind 'on'."""
    event = _EVENT_OF[tokens.text(at)]
    name = at + 1 + (tokens.text(at + 1) in ("from", "of", "to", "on", "for", "in"))
    if not _is_word_at(tokens, name) or tokens.text(name) in ("do", "goto", "if"):
        return write(event), at, at + 1
    to = "to" if event == "request" else "from"
    return write(f"{event} {to} {tokens.text(name)}"), at, name + 1


def _in_transitions(tokens: Tokens, at: int, message: str) -> Advised | None:
    """Statements of programs and of state charts."""
    token, following, before = tokens.text(at), tokens.text(at + 1), _before(tokens, at)
    if message.startswith("expected a value after 'else'") and token in ("do", "goto", "if"):
        return "write one more transition: 'on … else …'", at, at + 1
    if before == "if" and _before(tokens, at, 2) == ":=":
        return _NO_CONDITIONAL, at - 1, at
    if token == "then" and message.startswith("expected ','"):
        return _NO_CONDITIONAL, at, at + 1
    if token == "{" and ("'do'" in message or message.startswith("expected a variable to assign")):
        return _NO_BRACES, at, at + 1
    if "'goto'" in message and following == ":=" and "'do'" in message:
        return write(f"do {token}"), at, at + 1
    if "'goto'" in message and token in _GOES and _is_word_at(tokens, at + 1):
        return write("goto"), at, at + 1 + (following == "to")
    if token in _WAITS and "'after'" in message:
        if "'goto'" not in message and _is_number_at(tokens, at + 1):
            return write("after"), at, at + 1
        return "write 'goto WAITING', and in that state 'after 3 s goto …'", at, at + 1
    return None


def _in_assignments(tokens: Tokens, at: int, message: str) -> Advised | None:
    """``do set x to 1``, ``do x++``, ``do publish halt``, ``do print(…)``."""
    if not message.startswith("expected ':=' after the variable"):
        return None
    token, following, before = tokens.text(at), tokens.text(at + 1), _before(tokens, at)
    if token in ("+", "-") and following == token:
        return write(f"{before} := {before} {token} 1"), at - 1, at + 2
    if before in _SETS and _is_word_at(tokens, at):
        assigned = following in ("to", "=", ":=")
        return write(f"{token} :="), at - 1, at + 1 + assigned
    if before in _SENDS:
        hint = "the controller sends a command whenever it is allowed: write a 'requirement'"
        return hint, at - 1, at + (token != "(")
    if token == "(":
        return "'do' only assigns to variables", at - 1, at
    return None


_ALL: tuple[Callable[[Tokens, int, str], Advised | None], ...] = (
    _superfluous,
    _missing,
    _in_declarations,
    _measured,
    _in_conditions,
    _at_events,
    _in_transitions,
    _in_assignments,
)
