"""The grammar of data types, interfaces, communications, constants and parameters."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, cast

from pyparsing import ParserElement, ZeroOrMore

from robosc import errors, limits
from robosc.language import events, tokens
from robosc.language.attributes import TRANSFORM, TRANSFORM_TYPE, Attribute, Value, attributes_of
from robosc.syntax import blocks, expressions, leaves, nodes, parse_state
from robosc.syntax import terminals as t
from robosc.syntax.elements import (
    built,
    choice,
    either,
    keyword,
    label,
    later,
    listed,
    maybe,
    nested,
    symbol,
    terminal,
)


def object_rules() -> blocks.Block:
    """The block of an object: its properties."""
    properties = blocks.Rule(_property, leaves.make_node(nodes.PropertyNode))
    begins = tokens.pattern("WORD ':'")
    return blocks.Block(
        blocks.Items(("a property 'name: type'",), {}, free=properties, begins=begins, item=begins)
    )


def _property() -> ParserElement:
    return (
        t.name("a property name or '}'")
        - symbol(":", "':' after the property name")
        - t.type_("a type after ':'")
    )


def enum_rules() -> blocks.Block:
    """The block of an enum: its rules."""
    rules = blocks.Rule(_enum_rule, leaves.make_node(nodes.EnumRuleNode))
    begins = tokens.pattern("value | default")
    return blocks.Block(
        blocks.Items(
            ("a rule 'condition -> value'",),
            {},
            free=rules,
            begins=begins,
            item=begins,
            past=tokens.pattern(f"'->' {_ENUM_VALUE}"),
            lines=True,
        )
    )


# A word before an operator begins the next rule: the value of this one is missing.
_ENUM_VALUE = "WORD (?! '->' | INFIX | FOREIGN | '.' | '..' | '[' )"


def _enum_rule() -> ParserElement:
    condition = expressions.Expression("a rule 'condition -> value' or '}'") - symbol("->")
    default = terminal("default '->'", "'default ->'", lambda reading, start, end, parts: None)
    either_of = either([default, condition], "a rule 'condition -> value' or '}'")
    return either_of - terminal(_ENUM_VALUE, "the name of the value after '->'", leaves.make_name)


def datatype_rule(object_block: blocks.Block, enum_block: blocks.Block) -> blocks.Rule:
    """``datatype object NAME { … }`` or ``datatype enum NAME from TYPE to { … }``."""

    def build(
        reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
    ) -> nodes.ObjectNode | nodes.EnumNode:
        kind: Any = nodes.ObjectNode if parts[0] == "object" else nodes.EnumNode
        node: nodes.ObjectNode | nodes.EnumNode = kind(*parts[1:], span=reading.span(start, end))
        return node

    return blocks.Rule(
        _datatype,
        build,
        block=lambda parts: object_block if parts[0] == "object" else enum_block,
    )


def _datatype() -> ParserElement:
    object_rule = choice("object", "'object'") - t.name("a name for the object")
    enum_rule = (
        choice("enum", "'enum'")
        - t.name("a name for the enum")
        - keyword("from", "'from' and the type that is converted")
        - t.type_("the type that is converted after 'from'")
        - keyword("to", "'to' after the type")
    )
    return either([object_rule, enum_rule], "'object' or 'enum' after 'datatype'")


def interface_rule() -> blocks.Rule:
    """``interface NAME use TYPE from PACKAGE``."""
    return blocks.Rule(_interface, leaves.make_node(nodes.InterfaceNode))


def _interface() -> ParserElement:
    return (
        t.name("a name for the interface")
        - keyword("use", "'use' and the ROS type")
        - t.name("the name of the ROS type after 'use'")
        - keyword("from", "'from' and the ROS package")
        - t.name("the name of the ROS package after 'from'")
    )


def communication_rule(word: str) -> blocks.Rule:
    """A message, service or action, with its attributes from the table of the language."""

    def build(
        reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
    ) -> nodes.CommunicationNode:
        (made,) = parts
        return cast(nodes.CommunicationNode, replace(made, span=reading.span(start, end)))

    return blocks.Rule(lambda: _communication(word), build, tail=_links_missing)


@functools.cache
def _communication(word: str) -> ParserElement:
    if word == "outgoing":
        return either(
            [
                keyword(noun) - later(partial(_declared, noun, sort))
                for noun, sort in _OUTGOING.items()
            ],
            "'message', 'transform', 'service' or 'action' after 'outgoing'",
        )
    if word == "incoming":
        return keyword("message", f"'message' after '{word}'") - _declared("message", word)
    return _declared(word, word)


_OUTGOING = {
    "message": "outgoing",
    "transform": TRANSFORM,
    "service": "outgoing service",
    "action": "outgoing action",
}
"""What may follow 'outgoing', and the sort of communication that it is then."""

_NODES: dict[str, Any] = {
    "incoming": partial(cast(Any, nodes.MessageNode), "incoming"),
    "outgoing": partial(cast(Any, nodes.MessageNode), "outgoing"),
    TRANSFORM: partial(cast(Any, nodes.TransformNode), "outgoing"),
    "service": nodes.ServiceNode,
    "action": nodes.ActionNode,
    "outgoing service": nodes.ServedServiceNode,
    "outgoing action": nodes.ServedActionNode,
}


def _declared(noun: str, sort: str) -> ParserElement:
    """The name and the attributes of one sort of communication; leaves its node."""
    attributes = attributes_of(sort)
    types = [attribute.name for attribute in attributes if attribute.required]
    fields = {attribute.name: attribute.field for attribute in attributes}

    def build(
        reading: parse_state.ParseState, start: int, end: int, parts: list[Any]
    ) -> nodes.CommunicationNode:
        name, *pairs = parts
        found = _checked(reading, end, pairs, types)
        given: dict[str, Any] = {"identifier": None, "links": None}
        given |= {fields.get(attribute, attribute): value for attribute, value in found.items()}
        if sort == TRANSFORM:
            span = reading.span(start - 1, start)  # the word 'transform' stands for its type
            package, type_ = (nodes.Name(text, span=span) for text in TRANSFORM_TYPE)
            given["type"] = nodes.RosTypeNode(package, type_, span=span)
        elif "type" in given and "type" not in types:
            definition = replace(given.pop("type"), folder=events.FOLDERS[sort])
            given |= {part: replace(definition, part=n) for n, part in enumerate(types)}
        node: nodes.CommunicationNode = _NODES[sort](
            name=name, **given, span=reading.span(start, end)
        )
        return node

    named = t.name(f"a name for the {noun}") - keyword("with", f"'with' and {_types(types)}")
    return built(named - _attributes(attributes), build)


def _attributes(attributes: Sequence[Attribute]) -> ParserElement:
    """The attributes, in any order; each leaves its name, its value and its last token."""
    elements = {attribute.name: _attribute(attribute) for attribute in attributes}
    if "request" in elements:
        definition = label("type") - t.ros_type("a ROS type 'package/Type' after 'type:'")
        elements["type"] = built(definition, _named("type"))
    links = keyword("links") - t.interface("the name of an interface after 'links'")
    expected = errors.listing((f"'{name}:'" for name in elements), "or")
    several = [either(list(elements.values()), expected + where) for where in (" after 'with'", "")]
    first, others = several
    listed = first - ZeroOrMore(symbol(",") - others)
    return listed - maybe(built(links, _named("links"))) if "type" in elements else listed


def _checked(
    reading: parse_state.ParseState, end: int, pairs: Sequence[Any], types: Sequence[str]
) -> dict[str, Any]:
    """The attributes by name; a :class:`Fault` if one stands twice, or types are missing."""
    given: dict[str, Any] = {}
    behind = end
    for pair in pairs:
        if pair is None:
            continue
        name, value, first, after = pair
        if name in given:
            raise parse_state.Fault(first, f"'{name}:' stands twice", hint="leave one of them out")
        given[name] = value
        behind = behind if name == "links" else after
    missing = [name for name in types if name not in given]
    if "type" in given and "type" not in types:
        for name in types:
            if name in given:
                message = f"'type:' is the definition of all parts: there is no '{name}:' beside it"
                raise parse_state.Fault(behind - 1, message, hint=f"leave '{name}:' or 'type:' out")
        return given
    if missing:
        either_of = _types(types) if missing == list(types) else f"'{missing[0]}:'"
        raise reading.expected(behind, f"expected ',' and {either_of}")
    return given


def _types(names: Sequence[str]) -> str:
    """With which attribute the types begin, in messages: one of ROS names all parts of a call."""
    if names[0] == "from":
        return "'from:'"
    return errors.listing((f"'{name}:'" for name in dict.fromkeys(("type", names[0]))), "or")


def _attribute(attribute: Attribute) -> ParserElement:
    values: dict[Value, Callable[[str], ParserElement]] = {
        Value.STRING: t.string,
        Value.DURATION: t.duration,
        Value.CONDITION: expressions.Expression,
        Value.RATE: t.rate,
        Value.REPLACE: t.replace,
        Value.NONE: t.none,
        Value.TYPE: t.type_,
    }
    value = partial(values[attribute.value], f"{attribute.value.value} after '{attribute.name}:'")
    return built(label(attribute.name) - later(value), _named(attribute.name))


def _named(name: str) -> parse_state.Build:
    return lambda reading, start, end, parts: (name, parts[0], start, end)


def _links_missing(node: Any) -> tuple[str, ...]:
    type_ = node.type if isinstance(node, nodes.MessageNode) else node.request
    return () if node.links or isinstance(type_, nodes.RosTypeNode) else ("'links'",)


def value_rules() -> dict[str, blocks.Rule]:
    """The rules of constants, parameters, named conditions and functions."""
    return {
        "function": blocks.Rule(_function, leaves.make_node(nodes.FunctionNode)),
        "constant": blocks.Rule(_constant, leaves.make_node(nodes.ConstantNode)),
        "parameter": blocks.Rule(_parameter, leaves.make_node(nodes.ParameterNode)),
        "condition": blocks.Rule(_condition, leaves.make_node(nodes.ConditionNode)),
    }


def _typed(what: str, type_: ParserElement) -> ParserElement:
    return (
        t.name(f"a name for the {what}") - symbol(":", f"':' after the name of the {what}") - type_
    )


def _constant() -> ParserElement:
    return _typed("constant", _value_type()) - symbol("=", "'=' and a value") - data_part()


def _parameter() -> ParserElement:
    ranged = either([t.ranged_double(), _value_type()], "a type after ':'")
    return _typed("parameter", ranged) - maybe(symbol("=") - data_part())


def _value_type() -> ParserElement:
    return t.type_("a type after ':'")


def _condition() -> ParserElement:
    return (
        t.name("a name for the condition")
        - symbol("=", "'=' after the name of the condition")
        - expressions.Expression("a condition after '='")
        # One with 'in' or ',' behind its name begins a statement.
        - maybe(keyword("for (?! NAME (?: in | ',' ) )") - t.duration("a duration after 'for'"))
    )


def _function() -> ParserElement:
    argument = built(
        t.name("a name for an argument")
        - symbol(":", "':' after the name of the argument")
        - _value_type(),
        leaves.make_node(nodes.PropertyNode),
    )
    return (
        t.name("a name for the function")
        - symbol("(", "'(' after the name of the function")
        - built(listed(argument), leaves.make_tuple)
        - symbol(")", "',' or ')'")
        - symbol(":", "':' and the type of the result")
        - _value_type()
        - symbol("=", "'=' and an expression")
        - data_part()
    )


@functools.cache
def data_part() -> ParserElement:
    """An expression, an object or an array, nested to a limit; made once, as it is large."""
    return nested(_datum, limits.NESTED_DATA, "objects are")


def _datum(inner: ParserElement) -> ParserElement:
    """An expression, an object or an array, whose parts are ``inner``."""
    field = built(
        t.name("a property name") - symbol(":", "':' after the property name") - inner,
        leaves.make_node(nodes.DataFieldNode),
    )
    filled = listed(field) - symbol("}", "',' or '}'")
    braces = symbol("{", "an object") - either([symbol("}"), filled], "a property name or '}'")
    made = built(braces, leaves.make_node(nodes.DataObjectNode, fixed=0))
    filled = inner + either([_through_array(), ZeroOrMore(symbol(",") - inner)], "',' or ']'")
    brackets = symbol("[") - either(
        [symbol("]"), filled - symbol("]", "',' or ']'")], "a value or ']'"
    )
    array = built(brackets, _make_array)
    return either([made, array, expressions.Expression("a value")], "a value or '{'")


def _through_array() -> ParserElement:
    """``for position, variable in array if condition``, behind the element of a made array."""
    expected = "a name and 'in' after 'for'"
    names = t.name(expected) + maybe(symbol(",") - t.name(expected)) - keyword("in", expected)
    chosen = keyword("if") - expressions.Expression("a condition after 'if'")
    return keyword("for") - names - expressions.Expression("an array after 'in'") - maybe(chosen)


def _make_array(reading: parse_state.ParseState, start: int, end: int, parts: list[Any]) -> Any:
    span = reading.span(start, end)
    if len(parts) < 2 or not isinstance(parts[1], nodes.Name):
        return nodes.ArrayNode(tuple(parts), span=span)
    element, first, second, array, condition = parts
    position, variable = (None, first) if second is None else (first, second)
    function = leaves.make_name(reading, start, start + 1, [])
    return nodes.AggregateNode(function, element, variable, array, condition, position, span=span)
