"""One session with the server, and documents in it: fixtures, loaded as a plugin."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_lsp
from lsp_models import LIBRARY, MODEL, place
from lsprotocol import types
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities

GOOD = MODEL.replace("    never Wheel.moving => Hand.closing\n", "")
WARNINGS = {"no-stop", "stale-data", "restricted-command"}


CONFIG = ClientServerConfig(server_command=[sys.executable, "-m", "robosc", "lsp", "--stdio"])


async def session(client: LanguageClient, folder: Path) -> AsyncIterator[None]:
    """A session of a client in a folder, in which a library lies."""
    capabilities = client_capabilities("visual-studio-code")
    params = types.InitializeParams(capabilities=capabilities, root_uri=folder.as_uri())
    client.feature(types.CLIENT_REGISTER_CAPABILITY)(lambda params: None)
    await client.initialize_session(params)
    (folder / "arms.rscd").write_text(LIBRARY)
    yield
    await client.shutdown_session()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where the models of the session lie; a module whose tests share a session has its own."""
    return tmp_path


@pytest.fixture
def name() -> str:
    """That of the first model of a test; where they share a session, each has another."""
    return "model.rscd"


@pytest_lsp.fixture(config=CONFIG)
async def client(lsp_client: LanguageClient, folder: Path) -> AsyncIterator[None]:
    async for _ in session(lsp_client, folder):
        yield


def _typed(line: str, units: int, text: str) -> str:
    before = line.encode("utf-16-le")[: 2 * units].decode("utf-16-le")
    return before + text + line[len(before) :]


class Document:
    def __init__(self, client: LanguageClient, path: Path, text: str) -> None:
        self.client = client
        self.uri = path.as_uri()
        self.id = types.TextDocumentIdentifier(self.uri)
        self.text = text
        self.version = 1
        self.is_open = True
        item = types.TextDocumentItem(self.uri, "rscd", 1, text)
        client.text_document_did_open(types.DidOpenTextDocumentParams(item))

    def write(self, text: str) -> None:
        self.text = text
        self.version += 1
        self.client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(self.version, self.uri),
                [types.TextDocumentContentChangeWholeDocument(text)],
            )
        )

    def insert(self, at: types.Position, text: str) -> None:
        """Type at a place, which is all that the server is told."""
        lines = self.text.split("\n")
        lines[at.line] = _typed(lines[at.line], at.character, text)
        self.text = "\n".join(lines)
        self.version += 1
        self.client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(self.version, self.uri),
                [types.TextDocumentContentChangePartial(types.Range(at, at), text)],
            )
        )

    def close(self) -> None:
        if not self.is_open:
            return
        self.is_open = False
        self.client.text_document_did_close(types.DidCloseTextDocumentParams(self.id))

    def at(self, words: str, inside: int = 0) -> types.Position:
        return place(self.text, words, inside)

    async def codes(self, wanted: set[str], told: str = "") -> list[types.Diagnostic]:
        """The diagnostics, as soon as they have just these codes, and all tell something."""
        while True:
            found = list(self.client.diagnostics.get(self.uri, []))
            if {d.code for d in found} == wanted and all(told in d.message for d in found):
                return found
            await asyncio.wait_for(
                self.client.wait_for_notification(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS), 30
            )


@pytest.fixture
def open_model(client: LanguageClient, folder: Path, name: str):
    """Opens documents, which are closed when the test ends."""
    documents = []

    def opened(text: str, file: str = name) -> Document:
        documents.append(Document(client, folder / file, text))
        return documents[-1]

    yield opened
    for document in documents:
        document.close()
