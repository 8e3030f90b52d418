"""The names of a model as they were in a recorded run, where nodes may have been remapped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from robosc.errors import UsageError
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Robot
from robosc.names import package_name


@dataclass(frozen=True)
class RecordedNames:
    """The names that the controller had: ``namespace`` begins with a slash and ends with none,
    ``node`` is its full name; ``rules`` are resolved names with those that took their place."""

    namespace: str
    node: str
    rules: Mapping[str, str]

    def of(self, identifier: str) -> str:
        """The full name of a topic, a service or an action."""
        name = self._resolved(identifier)
        return self.rules.get(name, name)

    def with_rule(self, name: str, other: str) -> RecordedNames:
        rules = {**self.rules, self._resolved(name): self._resolved(other)}
        return RecordedNames(self.namespace, self.node, rules)

    def _resolved(self, name: str) -> str:
        if name.startswith("~"):
            return f"{self.node}/{name[1:].lstrip('/')}"
        return name if name.startswith("/") else f"{self.namespace}/{name}"


def recorded_names(robot: Robot, given: Sequence[str] = ()) -> RecordedNames:
    """The names of a run whose controller was remapped by ``given``, like ``/vel:=/base/vel``;
    ``__ns`` and ``__name`` are its namespace and name.

    Raises:
        UsageError: one is no such rule.
    """
    pairs = [tuple(map(str.strip, rule.partition(":=")[::2])) for rule in given]
    for rule, pair in zip(given, pairs, strict=True):
        if not all(pair):
            raise UsageError(f"{rule!r} must be two names, like /vel:=/base/vel")
    special = {name: other for name, other in pairs if name in ("__ns", "__name")}
    namespace = "/" + special.get("__ns", "").strip("/")
    namespace = namespace.rstrip("/")
    node = special.get("__name", f"{package_name(robot.name)}_controller")
    names = RecordedNames(namespace, f"{namespace}/{node}", {})
    for name, other in pairs:
        if name not in special:
            names = names.with_rule(name, other)
    return names
