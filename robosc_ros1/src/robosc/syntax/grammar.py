"""The grammar of the language, and the nodes that its rules become.

It is built once, on first use, and works on the kinds of tokens. ``a - b`` in a rule means: once
``a`` has matched, ``b`` must. What stands between braces is read by blocks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any, cast

from pyparsing import ParserElement, ZeroOrMore

from robosc.language.attributes import Attribute, Value, attributes_of
from robosc.language.keywords import Role, words_of
from robosc.language.tokens import pattern
from robosc.syntax import terminals as t
from robosc.syntax.blocks import Block, Child, Items, Rule
from robosc.syntax.elements import (
    built,
    choice,
    either,
    in_words,
    keyword,
    label,
    listed,
    maybe,
    nested,
    nothing,
    symbol,
    terminal,
)
from robosc.syntax.expressions import ACCESS, Expression
from robosc.syntax.nodes import (
    ActionNode,
    AfterNode,
    ArgumentNode,
    ArrayNode,
    AssignmentNode,
    BehaviourNode,
    CommunicationNode,
    ComponentNode,
    ConditionNode,
    ConstantNode,
    DataFieldNode,
    DataObjectNode,
    EnumNode,
    EnumRuleNode,
    ForNode,
    ImportNode,
    InterfaceNode,
    MessageNode,
    ObjectNode,
    ParameterNode,
    PreferNode,
    PropertyNode,
    ProvideNode,
    RequirementNode,
    ResultTransitionNode,
    RosTypeNode,
    ServiceNode,
    StateNode,
    StringNode,
    TauNode,
    VariableNode,
)
from robosc.syntax.reading import Build, Fault, Reading
from robosc.syntax.values import make_access, make_name

__all__ = ["library_block", "robot_block"]


def _node(kind: Callable[..., Any], *first: Any, fixed: int | None = None) -> Build:
    """Builds a node from its parts in order; those from ``fixed`` on become one tuple."""

    def build(reading: Reading, start: int, end: int, parts: list[Any]) -> Any:
        if fixed is not None:
            parts[fixed:] = [tuple(parts[fixed:])]
        return kind(*first, *parts, span=reading.span(start, end))

    return build


def _tuple(reading: Reading, start: int, end: int, parts: list[Any]) -> Any:
    return tuple(parts)


# --- data types and interfaces -------------------------------------------------------------------


def _object_block() -> Block:
    properties = Rule(
        t.name("a property name or '}'")
        - symbol(":", "':' after the property name")
        - t.type_("a type after ':'"),
        _node(PropertyNode),
    )
    begins = pattern("WORD ':'")
    return Block(
        Items(("a property 'name: type'",), {}, free=properties, begins=begins, item=begins)
    )


def _enum_block() -> Block:
    # What an operator follows is no value: it is missing, and this begins the next rule.
    value = "WORD (?! '->' | INFIX | '<>' | '==' | '=<' | '=/=' | '.' | '..' | '[' )"
    condition = Expression("a rule 'condition -> value' or '}'") - symbol("->")
    default = terminal("default '->'", "", lambda reading, start, end, parts: None)
    rules = Rule(
        either([default, condition], "a rule 'condition -> value' or '}'")
        - terminal(value, "the name of the value after '->'", make_name),
        _node(EnumRuleNode),
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


def _datatype(object_block: Block, enum_block: Block) -> Rule:
    object_rule = choice("object", "'object'") - t.name("a name for the object")
    enum_rule = (
        choice("enum", "'enum'")
        - t.name("a name for the enum")
        - keyword("from", "'from' and the type that is converted")
        - t.type_("the type that is converted after 'from'")
        - keyword("to", "'to' after the type")
    )

    def build(reading: Reading, start: int, end: int, parts: list[Any]) -> ObjectNode | EnumNode:
        kind: Any = ObjectNode if parts[0] == "object" else EnumNode
        node: ObjectNode | EnumNode = kind(*parts[1:], span=reading.span(start, end))
        return node

    return Rule(
        either([object_rule, enum_rule], "'object' or 'enum' after 'datatype'"),
        build,
        block=lambda parts: object_block if parts[0] == "object" else enum_block,
    )


def _interface() -> Rule:
    grammar = (
        t.name("a name for the interface")
        - keyword("use", "'use' and the ROS type")
        - t.name("the name of the ROS type after 'use'")
        - keyword("from", "'from' and the ROS package")
        - t.name("the name of the ROS package after 'from'")
    )
    return Rule(grammar, _node(InterfaceNode))


# --- communications ------------------------------------------------------------------------------


def _communication(word: str) -> Rule:
    """A message, service or action, its attributes as the table says."""
    if word in ("incoming", "outgoing"):
        kind: Any = partial(cast(Any, MessageNode), word)
        named = keyword("message", f"'message' after '{word}'") - t.name("a name for the message")
    else:
        kind = ServiceNode if word == "service" else ActionNode
        named = t.name(f"a name for the {word}")
    attributes = attributes_of(word)
    types = [attribute.name for attribute in attributes if attribute.value is Value.TYPE]
    start = keyword("with", f"'with' and '{types[0]}:'")

    def build(reading: Reading, start: int, end: int, parts: list[Any]) -> CommunicationNode:
        name, *pairs = parts
        given = {"identifier": None, "links": None, **dict(pairs)}
        if "type" in given and "type" not in types:
            definition = replace(given.pop("type"), folder=_FOLDERS[word])
            given |= {type_: replace(definition, part=n) for n, type_ in enumerate(types)}
        node: CommunicationNode = kind(name=name, **given, span=reading.span(start, end))
        return node

    return Rule(named - start - _attributes(attributes, 0), build, tail=_links_missing)


_FOLDERS = {"service": "srv", "action": "action"}


def _attributes(attributes: Sequence[Attribute], place: int) -> ParserElement:
    """Those from a place on; each leaves its name and its value."""
    optional = [attribute for attribute in attributes if not attribute.required]
    required = [attribute for attribute in attributes if attribute.required]
    first = required[0].name
    choices = {}
    for later, attribute in enumerate(optional[place:], place + 1):
        comma = symbol(",", f"',' and '{first}:'")
        choices[attribute.name] = _attribute(attribute) - comma - _attributes(attributes, later)
    ending = _attribute(required[0])
    for attribute in required[1:]:
        ending = ending - symbol(",", f"',' and '{attribute.name}:'") - _attribute(attribute)
    links = keyword("links") - t.name("the name of an interface after 'links'")
    choices[first] = ending - maybe(built(links, _named("links")), ("links", None))
    if first != "type":
        definition = label("type") - t.ros_type("a ROS type 'package/Type' after 'type:'")
        choices["type"] = built(definition, _named("type"))
    expected = in_words(f"'{name}:'" for name in choices)
    return either(list(choices.values()), expected if place else f"{expected} after 'with'")


def _attribute(attribute: Attribute) -> ParserElement:
    values = {Value.STRING: t.string, Value.DURATION: t.duration, Value.TYPE: t.type_}
    value = values[attribute.value](f"{attribute.value.value} after '{attribute.name}:'")
    return built(label(attribute.name) - value, _named(attribute.name))


def _named(name: str) -> Build:
    return lambda reading, start, end, parts: (name, parts[0])


def _links_missing(node: Any) -> tuple[str, ...]:
    type_ = node.type if isinstance(node, MessageNode) else node.request
    return () if node.links or isinstance(type_, RosTypeNode) else ("'links'",)


# --- names for values ----------------------------------------------------------------------------


def _values() -> dict[str, Rule]:
    """Constants, parameters and conditions."""

    def typed(what: str, value: ParserElement) -> ParserElement:
        return (
            t.name(f"a name for the {what}")
            - symbol(":", f"':' after the name of the {what}")
            - t.type_("a type after ':'")
            - symbol("=", "'=' and a value")
            - value
        )

    condition = (
        t.name("a name for the condition")
        - symbol("=", "'=' after the name of the condition")
        - Expression("a condition after '='")
    )
    return {
        "constant": Rule(typed("constant", _data()), _node(ConstantNode)),
        "parameter": Rule(
            typed("parameter", Expression("a value after '='")), _node(ParameterNode)
        ),
        "condition": Rule(condition, _node(ConditionNode)),
    }


# --- behaviour -----------------------------------------------------------------------------------


def _condition() -> ParserElement:
    return keyword("if") - Expression("a condition after 'if'")


def _transitions() -> dict[str, Rule]:
    goto = maybe(keyword("goto") - t.name("the name of a state after 'goto'"))
    assignment = built(
        terminal(ACCESS, "a variable to assign to", make_access)
        - symbol(":=", "':=' after the variable")
        - Expression("a value after ':='"),
        _node(AssignmentNode),
    )
    assignments = maybe(built(keyword("do") - listed(assignment), _tuple), ())
    events = words_of(Role.EVENT)
    expected = in_words(f"'{word}'" for word in events) + " after 'on'"
    result = (
        terminal(" | ".join(events), expected, _build_event)
        - terminal("from | to", "'from' or 'to' after the kind of event")
        - t.communication("the name of a communication")
        - maybe(_condition())
        - assignments
        - goto
    )
    after = t.duration("a duration after 'after'") - maybe(_condition()) - assignments - goto
    tau = maybe(_condition()) + goto
    return {
        "on": Rule(result, _build_result, tail=_clauses_missing),
        "transition": Rule(tau, _node(TauNode), tail=_clauses_missing),
        "after": Rule(after, _node(AfterNode), tail=_clauses_missing),
    }


def _clauses_missing(node: Any) -> tuple[str, ...]:
    """The clauses that may still follow at the end of a transition."""
    assigns = not isinstance(node, TauNode)
    if node.goto:
        return ()
    if assigns and node.assignments:
        return ("','", "'goto'")
    clauses = ("'do'", "'goto'") if assigns else ("'goto'",)
    return clauses if node.guard else ("'if'", *clauses)


def _build_event(reading: Reading, start: int, end: int, parts: list[Any]) -> Any:
    return reading.text(start), reading.span(start, end)


def _build_result(reading: Reading, start: int, end: int, parts: list[Any]) -> ResultTransitionNode:
    (event, event_span), communication, guard, assignments, goto = parts
    span = reading.span(start, end)
    return ResultTransitionNode(
        event, event_span, communication, guard, assignments, goto, span=span
    )


def _state(block: Block, first: str) -> Rule:
    """A state that begins with ``initial``, ``marked`` or ``state``."""
    named = t.name("a name for the state")
    plain = keyword("state", f"'state' after '{first}'") - named
    flag = choice("marked", "") if first == "initial" else terminal("initial", "", _late_initial)
    second = maybe(flag)
    initial = second - keyword("state", "'marked' or 'state' after 'initial'") - named

    def build(reading: Reading, start: int, end: int, parts: list[Any]) -> StateNode:
        also = parts.pop(0) is not None if first != "state" else False
        is_initial = first == "initial" or (first == "marked" and also)
        is_marked = first == "marked" or (first == "initial" and also)
        name, transitions = parts
        span = reading.span(start, end)
        return StateNode(name, is_initial, is_marked, transitions, span=span)

    grammar = {"initial": initial, "marked": second + plain, "state": named}[first]
    return Rule(grammar, build, block=lambda parts: block)


def _late_initial(reading: Reading, start: int, end: int, parts: list[Any]) -> bool:
    reading.report("syntax", "'initial' stands before 'marked'", start)
    return True


def _variable() -> Rule:
    grammar = (
        t.name("a name for the variable")
        - symbol(":", "':' after the name of the variable")
        - t.type_("a type after ':'")
        - maybe(symbol("=") - Expression("an initial value after '='"))
    )
    return Rule(grammar, _node(VariableNode), tail=lambda node: () if node.initial else ("'='",))


def _behaviour_block() -> Block:
    transitions = _transitions()
    advice = (
        ("if", "'if' stands before 'do' and 'goto'"),
        ("do", "'do' stands before 'goto', and only after 'on'"),
        ("':='", "write '=' for an initial value"),
    )
    state_block = Block(Items(("'on'", "'transition'", "'after'"), transitions, advice=advice))
    rules = {
        "variable": _variable(),
        **{word: _state(state_block, word) for word in ("initial", "marked", "state")},
        "on": transitions["on"],
        "transition": transitions["transition"],
    }
    return Block(
        Items(("'variable'", "'state'", "'on'", "'transition'"), rules, advice=advice),
        child=Child(state_block, lambda node, late: None),
    )


# --- components ----------------------------------------------------------------------------------


def _component_block() -> Block:
    behaviour_block = _behaviour_block()
    values = _values()
    rules = {
        **{word: _communication(word) for word in ("incoming", "outgoing", "service", "action")},
        "behaviour": Rule(nothing(), _node(BehaviourNode), block=lambda parts: behaviour_block),
        **values,
    }
    words: tuple[str, ...] = (
        "'incoming message'",
        "'outgoing message'",
        "'service'",
        "'action'",
        "'behaviour'",
    )
    words += tuple(f"'{word}'" for word in values)
    order = "'timeout:' stands before what is carried: with timeout: 1 s, type: T"
    advice = (
        ("',' identifier ':'", "'identifier:' stands right behind 'with'"),
        *((place, order) for place in ("',' timeout ':'", "timeout ':'")),
    )
    meant = (("message", "write 'incoming message' or 'outgoing message'"),)
    return Block(
        Items(words, rules, advice=advice, meant=meant),
        child=Child(behaviour_block, _adopt(BehaviourNode)),
    )


def _adopt(kind: type[ComponentNode] | type[BehaviourNode]) -> Callable[[Any, list[Any]], Any]:
    """How a block that was closed too early gets the rest of its items."""

    def adopt(node: Any, late: list[Any]) -> Any:
        grown: Any = node
        return replace(grown, items=(*grown.items, *late)) if isinstance(node, kind) else None

    return adopt


def _component(block: Block) -> Rule:
    prefix = label("prefix") - t.string("a string after 'prefix:'")
    argument = built(
        terminal("(?! prefix ) NAME (?= ':' )", "a name", make_name)
        - symbol(":")
        - Expression("a value after ':'"),
        _node(ArgumentNode),
    )
    expected = "'prefix:' or the name of a constant or parameter"
    given = either([prefix, argument], expected)
    first = either([prefix, argument], f"{expected} after 'with'")
    imported = built(
        keyword("from")
        - t.name("the name of a library after 'from'")
        - keyword("import", "'import' and the name of a component")
        - t.name("the name of a component after 'import'")
        - maybe(keyword("with") - first - ZeroOrMore(symbol(",") - given)),
        _tuple,
    )
    return Rule(
        t.name("a name for the component") - maybe(_several()) - maybe(imported),
        _build_component,
        block=lambda parts: None if parts[2] else block,
        opening="'{' or 'from' after the name of the component",
    )


def _several() -> ParserElement:
    """The indexes of several components."""
    return symbol("[") - t.range_() - symbol("]", "']' after the last index")


def _build_component(
    reading: Reading, start: int, end: int, parts: list[Any]
) -> ComponentNode | ImportNode:
    span = reading.span(start, end)
    name, indexes, imported = parts[:3]
    if not imported:
        return ComponentNode(name, parts[3], indexes, span=span)
    library, component, *given = imported
    prefixes = [part for part in given if isinstance(part, StringNode)]
    if len(prefixes) > 1:
        message = "there are two prefixes"
        raise Fault(start, message, span=prefixes[1].span, hint="leave one of them out")
    prefix = prefixes[0] if prefixes else None
    arguments = tuple(part for part in given if isinstance(part, ArgumentNode))
    return ImportNode(name, library, component, prefix, arguments, indexes, span=span)


# --- requirements and data -----------------------------------------------------------------------


def _requirement() -> Rule:
    expected = "a communication or a condition after 'requirement'"
    needs = choice("needs", "'needs'") - Expression("a condition after 'needs'")
    disables = choice("disables", "'disables'") - t.communications(
        "the name of a communication after 'disables'"
    )
    # 'never' and 'always' may also be names: of a communication, or where an expression begins.
    named = "needs | disables | and | or | '.' | '[' | INFIX | ')'"
    invariant = choice(f"(?: never | always ) (?! {named} )", "") - Expression(
        "a condition after 'never' or 'always'"
    )
    single = Expression(expected) - either([needs, disables], "'needs' or 'disables'")
    return Rule(
        either([invariant, t.braced_communications() - needs, single], expected), _build_requirement
    )


def _build_requirement(reading: Reading, start: int, end: int, parts: list[Any]) -> RequirementNode:
    span = reading.span(start, end)
    if parts[0] in ("never", "always"):
        return RequirementNode(parts[0], (), parts[1], span=span)
    left, kind, right = parts
    if kind == "disables":
        return RequirementNode("disables", right, left, span=span)
    if isinstance(left, tuple):
        return RequirementNode("needs", left, right, span=span)
    if (one := t.as_communication(left)) is None:
        message = "expected the name of a communication before 'needs'"
        raise Fault(start + 1, message, span=left.span)
    return RequirementNode("needs", (one,), right, span=span)


def _prefer() -> Rule:
    grammar = (
        t.communications("the name of a communication after 'prefer'")
        - keyword("over", "'over' and the name of a communication")
        - t.communications("the name of a communication after 'over'")
    )
    return Rule(grammar, _node(PreferNode))


def _for(block: Block) -> Rule:
    grammar = (
        t.name("a name for the index after 'for'")
        - keyword("in", "'in' after the name")
        - t.range_()
    )
    return Rule(grammar, _node(ForNode), block=lambda parts: block)


def _provide() -> Rule:
    grammar = (
        t.communication("the name of a communication after 'provide'")
        - keyword("with", "'with' and the data")
        - _data()
        - maybe(_condition())
    )
    return Rule(grammar, _node(ProvideNode), tail=lambda node: () if node.condition else ("'if'",))


def _data() -> ParserElement:
    return nested(_datum, t.MAX_NESTING, "objects are")


def _datum(inner: ParserElement) -> ParserElement:
    """An expression, an object or an array, whose parts are ``inner``."""
    field = built(
        t.name("a property name") - symbol(":", "':' after the property name") - inner,
        _node(DataFieldNode),
    )
    filled = listed(field) - symbol("}", "',' or '}'")
    braces = symbol("{") - either([symbol("}"), filled], "a property name or '}'")
    made = built(braces, _node(DataObjectNode, fixed=0))
    elements = listed(inner) - symbol("]", "',' or ']'")
    brackets = symbol("[") - either([symbol("]"), elements], "a value or ']'")
    array = built(brackets, _node(ArrayNode, fixed=0))
    return either([made, array, Expression("a value")], "a value or '{'")


# --- files ---------------------------------------------------------------------------------------


def _file_block(kind: str) -> Block:
    component_block, object_block, enum_block = _component_block(), _object_block(), _enum_block()
    values = _values()
    statements = {
        "requirement": _requirement(),
        "provide": _provide(),
        "prefer": _prefer(),
        "condition": values["condition"],
    }
    for_block = Block(Items(tuple(f"'{word}'" for word in (*statements, "for")), statements))
    statements["for"] = _for(for_block)
    rules = {
        "component": _component(component_block),
        "requirement": statements["requirement"],
        "provide": statements["provide"],
        "datatype": _datatype(object_block, enum_block),
        "interface": _interface(),
        **values,
        "prefer": statements["prefer"],
        "for": statements["for"],
    }
    if kind == "library":
        for word, plural in _NOT_IN_LIBRARIES.items():
            refusal = f"a library holds no {plural}: write this in the robot that imports it"
            rules[word].refusal = refusal
    words = tuple(f"'{word}'" for word in rules if not rules[word].refusal)
    block = Block(Items(words, rules), child=Child(component_block, _adopt(ComponentNode)))
    object_block.parent = enum_block.parent = for_block.parent = block
    return block


_NOT_IN_LIBRARIES = {
    "requirement": "requirements",
    "provide": "provided data",
    "prefer": "preferences",
    "for": "statements",
}


@cache
def robot_block() -> Block:
    """The grammar of what stands between the braces of a robot."""
    return _file_block("robot")


@cache
def library_block() -> Block:
    """The grammar of what stands between the braces of a library."""
    return _file_block("library")
