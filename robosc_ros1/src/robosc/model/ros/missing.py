"""Reports of definitions that are not available, each missing package once."""

from __future__ import annotations

from difflib import get_close_matches

from robosc.model.diagnostics import Report
from robosc.model.ros.definitions import MessageDefinitions, install_advice
from robosc.model.ros.interfaces import KINDS, Interface, Missing
from robosc.source import Span
from robosc.syntax.nodes import InterfaceNode, RosTypeNode


class MissingDefinitions:
    """Reports the missing definitions of one file."""

    def __init__(self, definitions: MessageDefinitions, report: Report) -> None:
        self._definitions = definitions
        self._report = report
        self._reported: set[tuple[str, str]] = set()

    def of_interface(self, missing: Missing, node: InterfaceNode | RosTypeNode, kind: str) -> bool:
        """Report why a definition is missing; True if it is only a warning.

        ``kind`` is the word for messages: message, service or action.
        """
        required = isinstance(node, RosTypeNode)
        if missing.reason == "package":
            self.of_package(missing, node.package.span, required=required)
            return not required
        if missing.reason == "file" and missing.package == node.package.text:
            self._report.add(
                "interface-not-found",
                node.type.span,
                f"{missing.package} has no {kind} '{node.type.text}'",
                self._other_kind(missing.package, node.type.text)
                or self._report.suggest(node.type.text, missing.names, f"its {kind}s"),
            )
        else:
            self._report.add(
                "faulty-definition",
                node.type.span,
                f"the definition of this {kind} cannot be read:"
                f" {missing.detail or f'it uses a message that {missing.package} does not have'}",
            )
        return False

    def of_doubts(self, interface: Interface, span: Span) -> None:
        """Report, once, what ROS refuses in a definition that was read."""
        doubts = [doubt for part in interface.parts for doubt in part.doubts]
        name = f"{interface.package}/{interface.type}"
        if doubts and (name, "refused-definition") not in self._reported:
            self._reported.add((name, "refused-definition"))
            message = f"ROS 2 does not build {name}: {'; '.join(doubts)}"
            self._report.add("refused-definition", span, message, "correct these lines of its file")

    def _other_kind(self, package: str, type_: str) -> str | None:
        for folder, kind in KINDS.items():
            if isinstance(self._definitions.interface(package, type_, folder), Interface):
                article = "an" if kind == "action" else "a"
                return f"it has {article} {kind} of this name"
        return None

    def of_package(
        self, missing: Missing, span: Span, *, required: bool = False, field: str | None = None
    ) -> None:
        """Report a missing package: a warning, or an error if a type of it is ``required``;
        ``field`` is one that only passes through, and cannot be used."""
        package = missing.package
        code = "ros-type-unknown" if required else "package-not-found"
        if (package, code) in self._reported:
            return
        self._reported.add((package, code))
        without = "its types are not known" if required else "its definitions are not checked"
        if field is not None:
            without = f"the field {field} is passed over"
        message = f"ROS package '{package}' is not found, so {without}"
        advice = install_advice(package)
        near = get_close_matches(package, self._definitions.packages.all(), n=1, cutoff=0.8)
        if near:
            advice = f"did you mean '{near[0]}'? if not, {advice}"
        self._report.add(code, span, message, advice)
