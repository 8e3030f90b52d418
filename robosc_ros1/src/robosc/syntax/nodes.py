"""The syntax tree: what the user wrote, frozen, each node with its span.

Names are plain strings without the ``^`` escape. Spans take no part in equality, so two trees are
equal when they say the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from robosc.source import Span

__all__ = [
    "Access", "ActionNode", "AfterNode", "AggregateNode", "ArgumentNode", "ArrayNode",
    "ArrayTypeNode", "AssignmentNode", "BasicTypeNode", "BehaviourNode", "BinaryNode", "CallNode",
    "CommunicationNode", "ComponentNode", "ConditionNode", "ConstantNode", "DataFieldNode",
    "DataNode", "DataObjectNode", "DeclarationNode", "DurationNode", "ElementNode", "EnumNode",
    "EnumRuleNode", "ExprNode", "FileNode", "ForNode", "ImportNode", "InNode", "InterfaceNode",
    "LiteralNode", "MemberNode", "MessageNode", "Name", "NamedTypeNode", "ObjectNode",
    "ParameterNode", "PreferNode", "PropertyNode", "ProvideNode", "RangeNode", "RequirementNode",
    "ResultTransitionNode", "RosTypeNode", "ServiceNode", "SliceNode", "StatementNode",
    "StateNode", "StringNode", "TauNode", "TypeNode", "UnaryNode", "ValueNode", "VariableNode",
]  # fmt: skip


def _span() -> Span:
    return field(compare=False, repr=False, kw_only=True)  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True)
class Name:
    """An identifier at its place (without the escape ``^``)."""

    text: str
    span: Span = _span()

    @property
    def escaped(self) -> bool:
        """Was it written with ``^``? Tells a variable called ``value`` from the keyword."""
        return self.span.text.startswith("^")


# --- expressions ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class LiteralNode:
    """``true``, ``42``, ``4.25`` or ``"text"``; int, float, bool or str by how it was written."""

    value: bool | int | float | str
    span: Span = _span()

    def __eq__(self, other: object) -> bool:
        # 1, 1.0 and True are three literals, not one.
        return (
            isinstance(other, LiteralNode)
            and type(self.value) is type(other.value)
            and self.value == other.value
        )

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))


@dataclass(frozen=True, slots=True)
class Access:
    """``a.b[0].c``: a name (``value`` included), then members as Name and indexes as int.

    ``index`` stands behind the root of a communication, as in ``Station[i-1].go``, until the
    copies of a component are made; a literal index is part of the path.
    """

    root: Name
    path: tuple[Name | int, ...]
    index: ExprNode | None = None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class UnaryNode:
    operator: Literal["!", "-"]
    operand: ExprNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class BinaryNode:
    """``operator`` is one of the table ``BINARY`` of robosc.language.operators."""

    operator: str
    left: ExprNode
    right: ExprNode
    operator_span: Span = _span()
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class DurationNode:
    """``0.5 s``: a number with a unit of time."""

    amount: int | float
    unit: str
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class CallNode:
    """``abs(x)``, ``Way(value.x)`` or ``Library.Way(value.x)``."""

    function: Access
    arguments: tuple[ExprNode, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class AggregateNode:
    """``any(element for variable in array if condition)``; ``function`` is the word before it."""

    function: Name
    element: ExprNode
    variable: Name
    array: ExprNode
    condition: ExprNode | None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class InNode:
    """``operand in { a, b }``."""

    operand: ExprNode
    values: tuple[ExprNode, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ElementNode:
    """``array[index]`` with an index that is no literal."""

    array: ExprNode
    index: ExprNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class SliceNode:
    """``array[first..last]``, both ends included."""

    array: ExprNode
    first: ExprNode
    last: ExprNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class MemberNode:
    """A part of what is no plain name: ``a[i].x`` is the part ``x`` of the element ``a[i]``."""

    object: ExprNode
    path: tuple[Name | int, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ArrayNode:
    """``[a, b]``; in provided data the elements may be objects."""

    elements: tuple[DataNode, ...]
    span: Span = _span()


ExprNode: TypeAlias = (
    LiteralNode
    | Access
    | UnaryNode
    | BinaryNode
    | DurationNode
    | CallNode
    | AggregateNode
    | InNode
    | ElementNode
    | SliceNode
    | MemberNode
    | ArrayNode
)


# --- types ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class BasicTypeNode:
    """``string``, ``boolean``, ``double``, ``none`` or ``integer``; bounds only for the last."""

    name: Literal["string", "boolean", "double", "none", "integer"]
    bounds: tuple[int, int] | None = None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ArrayTypeNode:
    element: TypeNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class NamedTypeNode:
    """A type by its name, or by that of its library: ``Library.Way``. ``duration`` is one, too."""

    name: Name
    library: Name | None = None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class RosTypeNode:
    """``package/Type`` or ``package/msg/Type``: a type that ROS itself defines.

    ``folder`` is ``msg``, or ``srv`` or ``action`` behind ``type:`` of a service or action, whose
    requests, responses and feedbacks are its parts 0, 1 and 2. ``written`` is the middle of the
    three words.
    """

    package: Name
    type: Name
    written: Name | None = None
    folder: Literal["msg", "srv", "action"] = "msg"
    part: int = 0
    span: Span = _span()


TypeNode: TypeAlias = BasicTypeNode | ArrayTypeNode | NamedTypeNode | RosTypeNode


# --- data types and interfaces -------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PropertyNode:
    name: Name
    type: TypeNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ObjectNode:
    name: Name
    properties: tuple[PropertyNode, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class EnumRuleNode:
    """``condition -> value``; the ``default`` rule has no condition."""

    condition: ExprNode | None
    value: Name
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class EnumNode:
    name: Name
    source: TypeNode
    rules: tuple[EnumRuleNode, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class InterfaceNode:
    """``interface name use type from package``."""

    name: Name
    type: Name
    package: Name
    span: Span = _span()


# --- communications ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class StringNode:
    text: str
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class MessageNode:
    direction: Literal["incoming", "outgoing"]
    name: Name
    identifier: StringNode | None
    type: TypeNode
    links: Name | None
    timeout: ExprNode | None = None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ServiceNode:
    """With ``type:`` instead of request and response, these are parts of that RosTypeNode."""

    name: Name
    identifier: StringNode | None
    request: TypeNode
    response: TypeNode
    links: Name | None
    timeout: ExprNode | None = None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ActionNode:
    """With ``type:`` instead of the three types, these are the parts of that RosTypeNode."""

    name: Name
    identifier: StringNode | None
    request: TypeNode
    response: TypeNode
    feedback: TypeNode
    links: Name | None
    timeout: ExprNode | None = None
    span: Span = _span()


CommunicationNode: TypeAlias = MessageNode | ServiceNode | ActionNode


# --- names for values ---------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ConstantNode:
    """``constant name: type = value``."""

    name: Name
    type: TypeNode
    value: DataNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ParameterNode:
    """``parameter name: type = value``."""

    name: Name
    type: TypeNode
    value: ExprNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ConditionNode:
    """``condition name = value``."""

    name: Name
    value: ExprNode
    span: Span = _span()


ValueNode: TypeAlias = ConstantNode | ParameterNode | ConditionNode

# --- behaviour -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class VariableNode:
    name: Name
    type: TypeNode
    initial: ExprNode | None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class AssignmentNode:
    target: Access
    value: ExprNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ResultTransitionNode:
    """``on <event> from|to <communication> if … do … goto …``; the name may be qualified."""

    event: Literal["request", "response", "feedback", "error", "cancel", "timeout"]
    event_span: Span = field(compare=False, repr=False)
    communication: Access
    guard: ExprNode | None
    assignments: tuple[AssignmentNode, ...]
    goto: Name | None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class TauNode:
    """``transition if … goto …``."""

    guard: ExprNode | None
    goto: Name | None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class AfterNode:
    """``after <duration> if … do … goto …``."""

    duration: ExprNode
    guard: ExprNode | None
    assignments: tuple[AssignmentNode, ...]
    goto: Name | None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class StateNode:
    name: Name
    initial: bool
    marked: bool
    transitions: tuple[ResultTransitionNode | TauNode | AfterNode, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class BehaviourNode:
    """Items in source order: the order of taus matters."""

    items: tuple[VariableNode | StateNode | ResultTransitionNode | TauNode, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class RangeNode:
    """``first..last``, both ends included."""

    first: int
    last: int
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ComponentNode:
    """``component name { … }``, or ``component name[1..6] { … }`` for several of a kind.

    ``index`` is that of a copy, once the copies are written out.
    """

    name: Name
    items: tuple[CommunicationNode | BehaviourNode | ValueNode, ...]
    indexes: RangeNode | None = None
    index: int | None = None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ArgumentNode:
    """``name: value`` behind the ``with`` of an import."""

    name: Name
    value: ExprNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ImportNode:
    """``component name from library import component with prefix: "…", radius: 0.2``."""

    name: Name
    library: Name
    component: Name
    prefix: StringNode | None
    arguments: tuple[ArgumentNode, ...] = ()
    indexes: RangeNode | None = None
    span: Span = _span()


# --- requirements and data -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class RequirementNode:
    """``c needs e``, ``e disables c``, ``never e`` or ``always e`` (no communications).

    ``place`` are the indexes of a copy that a ``for`` makes.
    """

    kind: Literal["needs", "disables", "never", "always"]
    communications: tuple[Access, ...]
    condition: ExprNode
    place: str = ""
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class DataFieldNode:
    name: Name
    value: DataNode
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class DataObjectNode:
    fields: tuple[DataFieldNode, ...]
    span: Span = _span()


DataNode: TypeAlias = DataObjectNode | ExprNode


@dataclass(frozen=True, slots=True)
class ProvideNode:
    communication: Access
    data: DataNode
    condition: ExprNode | None
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class PreferNode:
    """``prefer a over b``, ``prefer { a, b } over c``."""

    preferred: tuple[Access, ...]
    over: tuple[Access, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class ForNode:
    """``for name in 1..6 { … }`` around statements of a robot."""

    variable: Name
    indexes: RangeNode
    statements: tuple[StatementNode, ...]
    span: Span = _span()


StatementNode: TypeAlias = RequirementNode | ProvideNode | PreferNode | ConditionNode | ForNode
DeclarationNode: TypeAlias = (
    ComponentNode
    | ImportNode
    | StatementNode
    | ConstantNode
    | ParameterNode
    | ObjectNode
    | EnumNode
    | InterfaceNode
)


@dataclass(frozen=True, slots=True)
class FileNode:
    """A whole file: one robot or one library, its declarations in source order.

    ``broken`` holds every word in the declarations that were skipped for their faults: a name that
    is unknown but among them was probably declared there, and calling it unknown would be noise.
    ``written`` is the file as it was written, where in this one the copies of components and
    statements are written out; ``mentions`` are names of components that this has left out.
    """

    kind: Literal["robot", "library"]
    name: Name
    declarations: tuple[DeclarationNode, ...]
    broken: frozenset[str] = field(default=frozenset(), compare=False, repr=False)
    written: FileNode | None = field(default=None, compare=False, repr=False)
    mentions: tuple[Name, ...] = field(default=(), compare=False, repr=False)
    span: Span = _span()
