"""The codes of diagnostics, with the severity of each; ``docs/diagnostics.md`` explains them.

Codes are stable: one is never given to another fault. Tests compare the page with this table, and
hold that each code has a faulty model with its exact output.
"""

from __future__ import annotations

from collections.abc import Mapping

from robosc.errors import Severity
from robosc.lazy_dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Code:
    """One kind of fault.

    ``strict``: ``--strict`` makes the warning an error. ``needs_plant``: it is found on the
    synthesised system, not in the text. ``supervised``: it is found when a supervisor is generated
    that guards another controller.
    """

    code: str
    severity: Severity
    strict: bool = False
    needs_plant: bool = False
    supervised: bool = False


_MODEL_ERRORS = (
    # reading the text
    "syntax", "misplaced", "missing-brace", "unexpected-brace", "several-robots", "reserved-name",
    "bad-character", "bad-escape", "bad-number", "number-too-large", "unterminated-string",
    "unterminated-comment", "too-deep", "too-many-errors", "invalid-utf8",
    # names
    "unknown-name", "unknown-member", "unknown-communication", "unknown-type", "unknown-interface",
    "unknown-state", "unknown-property", "unknown-component", "duplicate-name", "ambiguous-name",
    "bad-index", "duplicate-id",
    # types and data types
    "type-mismatch", "not-finite", "out-of-range", "empty-range", "variable-type",
    "none-not-allowed", "array-not-allowed", "recursive-datatype", "missing-default",
    "several-defaults", "enum-source", "initial-not-constant", "value-not-allowed",
    # communications
    "enum-sent", "missing-links", "ros-name", "frames",
    # behaviour
    "several-behaviours", "no-initial-state", "several-initial-states", "no-marked-reachable",
    "event-not-available", "duplicate-transition", "misplaced-else", "foreign-assignment",
    "not-assignable", "duplicate-assignment", "performs-outgoing", "performed-elsewhere",
    "states-in-performing", "misplaced-retry",
    # requirements and data
    "not-over-components", "requirement-on-outgoing", "preference-on-outgoing", "preference-cycle",
    "provide-for-outgoing", "nothing-to-provide", "data-not-given", "stop-not-a-message",
    "several-stops", "served-twice", "error-is-free", "unanswered", "assumption-on-command",
    # libraries
    "library-not-found", "library-clash", "import-cycle", "import-incomplete",
    # ROS interfaces
    "parameter-name", "unknown-field", "field-kind", "field-range", "field-index",
    "no-single-field", "field-length", "interface-not-found", "faulty-definition",
    "ros-type-unknown",
)  # fmt: skip
_MODEL_WARNINGS = (
    "unreachable-state", "hidden-transition", "repeated-communication", "unread-field",
    "topic-shared", "stale-data", "stale-event", "undefined-data", "no-stop", "stop-restricted",
    "topic-types", "names-differ-in-case", "call-not-taken", "refusal-not-seen", "refusal-unread",
    "cancel-is-not-end",
    "unused-datatype", "unused-interface", "unused-variable", "unused-value", "unused-timeout",
    "unused-enum-value", "refused-definition",
)  # fmt: skip
_PLANT_ERRORS = ("empty-supervisor", "guard-overlap")
_PLANT_WARNINGS = (
    "never-allowed", "restricted-command", "topic-conflict", "provide-overlap", "provide-missing",
    "nothing-to-send", "requirement-always-true", "requirement-never-met", "livelock",
    "properties-unchecked", "synthesis-unchecked", "explanations-left-out",
    "order-matters", "blocking-under-control",
    "impossible-under-control", "possible-free", "self-cancelling", "assumption-excludes-all",
    "assumption-broken",
)  # fmt: skip
_SUPERVISOR_ERRORS = ("commands-alike", "topic-both-ways", "data-of-others")

CODES: Mapping[str, Code] = {
    entry.code: entry
    for entry in (
        *(Code(code, Severity.ERROR) for code in _MODEL_ERRORS),
        *(Code(code, Severity.WARNING) for code in _MODEL_WARNINGS),
        Code("package-not-found", Severity.WARNING, strict=True),
        *(Code(code, Severity.ERROR, needs_plant=True) for code in _PLANT_ERRORS),
        *(Code(code, Severity.WARNING, needs_plant=True) for code in _PLANT_WARNINGS),
        *(Code(code, Severity.ERROR, supervised=True) for code in _SUPERVISOR_ERRORS),
    )
}
"""All codes."""
