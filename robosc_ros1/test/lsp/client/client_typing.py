"""A whole model typed, three letters at a time: each text is broken in its own way."""

from __future__ import annotations

import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_lsp
from lsp_models import LIBRARY, MODEL, place
from lsprotocol import types
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities


@pytest_lsp.fixture(
    config=ClientServerConfig(server_command=[sys.executable, "-m", "robosc", "lsp"])
)
async def client(lsp_client: LanguageClient, tmp_path: Path) -> AsyncIterator[None]:
    params = types.InitializeParams(
        capabilities=client_capabilities("neovim"), root_uri=tmp_path.as_uri()
    )
    lsp_client.feature(types.CLIENT_REGISTER_CAPABILITY)(lambda params: None)
    await lsp_client.initialize_session(params)
    (tmp_path / "arms.rscd").write_text(LIBRARY)
    yield
    await lsp_client.shutdown_session()


@pytest.mark.asyncio
async def test_typing(client: LanguageClient, tmp_path: Path) -> None:
    """Each request after each change gets an answer; an error of the server would raise here."""
    uri = (tmp_path / "typed.rscd").as_uri()
    document = types.TextDocumentIdentifier(uri)
    client.text_document_did_open(
        types.DidOpenTextDocumentParams(types.TextDocumentItem(uri, "rscd", 0, ""))
    )
    offered = 0
    for count in range(1, len(MODEL) + 1, 3):
        text = MODEL[:count]
        client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(count, uri),
                [types.TextDocumentContentChangeWholeDocument(text)],
            )
        )
        here = place(text + "\0", "\0")
        items = await client.text_document_completion_async(types.CompletionParams(document, here))
        offered += bool(items.items)
        await client.text_document_hover_async(types.HoverParams(document, here))
        everywhere = types.Range(types.Position(0, 0), here)
        await client.text_document_code_action_async(
            types.CodeActionParams(document, everywhere, types.CodeActionContext([]))
        )
        if count % 5 == 0:
            await client.text_document_semantic_tokens_full_async(
                types.SemanticTokensParams(document)
            )
            await client.text_document_document_symbol_async(types.DocumentSymbolParams(document))
            await client.text_document_folding_range_async(types.FoldingRangeParams(document))
            await client.text_document_definition_async(types.DefinitionParams(document, here))
            await client.text_document_references_async(
                types.ReferenceParams(types.ReferenceContext(True), document, here)
            )
            await client.text_document_formatting_async(
                types.DocumentFormattingParams(document, types.FormattingOptions(4, True))
            )
    assert offered > len(MODEL) / 12
    assert not [m for m in client.messages if m.type == types.MessageType.Error]
