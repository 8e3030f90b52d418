"""Name resolution of the targets of assignments: variables of the same component."""

from __future__ import annotations

from robosc.model.diagnostics import Report, first_of
from robosc.model.names.tables import Instance, SymbolTable
from robosc.model.typing.value_word import is_value
from robosc.syntax.nodes import Access, Name


class Targets:
    """Resolves the targets of assignments in one component."""

    def __init__(self, instance: Instance, symbols: SymbolTable, report: Report) -> None:
        self._instance = instance
        self._symbols = symbols
        self._report = report

    def resolve(self, access: Access) -> str | None:
        """The name of the variable that is assigned; None after a reported error."""
        own, root = self._instance, access.root.text
        self._record(access)
        if is_value(access):
            self._not_assignable(access, "'value' is the received value")
        elif not access.path:
            if root in own.variables:
                return root
            self._unknown_target(access)
        elif len(access.path) == 1 and isinstance(member := access.path[0], Name):
            component = self._symbols.component(root)
            if component is own and member.text in own.variables:
                return member.text
            self._foreign_target(access, component, member)
        else:
            self._not_assignable(access, "variables have no parts")
        return None

    def _record(self, access: Access) -> None:
        names = self._instance.types.scope.names
        owner, last = self._instance, access.root
        if access.path and isinstance(access.path[0], Name):
            component = self._symbols.component(access.root.text)
            if component is None:
                return
            owner, last = component, access.path[0]
            names.use(access.root, owner.declaration)
        names.use(last, owner.member(last.text), owner.name, write=True)

    def _not_assignable(self, access: Access, why: str) -> None:
        variables = first_of(self._instance.variables)
        self._report.add(
            "not-assignable",
            access.span,
            f"only variables can be assigned: {why}",
            f"{self._instance.name} has the variables: {variables}" if variables else None,
        )

    def _unknown_target(self, access: Access) -> None:
        own, name = self._instance, access.root.text
        if own.types.scope.is_unresolved(name, "variable"):
            return
        if name in own.states:
            self._not_assignable(access, f"'{name}' is a state; use goto")
        elif self._symbols.component(name) is not None:
            self._not_assignable(access, f"'{name}' is a component")
        elif name in own.communications:
            self._not_assignable(access, f"'{name}' is a communication")
        else:
            self._report.add(
                "unknown-name",
                access.span,
                f"{own.name} has no variable '{name}'",
                self._report.suggest(name, own.variables, "its variables"),
            )

    def _foreign_target(self, access: Access, component: Instance | None, member: Name) -> None:
        root = access.root.text
        scope = self._instance.types.scope
        if component is None:
            if self._symbols.is_broken(root) or scope.is_unresolved(root, "component"):
                return
            known = list(self._symbols.components)
            self._report.add(
                "unknown-name",
                access.root.span,
                f"there is no component '{root}'",
                self._report.suggest(root, known),
            )
        elif member.text in component.variables:
            self._report.add(
                "foreign-assignment",
                access.span,
                f"{self._instance.name} cannot assign a variable of {component.name}",
                f"let {component.name} react to the same event",
            )
        elif member.text in component.states:
            self._not_assignable(access, f"'{access.span.text}' is a state")
        elif not scope.is_unresolved(member.text, "variable"):
            self._report.add(
                "unknown-member",
                member.span,
                f"{root} has no variable '{member.text}'",
                self._report.suggest(member.text, component.variables, "its variables"),
            )
