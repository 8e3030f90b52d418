"""The keyword sections of the TextMate grammar with which editors highlight models.

``./dev renew`` updates ``editors/vscode/syntaxes/rscd.tmLanguage.json`` with it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from robosc.language.keywords import UNITS, Role, words_of
from robosc.language.operators import symbols

_NAME = r"\^?[A-Za-z_]\w*"
_NO_MEMBER, _NO_NAME = r"(?<!\.)\b", r"\b(?!\s*[.=:,)])"
_NUMBER = r"(?<![\w])\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"


def with_keywords(grammar: dict[str, Any]) -> dict[str, Any]:
    """Return the grammar with its sections of keywords made from the table of keywords."""
    repository = {**grammar["repository"], **_sections()}
    return {**grammar, "repository": repository}


def _sections() -> dict[str, Any]:
    def words(role: Role, scope: str, behind: str = _NO_NAME) -> dict[str, str]:
        return _rule(scope, f"{_NO_MEMBER}({_any(words_of(role))}){behind}")

    events = _any(words_of(Role.EVENT))
    units = _any((*UNITS, "Hz"))
    target = rf"((?:{_NAME}(?:\[[^\]]*\])?\s*\.\s*)?{_NAME})"
    return {
        "label": {"patterns": [
            _captured(r"\b(goals|rate|stop)\s*(:)\s*(replace|once|none)\b",
                      "keyword.other", "punctuation.separator", "keyword.control"),
            _captured(rf"\b({_any(words_of(Role.LABEL))})\s*(:)(?!=)",
                      "keyword.other", "punctuation.separator"),
            _captured(rf"({_NAME})\s*(:)(?!=)",
                      "variable.other.property", "punctuation.separator"),
        ]},
        "event": _captured(rf"\b(on)\s+({events})\s+(from|to)\s+{target}",
                           *["keyword.control"] * 3, "entity.name.function"),
        "keyword": {"patterns": [
            words(Role.DECLARATION, "keyword.declaration"),
            words(Role.MODIFIER, "storage.modifier"),
            words(Role.CLAUSE, "keyword.control"),
            words(Role.OPERATOR, "keyword.operator.word", r"\b"),
        ]},
        "type": _rule("support.type.primitive",
                      rf"(?<![.\w])({_any(words_of(Role.TYPE))})\b(?!\s*[.=:])"),
        "constant": {"patterns": [
            words(Role.CONSTANT, "constant.language.boolean", r"\b"),
            words(Role.VALUE, "variable.language", r"\b"),
            _captured(rf"({_NUMBER})\s*\b({units})\b",
                      "constant.numeric", "keyword.other.unit"),
            _rule("constant.numeric", _NUMBER),
        ]},
        "operator": _rule("keyword.operator", _any(re.escape(s) for s in _signs())),
    }  # fmt: skip


def _signs() -> list[str]:
    return sorted({":=", "->", "..", *symbols(words=False)}, key=lambda sign: (-len(sign), sign))


def _any(words: Iterable[str]) -> str:
    return "|".join(words)


def _rule(scope: str, match: str) -> dict[str, str]:
    return {"name": f"{scope}.rscd", "match": match}


def _captured(match: str, *scopes: str) -> dict[str, Any]:
    captures = {str(n): {"name": f"{scope}.rscd"} for n, scope in enumerate(scopes, 1)}
    return {"match": match, "captures": captures}
