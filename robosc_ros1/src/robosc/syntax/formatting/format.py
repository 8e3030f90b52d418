"""The formatter's entry points: a model in canonical layout.

The tree decides what stands on a line and where a line may be broken; the tokens themselves, and
the comments between them, are taken from the text one by one. So no token can get lost or change
places, and every name, number and string stays as it was written.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import accumulate, pairwise
from operator import eq
from typing import Any

from robosc.errors import ModelError, has_errors
from robosc.language import attributes, operators
from robosc.language.tokens import Comment, Tokens, tokenize
from robosc.lazy_dataclasses import dataclass
from robosc.source import Source
from robosc.syntax import nodes, parser
from robosc.syntax.formatting.pretty_printing import Doc, Group, Indent, Line, Remark, print_doc

# The layout of each kind of node, as a document for the pretty printer.


# The tokens of a model one by one, and the comments between them, for the formatter.


@dataclass(frozen=True, slots=True)
class _Gap:
    """The comments between two words: ``behind`` the first, and ``before`` the second.

    ``blank`` says whether an empty line precedes each of the latter, and the second word.
    """

    behind: tuple[Remark, ...]
    before: tuple[Remark, ...]
    blank: tuple[bool, ...]

    @property
    def ends_line(self) -> bool:
        return bool(self.before) or any(remark.ends_line for remark in self.behind)


_PLAIN = (_Gap((), (), (False,)), _Gap((), (), (True,)))
"""Gaps without comments, without and with an empty line."""


class Words:
    """The words (tokens) of a model in order, each taken once, with its comments.

    ``index`` counts the words that were taken.
    """

    def __init__(self, tokens: Tokens) -> None:
        source = tokens.source
        spans = list(zip(tokens.starts, tokens.ends, strict=True))
        self._texts = [source.text[start:end] for start, end in spans]
        self._starts = [start for start, _ in spans]
        self._gaps = list(_gaps(source, spans, tokens.comments))
        self._ends_line = list(accumulate((gap.ends_line for gap in self._gaps), initial=0))
        self._line_ends = [
            "\n" in source.text[end:start] for (_, end), (start, _) in pairwise(spans)
        ]
        self._comments_taken = False
        self.index = 0

    @property
    def start(self) -> int:
        """The character offset of the next word."""
        return self._starts[self.index]

    def next_is(self, *texts: str) -> bool:
        return self.index < len(self._texts) and self._texts[self.index] in texts

    @property
    def line_ends_behind(self) -> bool:
        """Whether the next word is the last one on its line."""
        return self._line_ends[self.index]

    def take(self) -> Doc:
        """The next word with its comments."""
        before = () if self._comments_taken else self._gaps[self.index].before
        text = self._texts[self.index]
        self._comments_taken = False
        self.index += 1
        behind = self._gaps[self.index].behind
        return [*before, text, *behind] if before or behind else text

    def until(self, end: int) -> list[Doc]:
        """All words that begin before the offset ``end``, with no blanks between them."""
        docs: list[Doc] = []
        while self.index < len(self._texts) and self.start < end:
            docs.append(self.take())
        return docs

    def comments(self, first: bool) -> list[Doc]:
        """The comments before the next word, each on its line; no empty line first if ``first``."""
        gap = self._gaps[self.index]
        docs: list[Doc] = []
        for remark, blank in zip(gap.before, gap.blank, strict=False):
            docs += [Line(hard=True, blank=blank and not first), remark]
            first = False
        self._comments_taken = True
        return docs

    def beginning(self, first: bool) -> list[Doc]:
        """The line end before a declaration, with the comments and empty lines before it."""
        gap = self._gaps[self.index]
        docs = self.comments(first)
        first = first and not gap.before
        return [*docs, Line(hard=True, blank=gap.blank[-1] and not first)]

    def group(self, begin: int, docs: Sequence[Doc], broken: bool = False) -> Group:
        """A group of the words from index ``begin`` on; a comment among them breaks it."""
        ends = self._ends_line[self.index] - self._ends_line[begin + 1] if begin < self.index else 0
        return Group(docs, broken or ends > 0)


def _gaps(source: Source, spans: list[tuple[int, int]], comments: Sequence[Comment]) -> list[_Gap]:
    """One gap before each word and one behind the last."""
    gaps: list[_Gap] = []
    text = source.text
    end = 0
    index = 0
    upcoming = comments[0].start if comments else len(text)
    for start, next_end in [*spans, (len(text), len(text))]:
        if start <= upcoming:
            gaps.append(_PLAIN[text.count("\n", end, start) > 1])
            end = next_end
            continue
        behind: list[Remark] = []
        before: list[Remark] = []
        blank: list[bool] = []
        while index < len(comments) and comments[index].start < start:
            comment = comments[index]
            white = text[end : comment.start]
            own_line = bool(before) or "\n" in white or not gaps
            remark = Remark(comment.text, own_line, source.position(comment.start)[1] - 1)
            if own_line:
                before.append(remark)
                blank.append(white.count("\n") > 1)
            else:
                behind.append(remark)
            end = comment.end
            index += 1
        blank.append(text.count("\n", end, start) > 1)
        gaps.append(_Gap(tuple(behind), tuple(before), tuple(blank)))
        end = next_end
        upcoming = comments[index].start if index < len(comments) else len(text)
    return gaps


WIDTH = 100
"""Columns of a line; longer ones are broken where the layout allows it."""

_HARD = Line(hard=True)
_LINE = Line()
_TIGHT = Line(flat="")

_INDEXED = ("component {name}", "?[{indexes}]")
_EFFECT = ("? | do {assignments}", "? | goto {goto}")
_CLAUSES = ("? | if {guard}", *_EFFECT)
_STATE = ("?{initial} ", "?{marked} ", "state {name}", "? if {when}")
_LAYOUTS: Mapping[type, tuple[str, ...]] = {
    nodes.FileNode: ("{kind} {name} {declarations}",),
    nodes.ComponentNode: (*_INDEXED, " {items}"),
    nodes.ImportNode: (*_INDEXED, " | from {library} import {component}", "? | with {given}"),
    nodes.ObjectNode: ("datatype object {name} {properties}",),
    nodes.PropertyNode: ("{name}: {type}",),
    nodes.EnumNode: ("datatype enum {name} from {source} to {rules}",),
    nodes.EnumRuleNode: ("{condition} | -> {value}",),
    nodes.InterfaceNode: ("interface {name} | use {type} | from {package}",),
    nodes.MessageNode: ("{direction} message {name} with > {attributes}", "? links {links}"),
    nodes.TransformNode: ("outgoing transform {name} with > {attributes}",),
    nodes.ServedServiceNode: ("outgoing service {name} with > {attributes}", "? links {links}"),
    nodes.ServedActionNode: ("outgoing action {name} with > {attributes}", "? links {links}"),
    nodes.ServiceNode: ("service {name} with > {attributes}", "? links {links}"),
    nodes.ActionNode: ("action {name} with > {attributes}", "? links {links}"),
    nodes.ConstantNode: ("constant {name}: {type} = | {value}",),
    nodes.ParameterNode: ("parameter {name}: {type}", "? = | {value}"),
    nodes.FunctionNode: ("function {name}{parameters}: {type} = | {value}",),
    nodes.ConditionNode: ("condition {name} = | {value}", "? | for {duration}"),
    nodes.BehaviourNode: ("behaviour {items}",),
    nodes.VariableNode: ("?{persistent} ", "variable {name}: {type}", "? | = {initial}"),
    nodes.StateNode: (*_STATE, " {items}"),
    nodes.ResultTransitionNode: ("on {events} from {communications}", *_CLAUSES),
    nodes.AfterNode: ("after {duration}", *_CLAUSES),
    nodes.TauNode: ("transition", *_CLAUSES),
    nodes.RetryNode: (
        "retry",
        "? {times} times",
        "? | every {every}",
        "? | goto {goto}",
        "?{finally_}",
    ),
    nodes.EffectNode: (" | else", *_EFFECT),
    nodes.AssignmentNode: ("{target} := {value}",),
    nodes.PreferNode: ("prefer", "? {title}", " {preferred} | over {over}"),
    nodes.RequirementsNode: ("requirement {title} {statements}",),
    nodes.StopNode: ("stop with {communication}",),
    nodes.ForNode: ("for {variable} in {indexes} {statements}",),
    nodes.UnaryNode: ("-{operand}",),
    nodes.DurationNode: ("{amount} {unit}",),
    nodes.RateNode: ("{hertz} Hz",),
    nodes.CallNode: ("{function}{arguments}",),
    nodes.InNode: ("{operand} in {values}",),
    nodes.ElementNode: ("{array}[{index}]",),
    nodes.SliceNode: ("{array}[{first}..{last}]",),
    nodes.ArrayNode: ("{elements}",),
}
"""The layout of each kind of node, in segments.

A word or sign is one token, whatever it is in the text, and ``{field}`` the tokens of a field of
the node. Blanks are printed; ``|`` is a possible line break. What follows it, or the blank ``>``,
is indented. A segment that begins with ``?`` is left out if its field is absent.
"""

_REQUIREMENTS = {
    "needs": ("{communications} | needs {condition}",),
    "disables": ("{condition} | disables {communications}",),
    "never": ("never {condition}",),
    "always": ("always {condition}",),
}
_ASSUMPTIONS = {
    "needs": ("assume", "? {title}", " {communication} | needs {condition}"),
    "never": ("assume", "? {title}", " never {condition}"),
    "always": ("assume", "? {title}", " always {condition}"),
}
_POSSIBLE = ("possible {condition}", "? | from {origin}", "? | while {along}")
_REQUIREMENT = ("requirement", "? {title}", " ")
_ELSE = ("on {events} from {communications}", " | else", *_EFFECT)
_PERFORMS = (" performs {communication}", "? {meanwhile}", "? with {data}")
_THEN = (" | then", "? do {assignments}", "? goto {goto}")
_DEFAULT_RULE = ("default | -> {value}",)
_OTHERWISE = (" | else with {data}", "? if {condition}")
_PROVIDE, _PROVIDE_IF = ("provide {communication} with {data}",), ("? | if {condition}",)

_PART = re.compile(r"\{(?P<field>\w+)\}|(?P<line> [|>] )|(?P<blank> )|(?P<token>[^ {]+)")
_BLOCKS = ("declarations", "items", "properties", "rules", "statements")


class Formatter:
    """Builds the document of each kind of node, taking the words of the text in order."""

    def __init__(self, tokens: Tokens) -> None:
        self.words = Words(tokens)
        self._forms: dict[str | None, Callable[[Any], Doc]] = {
            **dict.fromkeys(_BLOCKS, self._block),
            **dict.fromkeys(("given", "attributes"), self._labelled),
            **dict.fromkeys(("communications", "preferred", "over"), self._names),
            **dict.fromkeys(("arguments", "values", "elements", "parameters"), self._listed),
            **dict.fromkeys(("index", "first", "last"), self._tight),
            "assignments": self._assignments,
            "events": self._events,
        }

    def file(self, node: nodes.FileNode) -> Doc:
        """The document of the whole file."""
        head = self.words.beginning(first=True)
        body = self._filled(node, _LAYOUTS[nodes.FileNode])
        return [*head, *body, *self.words.comments(first=False)]

    # --- layouts ---

    def _filled(self, node: Any, layout: Sequence[str]) -> list[Doc]:
        """The document of a node in a layout."""
        docs: list[Doc] = []
        clauses: list[Doc] = []
        for part in _parts(node, layout):
            if part["line"]:
                clauses.append(_LINE if part["line"] == " | " else " ")
            else:
                (clauses if clauses else docs).append(self._part(node, part))
        return [*docs, Indent(clauses)] if clauses else docs

    def _part(self, node: Any, part: re.Match[str]) -> Doc:
        if part["blank"]:
            return " "
        name = part["field"]
        value = _field(node, name) if name else part["token"]
        if isinstance(value, str | int | float):
            return self.words.take()
        return self._forms.get(name, self._data)(value)

    def _declaration(self, node: Any) -> Doc:
        begin = self.words.index
        match node:
            case nodes.ProvideNode():
                docs = self._filled(node, _PROVIDE)
                begin = self.words.index
                clauses = self._filled(node, _PROVIDE_IF)
                for part in node.otherwise:
                    clauses += self._filled(part, _OTHERWISE)
                return [*docs, self.words.group(begin, clauses)]
            case nodes.AssumeNode(kind=kind):
                docs = self._filled(node, _ASSUMPTIONS[kind])
            case nodes.RequirementNode() | nodes.PossibleNode():
                layout = (
                    _POSSIBLE if isinstance(node, nodes.PossibleNode) else _REQUIREMENTS[node.kind]
                )
                end = (" | to start",) if getattr(node, "to_start", False) else ()
                first = _REQUIREMENT if self.words.next_is("requirement") else ()
                docs = self._filled(node, (*first, *layout, *end))
            case nodes.ResultTransitionNode(guard=nodes.ElseNode()):
                docs = self._filled(node, _ELSE)
            case nodes.EnumRuleNode(condition=None):
                docs = self._filled(node, _DEFAULT_RULE)
            case (
                nodes.ConstantNode(value=nodes.DataObjectNode())
                | nodes.FunctionNode(value=nodes.DataObjectNode())
                | nodes.ParameterNode(value=nodes.DataObjectNode())
            ):
                unbroken = (part.replace(" | ", " ") for part in _LAYOUTS[type(node)])
                docs = self._filled(node, tuple(unbroken))
            case nodes.StateNode(performs=nodes.PerformsNode() as performs):
                docs = [*self._filled(node, _STATE), *self._filled(performs, _PERFORMS)]
                begin = self.words.index
                docs.append(self.words.group(begin, self._filled(performs, _THEN)))
                if self.words.next_is("{"):
                    docs += [" ", self._block(node.items)]
            case _:
                docs = self._filled(node, _LAYOUTS[type(node)])
        has_block = any(hasattr(node, name) for name in _BLOCKS)
        return docs if has_block else self.words.group(begin, docs)

    def _block(self, listed: Sequence[Any]) -> Doc:
        """``{ … }`` with each node on lines of its own."""
        docs: list[Doc] = [self.words.take()]
        inside: list[Doc] = []
        for node in listed:
            inside += self.words.beginning(first=not inside)
            inside.append(self._declaration(node))
        inside += self.words.comments(first=not inside)
        if inside:
            docs += [Indent(inside), _HARD]
        return [*docs, self.words.take()]

    def _labelled(self, values: Sequence[nodes.DataNode]) -> Doc:
        """``label: value`` for each value, separated by commas."""
        docs: list[Doc] = []
        for value in values:
            docs += [self.words.take(), _LINE] if docs else []
            docs += [self.words.take(), self.words.take(), " ", self._data(value)]
        return docs

    def _assignments(self, listed: Sequence[nodes.AssignmentNode]) -> Doc:
        begin = self.words.index
        docs: list[Doc] = []
        for node in listed:
            docs += [self.words.take(), _LINE] if docs else []
            docs += self._filled(node, _LAYOUTS[nodes.AssignmentNode])
        return self.words.group(begin, [Indent(docs)])

    def _events(self, listed: Sequence[nodes.Name]) -> Doc:
        docs: list[Doc] = []
        for _ in listed:
            docs += [self.words.take(), " "] if docs else []
            docs.append(self.words.take())
        return docs

    def _names(self, listed: nodes.Group) -> Doc:
        """One communication, perhaps in parentheses, or several in braces, and what is left out."""
        match listed:
            case (*items, nodes.ExceptNode(communications=others)):
                group = self._names(tuple(items))
                return [group, " ", self.words.take(), " ", self._names(others)]
            case (nodes.Access() as only,) if not self.words.next_is("{"):
                return self._expression(only)
        begin = self.words.index
        docs: list[Doc] = [self.words.take()]
        inside: list[Doc] = []
        for node in listed:
            inside += [self.words.take()] if inside else []
            inside += [_LINE, *self.words.until(node.span.end)]
        return self.words.group(begin, [*docs, Indent(inside), _LINE, self.words.take()])

    # --- data and expressions ---

    def _data(self, node: nodes.DataNode) -> Doc:
        if not isinstance(node, nodes.DataObjectNode):
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

    def _expression(self, node: nodes.ExprNode) -> Doc:
        """The expression, with the parentheses that it has in the text; also a name or a type."""
        begin = self.words.index
        docs: list[Doc] = []
        while self.words.start < node.span.start:
            docs.append(self.words.take())
        count = len(docs)
        match node:
            case nodes.BinaryNode(operator=operator):
                inside: list[Doc] = []
                self._chain(node, operators.BINARY[operator].level, inside)
                docs.append(self.words.group(begin, inside if count else [Indent(inside)]))
            case nodes.AggregateNode():
                docs.append(self._aggregate(node))
            case nodes.MemberNode(object=inner):
                docs += [self._expression(inner), *self.words.until(node.span.end)]
            case _ if layout := _LAYOUTS.get(type(node)):
                docs += self._filled(node, layout)
            case _:
                docs += self.words.until(node.span.end)
        return [*docs, *(self.words.take() for _ in range(count))]

    def _chain(self, node: nodes.ExprNode, level: int, docs: list[Doc]) -> None:
        """Add the operands and operators of a chain of one level of precedence to ``docs``."""
        bare = self.words.start >= node.span.start
        if (
            bare
            and isinstance(node, nodes.BinaryNode)
            and operators.BINARY[node.operator].level == level
        ):
            self._chain(node.left, level, docs)
            docs += [_LINE, self.words.take(), " "]
            self._chain(node.right, level, docs)
        else:
            docs.append(self._expression(node))

    def _listed(self, listed: Sequence[nodes.DataNode]) -> Doc:
        """A list in brackets, separated by commas."""
        begin = self.words.index
        docs: list[Doc] = [self.words.take()]
        inside: list[Doc] = []
        for node in listed:
            inside += [self.words.take(), _LINE] if inside else [_TIGHT]
            inside.append(self._data(node))
        if inside:
            docs += [Indent(inside), _TIGHT]
        return self.words.group(begin, [*docs, self.words.take()])

    def _aggregate(self, node: nodes.AggregateNode) -> Doc:
        begin = self.words.index
        docs: list[Doc] = [self.words.take()]
        if node.function.text != "[":
            docs.append(self.words.take())
        inside = [_TIGHT, *self._filled(node, ("{element}",)), _LINE]
        names = "{position}, {variable}" if node.position else "{variable}"
        inside += self._filled(node, (f"for {names} in {{array}}",))
        if node.condition is not None:
            inside += [_LINE, *self._filled(node, ("if {condition}",))]
        return self.words.group(begin, [*docs, Indent(inside), _TIGHT, self.words.take()])

    def _tight(self, node: nodes.ExprNode) -> Doc:
        """An index, without blanks if it is arithmetic only."""
        simple = all(character not in node.span.text for character in ",{")
        return self.words.until(node.span.end) if simple else self._expression(node)


def _parts(node: Any, layout: Sequence[str]) -> Iterator[re.Match[str]]:
    """The parts of all segments of a layout that are not left out."""
    for segment in layout:
        parts = _split(segment.removeprefix("?"))
        optional = (
            next(part["field"] for part in parts if part["field"]) if segment[0] == "?" else ""
        )
        if not optional or _field(node, optional):
            yield from parts


@cache
def _split(segment: str) -> tuple[re.Match[str], ...]:
    return tuple(_PART.finditer(segment))


def _field(node: Any, name: str) -> Any:
    """A field of a node; ``attributes`` and ``given`` are the values behind its ``with``, in order.

    An attribute ``type`` that stands for several is there once.
    """
    if name not in ("attributes", "given"):
        return getattr(node, name)
    if isinstance(node, nodes.ImportNode):
        values = [*(argument.value for argument in node.arguments), node.prefix]
    else:
        values = [getattr(node, attribute.field, None) for attribute in attributes.ATTRIBUTES]
    by_place = {value.span.start: value for value in values if value is not None}
    # That of a transform is its keyword.
    by_place = {start: value for start, value in by_place.items() if start > node.name.span.start}
    return [by_place[start] for start in sorted(by_place)]


def format_text(source: Source) -> str:
    """The model in canonical layout.

    Raises:
        ModelError: it has syntax errors.
    """
    tree, diagnostics = parser.parse(source)
    if tree is None or has_errors(diagnostics):
        raise ModelError(diagnostics)
    return format_tree(tree)


def format_tree(tree: nodes.FileNode) -> str:
    """The model in canonical layout, given its tree, which was parsed without errors."""
    tokens = tokenize(tree.span.source)
    formatted = Source(tokens.source.path, print_doc(Formatter(tokens).file(tree), WIDTH))
    if formatted.text == tokens.source.text:
        return formatted.text
    again = tokenize(formatted)
    # Equal tokens are the cheap check and almost always hold; equal trees are what must hold.
    same = again.kinds == tokens.kinds and all(map(eq, again.texts(), tokens.texts()))
    assert same or parser.parse(formatted)[0] == tree, "formatting has changed the model"
    return formatted.text
