"""The server: requests of the protocol to what the other modules know.

Requests are answered in one thread. Reading a model takes some ten milliseconds, a long one up to a
second. So a text is read when no key comes for a moment, the longer it is the longer, a long one in
a thread of its own: completion answers meanwhile, from what is known so far, and other requests
about it wait until it is read. Synthesis is computed in a process
(:mod:`robosc.lsp.synthesis_process`).
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, BinaryIO

from lsprotocol import types

from robosc import errors, limits, pipeline
from robosc.lsp import hover, open_texts, positions, protocol, semantic_tokens
from robosc.lsp.actions import Edit, actions_for
from robosc.lsp.analysis import READING, Analysis, Workspace
from robosc.lsp.completion.complete import complete
from robosc.lsp.hover import hover_text, inlay_hints, keyword_hover, signature_at
from robosc.lsp.outline import folds, outline, symbols
from robosc.lsp.rename import RenameError, may_be_renamed, references, rename
from robosc.model.names.occurrences import Occurrence
from robosc.source import Source, Span
from robosc.syntax.formatting.format import format_text, format_tree


def serve(version: str, library_path: Sequence[str] = (), strict: bool = False) -> None:
    """Serve one client on standard input and output until it says that it has ended."""
    session = _Session(version, Workspace(list(library_path), strict))
    # pygls closes what it writes to; and whatever else might be printed must not get in between.
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    with contextlib.redirect_stdout(sys.stderr):
        session.serve(output)


class _Session:
    """The requests of one client."""

    def __init__(self, version: str, workspace: Workspace) -> None:
        self._workspace = workspace
        self._texts = open_texts.OpenTexts(version, workspace)
        self._register()

    def serve(self, output: BinaryIO) -> None:
        """Answer what comes from standard input until the client says that it has ended."""
        self._texts.server.start_io(stdout=output)

    def _register(self) -> None:
        handlers: dict[str, Callable[[Any], Any]] = {
            types.INITIALIZE: self._texts.initialize,
            types.INITIALIZED: self._texts.initialized,
            types.SHUTDOWN: self._texts.shutdown,
            types.TEXT_DOCUMENT_DID_OPEN: self._texts.opened,
            types.TEXT_DOCUMENT_DID_CHANGE: self._texts.changed,
            types.TEXT_DOCUMENT_DID_SAVE: self._texts.saved,
            types.TEXT_DOCUMENT_DID_CLOSE: self._texts.closed,
            types.WORKSPACE_DID_CHANGE_WATCHED_FILES: self._texts.files_changed,
            types.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS: self._texts.folders_changed,
            types.WORKSPACE_DID_CHANGE_CONFIGURATION: self._texts.configured,
            types.TEXT_DOCUMENT_FORMATTING: self._formatting,
            types.WORKSPACE_SYMBOL: self._workspace_symbols,
        }
        reading: dict[str, Callable[[Analysis, Any], Any]] = {
            types.TEXT_DOCUMENT_DOCUMENT_SYMBOL: self._symbols,
            types.TEXT_DOCUMENT_FOLDING_RANGE: self._folding,
            types.TEXT_DOCUMENT_HOVER: self._hover,
            types.TEXT_DOCUMENT_DEFINITION: self._of_name(self._definition),
            types.TEXT_DOCUMENT_REFERENCES: self._of_name(self._references),
            types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: self._of_name(self._highlight),
            types.TEXT_DOCUMENT_PREPARE_RENAME: self._of_name(self._prepare_rename),
            types.TEXT_DOCUMENT_INLAY_HINT: self._inlay_hints,
        }
        for name, handler in handlers.items():
            self._add(name, handler)
        for name, answer in reading.items():
            self._add_reading(name, answer)
        renaming = self._of_name(self._rename)
        self._add_reading(types.TEXT_DOCUMENT_RENAME, renaming, types.RenameOptions(True))
        self._add(
            types.TEXT_DOCUMENT_COMPLETION,
            self._completion,
            types.CompletionOptions(trigger_characters=[".", ":", ">", "=", " ", "{", "["]),
        )
        self._add_reading(
            types.TEXT_DOCUMENT_SIGNATURE_HELP,
            self._signature,
            types.SignatureHelpOptions(trigger_characters=["(", ","]),
        )
        self._add_reading(
            types.TEXT_DOCUMENT_CODE_ACTION,
            self._actions,
            types.CodeActionOptions([types.CodeActionKind.QuickFix]),
        )
        self._add_reading(
            types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL,
            self._tokens,
            protocol.legend(semantic_tokens.TYPES, semantic_tokens.MODIFIERS),
        )

    def _add(self, name: str, handler: Callable[[Any], Any], options: Any = None) -> None:
        def handle(params: Any) -> Any:  # pygls marks what it is given; methods cannot be marked
            return self._handled(handler, params)

        self._texts.server.feature(name, options)(handle)

    def _add_reading(
        self, name: str, handler: Callable[[Analysis, Any], Any], options: Any = None
    ) -> None:
        """A request that is answered from the text as it is; it can be cancelled until then."""

        def answer(params: Any) -> Any:
            analysis = self._workspace.analysis(protocol.path_of(params.text_document.uri))
            return None if analysis is None else handler(analysis, params)

        async def handle(params: Any) -> Any:
            await self._texts.read(protocol.path_of(params.text_document.uri))
            return self._handled(answer, params)

        self._texts.server.feature(name, options)(handle)

    def _of_name(
        self, handler: Callable[[Analysis, Occurrence, Any], Any]
    ) -> Callable[[Analysis, Any], Any]:
        """A request about the name at its position; None where there is none."""

        def answer(analysis: Analysis, params: Any) -> Any:
            found = analysis.index.at(self._offset(analysis.source, params.position))
            return None if found is None else handler(analysis, found, params)

        return answer

    def _handled(self, handler: Callable[[Any], Any], params: Any) -> Any:
        try:
            return handler(params)
        finally:
            self._texts.handled_at = asyncio.get_running_loop().time()

    @property
    def _encoding(self) -> positions.Encoding:
        return self._texts.encoding

    # --- requests about a document ---------------------------------------------------------------

    def _offset(self, source: Source, position: types.Position) -> int:
        return positions.offset_of(source, (position.line, position.character), self._encoding)

    def _symbols(self, analysis: Analysis, _: Any) -> list[types.DocumentSymbol]:
        return [protocol.document_symbol(entry, self._encoding) for entry in outline(analysis)]

    def _workspace_symbols(
        self, params: types.WorkspaceSymbolParams
    ) -> list[types.WorkspaceSymbol]:
        with pipeline.collector_at_rest():
            matching = symbols(self._workspace, params.query)
        return [protocol.workspace_symbol(one, self._encoding) for one in matching]

    def _folding(self, analysis: Analysis, _: Any) -> list[types.FoldingRange]:
        return [protocol.folding_range(fold) for fold in folds(analysis.source)]

    def _formatting(self, params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
        """None for a text with errors of syntax: it stays as it is."""
        path = protocol.path_of(params.text_document.uri)
        source = self._workspace.source(path)
        if source is None:
            return None
        try:
            with pipeline.collector_at_rest():
                text = self._formatted(path, source)
        except errors.ModelError:
            return None
        edit = _difference(source, text)
        return [protocol.text_edit(edit, self._encoding)] if edit is not None else []

    def _formatted(self, path: str, source: Source) -> str:
        """The text in canonical layout; its tree may be there already. Raises ModelError."""
        analysis = self._workspace.analysis(path) if self._workspace.is_known(path) else None
        if analysis is None or analysis.contents is None or analysis.contents.scope.faults:
            with READING:
                return format_text(source)
        node = analysis.contents.scope.node
        return format_tree(node.written or node)

    def _hover(self, analysis: Analysis, params: types.HoverParams) -> types.Hover | None:
        offset = self._offset(analysis.source, params.position)
        occurrence = analysis.index.at(offset)
        if occurrence is None:
            hover = keyword_hover(analysis.source, offset)
            return None if hover is None else protocol.hover(*hover, self._encoding)
        derived = self._texts.derived.get(analysis.path)
        if derived is not None and derived.source.text != analysis.source.text:
            derived = None
        text = hover_text(analysis, occurrence, derived)
        return protocol.hover(text, occurrence.span, self._encoding)

    def _signature(
        self, analysis: Analysis, params: types.SignatureHelpParams
    ) -> types.SignatureHelp | None:
        signature = signature_at(analysis, self._offset(analysis.source, params.position))
        return protocol.signature_help(signature) if signature is not None else None

    def _inlay_hints(
        self, analysis: Analysis, params: types.InlayHintParams
    ) -> list[types.InlayHint]:
        start = self._offset(analysis.source, params.range.start)
        end = self._offset(analysis.source, params.range.end)
        hints = inlay_hints(analysis, start, end)
        return [protocol.inlay_hint(span, text, self._encoding) for span, text in hints]

    def _definition(
        self, analysis: Analysis, occurrence: Occurrence, _: Any
    ) -> types.Location | None:
        span = hover.definition_of(analysis, occurrence)
        return protocol.location(span, self._encoding) if span is not None else None

    def _references(
        self, analysis: Analysis, occurrence: Occurrence, params: types.ReferenceParams
    ) -> list[types.Location]:
        declaration = params.context.include_declaration
        found = references(
            self._workspace, analysis.path, occurrence.symbol, declaration=declaration
        )
        return [protocol.location(o.span, self._encoding) for here in found.values() for o in here]

    def _highlight(
        self, analysis: Analysis, occurrence: Occurrence, _: Any
    ) -> list[types.DocumentHighlight]:
        kinds = types.DocumentHighlightKind
        return [
            types.DocumentHighlight(
                protocol.range_(o.span, self._encoding),
                kinds.Write if o.write or o.declaration else kinds.Read,
            )
            for o in analysis.index.of(occurrence.symbol)
        ]

    def _prepare_rename(
        self, analysis: Analysis, occurrence: Occurrence, _: Any
    ) -> types.Range | None:
        if not may_be_renamed(occurrence.symbol):
            return None
        return protocol.range_(occurrence.span, self._encoding)

    def _rename(
        self, analysis: Analysis, occurrence: Occurrence, params: types.RenameParams
    ) -> types.WorkspaceEdit:
        from pygls.exceptions import JsonRpcInvalidParams

        try:
            edits = rename(self._workspace, analysis.path, occurrence.symbol, params.new_name)
        except RenameError as error:
            raise JsonRpcInvalidParams(str(error)) from error
        return self._workspace_edit(edits)

    def _workspace_edit(self, edits: Mapping[str, Sequence[Edit]]) -> types.WorkspaceEdit:
        return types.WorkspaceEdit(
            {
                self._texts.uri(path): [protocol.text_edit(edit, self._encoding) for edit in here]
                for path, here in edits.items()
            }
        )

    def _completion(self, params: types.CompletionParams) -> types.CompletionList:
        path = protocol.path_of(params.text_document.uri)
        source = self._workspace.source(path)
        if source is None:
            return types.CompletionList(False, [])
        offset = self._offset(source, params.position)
        context = self._workspace.context(path, offset)
        start = context.start if context is not None else offset
        typed = source.text[start:offset].lstrip("^").casefold()
        snippets = self._has_snippets()
        candidates = complete(self._workspace, path, offset)
        candidates = [c for c in candidates if snippets or c.kind != "snippet"]
        if len(candidates) > limits.COMPLETIONS:
            candidates = [c for c in candidates if c.label.casefold().startswith(typed)]
        place = protocol.range_(Span(source, start, offset), self._encoding)
        return types.CompletionList(
            len(candidates) > limits.COMPLETIONS,
            [
                protocol.completion_item(c, place, snippets)
                for c in candidates[: limits.COMPLETIONS]
            ],
        )

    def _has_snippets(self) -> bool:
        document = self._texts.server.client_capabilities.text_document
        completion = document.completion if document is not None else None
        item = completion.completion_item if completion is not None else None
        return bool(item is not None and item.snippet_support)

    def _actions(
        self, analysis: Analysis, params: types.CodeActionParams
    ) -> list[types.CodeAction]:
        start = self._offset(analysis.source, params.range.start)
        end = self._offset(analysis.source, params.range.end)
        actions = []
        for diagnostic in self._texts.diagnostics(analysis):
            span = diagnostic.span
            if span.source is not analysis.source or span.start > end or span.end < start:
                continue
            for action in actions_for(analysis, diagnostic):
                shown = self._texts.shown(analysis, [diagnostic])
                actions.append(
                    types.CodeAction(
                        title=action.title,
                        kind=types.CodeActionKind.QuickFix,
                        diagnostics=shown,
                        edit=self._workspace_edit({analysis.path: action.edits}),
                    )
                )
        return actions

    def _tokens(self, analysis: Analysis, _: Any) -> types.SemanticTokens:
        return types.SemanticTokens(semantic_tokens.encoded(analysis, self._encoding))


def _difference(source: Source, text: str) -> Edit | None:
    """The lines that differ, as one edit; the cursor and folds elsewhere stay where they are."""
    if source.text == text:
        return None
    old, new = source.text.splitlines(keepends=True), text.splitlines(keepends=True)
    most = min(len(old), len(new))
    head = next((i for i in range(most) if old[i] != new[i]), most)
    most -= head
    tail = next((i for i in range(most) if old[-1 - i] != new[-1 - i]), most)
    start = sum(map(len, old[:head]))
    end = len(source.text) - sum(map(len, old[len(old) - tail :]))
    return Edit(Span(source, start, end), "".join(new[head : len(new) - tail]))
