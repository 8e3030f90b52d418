"""The grammar of the language, and the nodes that its rules become.

It is built once, on first use, and works on the kinds of tokens. ``a - b`` in a rule means: once
``a`` has matched, ``b`` must. What stands between braces is read by blocks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

from pyparsing import ParserElement

from robosc.language.keywords import Role, words_of
from robosc.language.tokens import pattern
from robosc.syntax import terminals as t
from robosc.syntax.blocks import Block, Child, Items, Rule
from robosc.syntax.elements import (
    built,
    choice,
    either,
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
    Access,
    ActionNode,
    AssignmentNode,
    BehaviourNode,
    ComponentNode,
    DataFieldNode,
    DataObjectNode,
    EnumNode,
    EnumRuleNode,
    ImportNode,
    InterfaceNode,
    MessageNode,
    ObjectNode,
    PropertyNode,
    ProvideNode,
    RequirementNode,
    ResultTransitionNode,
    RosTypeNode,
    ServiceNode,
    StateNode,
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


def _identifier(first: str) -> ParserElement:
    """``with``, an optional identifier, and the label of the first type."""
    first_label = label(first)
    comma = symbol(",", f"',' and '{first}:'")
    given = label("identifier") - t.string("a string after 'identifier:'") - comma - first_label
    return keyword("with", f"'with' and '{first}:'") - either(
        [built(first_label, lambda reading, start, end, parts: None), given],
        f"'identifier:' or '{first}:' after 'with'",
    )


def _typed(first: str) -> ParserElement:
    return symbol(",", f"',' and '{first}:'") - label(first) - t.type_(f"a type after '{first}:'")


def _links() -> ParserElement:
    return maybe(keyword("links") - t.name("the name of an interface after 'links'"))


def _links_missing(node: Any) -> tuple[str, ...]:
    type_ = node.type if isinstance(node, MessageNode) else node.request
    return () if node.links or isinstance(type_, RosTypeNode) else ("'links'",)


def _message(direction: str) -> Rule:
    grammar = (
        keyword("message", f"'message' after '{direction}'")
        - t.name("a name for the message")
        - _identifier("type")
        - t.type_("a type after 'type:'")
        - _links()
    )
    return Rule(grammar, _node(MessageNode, direction), tail=_links_missing)


def _service() -> Rule:
    return _with_parts(ServiceNode, "service", "srv", ("request", "response"))


def _action() -> Rule:
    return _with_parts(ActionNode, "action", "action", ("request", "response", "feedback"))


def _with_parts(
    kind: Callable[..., ServiceNode | ActionNode], word: str, folder: str, labels: tuple[str, ...]
) -> Rule:
    """A service or action: its types one by one, or ``type:`` for all of them at once."""
    first, *others = labels
    types = label(first) - t.type_(f"a type after '{first}:'")
    for other in others:
        types = types - _typed(other)
    type_ = label("type") - t.ros_type("a ROS type after 'type:'")
    either_way = [type_, types - _links()]
    words = f"'type:' or '{first}:'"
    absent = terminal(f"(?= type ':' | {first} ':' )", "", _nothing)
    given = label("identifier") - t.string("a string after 'identifier:'")
    given = given - symbol(",", f"',' and {words}")
    grammar = t.name(f"a name for the {word}") - keyword("with", f"'with' and {words}")
    grammar = grammar - either(
        [absent - either(either_way, words), given - either(either_way, words)],
        f"'identifier:', {words} after 'with'",
    )

    def build(reading: Reading, start: int, end: int, parts: list[Any]) -> ServiceNode | ActionNode:
        name, identifier, *rest = parts
        if len(rest) == 1:
            rest = [replace(rest[0], folder=folder, part=n) for n in range(len(labels))]
            rest.append(None)
        return kind(name, identifier, *rest, span=reading.span(start, end))

    return Rule(grammar, build, tail=_links_missing)


def _nothing(reading: Reading, start: int, end: int, parts: list[Any]) -> None:
    return None


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
    events = words_of(Role.EVENT)
    *others, last = (f"'{word}'" for word in events)
    result = (
        terminal(" | ".join(events), f"{', '.join(others)} or {last} after 'on'", _build_event)
        - terminal("from | to", "'from' or 'to' after the kind of event")
        - t.communication("the name of a communication")
        - maybe(_condition())
        - maybe(built(keyword("do") - listed(assignment), _tuple), ())
        - goto
    )
    tau = maybe(_condition()) + goto
    return {
        "on": Rule(result, _build_result, tail=_clauses_missing),
        "transition": Rule(tau, _node(TauNode), tail=_clauses_missing),
    }


def _clauses_missing(node: Any) -> tuple[str, ...]:
    """The clauses that may still follow at the end of a transition."""
    assigns = isinstance(node, ResultTransitionNode)
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
    state_block = Block(Items(("'on'", "'transition'"), transitions, advice=advice))
    rules = {
        "variable": _variable(),
        **{word: _state(state_block, word) for word in ("initial", "marked", "state")},
        **transitions,
    }
    return Block(
        Items(("'variable'", "'state'", "'on'", "'transition'"), rules, advice=advice),
        child=Child(state_block, lambda node, late: None),
    )


# --- components ----------------------------------------------------------------------------------


def _component_block() -> Block:
    behaviour_block = _behaviour_block()
    rules = {
        "incoming": _message("incoming"),
        "outgoing": _message("outgoing"),
        "service": _service(),
        "action": _action(),
        "behaviour": Rule(nothing(), _node(BehaviourNode), block=lambda parts: behaviour_block),
    }
    words = ("'incoming message'", "'outgoing message'", "'service'", "'action'", "'behaviour'")
    advice = (("',' identifier ':'", "'identifier:' stands right behind 'with'"),)
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
    prefix = (
        keyword("with")
        - label("prefix", "'prefix:' after 'with'")
        - t.string("a string after 'prefix:'")
    )
    imported = built(
        keyword("from")
        - t.name("the name of a library after 'from'")
        - keyword("import", "'import' and the name of a component")
        - t.name("the name of a component after 'import'")
        - maybe(prefix),
        _tuple,
    )
    return Rule(
        t.name("a name for the component") - maybe(imported),
        _build_component,
        block=lambda parts: None if parts[1] else block,
        opening="'{' or 'from' after the name of the component",
    )


def _build_component(
    reading: Reading, start: int, end: int, parts: list[Any]
) -> ComponentNode | ImportNode:
    span = reading.span(start, end)
    name, imported = parts[:2]
    if imported:
        library, component, prefix = imported
        return ImportNode(name, library, component, prefix, span=span)
    return ComponentNode(name, parts[2], span=span)


# --- requirements and data -----------------------------------------------------------------------


def _requirement() -> Rule:
    expected = "a communication or a condition after 'requirement'"
    needs = choice("needs", "'needs'") - Expression("a condition after 'needs'")
    one = built(t.communication("the name of a communication"), _tuple)
    disables = choice("disables", "'disables'") - either(
        [t.communications(), one], "the name of a communication after 'disables'"
    )
    # 'never' and 'always' may also be names: of a communication, or where an expression begins.
    named = "needs | disables | and | or | '.' | '[' | INFIX | ')'"
    invariant = choice(f"(?: never | always ) (?! {named} )", "") - Expression(
        "a condition after 'never' or 'always'"
    )
    single = Expression(expected) - either([needs, disables], "'needs' or 'disables'")
    return Rule(
        either([invariant, t.communications() - needs, single], expected), _build_requirement
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
    if not isinstance(left, Access) or any(isinstance(part, int) for part in left.path):
        message = "expected the name of a communication before 'needs'"
        raise Fault(start + 1, message, span=left.span)
    return RequirementNode("needs", (left,), right, span=span)


def _provide() -> Rule:
    data = nested(_data, t.MAX_NESTING, "objects are")
    grammar = (
        t.communication("the name of a communication after 'provide'")
        - keyword("with", "'with' and the data")
        - data
        - maybe(_condition())
    )
    return Rule(grammar, _node(ProvideNode), tail=lambda node: () if node.condition else ("'if'",))


def _data(inner: ParserElement) -> ParserElement:
    """An expression or an object, whose fields are ``inner``."""
    field = built(
        t.name("a property name") - symbol(":", "':' after the property name") - inner,
        _node(DataFieldNode),
    )
    filled = listed(field) - symbol("}", "',' or '}'")
    braces = symbol("{") - either([symbol("}"), filled], "a property name or '}'")
    made = built(braces, _node(DataObjectNode, fixed=0))
    return either([made, Expression("a value")], "a value or '{'")


# --- files ---------------------------------------------------------------------------------------


def _file_block(kind: str) -> Block:
    component_block, object_block, enum_block = _component_block(), _object_block(), _enum_block()
    rules = {
        "component": _component(component_block),
        "requirement": _requirement(),
        "provide": _provide(),
        "datatype": _datatype(object_block, enum_block),
        "interface": _interface(),
    }
    if kind == "library":
        for word, plural in (("requirement", "requirements"), ("provide", "provided data")):
            refusal = f"a library holds no {plural}: write this in the robot that imports it"
            rules[word].refusal = refusal
    words = tuple(f"'{word}'" for word in rules if not rules[word].refusal)
    block = Block(Items(words, rules), child=Child(component_block, _adopt(ComponentNode)))
    object_block.parent = enum_block.parent = block
    return block


@cache
def robot_block() -> Block:
    """The grammar of what stands between the braces of a robot."""
    return _file_block("robot")


@cache
def library_block() -> Block:
    """The grammar of what stands between the braces of a library."""
    return _file_block("library")
