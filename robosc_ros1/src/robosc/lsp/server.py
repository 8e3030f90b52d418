"""The server: requests of the protocol to what the other modules know.

Requests are answered in one thread. Reading a model takes some ten milliseconds, a long one up to
a second. So a text is read when no key comes for a moment, the longer it is the longer, a long one
in a thread of its own: completion answers meanwhile, from what is known so far, and other requests
about it wait until it is read. Synthesis is computed in a process (:mod:`robosc.lsp.derived`).
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from lsprotocol import types
from pygls.lsp.server import LanguageServer

from robosc.errors import Diagnostic, ModelError, sort_diagnostics
from robosc.lsp import tokens, wire
from robosc.lsp.actions import Edit, actions_for
from robosc.lsp.analysis import READING, Analysis, Desk
from robosc.lsp.completion import complete
from robosc.lsp.definition import definition_of
from robosc.lsp.derived import Derived, command, derived_from, moved, request_for
from robosc.lsp.hover import hover_text, keyword_hover
from robosc.lsp.outline import folds, outline, symbols
from robosc.lsp.positions import Encoding, offset_of
from robosc.lsp.rename import RenameError, may_be_renamed, references, rename
from robosc.model.occurrences import Occurrence
from robosc.pipeline import collector_at_rest
from robosc.resources import diagnostics_page
from robosc.source import Source, Span
from robosc.syntax.format import format_text, format_tree

__all__ = ["serve"]

_PAUSE = 0.05
_PAUSE_PER_CHARACTER = 1e-6
_LONGEST_PAUSE = 0.25
"""Seconds without a keystroke until diagnostics are told: who types on gets none in between."""

_QUIET = 0.03
"""Seconds after the last message: what waits to be read is read by then."""

_REST = 0.5
"""Seconds without a keystroke until synthesis begins."""

_PATIENCE = 300.0
"""Seconds after which a process is given up that has not given up by itself."""

_MOST_ITEMS = 200
"""Of more completions, the editor gets the first, and asks again when more of the word is typed."""

_WATCHED = ("**/*.{rscd,rsc,msg,srv,action}", "**/package.xml")


def serve(version: str, library_path: Sequence[str] = (), strict: bool = False) -> None:
    """Serve one client on standard input and output until it says that it has ended."""
    session = _Session(version, Desk(list(library_path), strict))
    # pygls closes what it writes to; and whatever else might be printed must not get in between.
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    with contextlib.redirect_stdout(sys.stderr):
        session.server.start_io(stdout=output)


class _Session:
    """One client."""

    def __init__(self, version: str, desk: Desk) -> None:
        self.server = LanguageServer(
            "robosc", version, text_document_sync_kind=types.TextDocumentSyncKind.Incremental
        )
        self._desk = desk
        self._given_path = tuple(desk.library_path)
        self._derived: dict[str, Derived] = {}
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._awaited: dict[str, asyncio.Future[None]] = {}
        self._runs: dict[str, asyncio.Task[None]] = {}
        self._reads: set[asyncio.Task[None]] = set()  # the loop itself keeps no task alive
        self._reader = ThreadPoolExecutor(1)
        self._handled_at = 0.0
        self._page = _installed_page()
        self._register()

    def _register(self) -> None:
        handlers: dict[str, Callable[[Any], Any]] = {
            types.INITIALIZE: self._initialize,
            types.INITIALIZED: self._initialized,
            types.SHUTDOWN: self._shutdown,
            types.TEXT_DOCUMENT_DID_OPEN: self._opened,
            types.TEXT_DOCUMENT_DID_CHANGE: self._changed,
            types.TEXT_DOCUMENT_DID_SAVE: self._saved,
            types.TEXT_DOCUMENT_DID_CLOSE: self._closed,
            types.WORKSPACE_DID_CHANGE_WATCHED_FILES: self._files_changed,
            types.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS: self._folders_changed,
            types.WORKSPACE_DID_CHANGE_CONFIGURATION: self._configured,
            types.TEXT_DOCUMENT_FORMATTING: self._formatting,
            types.WORKSPACE_SYMBOL: self._workspace_symbols,
        }
        reading: dict[str, Callable[[Any], Any]] = {
            types.TEXT_DOCUMENT_DOCUMENT_SYMBOL: self._symbols,
            types.TEXT_DOCUMENT_FOLDING_RANGE: self._folding,
            types.TEXT_DOCUMENT_HOVER: self._hover,
            types.TEXT_DOCUMENT_DEFINITION: self._definition,
            types.TEXT_DOCUMENT_REFERENCES: self._references,
            types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: self._highlight,
            types.TEXT_DOCUMENT_PREPARE_RENAME: self._prepare_rename,
        }
        for name, handler in handlers.items():
            self._add(name, handler)
        for name, handler in reading.items():
            self._add_reading(name, handler)
        self._add_reading(types.TEXT_DOCUMENT_RENAME, self._rename, types.RenameOptions(True))
        self._add(
            types.TEXT_DOCUMENT_COMPLETION,
            self._completion,
            types.CompletionOptions(trigger_characters=[".", ":", ">", "=", " ", "{", "["]),
        )
        self._add_reading(
            types.TEXT_DOCUMENT_CODE_ACTION,
            self._actions,
            types.CodeActionOptions([types.CodeActionKind.QuickFix]),
        )
        self._add_reading(
            types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL,
            self._tokens,
            wire.legend(tokens.TYPES, tokens.MODIFIERS),
        )

    def _add(self, name: str, handler: Callable[[Any], Any], options: Any = None) -> None:
        def handle(params: Any) -> Any:  # pygls marks what it is given; methods cannot be marked
            return self._handled(handler, params)

        self.server.feature(name, options)(handle)

    def _add_reading(self, name: str, handler: Callable[[Any], Any], options: Any = None) -> None:
        """A request that is answered from the text as it is; it can be cancelled until then."""

        async def handle(params: Any) -> Any:
            await self._read(wire.path_of(params.text_document.uri))
            return self._handled(handler, params)

        self.server.feature(name, options)(handle)

    def _handled(self, handler: Callable[[Any], Any], params: Any) -> Any:
        try:
            return handler(params)
        finally:
            self._handled_at = asyncio.get_running_loop().time()

    # --- the client and its files ----------------------------------------------------------------

    @property
    def _encoding(self) -> Encoding:
        chosen = self.server.server_capabilities.position_encoding
        value = getattr(chosen, "value", chosen)
        return "utf-8" if value == "utf-8" else "utf-32" if value == "utf-32" else "utf-16"

    def _initialize(self, params: types.InitializeParams) -> None:
        self._configure(params.initialization_options)

    def _initialized(self, params: types.InitializedParams) -> None:
        self._find_folders()
        watching = self.server.client_capabilities.workspace
        watching = watching.did_change_watched_files if watching is not None else None
        if watching is None or not watching.dynamic_registration:
            return
        watchers = [types.FileSystemWatcher(pattern) for pattern in _WATCHED]
        registration = types.Registration(
            "files",
            types.WORKSPACE_DID_CHANGE_WATCHED_FILES,
            types.DidChangeWatchedFilesRegistrationOptions(watchers),
        )
        self.server.client_register_capability(types.RegistrationParams([registration]))

    def _find_folders(self) -> None:
        folders = self.server.workspace.folders.values()
        roots = [wire.path_of(folder.uri) for folder in folders]
        if not roots and self.server.workspace.root_path:
            roots = [self.server.workspace.root_path]
        self._desk.folders = roots

    def _configured(self, params: types.DidChangeConfigurationParams) -> None:
        settings = params.settings
        if isinstance(settings, Mapping):
            self._configure(settings.get("robosc", settings))
            self._refresh()

    def _configure(self, options: Any) -> None:
        """``libraryPath``, ``strict`` and ``documentation``; others are as good as absent.

        Folders are relative to the workspace.
        """
        if not isinstance(options, Mapping):
            return
        folders = options.get("libraryPath")
        if isinstance(folders, list):
            self._find_folders()
            home = Path(*self._desk.folders[:1])
            more = [str(home / Path(f).expanduser()) for f in folders if isinstance(f, str)]
            self._desk.library_path = [*self._given_path, *more]
        if isinstance(options.get("strict"), bool):
            self._desk.strict = options["strict"]
        site = options.get("documentation")
        if isinstance(site, str):
            self._page = f"{site.rstrip('/')}/diagnostics/" if site else _installed_page()

    def _shutdown(self, params: None) -> None:
        for timer in self._timers.values():
            timer.cancel()
        for run in self._runs.values():
            run.cancel()

    def _opened(self, params: types.DidOpenTextDocumentParams) -> None:
        self._take(params.text_document.uri, 0.0)

    def _changed(self, params: types.DidChangeTextDocumentParams) -> None:
        self._take(params.text_document.uri, _REST)

    def _saved(self, params: types.DidSaveTextDocumentParams) -> None:
        self._refresh()

    def _files_changed(self, params: types.DidChangeWatchedFilesParams) -> None:
        self._refresh()

    def _folders_changed(self, params: types.DidChangeWorkspaceFoldersParams) -> None:
        self._refresh()

    def _refresh(self) -> None:
        self._find_folders()
        self._desk.refresh()
        for path in self._desk.open:
            self._schedule(path, 0.0)

    def _closed(self, params: types.DidCloseTextDocumentParams) -> None:
        path = wire.path_of(params.text_document.uri)
        self._stop(path)
        self._release(path)
        self._derived.pop(path, None)
        self._desk.close(path)
        self.server.text_document_publish_diagnostics(
            types.PublishDiagnosticsParams(params.text_document.uri, [])
        )
        self._schedule_changed()  # what was not saved counts no longer

    def _take(self, uri: str, rest: float) -> None:
        path = wire.path_of(uri)
        self._desk.put(path, self.server.workspace.get_text_document(uri).source)
        self._schedule_changed()
        self._schedule(path, rest)

    def _schedule_changed(self) -> None:
        """Those about which there is something else to say now."""
        for path in self._desk.open:
            if not self._desk.is_known(path):
                self._schedule(path, _REST)

    # --- diagnostics -----------------------------------------------------------------------------

    def _schedule(self, path: str, rest: float) -> None:
        """Tell diagnostics soon, and what synthesis finds later."""
        self._stop(path)
        loop = asyncio.get_running_loop()
        source = self._desk.source(path)
        length = len(source.text) if source is not None else 0
        pause = min(_PAUSE + length * _PAUSE_PER_CHARACTER, _LONGEST_PAUSE)
        self._timers[path] = loop.call_later(pause, self._read_when_quiet, path)
        self._awaited.setdefault(path, loop.create_future())
        self._runs[path] = loop.create_task(self._derive(path, rest))

    def _stop(self, path: str) -> None:
        timer, run = self._timers.pop(path, None), self._runs.pop(path, None)
        if timer is not None:
            timer.cancel()
        if run is not None:
            run.cancel()

    async def _read(self, path: str) -> None:
        """Return when a long text that is open was read; at once for any other."""
        while self._desk.is_long(path) and not self._desk.is_known(path) and path in self._awaited:
            await asyncio.shield(self._awaited[path])

    def _read_when_quiet(self, path: str) -> None:
        """Tell diagnostics, unless there may be more to do first.

        While a request is worked on the pause goes by, and further keys wait to be read.
        """
        loop = asyncio.get_running_loop()
        rest = self._handled_at + _QUIET - loop.time()
        if rest > 0:
            self._timers[path] = loop.call_later(rest, self._read_when_quiet, path)
        elif self._desk.is_long(path) and not self._desk.is_known(path):
            read = loop.create_task(self._read_aside(path))
            self._reads.add(read)
            read.add_done_callback(self._reads.discard)
        else:
            self._tell(path)

    async def _read_aside(self, path: str) -> None:
        """Read a long text while requests are answered; what comes too late is forgotten.

        Whatever changes meanwhile has set a timer, after which the text is read again.
        """
        desk = self._desk
        source, revision = desk.source(path), desk.revision
        assert source is not None
        is_first = desk.recent(path) is None
        loop = asyncio.get_running_loop()
        try:
            found = await loop.run_in_executor(self._reader, self._analysed, source)
        except Exception:
            self._release(path)
            raise
        if found is not None:
            desk.adopt(found, revision)
        if desk.is_known(path):
            self._tell(path)
            if is_first:  # so that the first key need not find its way through all of the text
                desk.context(path, len(source.text))

    def _analysed(self, source: Source) -> Analysis | None:
        """What is known of a text; None if it was changed or read before its turn came."""
        if self._desk.source(source.path) is not source or self._desk.is_known(source.path):
            return None
        with collector_at_rest():
            return self._desk.analyse(source)

    def _release(self, path: str) -> None:
        """Requests that wait for a text go on."""
        if (waiting := self._awaited.pop(path, None)) is not None:
            waiting.set_result(None)

    def _tell(self, path: str) -> None:
        try:
            with collector_at_rest():
                analysis = self._desk.analysis(path)
        finally:
            self._release(path)
        if analysis is None or path not in self._desk.open:
            return
        uri = self._uri(path)
        self.server.text_document_publish_diagnostics(
            types.PublishDiagnosticsParams(
                uri,
                self._shown(analysis, self._diagnostics(analysis)),
                version=self.server.workspace.get_text_document(uri).version,
            )
        )

    def _uri(self, path: str) -> str:
        """The URI as the client has written it."""
        documents = self.server.workspace.text_documents.values()  # its keys are rewritten
        return next((d.uri for d in documents if wire.path_of(d.uri) == path), wire.uri_of(path))

    def _diagnostics(self, analysis: Analysis) -> list[Diagnostic]:
        derived = self._derived.get(analysis.path)
        if derived is None or analysis.reading.robot is None:
            return sort_diagnostics(analysis.diagnostics)
        return sort_diagnostics([*analysis.diagnostics, *moved(derived, analysis.source)])

    def _shown(
        self, analysis: Analysis, diagnostics: Sequence[Diagnostic]
    ) -> list[types.Diagnostic]:
        return wire.diagnostics_for(analysis.source, diagnostics, self._encoding, self._page)

    async def _derive(self, path: str, rest: float) -> None:
        """Ask a process of its own for what synthesis finds; cancelled when the text changes."""
        await asyncio.sleep(rest)
        await self._read(path)
        analysis = self._desk.analysis(path)
        if analysis is None or analysis.reading.robot is None:
            return
        source = analysis.source
        texts = {p: self._text(p) for p in self._desk.open if p != path}
        request = request_for(source, self._desk.library_path, texts)
        answer = await _run(request)
        derived = derived_from(source, answer) if answer is not None else None
        if derived is None:
            self._log(f"{path}: no answer from synthesis")
            return
        self._derived[path] = derived
        self._tell(path)

    def _text(self, path: str) -> str:
        source = self._desk.source(path)
        return source.text if source is not None else ""

    def _log(self, message: str) -> None:
        self.server.window_log_message(types.LogMessageParams(types.MessageType.Info, message))

    # --- requests about a document ---------------------------------------------------------------

    def _analysis(self, params: Any) -> Analysis | None:
        return self._desk.analysis(wire.path_of(params.text_document.uri))

    def _offset(self, source: Source, position: types.Position) -> int:
        return offset_of(source, (position.line, position.character), self._encoding)

    def _named(self, params: Any) -> tuple[Analysis, Occurrence] | None:
        """The name at the position of a request."""
        analysis = self._analysis(params)
        if analysis is None:
            return None
        found = analysis.index.at(self._offset(analysis.source, params.position))
        return (analysis, found) if found is not None else None

    def _symbols(self, params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
        analysis = self._analysis(params)
        entries = outline(analysis) if analysis is not None else ()
        return [wire.document_symbol(entry, self._encoding) for entry in entries]

    def _workspace_symbols(
        self, params: types.WorkspaceSymbolParams
    ) -> list[types.WorkspaceSymbol]:
        with collector_at_rest():
            found = symbols(self._desk, params.query)
        return [wire.workspace_symbol(one, self._encoding) for one in found]

    def _folding(self, params: types.FoldingRangeParams) -> list[types.FoldingRange]:
        analysis = self._analysis(params)
        found = folds(analysis.source) if analysis is not None else []
        return [wire.folding_range(fold) for fold in found]

    def _formatting(self, params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
        """None for a text with errors of syntax: it stays as it is."""
        path = wire.path_of(params.text_document.uri)
        source = self._desk.source(path)
        if source is None:
            return None
        try:
            with collector_at_rest():
                text = self._formatted(path, source)
        except ModelError:
            return None
        edit = _difference(source, text)
        return [wire.text_edit(edit, self._encoding)] if edit is not None else []

    def _formatted(self, path: str, source: Source) -> str:
        """The text in canonical layout; its tree may be there already. Raises ModelError."""
        analysis = self._desk.analysis(path) if self._desk.is_known(path) else None
        if analysis is None or analysis.contents is None or analysis.contents.scope.faults:
            with READING:
                return format_text(source)
        node = analysis.contents.scope.node
        return format_tree(node.written or node)

    def _hover(self, params: types.HoverParams) -> types.Hover | None:
        named = self._named(params)
        if named is None:
            return self._keyword_hover(params)
        analysis, found = named
        derived = self._derived.get(analysis.path)
        if derived is not None and derived.source.text != analysis.source.text:
            derived = None
        return wire.hover(hover_text(analysis, found, derived), found.span, self._encoding)

    def _keyword_hover(self, params: types.HoverParams) -> types.Hover | None:
        source = self._desk.source(wire.path_of(params.text_document.uri))
        found = keyword_hover(source, self._offset(source, params.position)) if source else None
        return wire.hover(*found, self._encoding) if found is not None else None

    def _definition(self, params: types.DefinitionParams) -> types.Location | None:
        named = self._named(params)
        span = definition_of(*named) if named is not None else None
        return wire.location(span, self._encoding) if span is not None else None

    def _references(self, params: types.ReferenceParams) -> list[types.Location]:
        named = self._named(params)
        if named is None:
            return []
        analysis, found = named
        by_file = references(
            self._desk,
            analysis.path,
            found.symbol,
            declaration=params.context.include_declaration,
        )
        return [wire.location(o.span, self._encoding) for here in by_file.values() for o in here]

    def _highlight(self, params: types.DocumentHighlightParams) -> list[types.DocumentHighlight]:
        named = self._named(params)
        if named is None:
            return []
        analysis, found = named
        kinds = types.DocumentHighlightKind
        return [
            types.DocumentHighlight(
                wire.range_(o.span, self._encoding),
                kinds.Write if o.write or o.declaration else kinds.Read,
            )
            for o in analysis.index.of(found.symbol)
        ]

    def _prepare_rename(self, params: types.PrepareRenameParams) -> types.Range | None:
        named = self._named(params)
        if named is None or not may_be_renamed(named[1].symbol):
            return None
        return wire.range_(named[1].span, self._encoding)

    def _rename(self, params: types.RenameParams) -> types.WorkspaceEdit | None:
        from pygls.exceptions import JsonRpcInvalidParams

        named = self._named(params)
        if named is None:
            return None
        analysis, found = named
        try:
            edits = rename(self._desk, analysis.path, found.symbol, params.new_name)
        except RenameError as error:
            raise JsonRpcInvalidParams(str(error)) from error
        return self._workspace_edit(edits)

    def _workspace_edit(self, edits: Mapping[str, Sequence[Edit]]) -> types.WorkspaceEdit:
        return types.WorkspaceEdit(
            {
                self._uri(path): [wire.text_edit(edit, self._encoding) for edit in here]
                for path, here in edits.items()
            }
        )

    def _completion(self, params: types.CompletionParams) -> types.CompletionList:
        path = wire.path_of(params.text_document.uri)
        source = self._desk.source(path)
        if source is None:
            return types.CompletionList(False, [])
        offset = self._offset(source, params.position)
        context = self._desk.context(path, offset)
        start = context.start if context is not None else offset
        typed = source.text[start:offset].lstrip("^").casefold()
        snippets = self._has_snippets()
        found = [c for c in complete(self._desk, path, offset) if snippets or c.kind != "snippet"]
        if len(found) > _MOST_ITEMS:
            found = [c for c in found if c.label.casefold().startswith(typed)]
        place = wire.range_(Span(source, start, offset), self._encoding)
        return types.CompletionList(
            len(found) > _MOST_ITEMS,
            [wire.completion_item(c, place, snippets) for c in found[:_MOST_ITEMS]],
        )

    def _has_snippets(self) -> bool:
        document = self.server.client_capabilities.text_document
        completion = document.completion if document is not None else None
        item = completion.completion_item if completion is not None else None
        return bool(item is not None and item.snippet_support)

    def _actions(self, params: types.CodeActionParams) -> list[types.CodeAction]:
        analysis = self._analysis(params)
        if analysis is None:
            return []
        start = self._offset(analysis.source, params.range.start)
        end = self._offset(analysis.source, params.range.end)
        found = []
        for diagnostic in self._diagnostics(analysis):
            span = diagnostic.span
            if span.source is not analysis.source or span.start > end or span.end < start:
                continue
            for action in actions_for(analysis, diagnostic):
                shown = self._shown(analysis, [diagnostic])
                found.append(
                    types.CodeAction(
                        title=action.title,
                        kind=types.CodeActionKind.QuickFix,
                        diagnostics=shown,
                        edit=self._workspace_edit({analysis.path: action.edits}),
                    )
                )
        return found

    def _tokens(self, params: types.SemanticTokensParams) -> types.SemanticTokens:
        analysis = self._analysis(params)
        data = tokens.encoded(analysis, self._encoding) if analysis is not None else []
        return types.SemanticTokens(data)


def _installed_page() -> str | None:
    """The address of the page that explains the codes of diagnostics."""
    page = diagnostics_page()
    return page.as_uri() if page is not None else None


async def _run(request: bytes) -> bytes | None:
    """The answer of the process for synthesis; None if it fails or takes too long."""
    process = await asyncio.create_subprocess_exec(
        *command(),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
    )
    try:
        answer, _ = await asyncio.wait_for(process.communicate(request), _PATIENCE)
    except (TimeoutError, OSError):
        return None
    finally:
        if process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
    return answer


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
