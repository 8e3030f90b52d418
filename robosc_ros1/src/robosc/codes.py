"""The registry of diagnostics: what each code means, by example, and how to mend it.

``docs/diagnostics.md`` is :func:`page`, written by ``./dev renew``. Codes are
stable: one is never given to another fault, and a test holds that each has a faulty model with its
output.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from robosc.errors import Severity

__all__ = ["CODES", "Code", "page"]


@dataclass(frozen=True, slots=True)
class Code:
    """One kind of fault.

    ``strict``: ``--strict`` makes the warning an error. ``needs_plant``: it is found on the
    synthesised system, not in the text. ``supervised``: it is found when a supervisor is generated
    that guards another controller.
    """

    code: str
    severity: Severity
    group: str
    explanation: str
    example: str
    remedy: str
    strict: bool = False
    needs_plant: bool = False
    supervised: bool = False


_TEXT = "Reading the text"
_NAMES = "Names"
_TYPES = "Types and data types"
_COMMUNICATION = "Communications"
_BEHAVIOUR = "Behaviour"
_STATEMENTS = "Requirements and data"
_LIBRARIES = "Libraries"
_ROS = "ROS interfaces"
_WHOLE = "The model as a whole"
_CONTROLLED = "The controlled system"
_SUPERVISOR = "Supervisors that guard another controller (`generate --mode supervisor`)"
_GROUPS = (
    _TEXT, _NAMES, _TYPES, _COMMUNICATION, _BEHAVIOUR, _STATEMENTS, _LIBRARIES, _ROS, _WHOLE,
    _CONTROLLED, _SUPERVISOR,
)  # fmt: skip


def _error(group: str, code: str, explanation: str, example: str, remedy: str) -> Code:
    return Code(code, Severity.ERROR, group, explanation, example, remedy)


def _warning(
    group: str,
    code: str,
    explanation: str,
    example: str,
    remedy: str,
    *,
    strict: bool = False,
) -> Code:
    return Code(code, Severity.WARNING, group, explanation, example, remedy, strict)


def _plant(severity: Severity, code: str, explanation: str, example: str, remedy: str) -> Code:
    return Code(code, severity, _CONTROLLED, explanation, example, remedy, needs_plant=True)


def _supervisor(code: str, explanation: str, example: str, remedy: str) -> Code:
    error = Severity.ERROR
    return Code(code, error, _SUPERVISOR, explanation, example, remedy, supervised=True)


_ALL = (
    # --- reading the text
    _error(
        _TEXT,
        "syntax",
        "The text does not follow the grammar at this place. The message says what is expected"
        " here. Reading continues at the next declaration.",
        "outgoing message distance with double",
        "Write what is expected, here `type: double`.",
    ),
    _error(
        _TEXT,
        "misplaced",
        "This declaration is not allowed inside the one that contains it.",
        "component Motor { datatype object Twist {} }",
        "Move it to the place that the message names.",
    ),
    _error(
        _TEXT,
        "missing-brace",
        "A block is not closed before something begins that cannot be part of it, or before the"
        " file ends.",
        "component Motor { behaviour {\ncomponent Light {}",
        "Add the closing brace.",
    ),
    _error(
        _TEXT,
        "unexpected-brace",
        "A closing brace has no opening one, or something follows the brace that ends its block.",
        "robot R { } }",
        "Remove the extra brace.",
    ),
    _error(
        _TEXT,
        "several-robots",
        "A file holds one robot or one library, never two.",
        "robot A {} robot B {}",
        "Move the second one to a file of its own.",
    ),
    _error(
        _TEXT,
        "reserved-name",
        "`value`, `true`, `false`, `and` and `or` have a meaning everywhere, so as names they need"
        " the escape `^`.",
        "variable value: integer",
        "Write `^value`.",
    ),
    _error(
        _TEXT,
        "bad-character",
        "This character has no meaning in the language.",
        "transition if a & b",
        "Write what the hint suggests, here `and`.",
    ),
    _error(
        _TEXT,
        "bad-escape",
        "A string may contain only the escapes `\\n`, `\\t`, `\\\\`, `\\\"` and `\\'`.",
        'message m with identifier: "a\\d", type: none',
        "Write the backslash twice, or remove it.",
    ),
    _error(
        _TEXT,
        "bad-number",
        "Numbers are written `42`, `4.25`, `1e-3`.",
        "variable x: double = 4.",
        "Write a digit on both sides of the point.",
    ),
    _error(
        _TEXT,
        "number-too-large",
        "The number has more digits than any ROS field or computation can carry.",
        "variable x: double = 1e999",
        "Use a smaller number.",
    ),
    _error(
        _TEXT,
        "unterminated-string",
        "The string does not end on the line on which it begins.",
        'identifier: "/vel',
        "Add the closing quote.",
    ),
    _error(
        _TEXT,
        "unterminated-comment",
        "A comment that begins with `/*` never ends, so the rest of the file is a comment.",
        "/* the motor",
        "Add `*/`.",
    ),
    _error(
        _TEXT,
        "too-deep",
        "Parentheses, types or data are nested deeper than any model needs.",
        "requirement move needs ((((((…",
        "Split it.",
    ),
    _error(
        _TEXT,
        "too-many-errors",
        "There are more errors than anyone would read; the rest is not shown.",
        "(a file that is not a model)",
        "Fix the first ones, and check again.",
    ),
    _error(
        _TEXT,
        "invalid-utf8",
        "Model files are UTF-8 text, and this one has other bytes in it.",
        "(a file saved as Latin-1 or UTF-16)",
        "Save the file as UTF-8.",
    ),
    # --- names
    _error(
        _NAMES,
        "unknown-name",
        "Nothing visible here has this name: no variable or state of this component, no enum value,"
        " no component.",
        "requirement move needs ObstacleGraber.idle",
        "Correct the spelling, or write `Component.name` for what belongs to another component.",
    ),
    _error(
        _NAMES,
        "unknown-member",
        "The component, enum or object before the point has no such member.",
        "requirement move needs LineDetector.current",
        "Use one of the members that the hint names.",
    ),
    _error(
        _NAMES,
        "unknown-communication",
        "No component of the robot has a communication of this name.",
        "on response from distanc",
        "Correct the spelling, or declare the communication.",
    ),
    _error(
        _NAMES,
        "unknown-type",
        "There is no datatype of this name in the file.",
        "variable current: Distence",
        "Correct the spelling, or declare the datatype. A robot does not see a library's"
        " datatypes.",
    ),
    _error(
        _NAMES,
        "unknown-interface",
        "There is no interface of this name in the file.",
        "incoming message move with type: Twist links twits",
        "Correct the spelling, or declare `interface twist use Twist from geometry_msgs`.",
    ),
    _error(
        _NAMES,
        "unknown-state",
        "`goto` names a state of the same component, and there is none of this name.",
        "on response from grab goto iddle",
        "Correct the spelling, or declare the state.",
    ),
    _error(
        _NAMES,
        "unknown-property",
        "Data is provided for a property that the object does not have.",
        "provide move with { linaer: { x: 0.4 } }",
        "Use one of the object's properties, or declare the property.",
    ),
    _error(
        _NAMES,
        "unknown-component",
        "The library has no component of this name.",
        "component Left from Wheels import Whel",
        "Use one of the library's components.",
    ),
    _error(
        _NAMES,
        "duplicate-name",
        "Two things of one kind have the same name: components, datatypes and interfaces of a file,"
        " communications of all local components, states and variables of a component, properties"
        " of an object. A boolean variable and a state of one component cannot share a name either,"
        " since nothing could distinguish them.",
        "component Motor {}\ncomponent Motor {}",
        "Give one of them another name.",
    ),
    _error(
        _NAMES,
        "ambiguous-name",
        "A bare name can mean several things, and the type expected here does not decide which.",
        "requirement move needs slow = slow",
        "Write `Enum.value`, `Component.variable` or `Component.communication`.",
    ),
    # --- types
    _error(
        _TYPES,
        "type-mismatch",
        "The expression has another type than the one expected. Integers become doubles where"
        " needed; nothing else is converted implicitly. `/` always gives a double.",
        "transition if speed + 1",
        "Compare, convert by an enum, or change the declared type.",
    ),
    _error(
        _TYPES,
        "not-finite",
        "Synthesis examines every value of a variable with a range that takes part in decisions, so"
        " whatever is assigned to it must have a range, too. (Other numbers and strings may take"
        " part in decisions where they are compared with something.)",
        "variable level: integer(0..9)\n…\non response from gauge do level := value  // an integer",
        "Give the integer a range, or convert the received value by an enum: `datatype enum Level"
        " from integer to { value > 5 -> high default -> low }`.",
    ),
    _error(
        _TYPES,
        "out-of-range",
        "A constant is outside the range of the variable or parameter that gets it.",
        "variable gear: integer(1..5) = 0",
        "Use a value inside the range, or widen the range.",
    ),
    _error(
        _TYPES,
        "empty-range",
        "The lower bound of a range is above the upper one.",
        "variable gear: integer(5..1)",
        "Swap the bounds.",
    ),
    _error(
        _NAMES,
        "bad-index",
        "An index of several components of a kind is missing, does not exist, or is not known"
        " beforehand; or there are too many of them.",
        "component Station[1..6] { … }\nrequirement Station[7].go needs Robot.idle",
        "Write an index that the message names.",
    ),
    _error(
        _STATEMENTS,
        "not-over-components",
        "A function over components, or over a list of expressions, is used where it cannot be"
        " expanded: `count` must be compared with a whole number, and `sum`, `min` and `max` must"
        " not have a condition.",
        "requirement go needs count(s.busy for s in Station) < Robot.limit",
        "Compare the count with a number.",
    ),
    _error(
        _TYPES,
        "variable-type",
        "A variable or constant cannot be of type `none`, an object or array variable has no"
        " initial value, and a parameter is of a basic type or an enum.",
        "variable nothing: none",
        "Use another type; an object or array holds nothing until something is assigned to it.",
    ),
    _error(
        _TYPES,
        "none-not-allowed",
        "`none` says that a communication carries nothing; a property or the elements of an array"
        " cannot be nothing.",
        "datatype object Twist { linear: none }",
        "Leave the property out.",
    ),
    _error(
        _TYPES,
        "array-not-allowed",
        "A communication does not carry an array directly, only as a property of an object.",
        "outgoing message scan with type: array(double)",
        "Use an object with the array as a property, or an enum from the array.",
    ),
    _error(
        _TYPES,
        "recursive-datatype",
        "A datatype contains itself, directly or by way of others. No ROS message can.",
        "datatype object Node { child: Node }",
        "Remove the property that closes the cycle.",
    ),
    _error(
        _TYPES,
        "missing-default",
        "An enum must say which value it gives if none of its rules matches.",
        "datatype enum Distance from double to { value > 0.5 -> free }",
        "Add `default -> obstructed`.",
    ),
    _error(
        _TYPES,
        "several-defaults",
        "An enum has exactly one default.",
        "default -> free\ndefault -> obstructed",
        "Remove one of them.",
    ),
    _error(
        _TYPES,
        "enum-source",
        "An enum converts the data of a message: not another enum, and not `none`.",
        "datatype enum Danger from Distance to { default -> low }",
        "Convert from the type that the other enum converts.",
    ),
    _error(
        _TYPES,
        "initial-not-constant",
        "An initial value, like a constant, may only be computed from literals, enum values and"
        " other constants, and not from itself.",
        "variable speed: integer = old_speed",
        "Write the constant, and assign the rest in a transition.",
    ),
    _error(
        _TYPES,
        "value-not-allowed",
        "`value` is what was just received. It can be used in the rules of an enum, and in"
        " transitions `on response from`, `on feedback from` and, for an action, `on error from` a"
        " communication that carries something. Elsewhere it has no meaning.",
        "on request to move do speed := value",
        "Store the received value in a variable, and use that.",
    ),
    # --- communications
    _error(
        _COMMUNICATION,
        "enum-sent",
        "An enum converts what is received, and not the reverse. So it cannot be sent, neither"
        " alone nor in an object.",
        "incoming message drive with type: Distance",
        "Send the type that the enum converts from.",
    ),
    _error(
        _COMMUNICATION,
        "missing-links",
        "robosc knows which ROS message carries a basic type. A service, an action, an object and"
        " an enum from an object need `links`.",
        "incoming message move with type: Twist",
        "Declare `interface twist use Twist from geometry_msgs`, and write `links twist`.",
    ),
    _error(
        _COMMUNICATION,
        "ros-name",
        "The name of a topic, service, action, type or package is not one that ROS allows.",
        'outgoing message distance with identifier: "/my topic", type: double',
        "Use letters, digits, `_` and `/`, each part beginning with a letter.",
    ),
    _error(
        _ROS,
        "parameter-name",
        "A parameter of the model has the name of another parameter of the generated node.",
        "parameter rate: double = 5.0",
        "Give it another name.",
    ),
    # --- behaviour
    _error(
        _BEHAVIOUR,
        "several-behaviours",
        "A component has one automaton.",
        "behaviour { … } behaviour { … }",
        "Put the states of both into one, or make two components.",
    ),
    _error(
        _BEHAVIOUR,
        "no-initial-state",
        "An automaton has to begin somewhere.",
        "behaviour { marked state idle {} }",
        "Write `initial` before one state.",
    ),
    _error(
        _BEHAVIOUR,
        "several-initial-states",
        "An automaton begins in exactly one state.",
        "initial state idle {} initial state busy {}",
        "Remove `initial` from all but one.",
    ),
    _error(
        _BEHAVIOUR,
        "no-marked-reachable",
        "From some state that the component can enter, no marked state can be reached by its own"
        " transitions. The supervisor keeps marked states reachable, so it could never let the"
        " component enter that state.",
        "initial marked state idle { on request to grab goto grabbing }\nstate grabbing {}",
        "Add the missing transition back (often `on error from` or `on response from`), or mark the"
        " state.",
    ),
    _warning(
        _BEHAVIOUR,
        "unreachable-state",
        "No transition of the component leads to this state, so nothing that is declared in it can"
        " happen.",
        "initial marked state idle {}\nmarked state busy {}",
        "Add a transition to it, or remove it.",
    ),
    _error(
        _BEHAVIOUR,
        "event-not-available",
        "The communication does not have this event. An outgoing message has `response`, and"
        " `timeout` if it declares one; an incoming message `request`; a service `request`,"
        " `response` and `error`; an action also `feedback` and `cancel`.",
        "on response from stop",
        "React to an event that exists.",
    ),
    _error(
        _BEHAVIOUR,
        "duplicate-transition",
        "One state has two transitions for one event, and nothing says which to take.",
        "on response from grab goto idle\non response from grab goto failed",
        "Join them, or give each a guard (`if`) that excludes the other's.",
    ),
    _warning(
        _BEHAVIOUR,
        "hidden-transition",
        "A transition of a state takes precedence over those for the same event that apply in every"
        " state. Their assignments are made together, but here something of the others is lost: a"
        " `goto`, an assignment to the same variable, or a transition for a request.",
        "on response from distance goto far\nstate sensing { on response from distance goto idle }",
        "If both are meant, repeat in this transition what the other one does.",
    ),
    _error(
        _BEHAVIOUR,
        "foreign-assignment",
        "Only a component itself assigns its variables.",
        "on response from distance do Motor.speed := 0",
        "Let the other component react to the same event.",
    ),
    _error(
        _BEHAVIOUR,
        "not-assignable",
        "The left side of `:=` is not a variable of this component.",
        "on response from grab do idle := true",
        "Assign a variable, or change the state with `goto`.",
    ),
    _error(
        _BEHAVIOUR,
        "duplicate-assignment",
        "The assignments of a transition are simultaneous, so only one of them may assign a"
        " variable.",
        "do speed := 1, speed := 2",
        "Remove one of them.",
    ),
    # --- statements
    _error(
        _STATEMENTS,
        "requirement-on-outgoing",
        "A requirement restricts what the controller does. It cannot forbid what the robot sends.",
        "requirement distance needs Motor.stopped",
        "Put the requirement on the command that should wait.",
    ),
    _error(
        _STATEMENTS,
        "preference-on-outgoing",
        "A preference orders the commands that the controller sends, not what the robot sends.",
        "outgoing message distance with type: integer(0..9)\nprefer distance over drive",
        "Prefer a command; or let a requirement on the other one read what the robot sent.",
    ),
    _error(
        _STATEMENTS,
        "preference-cycle",
        "The preferences between commands form a cycle, so none of the commands comes first.",
        "prefer drive over halt\nprefer halt over drive",
        "Remove one of the preferences.",
    ),
    _error(
        _STATEMENTS,
        "provide-for-outgoing",
        "The robot itself sends the data of an outgoing message.",
        "provide distance with 3.0",
        "Provide data for incoming messages, services and actions.",
    ),
    _error(
        _STATEMENTS,
        "nothing-to-provide",
        "The communication carries nothing, so there is nothing to provide for it.",
        "incoming message halt with type: none\nprovide halt with 1",
        "Remove the statement, or give the communication a type.",
    ),
    _warning(
        _STATEMENTS,
        "repeated-communication",
        "One requirement names a communication twice.",
        "requirement { move, stop, move } needs Motor.ready",
        "Remove one of them; perhaps another communication is meant.",
    ),
    # --- libraries
    _error(
        _LIBRARIES,
        "library-not-found",
        "No library of this name lies in the folder of the importing file, in `shared/` or"
        " `libraries/` beside that folder, in a `--library-path`, or in what a ROS package exports"
        " by"
        ' `<robosc libraries="…"/>`.',
        "component Left from Wheels import Wheel",
        "Correct the name, or add the folder with `--library-path`.",
    ),
    _error(
        _LIBRARIES,
        "library-clash",
        "Several files declare this library and differ, so it is ambiguous which one is meant.",
        "(Wheels in ./ and, different, in ../shared/)",
        "Remove or rename one of them.",
    ),
    _error(
        _LIBRARIES,
        "import-cycle",
        "A library imports itself, directly or by way of others.",
        "library A { component X from B import Y }\nlibrary B { component Y from A import X }",
        "Move what they share to a library of its own.",
    ),
    _error(
        _LIBRARIES,
        "import-incomplete",
        "A component of a library refers to another component of that library, which is not"
        " imported, or imported so often that it is ambiguous which one is meant.",
        "component Arm from Arms import Arm   // reacts to a message of Arms' Hand",
        "Import the other component too; imports that belong together have one prefix.",
    ),
    # --- ROS
    _error(
        _ROS,
        "unknown-field",
        "The real definition of the message, service or action has no field of this name.",
        "datatype object Twist { speed: double }   // linked to geometry_msgs/Twist",
        "Use one of the fields that the hint lists.",
    ),
    _warning(
        _ROS,
        "unread-field",
        "The real definition has no field of this name. Nothing reads or sends the property, so it"
        " has no effect.",
        "datatype object Twist { speed: double }   // linked to geometry_msgs/Twist",
        "Remove the property, or use one of the fields that the hint lists.",
    ),
    _error(
        _ROS,
        "field-kind",
        "The field exists, but is of another kind. What is sent must fit into the field: a double"
        " does not fit into an integer field. What is received must fit into the type of the model:"
        " an integer field can be read as a double, not the reverse.",
        "datatype object Header { seq: string }   // uint32 in ROS",
        "Use the type that the message names.",
    ),
    _error(
        _ROS,
        "field-range",
        "A constant or the range of an integer does not fit into the integer field that carries"
        " it.",
        "incoming message speed with type: integer\nprovide speed with 40000   // std_msgs/Int16",
        "Use a smaller value, or link an interface with a wider field.",
    ),
    _error(
        _ROS,
        "field-index",
        "An index lies beyond the end of an array whose length the definition fixes: the expression"
        " would never have a value.",
        "value.covariance[9] > 1 -> lost   // float64[9] covariance",
        "Use an index from 0 to the length minus one.",
    ),
    _error(
        _ROS,
        "no-single-field",
        "A basic type, or an enum from one, stands for the only data field of the linked interface."
        " This one has several, or none.",
        "outgoing message goal with type: double links twist",
        "Use an object that names the field.",
    ),
    _error(
        _ROS,
        "field-length",
        "The field is an array of fixed length, but the array that is sent has another length.",
        "provide pose with { covariance: [0.1, 0.1] }   // float64[36] covariance",
        "Write as many elements as the field has.",
    ),
    _error(
        _ROS,
        "interface-not-found",
        "The ROS package is installed, but has no such message, service or action.",
        "interface twist use Twits from geometry_msgs",
        "Use one of those that it has.",
    ),
    _error(
        _ROS,
        "faulty-definition",
        "The definition file of the message, service or action cannot be read.",
        "(a .srv file without ---)",
        "Correct the file that the message names.",
    ),
    _warning(
        _ROS,
        "package-not-found",
        "The ROS package of an interface is not installed and not in the workspace, so the model's"
        " types are not checked against it. With `--strict` this is an error.",
        "interface twist use Twist from geometry_msgs   // on a machine without ROS",
        "Install what the hint names.",
        strict=True,
    ),
    _error(
        _ROS,
        "ros-type-unknown",
        "The model uses a ROS definition as a type, and its package is not found. The fields of"
        " such a type are known only from its definition.",
        "outgoing message scan with type: sensor_msgs/LaserScan   // on a machine without it",
        "Install what the hint names, or declare a datatype of your own and link it.",
    ),
    # --- the whole
    _warning(
        _WHOLE,
        "topic-shared",
        "There are several outgoing messages on one topic. Each message on it counts as an event of"
        " all of them.",
        'component A { outgoing message x with identifier: "/t", type: none }\n'
        'component B { outgoing message y with identifier: "/t", type: none }',
        "Declare it once; any component can react to it.",
    ),
    _warning(
        _WHOLE,
        "stale-data",
        "A command depends on a variable that only a message sets, and the model does not say what"
        " happens if that message falls silent: the robot would go on with the last value for"
        " ever.",
        "outgoing message scan with type: Way\non response from scan do way := value\nrequirement"
        " drive needs Front.way = free",
        "Give the message a `timeout:`, and the command a requirement that names its freshness:"
        " `requirement drive needs scan.fresh`.",
    ),
    _warning(
        _WHOLE,
        "topic-types",
        "Two messages share a topic but not the ROS type. ROS connects only publishers and"
        " subscribers of the same type.",
        'outgoing message a with identifier: "/t", type: double\n'
        'incoming message b with identifier: "/t", type: boolean',
        "Use different topics, or the same type.",
    ),
    _warning(
        _WHOLE,
        "names-differ-in-case",
        "Two names of one kind differ only in upper and lower case: easily confused.",
        "state idle {} state Idle {}",
        "Rename one of them.",
    ),
    _warning(
        _WHOLE,
        "unused-datatype",
        "No communication, variable or other datatype uses this datatype.",
        "datatype object Twist {}",
        "Use it or remove it.",
    ),
    _warning(
        _WHOLE,
        "unused-interface",
        "No communication links this interface.",
        "interface twist use Twist from geometry_msgs",
        "Write `links twist` where it is meant, or remove it.",
    ),
    _warning(
        _WHOLE,
        "unused-variable",
        "The variable is never read, so it changes nothing.",
        "variable count: integer = 0",
        "Use it or remove it.",
    ),
    _warning(
        _WHOLE,
        "unused-value",
        "Nothing reads this constant or parameter, or names this condition.",
        "parameter limit: double = 0.5",
        "Use it or remove it.",
    ),
    _warning(
        _WHOLE,
        "unused-timeout",
        "The message has a timeout, but nothing depends on whether it is fresh or silent, so its"
        " silence changes nothing.",
        "outgoing message scan with timeout: 500 ms, type: boolean",
        "Name the freshness in a requirement (`requirement drive needs scan.fresh`), react to the"
        " silence (`on timeout from scan goto blind`), or remove the timeout.",
    ),
    _warning(
        _WHOLE,
        "unused-enum-value",
        "No expression reads this value, nor any other of the enum.",
        "datatype enum Distance from double to { value > 9 -> far value > 1 -> near default -> here"
        " }",
        "Use it, or remove its rule.",
    ),
    # --- the controlled system
    _plant(
        Severity.ERROR,
        "empty-supervisor",
        "No controller can satisfy the requirements: even from the initial state the robot can, on"
        " its own, reach a state in which a state requirement fails, a variable is out of range, or"
        " from which no marked state can be reached.",
        "requirement never Sensor.blocked   // the sensor alone decides that",
        "The message lists the events that nobody can prevent. Weaken the requirement, or model"
        " what the controller can do about it.",
    ),
    _plant(
        Severity.WARNING,
        "never-allowed",
        "The command can never be sent, because something that must not happen could follow, and"
        " nobody could prevent it. The message gives a shortest trace.",
        "state grabbing { on response from grab goto idle }   // and if the grab fails?",
        "Usually some event is not handled; the hint says which and where.",
    ),
    _plant(
        Severity.WARNING,
        "restricted-command",
        "The command is allowed less often than its requirements say, because in some states"
        " something that must not happen could follow, and nobody could prevent it.",
        "on response from fill do level := level + 1   // level: integer(0..3)",
        "If this is what you want, there is nothing to do: the controller takes care of it. If not,"
        " the hint says what would lift the restriction.",
    ),
    _plant(
        Severity.WARNING,
        "topic-conflict",
        "Two commands go to one topic and can be enabled at the same time, so that the robot may"
        " get both, one after the other.",
        'incoming message move with identifier: "/vel", type: Twist links twist\n'
        'incoming message stop with identifier: "/vel", type: Twist links twist',
        "Let the requirements of one exclude the other.",
    ),
    _plant(
        Severity.WARNING,
        "provide-overlap",
        "Two provide statements of one communication can hold at the same time. The first one in"
        " the file is used.",
        "provide move with { x: 1.0 } if A.slow\nprovide move with { x: 2.0 } if B.clear",
        "Make their conditions exclude each other.",
    ),
    _plant(
        Severity.WARNING,
        "provide-missing",
        "The command can be sent in a state in which none of its provide statements holds. The"
        " message's defaults are sent then, usually zeros.",
        "provide move with { x: 1.0 } if A.clear",
        "Add a provide statement for that case, or a requirement that forbids the command then.",
    ),
    _plant(
        Severity.WARNING,
        "nothing-to-send",
        "The command's data read an object or an array, and the command can be enabled before"
        " anything was assigned to it. It is not sent then; the running controller counts and"
        " reports that.",
        "provide drive with { target_pose: Operator.goal }   // before the first goal",
        "Enter a state when the data arrive, and let the command need that state.",
    ),
    _plant(
        Severity.WARNING,
        "requirement-always-true",
        "The requirement holds in every state that the robot can reach, so it forbids nothing.",
        "requirement move needs Arm.idle or Arm.busy   // it is always one of them",
        "Correct the condition, or remove the requirement.",
    ),
    _plant(
        Severity.WARNING,
        "requirement-never-met",
        "The requirement, or several of one command together, hold in no state in which the command"
        " could happen: it can never be sent.",
        "requirement move needs Arm.idle and Arm.busy",
        "Correct the condition, or what keeps the system from getting there.",
    ),
    _plant(
        Severity.ERROR,
        "guard-overlap",
        "Two transitions for one event leave the same state, and the robot can reach a state in"
        " which both guards hold: it is not determined what the component does.",
        "on response from distance if value > 1 goto near\non response from distance if value < 3"
        " goto far",
        "Make the guards exclude each other.",
    ),
    _plant(
        Severity.WARNING,
        "livelock",
        "The components' internal transitions can follow one another without end (a livelock). The"
        " controller takes them as soon as they are possible, so it would never wait for an input"
        " again. At run time a step bound ends that with a safe stop.",
        "state a { transition goto b } state b { transition goto a }",
        "Give one of the transitions a guard that fails after the step.",
    ),
    _plant(
        Severity.WARNING,
        "properties-unchecked",
        "There are internal transitions, and the controlled system has too many states to visit."
        " What the message names was not checked: whether internal transitions always end, whether"
        " they end in the same state in any order, whether the controller keeps reaching marked"
        " states. Synthesis itself is complete.",
        "state a { transition goto b } state b {}, beside twenty boolean variables",
        "Narrow the ranges of variables that requirements read, or avoid internal transitions.",
    ),
    _plant(
        Severity.WARNING,
        "synthesis-unchecked",
        "The state space is too large for a check: whether a controller exists, and what it would"
        " forbid, is not known. The message says what makes it large.",
        "two gauges of type integer(0..100000) that a requirement compares",
        "Convert large ranges by an enum; `robosc synthesize` has no time limit.",
    ),
    _plant(
        Severity.WARNING,
        "order-matters",
        "Several internal transitions are possible at once, and which one is taken first decides"
        " where the run ends. The controller takes them in the order of the file.",
        "state a { transition goto left transition goto right }",
        "Let their guards exclude each other, or keep in mind that the first one wins.",
    ),
    _plant(
        Severity.WARNING,
        "blocking-under-control",
        "A marked state can be reached, but the controller passes through it: it takes internal"
        " transitions as soon as they are possible, and every run to completion ends in a state"
        " that is not marked.",
        "marked state a { transition goto b } state b {}",
        "Mark the states in which the component comes to rest, or guard the transitions that leave"
        " the marked ones.",
    ),
    # --- supervisors
    _supervisor(
        "commands-alike",
        "Several commands share one topic, and their data do not show which of them a message of"
        " the other controller means. They do so if the provide statements of all but one give"
        " constants, or if some field has a different constant in each of them."
        " Requests of one service or action are not distinguished at all.",
        "provide drive with { linear: { x: Sensor.wanted } }\nprovide turn with { linear: { x:"
        " Sensor.wanted }, angular: { z: 1.0 } }",
        "Provide constant data for one of them, a field that distinguishes them, or give it a topic"
        " of its own. Declare a service or action once.",
    ),
    _supervisor(
        "topic-both-ways",
        "Robot and controller both send on one topic. A supervisor between them listens on both"
        " sides, so each message would be forwarded for ever.",
        'outgoing message pose with identifier: "/pose", type: double\n'
        'incoming message goto_pose with identifier: "/pose", type: double',
        "Use a topic for each direction.",
    ),
)

CODES: Mapping[str, Code] = {entry.code: entry for entry in _ALL}


def page() -> str:
    """The text of ``docs/diagnostics.md``."""
    lines = [
        "# Diagnostics",
        "",
        "Every message of robosc about a model carries a code in brackets. This page says what"
        " each",
        "code means. It is generated from `robosc/codes.py`.",
    ]
    group = ""
    for entry in sorted(_ALL, key=lambda entry: _GROUPS.index(entry.group)):
        if entry.group != group:
            group = entry.group
            lines += ["", f"## {group}"]
        strict = " (with `--strict` an error)" if entry.strict else ""
        lines += ["", f"### {entry.code}", "", f"*{entry.severity.value}*{strict}", ""]
        lines += [entry.explanation, "", "```", *entry.example.split("\n"), "```", ""]
        lines.append(entry.remedy)
    return "\n".join(lines) + "\n"
