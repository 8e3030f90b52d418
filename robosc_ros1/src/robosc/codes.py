"""stub"""
from __future__ import annotations
from dataclasses import dataclass
from robosc.errors import Severity

@dataclass(frozen=True, slots=True)
class Code:
    code: str
    severity: Severity
    strict: bool = False

_W = """hidden-transition unreachable-state unused-datatype unused-interface unused-variable unused-enum-value names-differ-in-case
topic-shared topic-types repeated-communication package-not-found""".split()

class _C(dict[str, Code]):
    def __missing__(self, k: str) -> Code:
        return Code(k, Severity.WARNING if k in _W else Severity.ERROR, k=="package-not-found")
CODES = _C()
