"""What is bounded, why, and what the user sees when a bound is reached.

Numbers that only choose between two ways to the same result stand where the choice is made.
"""


# The text of a model

FILE_BYTES = 2**26
"""Bytes of a model's file (a device such as /dev/zero has no end); a larger one cannot be read."""
LEXICAL_ERRORS = 100
"""Errors in the signs of one file; instead of further ones an error says that there are more."""
ERRORS = 1000
"""Errors of one run; after them one says that there are more."""
SUGGESTIONS = 100
"""Unknown names for which a similar one is looked for; a file with more is no model, and the rest
comes without suggestions."""
SHOWN_COLUMNS = 160
"""Characters of a line that are shown with an error; a longer line is cut around the place."""
BLOCKS_IN_BLOCKS = 20
"""Levels of blocks in blocks (a deeper text could exhaust the stack); more are the error
``too-deep``."""
NESTED_DATA = 20
"""Levels to which arrays of arrays, and provided objects in objects, are nested; more are an error.
"""
EXPRESSION_DEPTH = 200
"""Height of an expression's tree, so that later stages may recurse; more is the error ``too-deep``.

Chains of ``and`` or ``or`` do not count: long ones become balanced trees, which mean the same.
Arithmetic is not associative on doubles, so its chains stay as they are written.
"""
EXPRESSION_NESTING = 60
"""Nested brackets that an expression needs in Python; more are the error ``too-deep``.

The parser of Python 3.8 gives up at 90, and in generated code expressions are parts of longer ones.
"""
PACKAGE_NAME = 120
"""Characters of a package's name; CMake cannot build one that is longer, which is an error."""

# The model

NESTED_TYPES = 50
"""Levels of object types in object types, far beyond any ROS message; more are ``too-deep``."""
IMPORTS = 20
"""Levels of libraries that import libraries; more are an error."""
TEXT_CONSTANT = 2**16
"""Characters of a string constant; more are an error."""
CONDITION_TERMS = 50_000
"""Terms of a condition, which contains the conditions that it names; more are an error."""
CALL_TERMS = 5_000
"""Terms of a call, with those of the functions that it calls; more are an error."""
CALLS_IN_CALLS = 50
"""Levels of functions that call functions; more are an error."""
COPIES = 10_000
"""Copies of one component, or of the statements of one ``for``; more are an error at the range."""
STATEMENTS = 100_000
"""Statements that one ``for`` makes with those in it; more are an error."""
COUNT_NODES = 20_000
"""Nodes to which a count is expanded; one that needs more is an error."""
OVERLAP_CASES = 2_000
"""Combinations of values that are tried to see whether two guards hold together; where there are
more, synthesis alone tells of the overlap."""

# The plant

VALUES = 2**20
"""Values of a variable, or of a part of an event's value; a plant with more is refused."""
CASES_OF_A_COMMAND = 2**10
"""Cases of the data of one command, each an event of its own; a plant with more is refused."""
CASES_OF_A_CONDITION = 10_000
"""Combinations of values that a condition on data is split into; where there are more, its outcome
is taken as unknown."""

# Synthesis and its explanations

CHECK_SECONDS = 20.0
"""Processor seconds of synthesis in ``check``, which is asked for often; beyond, the warning
``synthesis-unchecked`` says so."""
CONFLICT_WORK = 2_000_000
"""Work that looking for what conflicts may take: plant states, times what may be left out, times
what is to be explained; beyond, explanations name nothing that conflicts."""
CONFLICT_PRODUCT = 2**20
"""Product of the variables of one independent part up to which it is looked for what conflicts."""
CONFLICT_EVENT = 1_000
"""Plant states to which one event of the plant amounts there."""
EXPLICIT_STATES = 2**20
"""States that the explicit engine visits unless ``--max-states`` says otherwise; more are the
symbolic engine's, or refused."""
EXPLICIT_STEPS = 10**7
"""Events that the explicit engine tries in states, whose transitions it keeps; more are refused if
there are also more than ``EXPLICIT_VALUES`` in each state, so many values do the messages have."""
EXPLICIT_VALUES = 256
COMBINATIONS = 2**20
"""Combinations of outcomes of one event's data that are enumerated; more are refused."""
MEMORY = 2 * 2**30
"""Bytes for the decision diagrams of one synthesis, if that much is free; beyond, synthesis is
refused."""
OPERAND_PAIRS = 2**22
"""Pairs of operand values of one operation in the symbolic engine; more are refused."""
COMPLETION_NODES = 2**23
"""New nodes, some seconds of work, of the symbolic search of run-to-completion steps; beyond, the
properties of the controller are told as unknown."""
COMPLETION_PARTS = 2**16
"""Parts of sets of states, some seconds of work, that this search closes under steps; the same."""
TRACE_NODES = 10_000_000
"""Nodes of the sets that images are taken of for all traces of one system, some seconds; beyond,
explanations say that no trace was looked for."""
BREADTH_FIRST_NODES = 50_000
"""Nodes of all layers of a breadth-first search together; beyond, traces need not be the shortest.
"""
EXPLAINING_SECONDS = (1.0, 10.0)
"""Least and most processor seconds for explanations, which otherwise may take as long as synthesis
has taken; what is not explained by then is left out, and said, unless ``--explain-seconds`` says
otherwise."""
FAULT_SURROUNDINGS = 5_000
"""States up to which such a search goes on in states that violate a requirement; beyond, it is not
told of states that lead only to these whether the plant is blocked there."""
FAULT_STATES = 500_000
"""States that must be avoided, among which a search state by state looks for what is wrong; beyond,
an explanation is left out."""
TRANSITION_CHOICES = 64
"""Combinations of transitions of one event; where there are more, ``self-cancelling`` is not looked
for."""
TOLD_VARIABLES = 8
"""State variables of one state that are told in an explanation; of the others their number is."""
SEARCHED_STATES = 100_000
"""Controlled states that are searched one by one for the properties of the controller; above, sets
of them are."""
FIRST_STEPS = 2_000
"""Run-to-completion steps that are searched for a cycle in a system with more states."""

# Verification, exploring, exports

VERIFIED_STATES = 2**20
"""States that ``verify`` searches one by one, about a minute and 700 MB; above, sets of states are
verified."""
VERIFIED_SECONDS = 300.0
"""Processor seconds of ``verify``; beyond, it stops and says so."""
VERIFIED_TRANSITIONS = 2**24
"""Transitions of such a search, 16 bytes each; beyond, verification stops with the number."""
VERIFIED_VALUES = 2**22
"""Combinations of the parts of an event's value; beyond, verification stops with the number."""
VERIFIED_ROWS = 2**18
"""Combinations of values that an event or a condition reads, some seconds each; beyond,
verification stops and names the variables."""
TRANSITIONS_PER_STATE = 30
"""Transitions that ``explore`` allows per state of its limit, some 80 bytes each; more are refused.
"""
CIF_VALUES = 2**14
"""Values of one event in CIF, which make a text of 40 MB in some 15 s; more are refused."""
DRAWN_STATES = 40
"""States of a controlled system that are drawn; more are no picture any more, and left out."""
DRAWN_PRODUCT = 2**22
"""Product of the variables up to which the controlled system is computed for a picture."""
SHOWN_CLASSES = 500
"""Classes of a number that the page names, in a table that grows with the square; of more it shows
the number alone."""
STEPS = 10_000
"""Steps of one run to completion of a generated controller; it stops at more, which only a fault
can cause."""
WRITING_SECONDS = 10.0
"""Seconds that another robosc may take to write into the same folder; then writing is refused."""

# Simulation, recordings, the page and the editor

PATH_STATES = 1_000_000
"""States that ``goto`` looks at; beyond, it says that it found no path."""
PATH_EVENTS = 4_000_000
"""Events that ``goto`` tries; beyond, it says that it found no path."""
STEPS_IN_ONE_GO = 100_000
"""Steps of one ``random``; a larger number is refused."""
SCRIPTS_IN_SCRIPTS = 10
"""Levels of scripts that play scripts; more are refused."""
WAIT_SECONDS = 3600.0
"""Seconds that the clock is turned on in one go; a longer ``wait`` is refused."""
LOG_LINE_BYTES = 2**24
"""Bytes of a line of an event log (a device such as /dev/zero has none); a longer one cannot be
read."""
KEPT_EVENTS = 5_000
"""Events that the page's server keeps; older ones are no longer shown."""
KEPT_CHARACTERS = 1_000_000
"""Characters of all these events (one can carry a whole map); older ones are no longer shown."""
REQUEST_BYTES = 100_000
"""Bytes of a request of the page; a longer one is refused."""
RANDOM_WALK = 1_000
"""Random steps that the page asks for in one go; more are refused."""
EDITOR_STATES = 2**17
"""States that the explicit engine visits in the editor, which leaves more to ``check``."""
EDITOR_SECONDS = 300.0
"""Seconds after which the editor gives up a synthesis that has not given up by itself."""
COMPLETIONS = 200
"""Completions that the editor gets at once; it asks again when more of the word is typed."""
SEARCHED_FILES = 500
"""Model files in which the editor looks for references; an editor may be open on a whole home."""
SEARCHED_FOLDERS = 3_000
"""Folders in which it looks for these files."""
