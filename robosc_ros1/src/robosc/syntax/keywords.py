"""Keywords, and how to tell that a word is one rather than a name.

Keywords are contextual: where a name is expected any word is one. Only where the user has forgotten
the name does the next declaration seem to begin in its place; then the words behind it tell.
"""

from __future__ import annotations

import re

from robosc.names import IDENTIFIER

__all__ = ["LOOKS", "NAME", "QUALIFIED", "is_declaration"]

NAME = rf"\^?{IDENTIFIER}"
QUALIFIED = rf"{NAME}(?:\s*\.\s*{NAME})*"

_EVENTS = "request|response|feedback|error|cancel"

LOOKS = {
    "component": rf"component\s+{NAME}\s*(?:\{{|from\b)",
    "requirement": (
        rf"requirement\s+(?!(?:and|or|needs|disables)\b)(?:{QUALIFIED}(?!\s*:)|[({{]|!(?!=))"
    ),
    "provide": rf"provide\s+{QUALIFIED}\s+with\b",
    "datatype": r"datatype\s+(?:object|enum)\b(?!\s*[:.])",
    "interface": rf"interface\s+{NAME}\s+use\b",
    "incoming": r"incoming\s+message\b(?!\s*[:.])",
    "outgoing": r"outgoing\s+message\b(?!\s*[:.])",
    "service": rf"service\s+{NAME}\s+with\b",
    "action": rf"action\s+{NAME}\s+with\b",
    "behaviour": r"behaviour\s*\{",
    "variable": rf"variable\s+{NAME}\s*:",
    "initial": r"initial\s+(?:marked\s+)?state\b",
    "marked": r"marked\s+state\b",
    "state": rf"state\s+{NAME}\s*\{{",
    "on": rf"on\s+(?:{_EVENTS})\s+(?:from|to)\b",
    "transition": r"transition\s+(?:if|goto)\b",
}
"""The first keyword of each declaration, and a pattern that hardly anything else matches."""

_CLAUSES = ("if", "do", "goto", "needs", "disables")
_ALL = "|".join(
    (*LOOKS, *_CLAUSES, "from", "to", "with", "use", "links", "import", "and", "or", "default")
)
_DECLARATION = re.compile("|".join(LOOKS.values()), re.ASCII)
_CLAUSE = re.compile(rf"(?:do|goto|needs|disables|not)[ \t]+(?!(?:{_ALL})\b){NAME}", re.ASCII)
_SUSPECTS = frozenset((*LOOKS, *_CLAUSES, "not"))


def is_declaration(text: str, loc: int, word: str) -> bool:
    """Where a name is expected: is it missing, and ``word`` at ``loc`` begins what follows it?"""
    if word not in _SUSPECTS:
        return False
    if _CLAUSE.match(text, loc):
        return True
    first = not text[text.rfind("\n", 0, loc) + 1 : loc].strip()
    return first and _DECLARATION.match(text, loc) is not None
