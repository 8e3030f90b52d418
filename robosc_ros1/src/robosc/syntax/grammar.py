"""The grammar of the language, and the nodes that its rules become.

It is built once, on first use. ``a - b`` in a rule means: once ``a`` has matched, ``b`` must.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any, cast

from pyparsing import And, Forward, MatchFirst, Opt, ParserElement, ZeroOrMore

from robosc.syntax.blocks import Block, Child, Items, Rule
from robosc.syntax.elements import Build, Built, Fault, ModelText, Nested, Terminal
from robosc.syntax.expressions import (
    ACCESS,
    Expression,
    make_access,
    make_integer,
    make_name,
    unquote,
)
from robosc.syntax.keywords import NAME, QUALIFIED
from robosc.syntax.nodes import (
    Access,
    ActionNode,
    ArrayTypeNode,
    AssignmentNode,
    BasicTypeNode,
    BehaviourNode,
    ComponentNode,
    DataFieldNode,
    DataObjectNode,
    EnumNode,
    EnumRuleNode,
    ImportNode,
    InterfaceNode,
    MessageNode,
    Name,
    NamedTypeNode,
    ObjectNode,
    PropertyNode,
    ProvideNode,
    RequirementNode,
    ResultTransitionNode,
    ServiceNode,
    StateNode,
    StringNode,
    TauNode,
    VariableNode,
)

__all__ = ["robot_block", "library_block"]

MAX_NESTING = 20
"""How deep arrays of arrays, and provided objects in objects, may be nested."""

_STRING = r"\"[^\"\\\n]*(?:\\.[^\"\\\n]*)*\"|'[^'\\\n]*(?:\\.[^'\\\n]*)*'"
_TYPE = r"string|boolean|double|none"


# --- tokens --------------------------------------------------------------------------------------


def _keyword(word: str, expected: str = "") -> ParserElement:
    return Terminal(rf"{word}(?!\w)", expected or f"'{word}'")


def _symbol(symbol: str, expected: str = "") -> ParserElement:
    pattern = "".join(f"\\{c}" for c in symbol)
    return Terminal(pattern, expected or f"'{symbol}'")


def _label(word: str, expected: str = "") -> ParserElement:
    """A keyword with its colon."""
    return Terminal(rf"{word}\s*:(?!=)", expected or f"'{word}:'")


def _choice(words: str, expected: str) -> ParserElement:
    return Terminal(rf"(?:{words})\b", expected, lambda text, start, end, found: found)


def _name(expected: str) -> ParserElement:
    return Terminal(NAME, expected, make_name, is_name=True)


def _communication(expected: str) -> ParserElement:
    return Terminal(QUALIFIED, expected, make_access, is_name=True)


def _string(expected: str) -> ParserElement:
    def build(text: ModelText, start: int, end: int, found: str) -> StringNode:
        return StringNode(unquote(text, start, found), span=text.span(start, end))

    return Terminal(_STRING, expected, build)


def _maybe(expr: ParserElement) -> ParserElement:
    return Opt(expr, default=None)


def _list(expr: ParserElement) -> ParserElement:
    return expr + ZeroOrMore(_symbol(",") - expr)


# --- types ---------------------------------------------------------------------------------------


def _type(expected: str = "a type") -> ParserElement:
    no_colon = r"(?!\w|\s*:)"
    kind = Forward()
    bound = Terminal(r"-?\s*\d+(?!\w)", "a whole number", make_integer)
    bounds = _symbol("(") - bound - _symbol("..") - bound - _symbol(")")
    integer = Built(_keyword(f"integer{no_colon}") + Opt(bounds), _build_integer)
    basic = Terminal(rf"(?:{_TYPE})\b{no_colon}", "a type", _build_basic)
    array = Built(
        _keyword(f"array{no_colon}") - _symbol("(", "'(' after 'array'") - kind - _symbol(")", "')' to close 'array('"),
        _build_array,
    )
    # What has a colon behind it is the name of the next property: the type is missing.
    named = Terminal(rf"{NAME}{no_colon}", "a type", _build_named, is_name=True)
    any_type = MatchFirst([basic, integer, array, named]).set_name(expected)
    kind <<= Nested(any_type, MAX_NESTING, "arrays are")
    return kind


def _build_basic(text: ModelText, start: int, end: int, found: str) -> BasicTypeNode:
    return BasicTypeNode(cast(Any, found), span=text.span(start, end))


def _build_named(text: ModelText, start: int, end: int, found: str) -> NamedTypeNode:
    return NamedTypeNode(make_name(text, start, end, found), span=text.span(start, end))


def _build_integer(text: ModelText, start: int, end: int, parts: list[Any]) -> BasicTypeNode:
    bounds = (parts[0], parts[1]) if parts else None
    return BasicTypeNode("integer", bounds, span=text.span(start, end))


def _build_array(text: ModelText, start: int, end: int, parts: list[Any]) -> ArrayTypeNode:
    return ArrayTypeNode(parts[0], span=text.span(start, end))


# --- data types and interfaces -------------------------------------------------------------------


def _datatype(top: list[Block]) -> Rule:
    kind = _type("a type after ':'")
    properties = Rule(
        _name("a property name or '}'") - _symbol(":", "':' after the property name") - kind,
        lambda text, start, end, p: PropertyNode(p[0], p[1], span=text.span(start, end)),
    )
    object_block = Block(
        Items(
            ("a property 'name: type'",),
            {},
            free=properties,
            begins=rf"{NAME}\s*:",
            resume=rf"(?P<item>(?<![\w.^]){NAME}\s*:(?!=))",
        )
    )
    rules = Rule(
        MatchFirst(
            [
                Terminal(r"default\s*->", "", lambda *_: None),
                Expression("a rule 'condition -> value' or '}'") - _symbol("->"),
            ]
        ).set_name("a rule 'condition -> value' or '}'")
        - Terminal(rf"{NAME}(?!\s*->)", "the name of the value after '->'", make_name),
        lambda text, start, end, p: EnumRuleNode(p[0], p[1], span=text.span(start, end)),
    )
    enum_block = Block(
        Items(
            ("a rule 'condition -> value'",),
            {},
            free=rules,
            begins=r"(?:value|default)\b",
            resume=rf"(?P<past>->[ \t]*{NAME}(?!\s*->)|\n)",
        )
    )
    top += [object_block, enum_block]
    object_rule = Built(
        _keyword("object") - _name("a name for the object") - object_block,
        lambda text, start, end, p: ObjectNode(p[0], tuple(p[1:]), span=text.span(start, end)),
    )
    enum_rule = Built(
        _keyword("enum")
        - _name("a name for the enum")
        - _keyword("from", "'from' and the type that is converted")
        - _type("the type that is converted after 'from'")
        - _keyword("to", "'to' after the type")
        - enum_block,
        lambda text, start, end, p: EnumNode(p[0], p[1], tuple(p[2:]), span=text.span(start, end)),
    )
    return Rule(
        MatchFirst([object_rule, enum_rule]).set_name("'object' or 'enum' after 'datatype'"),
        _from_keyword,
    )


def _from_keyword(text: ModelText, start: int, end: int, parts: list[Any]) -> Any:
    """The node that the body made, extended to the keyword before it."""
    return replace(parts[0], span=text.span(start, end))


def _interface() -> Rule:
    body = (
        _name("a name for the interface")
        - _keyword("use", "'use' and the ROS type")
        - _name("the name of the ROS type after 'use'")
        - _keyword("from", "'from' and the ROS package")
        - _name("the name of the ROS package after 'from'")
    )
    return Rule(
        body,
        lambda text, start, end, p: InterfaceNode(*p, span=text.span(start, end)),
    )


# --- communications ------------------------------------------------------------------------------


def _identifier(first: str) -> ParserElement:
    """``with``, an optional identifier, and the label of the first type."""
    given = _label("identifier") - _string("a string after 'identifier:'") - _symbol(",")
    label = _label(first, f"'{first}:'")
    start = _keyword("with", f"'with' and '{first}:'")
    return start - MatchFirst(
        [label + _nothing(), given - label]
    ).set_name(f"'identifier:' or '{first}:' after 'with'")


def _nothing() -> ParserElement:
    """Takes no text and leaves None, where an optional part is absent."""
    return Terminal(r"", "", lambda *_: None)


def _typed(label: str) -> ParserElement:
    return _symbol(",", f"',' and '{label}:'") - _label(label) - _type(f"a type after '{label}:'")


def _links() -> ParserElement:
    return _maybe(_keyword("links") - _name("the name of an interface after 'links'"))


def _links_missing(node: Any) -> tuple[str, ...]:
    return () if node.links else ("'links'",)


def _message(direction: str) -> Rule:
    body = (
        _keyword("message", f"'message' after '{direction}'")
        - _name("a name for the message")
        - _identifier("type")
        - _type("a type after 'type:'")
        - _links()
    )
    return Rule(
        body,
        lambda text, start, end, p: MessageNode(
            cast(Any, direction), *p, span=text.span(start, end)
        ),
        tail=_links_missing,
    )


def _service() -> Rule:
    body = (
        _name("a name for the service")
        - _identifier("request")
        - _type("a type after 'request:'")
        - _typed("response")
        - _links()
    )
    return Rule(
        body,
        lambda text, start, end, p: ServiceNode(*p, span=text.span(start, end)),
        tail=_links_missing,
    )


def _action() -> Rule:
    body = (
        _name("a name for the action")
        - _identifier("request")
        - _type("a type after 'request:'")
        - _typed("response")
        - _typed("feedback")
        - _links()
    )
    return Rule(
        body,
        lambda text, start, end, p: ActionNode(*p, span=text.span(start, end)),
        tail=_links_missing,
    )


# --- behaviour -----------------------------------------------------------------------------------


def _condition(keyword: str) -> ParserElement:
    return _keyword(keyword) - Expression(f"a condition after '{keyword}'")


def _transitions() -> dict[str, Rule]:
    goto = _maybe(_keyword("goto") - _name("the name of a state after 'goto'"))
    assignment = Built(
        Terminal(ACCESS, "a variable to assign to", make_access)
        - _symbol(":=", "':=' after the variable")
        - Expression("a value after ':='"),
        lambda text, start, end, p: AssignmentNode(*p, span=text.span(start, end)),
    )
    events = "request|response|feedback|error|cancel"
    result = (
        _choice(events, "'request', 'response', 'feedback', 'error' or 'cancel' after 'on'")
        - Terminal(r"(?:from|to)\b", "'from' or 'to' after the kind of event")
        - _communication("the name of a communication")
        - _maybe(_condition("if"))
        - Opt(_keyword("do") - _list(assignment))
        - goto
    )
    tau = _maybe(_condition("if")) + goto
    return {
        "on": Rule(
            Built(result, _build_result),
            _from_keyword,
            tail=_clauses_missing,
        ),
        "transition": Rule(
            Built(tau, lambda text, start, end, p: TauNode(*p, span=text.span(start, end))),
            _from_keyword,
            tail=_clauses_missing,
        ),
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


def _state(block: Block, keyword: str) -> Rule:
    named = _name("a name for the state") - block
    state = _keyword("state", f"'state' after '{keyword}'") - named
    marked = Opt(Terminal(r"marked\b", "'marked'", lambda *_: True), default=False)
    body = {
        "initial": marked - _keyword("state", "'marked' or 'state' after 'initial'") - named,
        "marked": state,
        "state": named,
    }[keyword]

    def build(text: ModelText, start: int, end: int, parts: list[Any]) -> StateNode:
        is_marked = parts.pop(0) if keyword == "initial" else keyword == "marked"
        name, *transitions = parts
        return StateNode(
            name, keyword == "initial", is_marked, tuple(transitions), span=text.span(start, end)
        )

    return Rule(body, build)


def _variable() -> Rule:
    body = (
        _name("a name for the variable")
        - _symbol(":", "':' after the name of the variable")
        - _type("a type after ':'")
        - _maybe(_symbol("=") - Expression("an initial value after '='"))
    )
    return Rule(
        body,
        lambda text, start, end, p: VariableNode(*p, span=text.span(start, end)),
        tail=lambda node: () if node.initial else ("'='",),
    )


def _behaviour_block() -> Block:
    transitions = _transitions()
    advice = (
        (r"if\b", "'if' stands before 'do' and 'goto'"),
        (r"do\b", "'do' stands before 'goto', and only after 'on'"),
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
            lambda text, start, end, p: BehaviourNode(tuple(p), span=text.span(start, end)),
        ),
    }
    words = ("'incoming message'", "'outgoing message'", "'service'", "'action'", "'behaviour'")
    advice = (
        (r"message\b", "write 'incoming message' or 'outgoing message'"),
        (r"behavior\b", "did you mean 'behaviour'?"),
        (r",?\s*identifier\s*:", "'identifier:' stands right behind 'with'"),
    )
    return Block(
        Items(words, rules, advice=advice), child=Child(behaviour_block, _adopt(BehaviourNode))
    )


def _adopt(kind: type[Any]) -> Any:
    def adopt(node: Any, late: list[Any]) -> Any | None:
        if not isinstance(node, kind):
            return None
        return replace(cast(Any, node), items=(*cast(Any, node).items, *late))

    return adopt


def _component(block: Block) -> Rule:
    prefix = (
        _keyword("with")
        - _label("prefix", "'prefix:' after 'with'")
        - _string("a string after 'prefix:'")
    )
    imported = Built(
        _keyword("from")
        - _name("the name of a library after 'from'")
        - _keyword("import", "'import' and the name of a component")
        - _name("the name of a component after 'import'")
        - _maybe(prefix),
        lambda text, start, end, p: tuple(p),
    )
    body = _name("a name for the component") - MatchFirst([imported, block]).set_name(
        "'{' or 'from' after the name of the component"
    )
    return Rule(body, _build_component)


def _build_component(
    text: ModelText, start: int, end: int, parts: list[Any]
) -> ComponentNode | ImportNode:
    name: Name = parts[0]
    span = text.span(start, end)
    if len(parts) == 2 and isinstance(parts[1], tuple):
        return ImportNode(name, *parts[1], span=span)
    return ComponentNode(name, tuple(parts[1:]), span=span)


# --- requirements and data -----------------------------------------------------------------------


def _communications() -> ParserElement:
    """One communication, or several in braces; leaves them as one tuple."""
    one = _communication("the name of a communication")
    several = (
        _symbol("{") - one - ZeroOrMore(_symbol(",") - one) - _symbol("}", "',' or '}'")
    )
    return Built(MatchFirst([several, one]), lambda text, start, end, p: tuple(p))


def _requirement() -> Rule:
    needs = Terminal(r"needs\b", "'needs'", lambda *_: "needs") - Expression(
        "a condition after 'needs'"
    )
    disables = (
        Terminal(r"disables\b", "'disables'", lambda *_: "disables")
        - _communications().set_name("the name of a communication after 'disables'")
    )
    # 'never' and 'always' may also be names: of a communication, or where an expression begins.
    named = r"(?!\s*(?:(?:needs|disables|and|or)\b|[.\[=<>*/+)]|!=))"
    invariant = Terminal(
        rf"(?:never|always)\b{named}", "", lambda text, start, end, found: found
    ) - Expression("a condition after 'never' or 'always'")
    several = (
        _symbol("{")
        - _communication("the name of a communication")
        - ZeroOrMore(_symbol(",") - _communication("the name of a communication"))
        - _symbol("}", "',' or '}'")
    )
    group = Built(several, lambda text, start, end, p: tuple(p)) - needs
    single = Expression("a communication or a condition after 'requirement'") - MatchFirst(
        [needs, disables]
    ).set_name("'needs' or 'disables'")
    return Rule(
        MatchFirst([invariant, group, single]).set_name(
            "a communication or a condition after 'requirement'"
        ),
        _build_requirement,
    )


def _build_requirement(
    text: ModelText, start: int, end: int, parts: list[Any]
) -> RequirementNode:
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
        _name("a property name") - _symbol(":", "':' after the property name") - data,
        lambda text, start, end, p: DataFieldNode(*p, span=text.span(start, end)),
    )
    filled = field - ZeroOrMore(_symbol(",") - field) - _symbol("}", "',' or '}'")
    braces = _symbol("{") - MatchFirst([_symbol("}"), filled]).set_name("a property name or '}'")
    made = Built(
        braces, lambda text, start, end, p: DataObjectNode(tuple(p), span=text.span(start, end))
    )
    data <<= Nested(
        MatchFirst([made, Expression("a value")]).set_name("a value or '{'"),
        MAX_NESTING,
        "objects are",
    )
    body = (
        _communication("the name of a communication after 'provide'")
        - _keyword("with", "'with' and the data")
        - data
        - _maybe(_condition("if"))
    )
    return Rule(
        body,
        lambda text, start, end, p: ProvideNode(*p, span=text.span(start, end)),
        tail=lambda node: () if node.condition else ("'if'",),
    )


# --- files ---------------------------------------------------------------------------------------


def _file_block(kind: str) -> Block:
    component_block = _component_block()
    inner: list[Block] = []
    rules = {
        "component": _component(component_block),
        "requirement": _requirement(),
        "provide": _provide(),
        "datatype": _datatype(inner),
        "interface": _interface(),
    }
    if kind == "library":
        for word, plural in (("requirement", "requirements"), ("provide", "provided data")):
            refusal = f"a library holds no {plural}: write this in the robot that imports it"
            rules[word] = replace(rules[word], refusal=refusal)
    words = tuple(f"'{word}'" for word in rules if not rules[word].refusal)
    block = Block(Items(words, rules), child=Child(component_block, _adopt(ComponentNode)))
    for each in inner:
        each.inside(block)
    return block


@cache
def robot_block() -> Block:
    """The grammar of what stands between the braces of a robot."""
    return _file_block("robot")


@cache
def library_block() -> Block:
    """The grammar of what stands between the braces of a library."""
    return _file_block("library")
