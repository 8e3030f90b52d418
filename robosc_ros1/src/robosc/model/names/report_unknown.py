"""Diagnostics about unknown and ambiguous names in expressions."""

from __future__ import annotations

from collections.abc import Sequence

from robosc import errors, source
from robosc.expr.tree import Expr, Literal, ParameterRef, StateRef, VariableRef
from robosc.expr.types import EnumType, Type
from robosc.language.events import ACTIVE
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.names import tables
from robosc.remedies import Change, Hint, Remedy, meant, write, write_one
from robosc.syntax.nodes import Access, Name

_MEANINGS = (
    "component", "enum", "state", "variable", "condition", "constant", "parameter",
    "message", "service", "action", "transform",
)  # fmt: skip
"""Keywords of the declarations that a name in an expression may refer to."""
_NO_VALUE = "'%s' is a communication; conditions are about variables and states"
_KEEP = "store its value in a variable of its component"
_SELF = ("self", "this")
_MESSAGES = ("msg", "message")
_OF_STATES = ("state", "status", "mode")
"""How other languages name an object itself, a callback's message, and the state of a part."""


class NameFaults:
    """Reports unknown and ambiguous names of one place; unresolved names are not reported."""

    def __init__(
        self, report: Report, types: TypeTable, symbols: tables.SymbolTable | None
    ) -> None:
        self._report = report
        self._types = types
        self._symbols = symbols

    def unknown(self, access: Access, needed: Type | None = None) -> None:
        """Report a name without meaning; ``needed`` is the expected type, if there is one."""
        name = access.root.text
        scope = self._types.scope
        if scope.is_unresolved(name, *_MEANINGS) or (
            access.path and scope.is_unresolved(last_name(access))
        ):
            return
        if access.path:
            self._unknown_owner(access)
            return
        symbols = self._symbols
        if symbols is not None and (about := self._not_a_value(symbols, name)):
            self._report.add("unknown-name", access.span, *about)
            return
        if isinstance(needed, EnumType) and self._types.type_declarations.may_have(needed, name):
            return
        if isinstance(needed, EnumType):
            message = f"{needed.name} has no value '{name}'"
            candidates = list(needed.values)
            known_text = f"{needed.name} has"
        else:
            own = self._own
            message = f"unknown name '{name}'"
            members = own.members if own else ()
            candidates = [*members, *self._types.values.names, *self._types.enum_values()]
            if name.lower() in ("true", "false"):
                candidates.append(name.lower())
            known_text = "there are"
        hint = self._elsewhere(symbols, name) if symbols is not None else None
        hint = hint or self._report.suggest(name, candidates, known_text)
        self._report.add("unknown-name", access.span, message, hint)

    def unknown_pair(
        self, left: Access, meanings: Sequence[Expr], right: Access, others: Sequence[Expr]
    ) -> None:
        """Report what is unknown of two names that are compared, given their meanings."""
        component = self._symbols.component(left.root.text) if self._symbols else None
        if component is not None and not left.path and right.root.text in component.states:
            whole = source.Span(left.span.source, left.span.start, right.span.end)
            state = f"{left.root.text}.{right.root.text}"
            hint = write(f"!{state}" if "!=" in whole.text else state)
            message = f"'{left.root.text}' is a component and has no value of its own"
            self._report.add("unknown-name", whole, message, hint)
            return
        if not meanings:
            self.unknown(left, others[0].type if len(others) == 1 else None)
        if not others:
            self.unknown(right, meanings[0].type if len(meanings) == 1 else None)

    def _unknown_owner(self, access: Access) -> None:
        """Report a name before a dot that is no component and no enum."""
        symbols, name = self._symbols, access.root.text
        infos = symbols.communications(name) if symbols is not None else ()
        if infos:
            self.no_condition(access, infos[0])
        elif name in self._types.libraries:
            self._of_library(access, last_name(access))
        elif not self.is_foreign(access):
            known = [*(symbols.components if symbols else ()), *self._types.scope.datatypes]
            self._report.add(
                "unknown-name",
                access.root.span,
                f"there is no component or enum '{name}'",
                self._report.suggest(name, known),
            )

    def is_foreign(self, access: Access) -> bool:
        """Report ``self.front`` and ``msg.ranges``; whether it is one of them."""
        name = access.root.text
        known = self._symbols is not None and name in self._symbols.components
        if known or name not in (*_SELF, *_MESSAGES):
            return False
        span, hint = access.root.span, write("value", ", in a transition on the message")
        if name in _SELF:
            span, hint = access.span, write(access.span.text.removeprefix(f"{name}."))
        message = f"there is no component or enum '{name}'"
        self._report.add("unknown-name", span, message, hint)
        return True

    def _of_library(self, access: Access, member: str) -> None:
        """Report ``Library.name`` that is no constant, parameter or condition."""
        library, name = self._types.libraries[access.root.text], access.root.text
        enums = [f"{name}.{enum.name}.{member}" for enum in library.enums_with(member)]
        self._report.add(
            "unknown-name",
            access.span,
            f"library {name} has no constant, parameter or condition '{member}'",
            f"for the value of an enum write {member} or {enums[0]}"
            if enums
            else self._report.suggest(member, library.values.declared, "it has"),
        )

    def no_condition(self, access: Access, info: tables.CommunicationInfo) -> None:
        """Report ``scan.fresh`` of a message without timeout, or ``scan.ranges``."""
        phases = info.sort.phases
        message = _NO_VALUE % info.name
        hint: Hint = _KEEP
        if phases is not None and info.phases is None and last_name(access) in phases.names:
            neither = " nor ".join(reversed(phases.names))
            message = f"'{info.name}' is neither {neither}: it has no timeout"
            timeout = "timeout: 500 ms,"
            text = f"give {info.name} a '{timeout}'"
            hint = Remedy(text, Change.ADD_TIMEOUT, (info.name, timeout))
        elif info.phases is not None and last_name(access) in (*ACTIVE, "idle"):
            message = f"'{info.name}' is never {last_name(access)}"
            hint = f"it is {errors.listing(info.phases.names, 'or')}"
        elif info.phases is not None and not info.sort.phases_with_timeout:
            hint = write_one([f"{info.name}.{phase}" for phase in info.phases.names])
        self._report.add("unknown-name", access.span, message, hint)

    def no_parts(self, access: Access) -> None:
        """Report what stands behind a name that has no such parts."""
        root, first = access.root.text, access.path[0]
        if self._symbols is not None and self._symbols.is_broken(root):
            return
        if self._types.scope.is_unresolved(root):
            return
        component = self._symbols.component(root) if self._symbols else None
        if component is not None and isinstance(first, Name):
            info = component.communications.get(first.text)
            if info is not None:
                self.no_condition(access, info)
                return
        if self.is_foreign(access) or self._of_state(access, component):
            return
        if component is not None and isinstance(first, Name) and not component.member(first.text):
            self.unknown_member(access, first)
            return
        library = self._types.libraries.get(root)
        enum = library.known(first.text) if library and isinstance(first, Name) else None
        if isinstance(enum, EnumType) and isinstance(last := access.path[-1], Name):
            self.unknown_value(last, f"{root}.{enum.name}", enum)
            return
        part = access.path[1] if isinstance(first, Name) else first
        span = part.span if isinstance(part, Name) else access.span
        self._report.add("unknown-member", span, "only 'value', objects and arrays have parts")

    def _of_state(self, access: Access, component: tables.Instance | None) -> bool:
        """Report what is no part of a state; whether the names before it are those of one."""
        names = [access.root, *(step for step in access.path if isinstance(step, Name))]
        component, steps = (component, names[1:]) if component is not None else (self._own, names)
        if component is None or len(names) != 1 + len(access.path):
            return False
        for length in range(len(steps) - 1, 0, -1):
            path = component.state(".".join(step.text for step in steps[:length]))
            if path is not None and component.variables.get(path) is None:
                said = self._no_part_of_state(component, path, steps[length].text)
                self._report.add("unknown-member", steps[length].span, *said)
                return True
        return False

    def _no_part_of_state(
        self, component: tables.Instance, path: str, word: str
    ) -> tuple[str, Hint | None]:
        """What to say of a word behind the path of a state, and a remedy."""
        state = f"state '{component.name}.{path}'"
        inner = [other.name.text for other in component.states[path].states]
        if path not in component.performed:
            if not inner:
                return f"no state stands in {state}", None
            ends = [p for p in component.states if p.startswith(f"{path}.")]
            deeper = [p.removeprefix(f"{path}.") for p in ends if p.endswith(f".{word}")]
            hint = meant(deeper[0]) if len(deeper) == 1 else self._report.suggest(word, inner)
            return f"no state '{word}' stands in {state}", hint
        awaited = component.performed[path].is_awaited
        if word in (tables.PERFORMING, tables.WAITING, tables.RETRIES) and not awaited:
            return f"{state} is done when its command is sent", None
        if word == tables.RETRIES:
            return f"the errors of {state} are not counted", "write: retry 2 times else goto failed"
        if word == tables.WAITING:
            return f"{state} does not wait before it tries again", "write: retry every 5 s"
        stages = component.stages(path)
        return f"{state} has no stage '{word}'", self._report.suggest(word, stages, "it has")

    @property
    def _own(self) -> tables.Instance | None:
        return self._symbols.own if self._symbols else None

    def _not_a_value(
        self, symbols: tables.SymbolTable, name: str
    ) -> tuple[str, Hint | None] | None:
        component = symbols.component(name)
        if component is not None:
            members = [f"{name}.{m}" for m in component.members]
            return (
                f"'{name}' is a component and has no value of its own",
                self._report.suggest(name, members, "write one of"),
            )
        if symbols.communications(name):
            return _NO_VALUE % name, _KEEP
        return None

    def _elsewhere(self, symbols: tables.SymbolTable, name: str) -> Hint | None:
        owners = [c for c in symbols.components.values() if name in c.variables or name in c.states]
        return meant(f"{owners[0].name}.{name}") if len(owners) == 1 else None

    def unknown_member(self, access: Access, member: Name) -> None:
        """Report a member that the component or enum before the dot does not have."""
        root = access.root.text
        component = self._symbols.component(root) if self._symbols else None
        enum = self._types.enum(root)
        if component is None:
            assert enum is not None
            self.unknown_value(member, root, enum)
        elif self._types.scope.is_damaged(component.node.span):
            return
        elif heard := [
            f"{info.name}.{member.text}"
            for info in component.communications.values()
            if (phases := info.phases) is not None and member.text in phases.names
        ]:
            message = f"'{member.text}' is of a message or a call, not of its component"
            self._report.add("unknown-member", access.span, message, write_one(heard))
        elif member.text in component.communications:
            self._report.add("unknown-member", member.span, _NO_VALUE % member.text, _KEEP)
        elif member.text in _OF_STATES and component.states:
            message = f"{root} has no variable or state '{member.text}'"
            state = next(iter(component.states))
            hint = f"a state is a condition by itself, such as {root}.{state}"
            self._report.add("unknown-member", member.span, message, hint)
        else:
            self._report.add(
                "unknown-member",
                member.span,
                f"{root} has no variable or state '{member.text}'",
                self._report.suggest(
                    member.text, [*component.members, *component.types.values.declared]
                )
                if component.members
                else f"{root} has no behaviour",
            )

    def unknown_value(self, value: Name, name: str, enum: EnumType) -> None:
        """Report a value that an enum does not have; ``name`` is that of the enum at this place."""
        if not self._types.type_declarations.may_have(enum, value.text):
            self._report.add(
                "unknown-member",
                value.span,
                f"{name} has no value '{value.text}'",
                self._report.suggest(value.text, enum.values),
            )

    def ambiguous(self, access: Access, meanings: list[Expr]) -> None:
        """Report a name of which several meanings fit the expected type."""
        names = list(dict.fromkeys(_qualified_name(m) for m in meanings))
        self._report.add(
            "ambiguous-name",
            access.span,
            f"'{access.span.text or last_name(access)}' can mean several things here",
            write_one(names)
            if len(names) > 1
            else "it is a state and a boolean variable: give one of them another name",
        )


def last_name(access: Access) -> str:
    """The name behind the last dot."""
    last = access.path[-1] if access.path else access.root
    return last.text if isinstance(last, Name) else access.root.text


def _qualified_name(meaning: Expr) -> str:
    match meaning:
        case ParameterRef(parameter=parameter):
            return parameter.key
        case VariableRef(component=component, variable=name):
            return f"{component}.{name}"
        case StateRef(component=component, state=name):
            return f"{component}.{name}"
        case Literal(value=value, type=type_):
            return f"{type_}.{value}"
    return "value"
