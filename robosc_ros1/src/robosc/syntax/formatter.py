"""The layout of each kind of node, as a document for the pretty printer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from robosc.language.attributes import ATTRIBUTES, Value
from robosc.language.operators import BINARY
from robosc.language.tokens import Tokens
from robosc.syntax.nodes import (
    Access,
    ActionNode,
    AfterNode,
    AggregateNode,
    ArgumentNode,
    ArrayNode,
    AssignmentNode,
    BehaviourNode,
    BinaryNode,
    CallNode,
    ComponentNode,
    ConditionNode,
    ConstantNode,
    DataNode,
    DataObjectNode,
    DurationNode,
    ElementNode,
    EnumNode,
    EnumRuleNode,
    ExprNode,
    FileNode,
    ForNode,
    ImportNode,
    InNode,
    InterfaceNode,
    LiteralNode,
    MemberNode,
    MessageNode,
    ObjectNode,
    ParameterNode,
    PreferNode,
    PropertyNode,
    ProvideNode,
    RequirementNode,
    ResultTransitionNode,
    ServiceNode,
    SliceNode,
    StateNode,
    TauNode,
    UnaryNode,
    VariableNode,
)
from robosc.syntax.pretty_printing import Doc, Indent, Line
from robosc.syntax.words import Words

__all__ = ["Formatter", "WIDTH"]

WIDTH = 100
"""Columns of a line; longer ones are broken where the layout allows it."""

_HARD = Line(hard=True)
_LINE = Line()


class Formatter:
    """Builds the document of each kind of node, taking the words of the text in order."""

    def __init__(self, tokens: Tokens) -> None:
        self.words = Words(tokens)
        self.kinds: dict[type, Callable[[Any], Doc]] = {
            ComponentNode: self._component,
            ImportNode: self._import,
            ObjectNode: self._object,
            EnumNode: self._enum,
            InterfaceNode: self._interface,
            MessageNode: self._communication,
            ServiceNode: self._communication,
            ActionNode: self._communication,
            BehaviourNode: self._behaviour,
            StateNode: self._state,
            VariableNode: self._variable,
            ResultTransitionNode: self._transition,
            TauNode: self._transition,
            AfterNode: self._transition,
            ConstantNode: self._constant,
            ParameterNode: self._constant,
            ConditionNode: self._condition,
            PreferNode: self._prefer,
            ForNode: self._for,
            PropertyNode: self._property,
            EnumRuleNode: self._rule,
            RequirementNode: self._requirement,
            ProvideNode: self._provide,
        }

    # --- declarations with blocks ---

    def file(self, node: FileNode) -> Doc:
        """The document of the whole file."""
        head = self.words.beginning(first=True)
        body = self._block(self._spaced(2), node.declarations)
        return [*head, body, *self.words.comments(first=False)]

    def _block(self, header: Sequence[Doc], nodes: Sequence[Any]) -> Doc:
        """``header { … }`` with each node on lines of its own."""
        docs: list[Doc] = [*header, " ", self.words.take()]
        inside: list[Doc] = []
        for node in nodes:
            inside += self.words.beginning(first=not inside)
            inside.append(self.kinds[type(node)](node))
        inside += self.words.comments(first=not inside)
        if inside:
            docs += [Indent(inside), _HARD]
        return [*docs, self.words.take()]

    def _component(self, node: ComponentNode) -> Doc:
        return self._block(self._named_component(node), node.items)

    def _named_component(self, node: ComponentNode | ImportNode) -> list[Doc]:
        docs = self._spaced(2)
        if node.indexes:
            docs += [self.words.take(), *self.words.until(node.indexes.span.end), self.words.take()]
        return docs

    def _for(self, node: ForNode) -> Doc:
        header = [*self._spaced(3), " ", *self.words.until(node.indexes.span.end)]
        return self._block(header, node.statements)

    def _behaviour(self, node: BehaviourNode) -> Doc:
        return self._block(self._spaced(1), node.items)

    def _state(self, node: StateNode) -> Doc:
        return self._block(self._spaced(2 + node.initial + node.marked), node.transitions)

    def _object(self, node: ObjectNode) -> Doc:
        return self._block(self._spaced(3), node.properties)

    def _enum(self, node: EnumNode) -> Doc:
        header = [*self._spaced(4), " ", *self.words.until(node.source.span.end)]
        return self._block([*header, " ", self.words.take()], node.rules)

    # --- declarations of one line ---

    def _import(self, node: ImportNode) -> Doc:
        begin = self.words.index
        docs = self._named_component(node)
        clauses: list[Doc] = [_LINE, *self._spaced(4)]
        given: list[Any] = [*node.arguments, *([node.prefix] if node.prefix else [])]
        for number, part in enumerate(sorted(given, key=lambda part: part.span.start)):
            clauses += [self.words.take(), _LINE] if number else [_LINE, self.words.take(), " "]
            clauses += [self.words.take(), self.words.take(), " "]
            value = part.value if isinstance(part, ArgumentNode) else None
            clauses.append(self._expression(value) if value else self.words.take())
        return self.words.group(begin, [*docs, Indent(clauses)])

    def _interface(self, node: InterfaceNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = [*self._spaced(2)]
        clauses: list[Doc] = [_LINE, *self._spaced(2), _LINE, *self._spaced(2)]
        return self.words.group(begin, [*docs, Indent(clauses)])

    def _communication(self, node: MessageNode | ServiceNode | ActionNode) -> Doc:
        begin = self.words.index
        head: list[Doc] = [*self._spaced(4 if isinstance(node, MessageNode) else 3)]
        clauses: list[Doc] = []
        for number, (kind, value) in enumerate(_attributes(node)):
            clauses += [self.words.take(), _LINE] if number else [" "]
            clauses += [self.words.take(), self.words.take(), " "]
            if kind is Value.DURATION:
                clauses.append(self._expression(value))
            else:
                clauses += self.words.until(value.span.end)
        if node.links:
            clauses += [" ", *self._spaced(2)]
        return self.words.group(begin, [*head, Indent(clauses)])

    def _constant(self, node: ConstantNode | ParameterNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = [*self._spaced(2), self.words.take(), " "]
        docs += [*self.words.until(node.type.span.end), " ", self.words.take()]
        if isinstance(node.value, DataObjectNode):
            return [*docs, " ", self._data(node.value)]
        return self.words.group(begin, [*docs, Indent([_LINE, self._data(node.value)])])

    def _condition(self, node: ConditionNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = self._spaced(3)
        return self.words.group(begin, [*docs, Indent([_LINE, self._expression(node.value)])])

    def _prefer(self, node: PreferNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = [self.words.take(), " ", self._names(node.preferred)]
        over: list[Doc] = [_LINE, self.words.take(), " ", self._names(node.over)]
        return self.words.group(begin, [*docs, Indent(over)])

    def _variable(self, node: VariableNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = [*self._spaced(2), self.words.take(), " "]
        docs += self.words.until(node.type.span.end)
        if node.initial is not None:
            docs.append(Indent([_LINE, self.words.take(), " ", self._expression(node.initial)]))
        return self.words.group(begin, docs)

    def _property(self, node: PropertyNode) -> Doc:
        docs: list[Doc] = [self.words.take(), self.words.take(), " "]
        return [*docs, *self.words.until(node.type.span.end)]

    def _rule(self, node: EnumRuleNode) -> Doc:
        begin = self.words.index
        condition = node.condition
        docs: list[Doc] = [self._expression(condition) if condition else self.words.take()]
        return self.words.group(begin, [*docs, Indent([_LINE, *self._spaced(2)])])

    def _transition(self, node: ResultTransitionNode | TauNode | AfterNode) -> Doc:
        begin = self.words.index
        head: list[Doc] = [self.words.take()]
        clauses: list[Doc] = []
        assignments: tuple[AssignmentNode, ...] = ()
        if isinstance(node, ResultTransitionNode):
            head += [" ", *self._spaced(2), " ", *self.words.until(node.communication.span.end)]
            assignments = node.assignments
        elif isinstance(node, AfterNode):
            head += [" ", self._expression(node.duration)]
            assignments = node.assignments
        if node.guard is not None:
            clauses += [_LINE, self.words.take(), " ", self._expression(node.guard)]
        if assignments:
            clauses += [_LINE, self.words.take(), " ", self._assignments(assignments)]
        if node.goto:
            clauses += [_LINE, *self._spaced(2)]
        return self.words.group(begin, [*head, Indent(clauses)])

    def _assignments(self, nodes: tuple[AssignmentNode, ...]) -> Doc:
        begin = self.words.index
        docs: list[Doc] = []
        for node in nodes:
            if docs:
                docs += [self.words.take(), _LINE]
            docs += self.words.until(node.target.span.end)
            docs += [" ", self.words.take(), " ", self._expression(node.value)]
        return self.words.group(begin, [Indent(docs)])

    def _requirement(self, node: RequirementNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = [self.words.take(), " "]
        if node.kind in ("never", "always"):
            docs += [self.words.take(), " ", self._expression(node.condition)]
        elif node.kind == "needs":
            docs.append(self._names(node.communications))
            docs.append(Indent([_LINE, self.words.take(), " ", self._expression(node.condition)]))
        else:
            docs.append(self._expression(node.condition))
            docs.append(Indent([_LINE, self.words.take(), " ", self._names(node.communications)]))
        return self.words.group(begin, docs)

    def _names(self, nodes: tuple[Access, ...]) -> Doc:
        """One communication, perhaps in parentheses, or several in braces."""
        if not self.words.next_is("{"):
            return self._expression(nodes[0])
        begin = self.words.index
        docs: list[Doc] = [self.words.take()]
        inside: list[Doc] = []
        for node in nodes:
            inside += [self.words.take()] if inside else []
            inside += [_LINE, *self.words.until(node.span.end)]
        return self.words.group(begin, [*docs, Indent(inside), _LINE, self.words.take()])

    # --- data ---

    def _provide(self, node: ProvideNode) -> Doc:
        docs: list[Doc] = [self.words.take(), " "]
        docs += [*self.words.until(node.communication.span.end), " ", self.words.take(), " "]
        docs.append(self._data(node.data))
        if node.condition is not None:
            begin = self.words.index
            clause: list[Doc] = [_LINE, self.words.take(), " ", self._expression(node.condition)]
            docs.append(self.words.group(begin, [Indent(clause)]))
        return docs

    def _data(self, node: DataNode) -> Doc:
        if isinstance(node, ArrayNode):
            return self._listed(node.elements)
        if not isinstance(node, DataObjectNode):
            return self._expression(node)
        begin = self.words.index
        expanded = bool(node.fields) and self.words.line_ends_behind
        docs: list[Doc] = [self.words.take()]
        inside: list[Doc] = []
        for field in node.fields:
            inside += [self.words.take()] if inside else []
            inside += [_LINE, self.words.take(), self.words.take(), " ", self._data(field.value)]
        if inside:
            docs += [Indent(inside), _LINE]
        return self.words.group(begin, [*docs, self.words.take()], broken=expanded)

    # --- expressions ---

    def _expression(self, node: ExprNode) -> Doc:
        """The expression, with the parentheses that it has in the text."""
        begin = self.words.index
        docs: list[Doc] = []
        count = 0
        while self.words.start < node.span.start:
            docs.append(self.words.take())
            count += 1
        match node:
            case BinaryNode(operator=operator):
                inside: list[Doc] = []
                self._chain(node, BINARY[operator].level, inside)
                docs.append(self.words.group(begin, inside if count else [Indent(inside)]))
            case UnaryNode(operand=operand):
                docs += [self.words.take(), self._expression(operand)]
            case DurationNode():
                docs += self._spaced(2)
            case CallNode(function=function, arguments=arguments):
                docs += [*self.words.until(function.span.end), self._listed(arguments)]
            case AggregateNode():
                docs.append(self._aggregate(node))
            case InNode(operand=operand, values=values):
                docs += [self._expression(operand), " ", self.words.take(), " "]
                docs.append(self._listed(values))
            case ElementNode(array=array, index=index):
                docs += [self._expression(array), self.words.take(), self._tight(index)]
                docs.append(self.words.take())
            case SliceNode(array=array, first=first, last=last):
                docs += [self._expression(array), self.words.take(), self._tight(first)]
                docs += [self.words.take(), self._tight(last), self.words.take()]
            case MemberNode(object=inner):
                docs += [self._expression(inner), *self.words.until(node.span.end)]
            case ArrayNode(elements=elements):
                docs.append(self._listed(elements))
            case Access() | LiteralNode():
                docs += self.words.until(node.span.end)
        return [*docs, *(self.words.take() for _ in range(count))]

    def _chain(self, node: ExprNode, level: int, docs: list[Doc]) -> None:
        """Add the operands and operators of a chain of one level of precedence to ``docs``."""
        bare = self.words.start >= node.span.start
        if bare and isinstance(node, BinaryNode) and BINARY[node.operator].level == level:
            self._chain(node.left, level, docs)
            docs += [_LINE, self.words.take(), " "]
            self._chain(node.right, level, docs)
        else:
            docs.append(self._expression(node))

    def _listed(self, nodes: Sequence[DataNode]) -> Doc:
        """A list in brackets, separated by commas."""
        begin = self.words.index
        docs: list[Doc] = [self.words.take()]
        inside: list[Doc] = []
        for node in nodes:
            inside += [self.words.take(), _LINE] if inside else [Line(flat="")]
            inside.append(self._data(node))
        if inside:
            docs += [Indent(inside), Line(flat="")]
        return self.words.group(begin, [*docs, self.words.take()])

    def _aggregate(self, node: AggregateNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = [self.words.take(), self.words.take()]
        inside: list[Doc] = [Line(flat=""), self._expression(node.element), _LINE]
        inside += [*self._spaced(3), " ", self._expression(node.array)]
        if node.condition is not None:
            inside += [_LINE, self.words.take(), " ", self._expression(node.condition)]
        docs += [Indent(inside), Line(flat="")]
        return self.words.group(begin, [*docs, self.words.take()])

    def _tight(self, node: ExprNode) -> Doc:
        """An index, without blanks if it is arithmetic only."""
        simple = all(character not in node.span.text for character in ",{")
        return self.words.until(node.span.end) if simple else self._expression(node)

    # --- words ---

    def _spaced(self, count: int) -> list[Doc]:
        """The next ``count`` words, separated by blanks."""
        docs: list[Doc] = [self.words.take()]
        for _ in range(count - 1):
            docs += [" ", self.words.take()]
        return docs


def _attributes(node: MessageNode | ServiceNode | ActionNode) -> list[tuple[Value, Any]]:
    """The attributes behind ``with`` in source order: kind and value of each, each value once."""
    values = {
        value.span.start: (attribute.value, value)
        for attribute in ATTRIBUTES
        if (value := getattr(node, attribute.name, None)) is not None
    }
    return [values[start] for start in sorted(values)]
