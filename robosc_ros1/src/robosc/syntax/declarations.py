"""The grammar of data types, interfaces, communications, constants and parameters."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, cast

from pyparsing import ParserElement, ZeroOrMore

from robosc import limits
from robosc.errors import listing
from robosc.language.attributes import TRANSFORM, TRANSFORM_TYPE, Attribute, Value, attributes_of
from robosc.language.events import FOLDERS
from robosc.language.tokens import pattern
from robosc.syntax import terminals as t
from robosc.syntax.blocks import Block, Items, Rule
from robosc.syntax.elements import (
    built,
    choice,
    either,
    keyword,
    label,
    listed,
    maybe,
    nested,
    symbol,
    terminal,
)
from robosc.syntax.expressions import Expression
from robosc.syntax.leaves import make_name, make_node, make_tuple
from robosc.syntax.nodes import (
    ActionNode,
    AggregateNode,
    ArrayNode,
    CommunicationNode,
    ConditionNode,
    ConstantNode,
    DataFieldNode,
    DataObjectNode,
    EnumNode,
    EnumRuleNode,
    FunctionNode,
    InterfaceNode,
    MessageNode,
    Name,
    ObjectNode,
    ParameterNode,
    PropertyNode,
    RosTypeNode,
    ServedActionNode,
    ServedServiceNode,
    ServiceNode,
    TransformNode,
)
from robosc.syntax.parse_state import Build, Fault, ParseState


def object_rules() -> Block:
    """The block of an object: its properties."""
    properties = Rule(
        t.name("a property name or '}'")
        - symbol(":", "':' after the property name")
        - t.type_("a type after ':'"),
        make_node(PropertyNode),
    )
    begins = pattern("WORD ':'")
    return Block(
        Items(("a property 'name: type'",), {}, free=properties, begins=begins, item=begins)
    )


def enum_rules() -> Block:
    """The block of an enum: its rules."""
    # A word before an operator begins the next rule: the value of this one is missing.
    value = "WORD (?! '->' | INFIX | FOREIGN | '.' | '..' | '[' )"
    condition = Expression("a rule 'condition -> value' or '}'") - symbol("->")
    default = terminal("default '->'", "", lambda reading, start, end, parts: None)
    rules = Rule(
        either([default, condition], "a rule 'condition -> value' or '}'")
        - terminal(value, "the name of the value after '->'", make_name),
        make_node(EnumRuleNode),
    )
    begins = pattern("value | default")
    return Block(
        Items(
            ("a rule 'condition -> value'",),
            {},
            free=rules,
            begins=begins,
            item=begins,
            past=pattern(f"'->' {value}"),
            lines=True,
        )
    )


def datatype_rule(object_block: Block, enum_block: Block) -> Rule:
    """``datatype object NAME { … }`` or ``datatype enum NAME from TYPE to { … }``."""
    object_rule = choice("object", "'object'") - t.name("a name for the object")
    enum_rule = (
        choice("enum", "'enum'")
        - t.name("a name for the enum")
        - keyword("from", "'from' and the type that is converted")
        - t.type_("the type that is converted after 'from'")
        - keyword("to", "'to' after the type")
    )

    def build(reading: ParseState, start: int, end: int, parts: list[Any]) -> ObjectNode | EnumNode:
        kind: Any = ObjectNode if parts[0] == "object" else EnumNode
        node: ObjectNode | EnumNode = kind(*parts[1:], span=reading.span(start, end))
        return node

    return Rule(
        either([object_rule, enum_rule], "'object' or 'enum' after 'datatype'"),
        build,
        block=lambda parts: object_block if parts[0] == "object" else enum_block,
    )


def interface_rule() -> Rule:
    """``interface NAME use TYPE from PACKAGE``."""
    grammar = (
        t.name("a name for the interface")
        - keyword("use", "'use' and the ROS type")
        - t.name("the name of the ROS type after 'use'")
        - keyword("from", "'from' and the ROS package")
        - t.name("the name of the ROS package after 'from'")
    )
    return Rule(grammar, make_node(InterfaceNode))


def communication_rule(word: str) -> Rule:
    """A message, service or action, with its attributes from the table of the language."""
    if word == "outgoing":
        grammar = either(
            [keyword(noun) - _declared(noun, sort) for noun, sort in _OUTGOING.items()],
            "'message', 'transform', 'service' or 'action' after 'outgoing'",
        )
    elif word == "incoming":
        grammar = keyword("message", f"'message' after '{word}'") - _declared("message", word)
    else:
        grammar = _declared(word, word)

    def build(reading: ParseState, start: int, end: int, parts: list[Any]) -> CommunicationNode:
        (made,) = parts
        return cast(CommunicationNode, replace(made, span=reading.span(start, end)))

    return Rule(grammar, build, tail=_links_missing)


_OUTGOING = {
    "message": "outgoing",
    "transform": TRANSFORM,
    "service": "outgoing service",
    "action": "outgoing action",
}
"""What may follow 'outgoing', and the sort of communication that it is then."""

_NODES: dict[str, Any] = {
    "incoming": partial(cast(Any, MessageNode), "incoming"),
    "outgoing": partial(cast(Any, MessageNode), "outgoing"),
    TRANSFORM: partial(cast(Any, TransformNode), "outgoing"),
    "service": ServiceNode,
    "action": ActionNode,
    "outgoing service": ServedServiceNode,
    "outgoing action": ServedActionNode,
}


def _declared(noun: str, sort: str) -> ParserElement:
    """The name and the attributes of one sort of communication; leaves its node."""
    attributes = attributes_of(sort)
    types = [attribute.name for attribute in attributes if attribute.required]
    fields = {attribute.name: attribute.field for attribute in attributes}

    def build(reading: ParseState, start: int, end: int, parts: list[Any]) -> CommunicationNode:
        name, *pairs = parts
        found = _checked(reading, end, pairs, types)
        given: dict[str, Any] = {"identifier": None, "links": None}
        given |= {fields.get(attribute, attribute): value for attribute, value in found.items()}
        if sort == TRANSFORM:
            span = reading.span(start - 1, start)  # the word 'transform' stands for its type
            package, type_ = (Name(text, span=span) for text in TRANSFORM_TYPE)
            given["type"] = RosTypeNode(package, type_, span=span)
        elif "type" in given and "type" not in types:
            definition = replace(given.pop("type"), folder=FOLDERS[sort])
            given |= {part: replace(definition, part=n) for n, part in enumerate(types)}
        node: CommunicationNode = _NODES[sort](name=name, **given, span=reading.span(start, end))
        return node

    named = t.name(f"a name for the {noun}") - keyword("with", f"'with' and {_types(types)}")
    return built(named - _attributes(attributes), build)


def _attributes(attributes: Sequence[Attribute]) -> ParserElement:
    """The attributes, in any order; each leaves its name, its value and its last token."""
    elements = {attribute.name: _attribute(attribute) for attribute in attributes}
    if "request" in elements:
        definition = label("type") - t.ros_type("a ROS type 'package/Type' after 'type:'")
        elements["type"] = built(definition, _named("type"))
    links = keyword("links") - t.name("the name of an interface after 'links'")
    expected = listing((f"'{name}:'" for name in elements), "or")
    several = [either(list(elements.values()), expected + where) for where in (" after 'with'", "")]
    first, others = several
    listed = first - ZeroOrMore(symbol(",") - others)
    return listed - maybe(built(links, _named("links"))) if "type" in elements else listed


def _checked(
    reading: ParseState, end: int, pairs: Sequence[Any], types: Sequence[str]
) -> dict[str, Any]:
    """The attributes by name; a :class:`Fault` if one stands twice, or types are missing."""
    given: dict[str, Any] = {}
    behind = end
    for pair in pairs:
        if pair is None:
            continue
        name, value, first, after = pair
        if name in given:
            raise Fault(first, f"'{name}:' stands twice", hint="leave one of them out")
        given[name] = value
        behind = behind if name == "links" else after
    missing = [name for name in types if name not in given]
    if "type" in given and "type" not in types:
        for name in types:
            if name in given:
                message = f"'type:' is the definition of all parts: there is no '{name}:' beside it"
                raise Fault(behind - 1, message, hint=f"leave '{name}:' or 'type:' out")
        return given
    if missing:
        either_of = _types(types) if missing == list(types) else f"'{missing[0]}:'"
        raise reading.expected(behind, f"expected ',' and {either_of}")
    return given


def _types(names: Sequence[str]) -> str:
    """With which attribute the types begin, in messages: one of ROS names all parts of a call."""
    if names[0] == "from":
        return "'from:'"
    return listing((f"'{name}:'" for name in dict.fromkeys(("type", names[0]))), "or")


def _attribute(attribute: Attribute) -> ParserElement:
    values: dict[Value, Callable[[str], ParserElement]] = {
        Value.STRING: t.string,
        Value.DURATION: t.duration,
        Value.CONDITION: Expression,
        Value.RATE: t.rate,
        Value.REPLACE: t.replace,
        Value.NONE: t.none,
        Value.TYPE: t.type_,
    }
    value = values[attribute.value](f"{attribute.value.value} after '{attribute.name}:'")
    return built(label(attribute.name) - value, _named(attribute.name))


def _named(name: str) -> Build:
    return lambda reading, start, end, parts: (name, parts[0], start, end)


def _links_missing(node: Any) -> tuple[str, ...]:
    type_ = node.type if isinstance(node, MessageNode) else node.request
    return () if node.links or isinstance(type_, RosTypeNode) else ("'links'",)


def value_rules() -> dict[str, Rule]:
    """The rules of constants, parameters, named conditions and functions."""

    type_ = t.type_("a type after ':'")

    def typed(what: str, type_: ParserElement) -> ParserElement:
        return (
            t.name(f"a name for the {what}")
            - symbol(":", f"':' after the name of the {what}")
            - type_
        )

    constant = typed("constant", type_) - symbol("=", "'=' and a value") - data_part()
    ranged = either([t.ranged_double(), type_], "a type after ':'")
    parameter = typed("parameter", ranged) - maybe(symbol("=") - data_part())
    condition = (
        t.name("a name for the condition")
        - symbol("=", "'=' after the name of the condition")
        - Expression("a condition after '='")
        # One with 'in' or ',' behind its name begins a statement.
        - maybe(keyword("for (?! NAME (?: in | ',' ) )") - t.duration("a duration after 'for'"))
    )
    argument = built(
        t.name("a name for an argument")
        - symbol(":", "':' after the name of the argument")
        - t.type_("a type after ':'"),
        make_node(PropertyNode),
    )
    function = (
        t.name("a name for the function")
        - symbol("(", "'(' after the name of the function")
        - built(listed(argument), make_tuple)
        - symbol(")", "',' or ')'")
        - symbol(":", "':' and the type of the result")
        - t.type_("a type after ':'")
        - symbol("=", "'=' and an expression")
        - data_part()
    )
    return {
        "function": Rule(function, make_node(FunctionNode)),
        "constant": Rule(constant, make_node(ConstantNode)),
        "parameter": Rule(parameter, make_node(ParameterNode)),
        "condition": Rule(condition, make_node(ConditionNode)),
    }


@functools.cache
def data_part() -> ParserElement:
    """An expression, an object or an array, nested to a limit; made once, as it is large."""
    return nested(_datum, limits.NESTED_DATA, "objects are")


def _datum(inner: ParserElement) -> ParserElement:
    """An expression, an object or an array, whose parts are ``inner``."""
    field = built(
        t.name("a property name") - symbol(":", "':' after the property name") - inner,
        make_node(DataFieldNode),
    )
    filled = listed(field) - symbol("}", "',' or '}'")
    braces = symbol("{") - either([symbol("}"), filled], "a property name or '}'")
    made = built(braces, make_node(DataObjectNode, fixed=0))
    filled = inner + either([_through_array(), ZeroOrMore(symbol(",") - inner)], "',' or ']'")
    brackets = symbol("[") - either(
        [symbol("]"), filled - symbol("]", "',' or ']'")], "a value or ']'"
    )
    array = built(brackets, _make_array)
    return either([made, array, Expression("a value")], "a value or '{'")


def _through_array() -> ParserElement:
    """``for position, variable in array if condition``, behind the element of a made array."""
    expected = "a name and 'in' after 'for'"
    names = t.name(expected) + maybe(symbol(",") - t.name(expected)) - keyword("in", expected)
    chosen = keyword("if") - Expression("a condition after 'if'")
    return keyword("for") - names - Expression("an array after 'in'") - maybe(chosen)


def _make_array(reading: ParseState, start: int, end: int, parts: list[Any]) -> Any:
    span = reading.span(start, end)
    if len(parts) < 2 or not isinstance(parts[1], Name):
        return ArrayNode(tuple(parts), span=span)
    element, first, second, array, condition = parts
    position, variable = (None, first) if second is None else (first, second)
    function = make_name(reading, start, start + 1, [])
    return AggregateNode(function, element, variable, array, condition, position, span=span)
