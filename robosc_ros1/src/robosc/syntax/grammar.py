"""The grammar of robots and libraries, and the nodes that its rules become.

It is built once, on first use, and matches kinds of tokens. ``a - b`` in a rule is pyparsing's
error stop: once ``a`` has matched, ``b`` must. The declarations between braces are parsed by
:class:`~robosc.syntax.blocks.Block`.

pyparsing is kept for what stands inside one declaration: sequences, choices, options, repetitions
and error stops, and what each element expects, of which the messages are made. The rest is own
code, each for a reason: elements match kinds of tokens, since with the text they would have to skip
comments, and a fault would have no token to point at; blocks go on behind a fault, and close or
reopen where a brace is missing, where pyparsing ends at the first one; and expressions are read
without recursion (:mod:`robosc.syntax.expressions` says why ``infix_notation`` does not do).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

from pyparsing import ParserElement, ZeroOrMore

from robosc.language.tokens import pattern
from robosc.remedies import write
from robosc.syntax import blocks, declarations, leaves, nodes, parse_state
from robosc.syntax import terminals as t
from robosc.syntax.behaviours import behaviour_rule, condition_part
from robosc.syntax.elements import (
    built,
    choice,
    either,
    keyword,
    label,
    maybe,
    nothing,
    symbol,
    terminal,
)
from robosc.syntax.expressions import Expression

# --- components ----------------------------------------------------------------------------------


def _component_block() -> blocks.Block:
    behaviour_block, group = behaviour_rule(), _requirements_block()
    rules = {
        **{word: declarations.communication_rule(word) for word in _COMMUNICATIONS},
        "behaviour": blocks.Rule(
            nothing, leaves.make_node(nodes.BehaviourNode), block=lambda parts: behaviour_block
        ),
        **declarations.value_rules(),
        **_statement_rules(group),
    }
    meant = ((pattern("message"), "write 'incoming message' or 'outgoing message'"),)
    block = blocks.Block(
        blocks.items_of("component", rules, meant=meant),
        child=blocks.Child(behaviour_block, _adopt(nodes.BehaviourNode)),
    )
    group.parent = block
    return block


_COMMUNICATIONS = ("incoming", "outgoing", "service", "action")


def _adopt(
    kind: type[nodes.ComponentNode] | type[nodes.BehaviourNode],
) -> Callable[[Any, list[Any]], Any]:
    """A function that adds items to a node of this kind; it returns None for other nodes."""

    def adopt(node: Any, late: list[Any]) -> Any:
        grown: Any = node
        return replace(grown, items=(*grown.items, *late)) if isinstance(node, kind) else None

    return adopt


_ARGUMENT = "the name of a constant or parameter"


def _component(block: blocks.Block) -> blocks.Rule:
    return blocks.Rule(
        _declared_component,
        _build_component,
        block=lambda parts: None if parts[2] else block,
        opening="'{' or 'from' after the name of the component",
    )


def _declared_component() -> ParserElement:
    prefix = label("prefix") - t.string("a string after 'prefix:'")
    argument = built(
        terminal("(?! prefix ) NAME (?= ':' )", _ARGUMENT, leaves.make_name)
        - symbol(":")
        - Expression("a value after ':'"),
        leaves.make_node(nodes.ArgumentNode),
    )
    expected = f"'prefix:' or {_ARGUMENT}"
    given = either([prefix, argument], expected)
    first = either([prefix, argument], f"{expected} after 'with'")
    imported = built(
        keyword("from")
        - t.name("the name of a library after 'from'")
        - keyword("import", "'import' and the name of a component")
        - t.name("the name of a component after 'import'")
        - maybe(keyword("with") - first - ZeroOrMore(symbol(",") - given)),
        leaves.make_tuple,
    )
    return t.name("a name for the component") - maybe(_several()) - maybe(imported)


def _several() -> ParserElement:
    """``[first..last]``: the indexes of an indexed component."""
    return symbol("[") - t.range_() - symbol("]", "']' after the last index")


def _build_component(
    reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
) -> nodes.ComponentNode | nodes.ImportNode:
    span = reading.span(start, end)
    name, indexes, imported = parts[:3]
    if not imported:
        return nodes.ComponentNode(name, parts[3], indexes, span=span)
    library, component, *given = imported
    prefixes = [part for part in given if isinstance(part, nodes.StringNode)]
    if len(prefixes) > 1:
        message = "there are two prefixes"
        raise parse_state.Fault(start, message, span=prefixes[1].span, hint="leave one of them out")
    prefix = prefixes[0] if prefixes else None
    arguments = tuple(part for part in given if isinstance(part, nodes.ArgumentNode))
    return nodes.ImportNode(name, library, component, prefix, arguments, indexes, span=span)


# --- requirements and data -----------------------------------------------------------------------


_NAMED = "needs | disables | and | or | '.' | '[' | INFIX | ')'"
"""Before these, 'never', 'always' and 'possible' are names: of a communication, or where an
expression begins."""


def _invariant() -> ParserElement:
    """``never e`` or ``always e``."""
    return choice(f"(?: never | always ) (?! {_NAMED} )", "'never' or 'always'") - Expression(
        "a condition after 'never' or 'always'"
    )


def _title() -> ParserElement:
    """``"SR-12 walking pace near people"``; what a condition begins with is none."""
    return maybe(terminal(f"STRING (?! in | {_NAMED} )", "a title", t.build_string))


_OPENS_GROUP = (
    "(?= '{' (?: '{' | (?: (?! '}' ) . )* (?: needs | disables | never | always | possible ) ) )"
)
"""Before requirements in braces: communications in braces are names only."""


def _requirements_block() -> blocks.Block:
    """The requirements of a group: such declarations without their first word."""
    begins = pattern("QUALIFIED | '{' | '(' | '!' ")
    words = (_MEMBER,)
    free = blocks.Rule(_member, _build_member, tail=_clauses_missing)
    return blocks.Block(blocks.Items(words, {}, free=free, begins=begins, item=begins, lines=True))


_MEMBER = "a requirement such as 'command needs condition'"


def _member() -> ParserElement:
    return _untitled(_MEMBER)


def _requirement(group: blocks.Block) -> blocks.Rule:
    return blocks.Rule(
        _titled,
        _build_requirement,
        block=lambda parts: group if len(parts) == 1 else None,
        tail=_clauses_missing,
    )


def _titled() -> ParserElement:
    expected = "a communication or a condition after 'requirement'"
    opens = terminal(f"STRING {_OPENS_GROUP}", "a title", t.build_string)
    return either([opens, _title() - _untitled(expected)], expected)


def _untitled(expected: str) -> ParserElement:
    """A requirement behind its first word and its title."""
    needs = choice("needs", "'needs'") - Expression("a condition after 'needs'")
    disables = choice("disables", "'disables'") - t.communications(
        "the name of a communication after 'disables'"
    )
    goal = (
        choice(f"possible (?! {_NAMED} )", "'possible'")
        - Expression("a condition after 'possible'")
        - maybe(keyword("from") - Expression("a condition after 'from'"))
        - maybe(keyword("while") - Expression("a condition after 'while'"))
    )
    single = (
        Expression(expected) - t.maybe_except() - either([needs, disables], "'needs' or 'disables'")
    )
    to_start = keyword("to") - choice("start", "'start' after 'to'")
    on_commands = either([t.braced_communications() - needs, single], expected) - maybe(to_start)
    return either([_invariant(), goal, on_commands], expected)


def _clauses_missing(
    node: nodes.RequirementNode | nodes.PossibleNode | nodes.RequirementsNode,
) -> tuple[str, ...]:
    """The clauses that could still be added at the end of a requirement, for messages."""
    if isinstance(node, nodes.RequirementsNode):
        return ()
    if isinstance(node, nodes.PossibleNode):
        if node.along is not None:
            return ()
        return ("'while'",) if node.origin is not None else ("'from'", "'while'")
    return () if node.to_start or not node.communications else ("'to start'",)


def _build_requirement(
    reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
) -> nodes.RequirementNode | nodes.PossibleNode | nodes.RequirementsNode:
    title, *rest = parts
    if len(rest) == 1 and isinstance(rest[0], tuple):
        statements = tuple(replace(one, title=title) for one in rest[0])
        return nodes.RequirementsNode(title, statements, span=reading.span(start, end))
    return replace(_build_untitled(reading, start, end, rest), title=title)


def _build_member(
    reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
) -> nodes.RequirementNode | nodes.PossibleNode:
    """One in a group: no word before it."""
    return replace(_build_untitled(reading, start - 1, end, parts), span=reading.span(start, end))


def _build_untitled(
    reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
) -> nodes.RequirementNode | nodes.PossibleNode:
    span = reading.span(start, end)
    if parts[0] == "possible":
        return nodes.PossibleNode(*parts[1:], span=span)
    if parts[0] in ("never", "always"):
        return nodes.RequirementNode(parts[0], (), parts[1], span=span)
    *parts, start_only = parts
    to_start = start_only is not None
    if isinstance(parts[0], tuple):
        left, _, right = parts
        return nodes.RequirementNode("needs", left, right, to_start, span=span)
    left, excepted, kind, right = parts
    if kind == "disables" and excepted is None:
        return nodes.RequirementNode("disables", right, left, to_start, span=span)
    if (one := t.as_communication(left)) is None:
        message = "expected the name of a communication before 'needs'"
        called = left.span.text.removesuffix("()")
        hint = write(called) if called != left.span.text else None
        raise parse_state.Fault(start + 1, message, span=left.span, hint=hint)
    if kind == "disables":
        message = "'except' is about commands, which stand behind 'disables'"
        raise parse_state.Fault(start + 1, message, span=excepted.span)
    group = t.make_group(reading, start, end, [(one,), excepted])
    return nodes.RequirementNode("needs", group, right, to_start, span=span)


def _assume() -> ParserElement:
    expected = "a communication, 'always' or 'never' after 'assume'"
    on_message = (
        t.communication(expected)
        - choice("needs", "'needs'")
        - Expression("a condition after 'needs'")
    )
    return _title() - either([_invariant(), on_message], expected)


def _build_assumption(
    reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
) -> nodes.AssumeNode:
    span = reading.span(start, end)
    title, *parts = parts
    if len(parts) == 2:
        return nodes.AssumeNode(parts[0], None, parts[1], title, span=span)
    communication, kind, condition = parts
    return nodes.AssumeNode(kind, communication, condition, title, span=span)


def _prefer() -> ParserElement:
    return (
        _title()
        - t.communications("the name of a communication after 'prefer'")
        - keyword("over", "'over' and the name of a communication")
        - t.communications("the name of a communication after 'over'")
    )


def _build_preference(
    reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
) -> nodes.PreferNode:
    title, preferred, over = parts
    return nodes.PreferNode(preferred, over, title, span=reading.span(start, end))


def _stop() -> ParserElement:
    return keyword("with", "'with' after 'stop'") - t.communication(
        "the name of an incoming message after 'with'"
    )


def _for() -> ParserElement:
    return (
        t.name("a name for the index after 'for'")
        - keyword("in", "'in' after the name")
        - t.range_()
    )


def _provide() -> ParserElement:
    grammar = (
        t.communication("the name of a communication after 'provide'")
        - keyword("with", "'with' and the data")
        - declarations.data_part()
        - maybe(condition_part())
    )
    otherwise = keyword("else") - keyword("with", "'with' and the data") - declarations.data_part()
    otherwise = built(otherwise - maybe(condition_part()), leaves.make_node(nodes.OtherwiseNode))
    return grammar - ZeroOrMore(otherwise)


def _build_provide(
    reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
) -> nodes.ProvideNode:
    communication, data, condition, *otherwise = parts
    conditions = [condition, *(part.condition for part in otherwise)]
    for missing, part in zip(conditions, otherwise, strict=False):
        if missing is None:
            message = "nothing comes to this: what stands before it has no condition"
            raise parse_state.Fault(start + 1, message, span=part.span, hint="give that an 'if'")
    span = reading.span(start, end)
    return nodes.ProvideNode(communication, data, condition, tuple(otherwise), span=span)


def _rest_of_provide(node: nodes.ProvideNode) -> tuple[str, ...]:
    """What could still follow at the end of a provide statement, for messages."""
    last = node.otherwise[-1].condition if node.otherwise else node.condition
    return ("'else'",) if last else ("'if'",)


def _statement_rules(group: blocks.Block) -> dict[str, blocks.Rule]:
    """The rules of the statements that stand in robots and in components."""
    return {
        "requirement": _requirement(group),
        "provide": blocks.Rule(_provide, _build_provide, tail=_rest_of_provide),
        "prefer": blocks.Rule(_prefer, _build_preference),
    }


# --- files ---------------------------------------------------------------------------------------


def _file_block(kind: str) -> blocks.Block:
    component_block, object_block, enum_block = (
        _component_block(),
        declarations.object_rules(),
        declarations.enum_rules(),
    )
    group = _requirements_block()
    rules = {
        "component": _component(component_block),
        **_statement_rules(group),
        "datatype": declarations.datatype_rule(object_block, enum_block),
        "interface": declarations.interface_rule(),
        **declarations.value_rules(),
        "assume": blocks.Rule(_assume, _build_assumption),
        "stop": blocks.Rule(_stop, leaves.make_node(nodes.StopNode)),
        "for": blocks.Rule(_for, leaves.make_node(nodes.ForNode), block=lambda parts: for_block),
    }
    for_block = blocks.Block(blocks.items_of("for", rules))
    if kind == "library":
        for word, plural in _NOT_IN_LIBRARIES.items():
            where = f"write this in {_INSTEAD.get(word, 'a component of it')}"
            rules[word].refusal = f"a library itself cannot contain {plural}: {where}"
    items = replace(blocks.items_of(kind, rules), rules=rules)
    block = blocks.Block(items, child=blocks.Child(component_block, _adopt(nodes.ComponentNode)))
    object_block.parent = enum_block.parent = for_block.parent = group.parent = block
    return block


_NOT_IN_LIBRARIES = {
    "requirement": "requirements",
    "provide": "provided data",
    "prefer": "preferences",
    "assume": "assumptions",
    "stop": "a stop command",
    "for": "statements",
}
_INSTEAD = dict.fromkeys(("assume", "stop", "for"), "the robot that imports it")


@cache
def robot_block() -> blocks.Block:
    """The block of a robot: its declarations and statements."""
    return _file_block("robot")


@cache
def library_block() -> blocks.Block:
    """The block of a library: its declarations."""
    return _file_block("library")


_INNER = ("component", "behaviour", "state")


@cache
def block_of(kind: str) -> blocks.Block:
    """The block of a kind, as the table of keywords names it; of a ``for`` that of its robot."""
    if kind in ("object", "enum"):
        return declarations.object_rules() if kind == "object" else declarations.enum_rules()
    block = library_block() if kind == "library" else robot_block()
    for _ in range(_INNER.index(kind) + 1 if kind in _INNER else 0):
        assert block.child is not None
        block = block.child.block
    return block
