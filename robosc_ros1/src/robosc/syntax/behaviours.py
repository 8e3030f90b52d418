"""The grammar of behaviours: variables, states and transitions."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from pyparsing import ParserElement

from robosc.errors import listing
from robosc.language import keywords, tokens
from robosc.syntax import declarations, expressions, leaves, nodes
from robosc.syntax import terminals as t
from robosc.syntax.blocks import Block, Child, Rule, items_of
from robosc.syntax.elements import built, choice, keyword, listed, maybe, symbol, terminal
from robosc.syntax.parse_state import Fault, ParseState


def condition_part() -> ParserElement:
    """``if`` and a condition."""
    return keyword("if") - expressions.Expression("a condition after 'if'")


def _goto() -> ParserElement:
    return maybe(keyword("goto") - t.state("the name of a state after 'goto'"))


def _effect() -> ParserElement:
    """``do`` and assignments, ``goto`` and a state; leaves a tuple and the state, or None."""
    assignment = built(
        terminal(expressions.ACCESS, "a variable to assign to", leaves.make_access)
        - symbol(":=", "':=' after the variable")
        - expressions.Expression("a value after ':='"),
        leaves.make_node(nodes.AssignmentNode),
    )
    return maybe(built(keyword("do") - listed(assignment), leaves.make_tuple), ()) + _goto()


def _performs() -> ParserElement:
    """What a state performs; leaves a PerformsNode, or None."""
    performing = (
        keyword("performs")
        - t.communication("the name of a command after 'performs'")
        - maybe(terminal("meanwhile", "'meanwhile'", leaves.make_name))
        - maybe(keyword("with") - declarations.data_part())
        - keyword("then", "'then' after what the state performs")
        - _effect()
    )
    return maybe(built(performing, leaves.make_node(nodes.PerformsNode)))


def _retry() -> ParserElement:
    times = terminal("INTEGER", "a number of times", _build_times)
    return (
        maybe(times - choice("times", "'times' after the number"))
        - maybe(keyword("every") - t.duration("a duration after 'every'"))
        - _goto()
        - maybe(built(keyword("else") - _effect(), leaves.make_node(nodes.EffectNode)))
    )


def _build_retry(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.RetryNode:
    *count, every, goto, rest = parts
    return nodes.RetryNode(count[0], every, goto, rest, span=reading.span(start, end))


def _build_times(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.LiteralNode:
    number = leaves.make_integer(reading, start, end, parts)
    return nodes.LiteralNode(number, span=reading.span(start, end))


def _transitions() -> dict[str, Rule]:
    return {
        "on": Rule(_on, leaves.make_node(nodes.ResultTransitionNode), tail=_clauses_missing),
        "transition": Rule(_tau, leaves.make_node(nodes.TauNode), tail=_clauses_missing),
        "after": Rule(_after, leaves.make_node(nodes.AfterNode), tail=_clauses_missing),
        "retry": Rule(_retry, _build_retry),
    }


def _on() -> ParserElement:
    events = keywords.words_of(keywords.Role.EVENT)
    expected = listing((f"'{word}'" for word in events), "or") + " after 'on'"
    return (
        built(listed(terminal(" | ".join(events), expected, leaves.make_name)), leaves.make_tuple)
        - terminal("from | to", "'from' or 'to' after the kind of event")
        - t.communications("the name of a communication")
        - _guard()
        - _effect()
    )


def _tau() -> ParserElement:
    return _guard() + _effect()


def _after() -> ParserElement:
    return t.duration("a duration after 'after'") - maybe(condition_part()) - _effect()


def _guard() -> ParserElement:
    otherwise = terminal("else", "'else'", leaves.make_node(nodes.ElseNode))
    return maybe(otherwise | condition_part())


def _clauses_missing(node: Any) -> tuple[str, ...]:
    """The clauses that could still be added at the end of a transition, for messages."""
    if node.goto:
        return ()
    if node.assignments:
        return ("','", "'goto'")
    return ("'do'", "'goto'") if node.guard else ("'if'", "'do'", "'goto'")


def _state(block: Callable[[], Block], first: str) -> Rule:
    """The rule of a state whose first keyword is ``initial``, ``marked`` or ``state``.

    ``block`` returns that of its items, which may be states.
    """

    def build(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.StateNode:
        also = parts.pop(0) is not None if first != "state" else False
        is_initial = first == "initial" or (first == "marked" and also)
        is_marked = first == "marked" or (first == "initial" and also)
        name, when, performs, _, *items = parts
        if when is not None and not is_initial:
            message = "only an initial state has a condition: in which copies it is initial"
            raise Fault(start, message, span=when.span, hint="write 'initial' before it")
        span = reading.span(start, end)
        inside = items[0] if items else ()
        return nodes.StateNode(name, is_initial, is_marked, inside, performs, when, span=span)

    return Rule(_STATES[first], build, block=lambda parts: _block_of(parts, block))


def _initial_state() -> ParserElement:
    second = maybe(choice("marked", "'marked'"))
    return second - keyword("state", "'marked' or 'state' after 'initial'") - _named_state()


def _marked_state() -> ParserElement:
    second = maybe(terminal("initial", "", _late_initial))
    return second + (keyword("state", "'state' after 'marked'") - _named_state())


@cache
def _named_state() -> ParserElement:
    name = t.name("a name for the state")
    return name - maybe(condition_part()) - _performs() - _opens()


_STATES: dict[str, Callable[[], ParserElement]] = {
    "initial": _initial_state,
    "marked": _marked_state,
    "state": _named_state,
}


def _opens() -> ParserElement:
    """Whether a brace follows; leaves a boolean."""
    return maybe(terminal("(?= '{' )", "'{'", lambda reading, start, end, parts: True), False)


def _block_of(parts: list[Any], block: Callable[[], Block]) -> Block | None:
    """The block of a state: one that performs something may have none."""
    performs, opens = parts[-2:]
    return block() if opens or performs is None else None


def _late_initial(reading: ParseState, start: int, end: int, parts: list[Any]) -> bool:
    reading.report("syntax", "'initial' comes before 'marked'", start)
    return True


def _variable(persistent: bool) -> Rule:
    """The rule of a variable whose first keyword is ``persistent`` or ``variable``."""
    return Rule(
        _persistent if persistent else _variable_itself,
        leaves.make_node(nodes.VariableNode, persistent),
        tail=lambda node: () if node.initial else ("'='",),
    )


def _persistent() -> ParserElement:
    return keyword("variable", "'variable' after 'persistent'") - _variable_itself()


@cache
def _variable_itself() -> ParserElement:
    return (
        t.name("a name for the variable")
        - symbol(":", "':' after the name of the variable")
        - t.type_("a type after ':'")
        - maybe(symbol("=") - expressions.Expression("an initial value after '='"))
    )


def behaviour_rule() -> Block:
    """The block ``behaviour { … }`` with the blocks of its states."""
    transitions = _transitions()
    advice = (
        (tokens.pattern("if"), "'if' comes before 'do' and 'goto'"),
        (tokens.pattern("do"), "'do' comes before 'goto'"),
        (tokens.pattern("':='"), "write '=' for an initial value"),
    )
    states = {word: _state(lambda: state_block, word) for word in ("initial", "marked", "state")}
    state_block = Block(items_of("state", {**states, **transitions}, advice=advice))
    variables = {word: _variable(word == "persistent") for word in ("persistent", "variable")}
    rules = {**variables, **states, **transitions}
    return Block(
        items_of("behaviour", rules, advice=advice),
        child=Child(state_block, lambda node, late: None),
    )
