"""What can follow in the statements of robots and libraries."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from robosc.expr.types import Type
from robosc.language.events import EventKind
from robosc.language.keywords import NOTHING
from robosc.lsp.completion.candidates import (
    Candidate,
    Candidates,
    block_words,
    ends_operand,
    keywords,
)
from robosc.lsp.completion.snippets import SNIPPETS
from robosc.lsp.interfaces import offered_types
from robosc.model.file_resolver import FileContents

ALL_COMMANDS = Candidate("all", "keyword", "all commands of the robot", rank=2)
SENT = ("request", "cancel")
"""The events of what the controller sends."""


class StatementCandidates(Candidates):
    """What can begin a declaration, and follow the words of a statement."""

    def beginnings(self) -> Iterator[Candidate]:
        """What a declaration of the block can begin with, and whole declarations to fill in."""
        block = self.context.block.kind
        yield from keywords(block_words(block))
        for one in SNIPPETS.get(block, ()):
            yield Candidate(one.label, "snippet", one.meaning, one.text, rank=2)

    def statement(self) -> Iterator[Candidate]:
        match self.context.word(0):
            case "component":
                yield from self._import()
            case "requirement":
                yield from self._requirement()
            case "assume":
                yield from self._assumption()
            case "prefer":
                yield from self._preference()
            case "stop" if self.context.last == "stop":
                yield from keywords(("with",))
            case "stop":
                yield from self.communications(("request",))
                yield from (replace(word, rank=ALL_COMMANDS.rank) for word in keywords((NOTHING,)))
            case "provide":
                yield from self._provide()
            case "datatype":
                yield from self._datatype()
            case "interface":
                yield from self._interface()
            case "constant" | "parameter" | "condition" | "function":
                yield from self.value()

    def value(self) -> Iterator[Candidate]:
        """A constant, a parameter or a named condition."""
        words, last = self.context.words, self.context.last
        if last == ":":
            yield from self.types(variable=True)
            yield Candidate("duration", "keyword", "built-in type")
        elif last == "=":
            type_ = self.type_named(self.context.behind(":"))
            yield from self.expression(type_)
        elif "=" in words:
            yield from self.expression_or_more()
        elif ":" in words or self.context.word(0) == "condition":
            yield from keywords(("=",) if len(words) > 1 else ())

    def _import(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        if last == "from":
            for name in self.workspace.libraries(self.path):
                yield Candidate(name, "library")
        elif last == "import":
            library = self.context.behind("from")
            for contents in self._library(library):
                for name in contents.scope.components:
                    yield Candidate(name, "component", f"component of {library}", rank=0)
        elif len(words) == 2:
            yield from keywords(("from",))
        elif self.context.word(-2) == "from":
            yield from keywords(("import",))
        elif self.context.word(-2) == "import":
            yield Candidate("with prefix:", "keyword", text='with prefix: "')
            yield from self.next_declaration()
        elif last in ("with", ",") and "with" in words:
            if "prefix" not in words:
                yield Candidate("prefix:", "keyword", text='prefix: "', rank=0)
            yield from self._arguments()
        elif "with" in words:
            yield from self.next_declaration()

    def _arguments(self) -> Iterator[Candidate]:
        """What an import can set of a component: what it has not set yet."""
        words = self.context.words
        for contents in self._library(self.context.behind("from")):
            owner = contents.instances.get(self.context.behind("import"))
            for name in owner.types.values.settable if owner is not None else ():
                if name not in words[words.index("with") :]:
                    yield Candidate(f"{name}:", "constant", text=f"{name}: ")

    def _library(self, name: str) -> Iterator[FileContents]:
        """The libraries of a name among the files that may have to do with this one."""
        for file in self.workspace.all_files(self.path):
            analysis = self.workspace.analysis(file)
            contents = analysis.contents if analysis is not None else None
            if contents is not None and contents.scope.node.name.text == name:
                yield contents

    def _requirement(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        if len(words) == 1:
            yield from self.communications(SENT, rank=0)
            yield ALL_COMMANDS
            yield from keywords(("never", "always", "possible"))
            yield from self.expression(None)
            return
        if (
            "needs" not in words
            and "disables" not in words
            and self.context.word(1) not in ("never", "always", "possible")
        ):
            if ends_operand(last):
                yield from keywords(("needs", "disables"), rank=0)
                yield from keywords(("except",))
            if len(words) == 2:
                return
        elif last == "disables":
            yield from self.communications(SENT)
            yield ALL_COMMANDS
            return
        yield from self.expression_or_more()

    def _assumption(self) -> Iterator[Candidate]:
        words = self.context.words
        if len(words) == 1:
            yield from self.communications(("response",), rank=0)
            yield from keywords(("never", "always"))
        elif "needs" in words or self.context.word(1) in ("never", "always"):
            yield from self.expression_or_more()
        else:
            yield from keywords(("needs",), rank=0)

    def _preference(self) -> Iterator[Candidate]:
        if self.context.last in ("prefer", "over", "except"):
            yield from self.communications(SENT)
            yield ALL_COMMANDS
        elif "over" not in self.context.words:
            yield from keywords(("over", "except"))
        else:
            yield from keywords(("except",))
            yield from self.next_declaration()

    def _provide(self) -> Iterator[Candidate]:
        words = self.context.words
        if len(words) == 1:
            yield from self.communications(("request",))
        elif "with" not in words:
            yield from keywords(("with",))
        elif self.context.word(-1) == "with":
            yield Candidate("{ }", "keyword", text="{ $0 }")
            yield from self.expression(self.request(words[1 : words.index("with")]))
        elif "if" not in words and ends_operand(self.context.word(-1)):
            yield from keywords(("if",))
            yield from self.next_declaration()
        else:
            yield from self.expression_or_more()

    def _datatype(self) -> Iterator[Candidate]:
        words = self.context.words
        if len(words) == 1:
            yield from keywords(("object", "enum"))
        elif self.context.word(1) == "enum" and len(words) > 2:
            if self.context.word(-1) == "from":
                yield from self.types(sources=True)
            else:
                yield from keywords(("to",) if "from" in words else ("from",))

    def _interface(self) -> Iterator[Candidate]:
        words, last = self.context.words, self.context.last
        definitions = self.workspace.definitions(self.path)
        if last == "use":
            for package, type_, folder in offered_types(definitions):
                yield Candidate(
                    type_, "ROS type", f"{package} ({folder})", f"{type_} from {package}"
                )
        elif last == "from" and len(words) > 3:
            for package, type_, folder in offered_types(definitions):
                if type_ in (self.context.word(3), self.context.word(3).removesuffix("Action")):
                    yield Candidate(package, "ROS package", f"{type_}.{folder}", rank=0)
                else:
                    yield Candidate(package, "ROS package", rank=2)
        elif len(words) == 2:
            yield from keywords(("use",))
        elif len(words) == 4:
            yield from keywords(("from",))
        elif len(words) > 5:
            yield from self.next_declaration()

    def request(self, words: tuple[str, ...]) -> Type | None:
        info = self.communication_of(words)
        if info is None:
            *call, answer = (word for word in words if word != ".") if words else ("",)
            info = self.communication_of(tuple(call))
            if info is not None and answer == EventKind.PROGRESS.word:
                info = info.feedback_command()
        return info.sent if info is not None else None
