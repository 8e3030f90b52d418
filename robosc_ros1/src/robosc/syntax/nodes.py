"""The nodes of the syntax tree: immutable, each with its span in the text.

Names are stored without the escape ``^``. Spans are ignored by ``==``: two trees are equal if they
differ in layout and comments only.
"""

from __future__ import annotations

from dataclasses import field
from typing import Literal, TypeAlias

from robosc.language.events import Folder
from robosc.lazy_dataclasses import dataclass
from robosc.names import Copy
from robosc.source import Span


@dataclass(frozen=True, slots=True)
class _Node:
    """What all nodes have: the range of the text that they stand for."""

    span: Span = field(compare=False, repr=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Name(_Node):
    """An identifier, without the escape ``^``."""

    text: str

    @property
    def escaped(self) -> bool:
        """Whether it was written with ``^``: a variable ``value`` is not the keyword."""
        return self.span.text.startswith("^")


# --- expressions ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class LiteralNode(_Node):
    """``true``, ``42``, ``4.25`` or ``"text"``; a bool, int, float or str accordingly."""

    value: bool | int | float | str

    def __eq__(self, other: object) -> bool:
        # Python's == equates 1, 1.0 and True.
        return (
            isinstance(other, LiteralNode)
            and type(self.value) is type(other.value)
            and self.value == other.value
        )

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))


@dataclass(frozen=True, slots=True)
class Access(_Node):
    """``a.b[0].c``: a name (``value`` included), then members as Name and indexes as int.

    ``index`` is the computed index behind the root of a communication, as in ``Station[i-1].go``;
    none is left once indexed components are expanded. A literal index is part of the path.
    """

    root: Name
    path: tuple[Name | int, ...]
    index: ExprNode | None = None


@dataclass(frozen=True, slots=True)
class UnaryNode(_Node):
    """``!operand`` or ``-operand``."""

    operator: Literal["!", "-"]
    operand: ExprNode


@dataclass(frozen=True, slots=True)
class BinaryNode(_Node):
    """``left operator right``, an operator of :data:`robosc.language.operators.BINARY`."""

    operator: str
    left: ExprNode
    right: ExprNode
    operator_span: Span = field(compare=False, repr=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class DurationNode(_Node):
    """``0.5 s``: a number with a unit of time."""

    amount: int | float
    unit: str


@dataclass(frozen=True, slots=True)
class CallNode(_Node):
    """``abs(x)``, ``Way(value.x)`` or ``Library.Way(value.x)``."""

    function: Access
    arguments: tuple[ExprNode, ...]


@dataclass(frozen=True, slots=True)
class AggregateNode(_Node):
    """``any(element for variable in array if condition)``, and ``function`` for ``any``.

    The function of ``[element for variable in array]`` is written ``[``. ``position`` is the name
    before that of the element: ``for position, variable in array``. In provided data an array can
    be made of objects.
    """

    function: Name
    element: DataNode
    variable: Name
    array: ExprNode
    condition: ExprNode | None
    position: Name | None = None


@dataclass(frozen=True, slots=True)
class InNode(_Node):
    """``operand in { a, b }``."""

    operand: ExprNode
    values: tuple[ExprNode, ...]


@dataclass(frozen=True, slots=True)
class ElementNode(_Node):
    """``array[index]`` with a computed index."""

    array: ExprNode
    index: ExprNode


@dataclass(frozen=True, slots=True)
class SliceNode(_Node):
    """``array[first..last]``, both ends included."""

    array: ExprNode
    first: ExprNode
    last: ExprNode


@dataclass(frozen=True, slots=True)
class MemberNode(_Node):
    """A part of a computed object: ``a[i].x`` is the part ``x`` of the element ``a[i]``."""

    object: ExprNode
    path: tuple[Name | int, ...]


@dataclass(frozen=True, slots=True)
class ArrayNode(_Node):
    """``[a, b]``; in provided data the elements may be objects."""

    elements: tuple[DataNode, ...]


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
class BasicTypeNode(_Node):
    """``string``, ``boolean``, ``double``, ``none`` or ``integer``; bounds only for the last, and
    for the ``double`` of a parameter."""

    name: Literal["string", "boolean", "double", "none", "integer"]
    bounds: tuple[int, int] | tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class ArrayTypeNode(_Node):
    """``array(element)``."""

    element: TypeNode


@dataclass(frozen=True, slots=True)
class NamedTypeNode(_Node):
    """A type or interface by name, perhaps of a library: ``Way``, ``Library.Way``, ``duration``."""

    name: Name
    library: Name | None = None


@dataclass(frozen=True, slots=True)
class RosTypeNode(_Node):
    """``package/Type`` or ``package/msg/Type``: a type that a ROS package defines.

    ``folder`` is ``msg``, but ``srv`` or ``action`` behind ``type:`` of a service or action, where
    ``part`` selects the request (0), response (1) or feedback (2) of the definition. ``written`` is
    the middle one of three names, if the user wrote it.
    """

    package: Name
    type: Name
    written: Name | None = None
    folder: Folder = "msg"
    part: int = 0


TypeNode: TypeAlias = BasicTypeNode | ArrayTypeNode | NamedTypeNode | RosTypeNode


# --- data types and interfaces -------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PropertyNode(_Node):
    """``name: type`` in an object."""

    name: Name
    type: TypeNode


@dataclass(frozen=True, slots=True)
class ObjectNode(_Node):
    """``datatype object name { … }``."""

    name: Name
    properties: tuple[PropertyNode, ...]


@dataclass(frozen=True, slots=True)
class EnumRuleNode(_Node):
    """``condition -> value``; the ``default`` rule has no condition."""

    condition: ExprNode | None
    value: Name


@dataclass(frozen=True, slots=True)
class EnumNode(_Node):
    """``datatype enum name from source to { … }``."""

    name: Name
    source: TypeNode
    rules: tuple[EnumRuleNode, ...]


@dataclass(frozen=True, slots=True)
class InterfaceNode(_Node):
    """``interface name use type from package``."""

    name: Name
    type: Name
    package: Name


@dataclass(frozen=True, slots=True)
class RateNode(_Node):
    """``20 Hz``: how often a command is sent."""

    hertz: int | float


# --- communications ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class StringNode(_Node):
    """The string of an ``identifier:`` or ``prefix:``, or a title, escapes replaced."""

    text: str


@dataclass(frozen=True, slots=True)
class MessageNode(_Node):
    """``incoming message name with …`` or ``outgoing message name with …``."""

    direction: Literal["incoming", "outgoing"]
    name: Name
    identifier: StringNode | None
    type: TypeNode
    links: NamedTypeNode | None
    timeout: ExprNode | None = None
    rate: RateNode | Name | None = None
    max_age: ExprNode | None = None
    stop: Name | None = None


@dataclass(frozen=True, slots=True)
class TransformNode(MessageNode):
    """``outgoing transform name with from: source, to: target``; its type is that of transforms."""

    source: StringNode | None = None
    target: StringNode | None = None


@dataclass(frozen=True, slots=True)
class ServiceNode(_Node):
    """``service name with …``; written with ``type:``, the two types are its parts 0 and 1."""

    name: Name
    identifier: StringNode | None
    request: TypeNode
    response: TypeNode
    links: NamedTypeNode | None
    timeout: ExprNode | None = None
    expect: ExprNode | None = None
    rate: RateNode | Name | None = None


@dataclass(frozen=True, slots=True)
class ServedServiceNode(ServiceNode):
    """``outgoing service name with …``: the component calls it, the controller serves it."""


@dataclass(frozen=True, slots=True)
class ActionNode(_Node):
    """``action name with …``; written with ``type:``, the three types are its parts."""

    name: Name
    identifier: StringNode | None
    request: TypeNode
    response: TypeNode
    feedback: TypeNode
    links: NamedTypeNode | None
    timeout: ExprNode | None = None
    within: ExprNode | None = None
    expect: ExprNode | None = None
    rate: RateNode | Name | None = None
    goals: Name | None = None


@dataclass(frozen=True, slots=True)
class ServedActionNode(ActionNode):
    """``outgoing action name with …``: the component calls it, the controller serves it."""


CommunicationNode: TypeAlias = MessageNode | ServiceNode | ActionNode


# --- names for values ---------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ConstantNode(_Node):
    """``constant name: type = value``."""

    name: Name
    type: TypeNode
    value: DataNode


@dataclass(frozen=True, slots=True)
class ParameterNode(_Node):
    """``parameter name: type = value``; without a value, it must be given when the node starts."""

    name: Name
    type: TypeNode
    value: DataNode | None


@dataclass(frozen=True, slots=True)
class ConditionNode(_Node):
    """``condition name = value``, or ``condition name = value for duration``."""

    name: Name
    value: ExprNode
    duration: ExprNode | None = None


@dataclass(frozen=True, slots=True)
class FunctionNode(_Node):
    """``function name(argument: type, …): type = value``; the value may be an object."""

    name: Name
    parameters: tuple[PropertyNode, ...]
    type: TypeNode
    value: DataNode


ValueNode: TypeAlias = ConstantNode | ParameterNode | ConditionNode

# --- behaviour -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class VariableNode(_Node):
    """``variable name: type = initial``, perhaps with ``persistent`` before it."""

    persistent: bool
    name: Name
    type: TypeNode
    initial: ExprNode | None


@dataclass(frozen=True, slots=True)
class AssignmentNode(_Node):
    """``target := value``."""

    target: Access
    value: ExprNode


@dataclass(frozen=True, slots=True)
class ElseNode(_Node):
    """``else`` in the place of a guard."""


@dataclass(frozen=True, slots=True)
class ResultTransitionNode(_Node):
    """``on EVENT, … from|to COMMUNICATION if … do … goto …``; names may be qualified.

    It stands for one transition of each event of each communication that has it.
    """

    events: tuple[Name, ...]
    communications: Group
    guard: ExprNode | ElseNode | None
    assignments: tuple[AssignmentNode, ...]
    goto: Name | Access | None


@dataclass(frozen=True, slots=True)
class TauNode(_Node):
    """``transition if … do … goto …``: an internal transition."""

    guard: ExprNode | ElseNode | None
    assignments: tuple[AssignmentNode, ...]
    goto: Name | Access | None


@dataclass(frozen=True, slots=True)
class AfterNode(_Node):
    """``after DURATION if … do … goto …``."""

    duration: ExprNode
    guard: ExprNode | None
    assignments: tuple[AssignmentNode, ...]
    goto: Name | Access | None


@dataclass(frozen=True, slots=True)
class PerformsNode(_Node):
    """``performs communication meanwhile with data then do … goto …``.

    ``meanwhile`` is that word where it stands.
    """

    communication: Access
    meanwhile: Name | None
    data: DataNode | None
    assignments: tuple[AssignmentNode, ...]
    goto: Name | Access | None


@dataclass(frozen=True, slots=True)
class EffectNode(_Node):
    """``do … goto …``."""

    assignments: tuple[AssignmentNode, ...]
    goto: Name | Access | None


@dataclass(frozen=True, slots=True)
class RetryNode(_Node):
    """``retry 2 times every 5 s goto … else do … goto …``; ``finally_`` stands behind ``else``."""

    times: LiteralNode | None
    every: ExprNode | None
    goto: Name | Access | None
    finally_: EffectNode | None


@dataclass(frozen=True, slots=True)
class StateNode(_Node):
    """``initial marked state name { … }``; one that performs a command needs no braces.

    ``when`` is the condition of ``initial state name if index = 1``; what it says is in ``initial``
    once the model is resolved.
    """

    name: Name
    initial: bool
    marked: bool
    items: tuple[ResultTransitionNode | TauNode | AfterNode | RetryNode | StateNode, ...]
    performs: PerformsNode | None = None
    when: ExprNode | None = None

    @property
    def states(self) -> tuple[StateNode, ...]:
        """The states that stand in it."""
        return tuple(item for item in self.items if isinstance(item, StateNode))


@dataclass(frozen=True, slots=True)
class BehaviourNode(_Node):
    """``behaviour { … }``; items in source order, which numbers the internal transitions."""

    items: tuple[VariableNode | StateNode | ResultTransitionNode | TauNode, ...]


@dataclass(frozen=True, slots=True)
class RangeNode(_Node):
    """``first..last``, both ends included."""

    first: int
    last: int


@dataclass(frozen=True, slots=True)
class ComponentNode(_Node):
    """``component name { … }``, or the indexed component ``component name[1..6] { … }``.

    ``copy`` says which copy it is, once indexed components are expanded.
    """

    name: Name
    items: tuple[
        CommunicationNode
        | BehaviourNode
        | ValueNode
        | FunctionNode
        | RequirementNode
        | PossibleNode
        | RequirementsNode
        | ProvideNode
        | PreferNode,
        ...,
    ]
    indexes: RangeNode | None = None
    copy: Copy | None = None


@dataclass(frozen=True, slots=True)
class ArgumentNode(_Node):
    """``name: value`` behind the ``with`` of an import."""

    name: Name
    value: ExprNode


@dataclass(frozen=True, slots=True)
class ImportNode(_Node):
    """``component name from library import component with prefix: "…", radius: 0.2``.

    ``copy`` is as in :class:`ComponentNode`.
    """

    name: Name
    library: Name
    component: Name
    prefix: StringNode | None
    arguments: tuple[ArgumentNode, ...] = ()
    indexes: RangeNode | None = None
    copy: Copy | None = None


# --- requirements and data -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ExceptNode(_Node):
    """``except a``: what is left out of the group before it."""

    communications: Group


Group: TypeAlias = tuple[Access | ExceptNode, ...]
"""``a``, ``{ a, b }``, ``all`` or a component, and perhaps, at the end, what is left out."""


@dataclass(frozen=True, slots=True)
class Repeated:
    """Which copy of a statement this is: the values of the variables of the ``for`` around it (of
    ``index`` in an indexed component).

    ``block`` is the innermost of what was copied.
    """

    values: tuple[tuple[str, int], ...]
    block: Span = field(compare=False, repr=False)

    def __str__(self) -> str:
        return ", ".join(f"{name} = {value}" for name, value in self.values)


@dataclass(frozen=True, slots=True)
class RequirementNode(_Node):
    """``c needs e``, ``e disables c``, ``never e`` or ``always e`` (no communications).

    ``to_start``: it ends with ``to start``. ``repeated`` says which copy of a statement it is.
    ``title`` is the string behind ``requirement``, or that of the group around it.
    """

    kind: Literal["needs", "disables", "never", "always"]
    communications: Group
    condition: ExprNode
    to_start: bool = False
    title: StringNode | None = None
    repeated: Repeated | None = None


@dataclass(frozen=True, slots=True)
class PossibleNode(_Node):
    """``requirement possible e from f while g``; ``origin`` is f and ``along`` is g.

    ``title`` and ``repeated`` are as in :class:`RequirementNode`.
    """

    condition: ExprNode
    origin: ExprNode | None
    along: ExprNode | None
    title: StringNode | None = None
    repeated: Repeated | None = None


@dataclass(frozen=True, slots=True)
class RequirementsNode(_Node):
    """``requirement "…" { … }``: requirements without the word, which have the title in common."""

    title: StringNode
    statements: tuple[RequirementNode | PossibleNode, ...]


@dataclass(frozen=True, slots=True)
class AssumeNode(_Node):
    """``assume c needs e``, ``assume always e`` or ``assume never e`` (no communication).

    ``title`` and ``repeated`` are as in :class:`RequirementNode`.
    """

    kind: Literal["needs", "never", "always"]
    communication: Access | None
    condition: ExprNode
    title: StringNode | None = None
    repeated: Repeated | None = None


@dataclass(frozen=True, slots=True)
class DataFieldNode(_Node):
    """``name: value`` in provided data."""

    name: Name
    value: DataNode


@dataclass(frozen=True, slots=True)
class DataObjectNode(_Node):
    """``{ name: value, … }`` in provided data."""

    fields: tuple[DataFieldNode, ...]


DataNode: TypeAlias = DataObjectNode | ExprNode


@dataclass(frozen=True, slots=True)
class OtherwiseNode(_Node):
    """``else with data if condition`` of a provide statement."""

    data: DataNode
    condition: ExprNode | None


@dataclass(frozen=True, slots=True)
class ProvideNode(_Node):
    """``provide communication with data if condition``, and what is sent ``otherwise``."""

    communication: Access
    data: DataNode
    condition: ExprNode | None
    otherwise: tuple[OtherwiseNode, ...] = ()


@dataclass(frozen=True, slots=True)
class PreferNode(_Node):
    """``prefer a over b`` or ``prefer { a, b } over c``."""

    preferred: Group
    over: Group
    title: StringNode | None = None


@dataclass(frozen=True, slots=True)
class StopNode(_Node):
    """``stop with communication``, or ``stop with nothing``."""

    communication: Access


@dataclass(frozen=True, slots=True)
class ForNode(_Node):
    """``for variable in 1..6 { … }`` around statements of a robot."""

    variable: Name
    indexes: RangeNode
    statements: tuple[StatementNode, ...]


StatementNode: TypeAlias = (
    RequirementNode
    | PossibleNode
    | RequirementsNode
    | AssumeNode
    | ProvideNode
    | PreferNode
    | StopNode
    | ConditionNode
    | ForNode
)
DeclarationNode: TypeAlias = (
    ComponentNode
    | ImportNode
    | StatementNode
    | ConstantNode
    | ParameterNode
    | FunctionNode
    | ObjectNode
    | EnumNode
    | InterfaceNode
)


@dataclass(frozen=True, slots=True)
class FileNode(_Node):
    """A whole file: one robot or one library, its declarations in source order.

    ``broken`` holds every word in the declarations that were skipped for syntax errors: a name that
    is unknown but among them was probably declared there, so it is not reported as unknown.
    ``written`` is the file as it was parsed, if indexed components and statements are expanded in
    this one; ``mentions`` are names of components that the expansion has removed.
    """

    kind: Literal["robot", "library"]
    name: Name
    declarations: tuple[DeclarationNode, ...]
    broken: frozenset[str] = field(default=frozenset(), compare=False, repr=False)
    written: FileNode | None = field(default=None, compare=False, repr=False)
    mentions: tuple[Name, ...] = field(default=(), compare=False, repr=False)
