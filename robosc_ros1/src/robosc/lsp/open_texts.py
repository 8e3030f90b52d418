"""Texts that a client has open: read after a pause, and their diagnostics published.

Reading a model takes some ten milliseconds, a long one up to a second. So a text is read when no
key comes for a moment, the longer it is the longer, a long one in a thread of its own. Synthesis is
computed in a process (:mod:`robosc.lsp.synthesis_process`).
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol

from robosc import errors, limits, pipeline, resources
from robosc.lazy_dataclasses import dataclass
from robosc.lsp import positions, protocol
from robosc.lsp.analysis import Analysis, Workspace
from robosc.lsp.synthesis_process import Derived, command, derived_from, moved, request_for
from robosc.source import Source

# The protocol as pygls has it, but for requests that are faulty or refused. pygls answers no
# request whose parameters it cannot read, and none for an unknown method without any (see
# findings/pygls_unanswered_requests.sh), and writes a traceback for each request that is refused. A
# client waits for every answer, and a refusal is none of the server's faults.


_LOG = logging.getLogger("pygls.protocol.json_rpc")


@dataclass(frozen=True)
class _Unreadable:
    """A message whose parameters are not those of its method; ``id`` is None for notifications."""

    id: Any
    method: str


class Protocol(LanguageServerProtocol):  # type: ignore[misc]  # pygls is not there for mypy
    """Answers each request, a faulty one with an error."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        _LOG.addFilter(_is_no_refusal)

    def structure_message(self, data: dict[str, Any]) -> Any:
        """What was received, as an object of its type."""
        if "jsonrpc" not in data or "method" not in data:
            return super().structure_message(data)
        try:
            _LOG.addFilter(_is_nothing)  # it would write the traceback before it raises
            return super().structure_message({"params": None, **data})  # JSON-RPC may omit them
        except JsonRpcInvalidParams:
            return _Unreadable(data.get("id"), str(data["method"]))
        finally:
            _LOG.removeFilter(_is_nothing)

    def handle_message(self, message: Any) -> None:
        if not isinstance(message, _Unreadable):
            super().handle_message(message)
            return
        text = f"{message.method}: its parameters are missing or of another form"
        if message.id is None:
            _LOG.warning("%s", text)
        else:
            self._send_response(message.id, error=JsonRpcInvalidParams(text).to_response_error())


def _is_nothing(record: logging.LogRecord) -> bool:
    return False


def _is_no_refusal(record: logging.LogRecord) -> bool:
    return record.exc_info is None or not isinstance(record.exc_info[1], JsonRpcInvalidParams)


_PAUSE = 0.05
_PAUSE_PER_CHARACTER = 1e-6
_LONGEST_PAUSE = 0.25
"""Seconds without a keystroke until diagnostics are sent: who types on gets none in between."""

_QUIET = 0.03
"""Seconds after the last message: what waits to be read is read by then."""

_REST = 0.5
"""Seconds without a keystroke until synthesis begins."""


_WATCHED = ("**/*.{rscd,rsc,msg,srv,action}", "**/package.xml")


class OpenTexts:
    """The files of one client, and what the server sends about them without being asked."""

    def __init__(self, version: str, workspace: Workspace) -> None:
        self.server = LanguageServer(
            "robosc",
            version,
            text_document_sync_kind=types.TextDocumentSyncKind.Incremental,
            protocol_cls=Protocol,
        )
        self._workspace = workspace
        self._given_path = tuple(workspace.library_path)
        self.derived: dict[str, Derived] = {}
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._awaited: dict[str, asyncio.Future[None]] = {}
        self._runs: dict[str, asyncio.Task[None]] = {}
        self._reads: set[asyncio.Task[None]] = set()  # the loop itself keeps no task alive
        self._reader = ThreadPoolExecutor(1)
        self.handled_at = 0.0
        self._page = _installed_page()

    # --- the client and its files ----------------------------------------------------------------

    @property
    def encoding(self) -> positions.Encoding:
        chosen = self.server.server_capabilities.position_encoding
        value = getattr(chosen, "value", chosen)
        return "utf-8" if value == "utf-8" else "utf-32" if value == "utf-32" else "utf-16"

    def initialize(self, params: types.InitializeParams) -> None:
        self._configure(params.initialization_options)

    def initialized(self, params: types.InitializedParams) -> None:
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
        roots = [protocol.path_of(folder.uri) for folder in folders]
        if not roots and self.server.workspace.root_path:
            roots = [self.server.workspace.root_path]
        self._workspace.folders = roots

    def configured(self, params: types.DidChangeConfigurationParams) -> None:
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
            home = Path(*self._workspace.folders[:1])
            more = [str(home / Path(f).expanduser()) for f in folders if isinstance(f, str)]
            self._workspace.library_path = [*self._given_path, *more]
        if isinstance(options.get("strict"), bool):
            self._workspace.strict = options["strict"]
        site = options.get("documentation")
        if isinstance(site, str):
            self._page = f"{site.rstrip('/')}/diagnostics/" if site else _installed_page()

    def shutdown(self, params: None) -> None:
        for timer in self._timers.values():
            timer.cancel()
        for run in self._runs.values():
            run.cancel()

    def opened(self, params: types.DidOpenTextDocumentParams) -> None:
        self._take(params.text_document.uri, 0.0)

    def changed(self, params: types.DidChangeTextDocumentParams) -> None:
        self._take(params.text_document.uri, _REST)

    def saved(self, params: types.DidSaveTextDocumentParams) -> None:
        self._refresh()

    def files_changed(self, params: types.DidChangeWatchedFilesParams) -> None:
        self._refresh()

    def folders_changed(self, params: types.DidChangeWorkspaceFoldersParams) -> None:
        self._refresh()

    def _refresh(self) -> None:
        self._find_folders()
        self._workspace.refresh()
        for path in self._workspace.open:
            self._schedule(path, 0.0)

    def closed(self, params: types.DidCloseTextDocumentParams) -> None:
        path = protocol.path_of(params.text_document.uri)
        self._stop(path)
        self._release(path)
        self.derived.pop(path, None)
        self._workspace.close(path)
        self.server.text_document_publish_diagnostics(
            types.PublishDiagnosticsParams(params.text_document.uri, [])
        )
        self._schedule_changed()  # what was not saved counts no longer

    def _take(self, uri: str, rest: float) -> None:
        path = protocol.path_of(uri)
        self._workspace.put(path, self.server.workspace.get_text_document(uri).source)
        self._schedule_changed()
        self._schedule(path, rest)

    def _schedule_changed(self) -> None:
        """Those about which there is something else to say now."""
        for path in self._workspace.open:
            if not self._workspace.is_known(path):
                self._schedule(path, _REST)

    # --- diagnostics -----------------------------------------------------------------------------

    def _schedule(self, path: str, rest: float) -> None:
        """Tell diagnostics soon, and what synthesis finds later."""
        self._stop(path)
        loop = asyncio.get_running_loop()
        source = self._workspace.source(path)
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

    async def read(self, path: str) -> None:
        """Return when a long text that is open was read; at once for any other."""
        while (
            self._workspace.is_long(path)
            and not self._workspace.is_known(path)
            and path in self._awaited
        ):
            await asyncio.shield(self._awaited[path])

    def _read_when_quiet(self, path: str) -> None:
        """Tell diagnostics, unless there may be more to do first.

        While a request is worked on the pause goes by, and further keys wait to be read.
        """
        loop = asyncio.get_running_loop()
        rest = self.handled_at + _QUIET - loop.time()
        if rest > 0:
            self._timers[path] = loop.call_later(rest, self._read_when_quiet, path)
        elif self._workspace.is_long(path) and not self._workspace.is_known(path):
            read = loop.create_task(self._read_aside(path))
            self._reads.add(read)
            read.add_done_callback(self._reads.discard)
        else:
            self._tell(path)

    async def _read_aside(self, path: str) -> None:
        """Read a long text while requests are answered; what comes too late is forgotten.

        Whatever changes meanwhile has set a timer, after which the text is read again.
        """
        workspace = self._workspace
        source, revision = workspace.source(path), workspace.revision
        assert source is not None
        is_first = workspace.recent(path) is None
        loop = asyncio.get_running_loop()
        try:
            found = await loop.run_in_executor(self._reader, self._analysed, source)
        except Exception:
            self._release(path)
            raise
        if found is not None:
            workspace.adopt(found, revision)
        if workspace.is_known(path):
            self._tell(path)
            if is_first:  # so that the first key need not find its way through all of the text
                workspace.context(path, len(source.text))

    def _analysed(self, source: Source) -> Analysis | None:
        """What is known of a text; None if it was changed or read before its turn came."""
        if self._workspace.source(source.path) is not source or self._workspace.is_known(
            source.path
        ):
            return None
        with pipeline.collector_at_rest():
            return self._workspace.analyse(source)

    def _release(self, path: str) -> None:
        """Requests that wait for a text go on."""
        if (waiting := self._awaited.pop(path, None)) is not None:
            waiting.set_result(None)

    def _tell(self, path: str) -> None:
        try:
            with pipeline.collector_at_rest():
                analysis = self._workspace.analysis(path)
        finally:
            self._release(path)
        if analysis is None or path not in self._workspace.open:
            return
        uri = self.uri(path)
        self.server.text_document_publish_diagnostics(
            types.PublishDiagnosticsParams(
                uri,
                self.shown(analysis, self.diagnostics(analysis)),
                version=self.server.workspace.get_text_document(uri).version,
            )
        )

    def uri(self, path: str) -> str:
        """The URI as the client has written it."""
        documents = self.server.workspace.text_documents.values()  # its keys are rewritten
        return next(
            (d.uri for d in documents if protocol.path_of(d.uri) == path), protocol.uri_of(path)
        )

    def diagnostics(self, analysis: Analysis) -> list[errors.Diagnostic]:
        derived = self.derived.get(analysis.path)
        if derived is None or analysis.reading.robot is None:
            return errors.sort_diagnostics(analysis.diagnostics)
        return errors.sort_diagnostics([*analysis.diagnostics, *moved(derived, analysis.source)])

    def shown(
        self, analysis: Analysis, diagnostics: Sequence[errors.Diagnostic]
    ) -> list[types.Diagnostic]:
        return protocol.diagnostics_for(analysis.source, diagnostics, self.encoding, self._page)

    async def _derive(self, path: str, rest: float) -> None:
        """Ask a process of its own for what synthesis finds; cancelled when the text changes."""
        await asyncio.sleep(rest)
        await self.read(path)
        analysis = self._workspace.analysis(path)
        if analysis is None or analysis.reading.robot is None:
            return
        source = analysis.source
        texts = {p: self._text(p) for p in self._workspace.open if p != path}
        request = request_for(source, self._workspace.library_path, texts)
        answer = await _run(request)
        derived = derived_from(source, answer) if answer is not None else None
        if derived is None:
            self._log(f"{path}: no answer from synthesis")
            return
        self.derived[path] = derived
        self._tell(path)

    def _text(self, path: str) -> str:
        source = self._workspace.source(path)
        return source.text if source is not None else ""

    def _log(self, message: str) -> None:
        self.server.window_log_message(types.LogMessageParams(types.MessageType.Info, message))


def _installed_page() -> str | None:
    """The address of the page that explains the codes of diagnostics."""
    page = resources.diagnostics_page()
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
        answer, _ = await asyncio.wait_for(process.communicate(request), limits.EDITOR_SECONDS)
    except (TimeoutError, OSError):
        return None
    finally:
        if process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
    return answer
