"""What can stand behind a dot."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.expr.types import ArrayType, ObjectType, Type
from robosc.lsp.chains import names_before
from robosc.lsp.completion.candidates import Candidate, Candidates, keywords
from robosc.model.names.tables import Instance
from robosc.model.ros.interfaces import Missing

_NAMES_COMMANDS = {"provide", "requirement", "disables", "performs", "prefer", "over"}
"""What stands before the name of a command."""


class MemberCandidates(Candidates):
    """The members of components, libraries, enums, values and what else has any."""

    def behind_dot(self) -> Iterator[Candidate]:
        """Behind a dot."""
        chain = names_before(self.context.words)
        aggregates = dict(self.aggregates)
        while chain and chain[0] in aggregates:
            chain = aggregates.pop(chain[0]) + chain[1:]
        if not chain:
            return
        if chain[:1] == ["value"]:
            yield from self._parts(chain[1:])
            return
        if len(chain) != 1 and not (chain[1:] == ["[]"] and chain[0] in self.several):
            yield from self._further(chain)
            return
        if self.context.words[-3:-2] == ("/",):
            yield from self._constants(self.context.word(-4), chain[0])
            return
        yield from self._further(chain)
        statement = self.context.word(0)
        before = self.context.words[-3:-2]
        commands = before and before[0] in ("to", "from", "provide", "requirement", "disables")
        for owner in self.owners(chain[0]):
            if commands:
                for name, info in owner.communications.items():
                    yield Candidate(name, "communication", info.kind.value, rank=0)
            if not (commands and statement in ("on", "provide")):
                yield from self.behaviour_of(owner, owner.name)
        for contents in self.known:
            library = contents.types.libraries.get(chain[0])
            if library is not None:
                yield from self.named_values(library.values)
                for name in library.scope.datatypes:
                    yield Candidate(name, "enum" if library.enum(name) else "object", rank=0)
            enum = contents.types.enum(chain[0])
            yield from self.values(enum)

    def _in_state(self, owner: Instance, path: list[str]) -> Iterator[Candidate]:
        """The states in a state; the stages of one that performs a command, and its count."""
        place = owner.state(".".join(path))
        if place is None:
            return
        whole = f"{owner.name}.{place}"
        for inner in owner.states[place].states:
            yield Candidate(inner.name.text, "state", f"state in {whole}", rank=0)
        for word in owner.parts_of_performing(place):
            yield Candidate(word, "condition", f"of {whole}", rank=0)

    def _further(self, chain: list[str]) -> Iterator[Candidate]:
        """What only some names have behind them: parts, phases, constants of an interface, and the
        values of a library's enum."""
        first, *rest = chain
        for owner in self.owners(self.own):
            yield from self._parts_of(owner.variables.get(first), rest)
            yield from self._in_state(owner, chain)
        for owner in self.owners(first) if rest else ():
            yield from self._parts_of(owner.variables.get(rest[0]), rest[1:])
            yield from self._in_state(owner, rest)
        for info in self.infos():
            if chain not in ([info.name], [info.instance.name, info.name]):
                continue
            before = self.context.words[-3:-2] if len(chain) == 1 else self.context.words[-5:-4]
            if info.sort.served and {*before} & _NAMES_COMMANDS:
                yield from keywords((e.word for e in info.events if e.served), rank=0)
            elif info.phases is not None:
                yield from keywords(info.phases.names, rank=0)
            if info.sort.may_be_heard:
                yield from keywords(("heard",), rank=0)
        for contents in self.known:
            library = contents.types.libraries.get(first)
            if library is not None and len(rest) == 1:
                yield from self.values(library.enum(rest[0]))
            interface = contents.scope.interfaces.get(first)
            if interface is not None and not rest:
                yield from self._constants(interface.package.text, interface.type.text)

    def _constants(self, package: str, type_: str) -> Iterator[Candidate]:
        """The constants of a real definition."""
        for contents in self.known:
            found = contents.types.type_declarations.ros.constants(package, type_)
            if not isinstance(found, Missing):
                for name, value in found.items():
                    yield Candidate(name, "constant", repr(value), rank=0)

    def _parts(self, path: list[str]) -> Iterator[Candidate]:
        """The properties of what comes in."""
        return self._parts_of(self.incoming(), path)

    def _parts_of(self, type_: Type | None, path: list[str]) -> Iterator[Candidate]:
        """The properties of a part of a type."""
        for part in path:
            if part == "[]":
                type_ = type_.element if isinstance(type_, ArrayType) else None
            else:
                type_ = type_.property(part) if isinstance(type_, ObjectType) else None
        if isinstance(type_, ObjectType):
            for name, inner in type_.properties:
                yield Candidate(name, "property", str(inner), rank=0)
