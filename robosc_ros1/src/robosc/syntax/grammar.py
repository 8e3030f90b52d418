"""The grammar of the language, and the nodes that its rules become.

It is built once, on first use. ``a - b`` in a rule means: once ``a`` has matched, ``b`` must.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

from pyparsing import Forward, MatchFirst, Opt, ParserElement

from robosc.syntax import terminals as t
from robosc.syntax.blocks import Block, Child, Items, Rule
from robosc.syntax.elements import Build, Built, Fault, ModelText, Nested, Terminal
from robosc.syntax.expressions import ACCESS, Expression, make_access, make_name
from robosc.syntax.keywords import NAME
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
    ServiceNode,
    StateNode,
    TauNode,
    VariableNode,
)

__all__ = ["library_block", "robot_block"]


def _node(kind: Callable[..., Any], *first: Any, fixed: int | None = None) -> Build:
    """Builds a node from its parts in order; those from ``fixed`` on become one tuple."""

    def build(text: ModelText, start: int, end: int, parts: list[Any]) -> Any:
        if fixed is not None:
            parts[fixed:] = [tuple(parts[fixed:])]
        return kind(*first, *parts, span=text.span(start, end))

    return build


def _tuple(text: ModelText, start: int, end: int, parts: list[Any]) -> Any:
    return tuple(parts)


def _from_keyword(text: ModelText, start: int, end: int, parts: list[Any]) -> Any:
    """The node that the body made, extended to the keyword before it."""
    return replace(parts[0], span=text.span(start, end))


# --- data types and interfaces -------------------------------------------------------------------


def _object_block() -> Block:
    properties = Rule(
        t.name("a property name or '}'")
        - t.symbol(":", "':' after the property name")
        - t.type_("a type after ':'"),
        _node(PropertyNode),
    )
    return Block(
        Items(
            ("a property 'name: type'",),
            {},
            free=properties,
            begins=rf"{NAME}\s*:",
            marks=rf"(?P<item>(?<![\w.^]){NAME}\s*:(?!=))",
        )
    )


def _enum_block() -> Block:
    # What an operator follows is no value: it is missing, and this begins the next rule.
    value = rf"{NAME}(?!\w|\s*(?:->|!=|[<>=.+*/\[]))"
    condition = Expression("a rule 'condition -> value' or '}'") - t.symbol("->")
    default = Terminal(r"default\s*->", "", lambda text, start, end, found: None)
    rules = Rule(
        MatchFirst([default, condition]).set_name("a rule 'condition -> value' or '}'")
        - Terminal(value, "the name of the value after '->'", make_name),
        _node(EnumRuleNode),
    )
    return Block(
        Items(
            ("a rule 'condition -> value'",),
            {},
            free=rules,
            begins=r"(?:value|default)\b",
            marks=rf"(?P<item>(?:value|default)\b)|(?P<past>->[ \t]*{value}|\n)",
        )
    )


def _datatype(object_block: Block, enum_block: Block) -> Rule:
    object_rule = Built(
        t.keyword("object") - t.name("a name for the object") - object_block,
        _node(ObjectNode, fixed=1),
    )
    enum_rule = Built(
        t.keyword("enum")
        - t.name("a name for the enum")
        - t.keyword("from", "'from' and the type that is converted")
        - t.type_("the type that is converted after 'from'")
        - t.keyword("to", "'to' after the type")
        - enum_block,
        _node(EnumNode, fixed=2),
    )
    either = MatchFirst([object_rule, enum_rule]).set_name("'object' or 'enum' after 'datatype'")
    return Rule(either, _from_keyword)


def _interface() -> Rule:
    body = (
        t.name("a name for the interface")
        - t.keyword("use", "'use' and the ROS type")
        - t.name("the name of the ROS type after 'use'")
        - t.keyword("from", "'from' and the ROS package")
        - t.name("the name of the ROS package after 'from'")
    )
    return Rule(body, _node(InterfaceNode))


# --- communications ------------------------------------------------------------------------------


def _identifier(first: str) -> ParserElement:
    """``with``, an optional identifier, and the label of the first type."""
    label = t.label(first)
    comma = t.symbol(",", f"',' and '{first}:'")
    given = t.label("identifier") - t.string("a string after 'identifier:'") - comma - label
    return t.keyword("with", f"'with' and '{first}:'") - MatchFirst(
        [label + t.nothing(), given]
    ).set_name(f"'identifier:' or '{first}:' after 'with'")


def _typed(first: str) -> ParserElement:
    return (
        t.symbol(",", f"',' and '{first}:'") - t.label(first) - t.type_(f"a type after '{first}:'")
    )


def _links() -> ParserElement:
    return t.maybe(t.keyword("links") - t.name("the name of an interface after 'links'"))


def _links_missing(node: Any) -> tuple[str, ...]:
    return () if node.links else ("'links'",)


def _message(direction: str) -> Rule:
    body = (
        t.keyword("message", f"'message' after '{direction}'")
        - t.name("a name for the message")
        - _identifier("type")
        - t.type_("a type after 'type:'")
        - _links()
    )
    return Rule(body, _node(MessageNode, direction), tail=_links_missing)


def _service() -> Rule:
    body = (
        t.name("a name for the service")
        - _identifier("request")
        - t.type_("a type after 'request:'")
        - _typed("response")
        - _links()
    )
    return Rule(body, _node(ServiceNode), tail=_links_missing)


def _action() -> Rule:
    body = (
        t.name("a name for the action")
        - _identifier("request")
        - t.type_("a type after 'request:'")
        - _typed("response")
        - _typed("feedback")
        - _links()
    )
    return Rule(body, _node(ActionNode), tail=_links_missing)


# --- behaviour -----------------------------------------------------------------------------------


def _condition() -> ParserElement:
    return t.keyword("if") - Expression("a condition after 'if'")


def _transitions() -> dict[str, Rule]:
    goto = t.maybe(t.keyword("goto") - t.name("the name of a state after 'goto'"))
    assignment = Built(
        Terminal(ACCESS, "a variable to assign to", make_access)
        - t.symbol(":=", "':=' after the variable")
        - Expression("a value after ':='"),
        _node(AssignmentNode),
    )
    events = "request|response|feedback|error|cancel"
    result = (
        t.choice(events, "'request', 'response', 'feedback', 'error' or 'cancel' after 'on'")
        - Terminal(r"(?:from|to)(?!\w)", "'from' or 'to' after the kind of event")
        - t.communication("the name of a communication")
        - t.maybe(_condition())
        - Opt(t.keyword("do") - t.listed(assignment))
        - goto
    )
    tau = t.maybe(_condition()) + goto
    return {
        "on": Rule(Built(result, _build_result), _from_keyword, tail=_clauses_missing),
        "transition": Rule(Built(tau, _node(TauNode)), _from_keyword, tail=_clauses_missing),
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


def _build_result(text: ModelText, start: int, end: int, parts: list[Any]) -> ResultTransitionNode:
    event, communication, guard, *assignments, goto = parts
    return ResultTransitionNode(
        event,
        text.span(start, start + len(event)),
        communication,
        guard,
        tuple(assignments),
        goto,
        span=text.span(start, end),
    )


def _state(block: Block, first: str) -> Rule:
    """A state that begins with ``initial``, ``marked`` or ``state``."""
    named = t.name("a name for the state") - block
    plain = t.keyword("state", f"'state' after '{first}'") - named
    marked = Opt(Terminal(r"marked(?!\w)", "", lambda text, start, end, found: True), default=False)
    late = Opt(Terminal(r"initial(?!\w)", "", _late_initial), default=False)
    initial = marked - t.keyword("state", "'marked' or 'state' after 'initial'") - named

    def build(text: ModelText, start: int, end: int, parts: list[Any]) -> StateNode:
        second = parts.pop(0) if first != "state" else False
        name, *transitions = parts
        is_initial = first == "initial" or (first == "marked" and second)
        is_marked = first == "marked" or (first == "initial" and second)
        span = text.span(start, end)
        return StateNode(name, is_initial, is_marked, tuple(transitions), span=span)

    return Rule({"initial": initial, "marked": late + plain, "state": named}[first], build)


def _late_initial(text: ModelText, start: int, end: int, found: str) -> bool:
    text.report("syntax", "'initial' stands before 'marked'", start, end)
    return True


def _variable() -> Rule:
    body = (
        t.name("a name for the variable")
        - t.symbol(":", "':' after the name of the variable")
        - t.type_("a type after ':'")
        - t.maybe(t.symbol("=") - Expression("an initial value after '='"))
    )
    return Rule(body, _node(VariableNode), tail=lambda node: () if node.initial else ("'='",))


def _behaviour_block() -> Block:
    transitions = _transitions()
    advice = (
        (r"if\b", "'if' stands before 'do' and 'goto'"),
        (r"do\b", "'do' stands before 'goto', and only after 'on'"),
        (r":=", "write '=' for an initial value"),
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
        "behaviour": Rule(
            behaviour_block,
            _node(BehaviourNode, fixed=0),
        ),
    }
    words = ("'incoming message'", "'outgoing message'", "'service'", "'action'", "'behaviour'")
    advice = ((r",\s*identifier\s*:", "'identifier:' stands right behind 'with'"),)
    meant = ((r"message\b", "write 'incoming message' or 'outgoing message'"),)
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
        t.keyword("with")
        - t.label("prefix", "'prefix:' after 'with'")
        - t.string("a string after 'prefix:'")
    )
    imported = Built(
        t.keyword("from")
        - t.name("the name of a library after 'from'")
        - t.keyword("import", "'import' and the name of a component")
        - t.name("the name of a component after 'import'")
        - t.maybe(prefix),
        _tuple,
    )
    body = t.name("a name for the component") - MatchFirst([imported, block]).set_name(
        "'{' or 'from' after the name of the component"
    )
    return Rule(body, _build_component)


def _build_component(
    text: ModelText, start: int, end: int, parts: list[Any]
) -> ComponentNode | ImportNode:
    name, *items = parts
    span = text.span(start, end)
    if items and isinstance(items[0], tuple):
        library, component, prefix = items[0]
        return ImportNode(name, library, component, prefix, span=span)
    return ComponentNode(name, tuple(items), span=span)


# --- requirements and data -----------------------------------------------------------------------


def _several() -> ParserElement:
    """Communications in braces; leaves them as one tuple."""
    one = t.communication("the name of a communication")
    return Built(t.symbol("{") - t.listed(one) - t.symbol("}", "',' or '}'"), _tuple)


def _requirement() -> Rule:
    expected = "a communication or a condition after 'requirement'"
    needs = t.choice("needs", "'needs'") - Expression("a condition after 'needs'")
    one = Built(t.communication("the name of a communication"), _tuple)
    disables = t.choice("disables", "'disables'") - MatchFirst([_several(), one]).set_name(
        "the name of a communication after 'disables'"
    )
    # 'never' and 'always' may also be names: of a communication, or where an expression begins.
    named = r"(?!\w|\s*(?:(?:needs|disables|and|or)\b|[.\[=<>*/+)]|!=))"
    invariant = t.choice(f"(?:never|always){named}", "") - Expression(
        "a condition after 'never' or 'always'"
    )
    single = Expression(expected) - MatchFirst([needs, disables]).set_name("'needs' or 'disables'")
    either = MatchFirst([invariant, _several() - needs, single]).set_name(expected)
    return Rule(either, _build_requirement)


def _build_requirement(text: ModelText, start: int, end: int, parts: list[Any]) -> RequirementNode:
    span = text.span(start, end)
    if parts[0] in ("never", "always"):
        return RequirementNode(parts[0], (), parts[1], span=span)
    left, kind, right = parts
    if kind == "disables":
        return RequirementNode("disables", right, left, span=span)
    if isinstance(left, tuple):
        return RequirementNode("needs", left, right, span=span)
    if not isinstance(left, Access) or any(isinstance(part, int) for part in left.path):
        message = "expected the name of a communication before 'needs'"
        raise Fault(text, left.span.start, message, end=left.span.end)
    return RequirementNode("needs", (left,), right, span=span)


def _provide() -> Rule:
    data = Forward()
    field = Built(
        t.name("a property name") - t.symbol(":", "':' after the property name") - data,
        _node(DataFieldNode),
    )
    filled = t.listed(field) - t.symbol("}", "',' or '}'")
    braces = t.symbol("{") - MatchFirst([t.symbol("}"), filled]).set_name("a property name or '}'")
    made = Built(braces, _node(DataObjectNode, fixed=0))
    data <<= Nested(
        MatchFirst([made, Expression("a value")]).set_name("a value or '{'"),
        t.MAX_NESTING,
        "objects are",
    )
    body = (
        t.communication("the name of a communication after 'provide'")
        - t.keyword("with", "'with' and the data")
        - data
        - t.maybe(_condition())
    )
    return Rule(body, _node(ProvideNode), tail=lambda node: () if node.condition else ("'if'",))


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
            rules[word] = replace(rules[word], refusal=refusal)
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
