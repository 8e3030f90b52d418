"""What a user of an editor sees, asked for through the protocol."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_lsp
from lsp_models import LARGE, LIBRARY, MODEL, place
from lsprotocol import types
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities

GOOD = MODEL.replace("    never Wheel.moving => Hand.closing\n", "")
WARNINGS = {"unused-enum-value", "restricted-command"}
STUCK = """\
robot Stuck {
    component Arm {
        service grip with request: none, response: none links empty
        behaviour {
            initial marked state open { on request to grip goto closing }
            state closing {
                on response from grip goto open
            }
        }
    }
    interface empty use Empty from std_srvs
}
"""


@pytest_lsp.fixture(
    config=ClientServerConfig(server_command=[sys.executable, "-m", "robosc", "lsp", "--stdio"])
)
async def client(lsp_client: LanguageClient, tmp_path: Path) -> AsyncIterator[None]:
    capabilities = client_capabilities("visual-studio-code")
    params = types.InitializeParams(capabilities=capabilities, root_uri=tmp_path.as_uri())
    lsp_client.feature(types.CLIENT_REGISTER_CAPABILITY)(lambda params: None)
    await lsp_client.initialize_session(params)
    (tmp_path / "arms.rscd").write_text(LIBRARY)
    yield
    await lsp_client.shutdown_session()


class Document:
    def __init__(self, client: LanguageClient, path: Path, text: str) -> None:
        self.client = client
        self.uri = path.as_uri()
        self.id = types.TextDocumentIdentifier(self.uri)
        self.text = text
        self.version = 1
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

    def close(self) -> None:
        self.client.text_document_did_close(types.DidCloseTextDocumentParams(self.id))

    def at(self, words: str, inside: int = 0) -> types.Position:
        return place(self.text, words, inside)

    async def codes(self, wanted: set[str]) -> list[types.Diagnostic]:
        """The diagnostics, as soon as they have just these codes."""
        while True:
            found = list(self.client.diagnostics.get(self.uri, []))
            if {d.code for d in found} == wanted:
                return found
            await asyncio.wait_for(
                self.client.wait_for_notification(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS), 30
            )


@pytest.fixture
def open_model(client: LanguageClient, tmp_path: Path):
    def opened(text: str, name: str = "model.rscd") -> Document:
        return Document(client, tmp_path / name, text)

    return opened


@pytest.mark.asyncio
async def test_diagnostics_follow_the_text(client: LanguageClient, open_model) -> None:
    document = open_model(MODEL)
    (wrong,) = await document.codes({"syntax"})
    assert wrong.range.start == document.at("never Wheel.moving =>")
    document.write(GOOD.replace("Eye.last = far", "Eye.last = fur"))
    (wrong,) = await document.codes({"unknown-name"})
    start = document.at("fur and")
    assert wrong.range == types.Range(start, types.Position(start.line, start.character + 3))
    assert "did you mean 'far'?" in wrong.message


@pytest.mark.asyncio
async def test_synthesis_explains_and_mends(client: LanguageClient, open_model) -> None:
    """What only synthesis knows comes by itself, and its remedy can be carried out."""
    document = open_model(STUCK)
    (warning,) = await document.codes({"never-allowed"})
    hover = await client.text_document_hover_async(
        types.HoverParams(document.id, document.at("grip with"))
    )
    assert "never allowed" in hover.contents.value and "on error from grip" in hover.contents.value
    (action,) = await client.text_document_code_action_async(
        types.CodeActionParams(document.id, warning.range, types.CodeActionContext([warning]))
    )
    (edit,) = action.edit.changes[document.uri]
    lines = document.text.split("\n")
    assert edit.range.start == edit.range.end
    assert edit.range.start.character == 0
    lines.insert(edit.range.start.line, edit.new_text.rstrip("\n"))
    document.write("\n".join(lines))
    await document.codes(set())


@pytest.mark.asyncio
async def test_unsaved_libraries_count(client: LanguageClient, open_model) -> None:
    document = open_model(GOOD)
    await document.codes(WARNINGS)
    library = open_model(LIBRARY.replace("closing", "shutting"), "arms.rscd")
    await document.codes({"unknown-member"})
    library.write(LIBRARY)
    await document.codes(WARNINGS)
    library.write(LIBRARY.replace("closing", "shutting"))
    await document.codes({"unknown-member"})
    library.close()  # not saved
    await document.codes(WARNINGS)


@pytest.mark.asyncio
async def test_libraries_change_on_disk(client: LanguageClient, open_model, tmp_path: Path) -> None:
    document = open_model(GOOD)
    await document.codes(WARNINGS)
    file = tmp_path / "arms.rscd"

    def changed(kind: types.FileChangeType) -> None:
        client.workspace_did_change_watched_files(
            types.DidChangeWatchedFilesParams([types.FileEvent(file.as_uri(), kind)])
        )

    file.write_text(LIBRARY.replace("closing", "shutting"))
    changed(types.FileChangeType.Changed)
    await document.codes({"unknown-member"})
    file.unlink()
    changed(types.FileChangeType.Deleted)
    await document.codes({"library-not-found"})
    file.write_text(LIBRARY)
    changed(types.FileChangeType.Created)
    await document.codes(WARNINGS)


@pytest.mark.asyncio
async def test_folders_that_join_the_workspace(
    client: LanguageClient, open_model, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """A robot that imports a library is found as soon as its folder is there."""
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    for folder in ("libraries", "robots"):
        (elsewhere / folder).mkdir()
    (elsewhere / "robots" / "robot.rscd").write_text(GOOD)
    (elsewhere / "libraries" / "arms.rscd").write_text(LIBRARY)
    library = open_model(LIBRARY, str(elsewhere / "libraries" / "arms.rscd"))

    async def files() -> set[str]:
        context = types.ReferenceContext(include_declaration=True)
        found = await client.text_document_references_async(
            types.ReferenceParams(context, library.id, library.at("closing {"))
        )
        return {Path(location.uri).name for location in found}

    assert await files() == {"arms.rscd"}
    joined = types.WorkspaceFolder((elsewhere / "robots").as_uri(), "robots")
    client.workspace_did_change_workspace_folders(
        types.DidChangeWorkspaceFoldersParams(
            types.WorkspaceFoldersChangeEvent(added=[joined], removed=[])
        )
    )
    assert await files() == {"arms.rscd", "robot.rscd"}


@pytest.mark.asyncio
async def test_definitions(client: LanguageClient, open_model, tmp_path: Path) -> None:
    document = open_model(GOOD)

    async def target(words: str, inside: int = 0) -> tuple[str, int]:
        found = await client.text_document_definition_async(
            types.DefinitionParams(document.id, document.at(words, inside))
        )
        return Path(found.uri).name, found.range.start.line + 1

    assert await target("closing and") == ("arms.rscd", 6)
    assert await target("grip }") == ("arms.rscd", 3)
    assert await target("Hand from") == ("arms.rscd", 2)
    assert await target("far and") == ("model.rscd", GOOD[: GOOD.index("-> far")].count("\n") + 1)


@pytest.mark.asyncio
async def test_rename_goes_through_all_files(client: LanguageClient, open_model) -> None:
    document = open_model(GOOD)
    edit = await client.text_document_rename_async(
        types.RenameParams(document.id, document.at("closing and"), "state")
    )
    assert sorted(Path(uri).name for uri in edit.changes) == ["arms.rscd", "model.rscd"]
    with pytest.raises(Exception, match="clash"):
        await client.text_document_rename_async(
            types.RenameParams(document.id, document.at("far and"), "near")
        )


@pytest.mark.asyncio
@pytest.mark.parametrize("name", ["a b.rscd", "50%20.rscd", "a;b#c?d é🤖.rscd"])
async def test_any_name_of_a_file(client: LanguageClient, open_model, name: str) -> None:
    """The client gets its own URI back, to the letter."""
    document = open_model(GOOD, name)
    await document.codes(WARNINGS)
    edit = await client.text_document_rename_async(
        types.RenameParams(document.id, document.at("Wheel"), "Roller")
    )
    assert list(edit.changes) == [document.uri]


@pytest.mark.asyncio
async def test_columns_count_as_the_protocol_does(client: LanguageClient, open_model) -> None:
    """🤖 is one character, two units of UTF-16."""
    text = "robot Wide { /* 🤖 */ component Motor { incoming message go with type: none } }\n"
    document = open_model(text)
    (found,) = await client.text_document_document_symbol_async(
        types.DocumentSymbolParams(document.id)
    )
    assert found.children[0].selection_range.start == document.at("Motor")
    hover = await client.text_document_hover_async(
        types.HoverParams(document.id, document.at("Motor", 4))
    )
    assert "Motor" in hover.contents.value


@pytest.mark.asyncio
@pytest.mark.parametrize("old, new", [("\n", "\r\n"), ("    ", "\t"), ("\n", "\r")])
async def test_other_ends_of_lines_and_tabs(
    client: LanguageClient, open_model, old: str, new: str
) -> None:
    """Places are those of the text as it is: a tab is one unit."""
    broken = GOOD.replace("Eye.last = far", "/* 🤖 */ Eye.last = fur")
    document = open_model(broken.replace(old, new))
    (wrong,) = await document.codes({"unknown-name"})
    start = place(broken.replace("    ", "\t") if new == "\t" else broken, "fur and")
    assert wrong.range == types.Range(start, types.Position(start.line, start.character + 3))
    (action,) = await client.text_document_code_action_async(
        types.CodeActionParams(document.id, wrong.range, types.CodeActionContext([]))
    )
    (edit,) = action.edit.changes[document.uri]
    assert (edit.range, edit.new_text) == (wrong.range, "far")


@pytest.mark.asyncio
async def test_synthesis_of_a_large_model_keeps_nobody_waiting(
    client: LanguageClient, open_model
) -> None:
    """It is given up when the text changes, and another model is not held up by it."""
    large = open_model(LARGE, "large.rscd")
    for count in range(10):
        large.write(LARGE + " " * count)
        params = types.HoverParams(large.id, large.at("Philosophers", 1))
        assert await client.text_document_hover_async(params) is not None
        await asyncio.sleep(0.1)
    small = open_model(STUCK, "small.rscd")
    await small.codes({"never-allowed"})
    large.write(STUCK)
    await large.codes({"never-allowed"})


@pytest.mark.asyncio
async def test_requests_that_are_cancelled(client: LanguageClient, open_model) -> None:
    document = open_model(GOOD)
    requests = [
        asyncio.ensure_future(
            client.text_document_completion_async(
                types.CompletionParams(document.id, document.at("far and"))
            )
        )
        for _ in range(20)
    ]
    for identity in range(200):
        client.cancel_request(types.CancelParams(identity))
    await asyncio.wait(requests, timeout=30)
    assert all(request.done() for request in requests)
    await document.codes(WARNINGS)


@pytest.mark.asyncio
async def test_guards_and_requirements_are_told(client: LanguageClient, open_model) -> None:
    document = open_model(GOOD)
    await document.codes(WARNINGS)
    hover = await client.text_document_hover_async(
        types.HoverParams(document.id, document.at("drive with type"))
    )
    text = hover.contents.value
    assert "requirement drive needs Eye.last = far and !(Eye.count > 2)  // line" in text
    assert "restricted further than the requirements say" in text
    assert "Synthesis allows it where" in text and "Why: " in text


@pytest.mark.asyncio
async def test_formatting(client: LanguageClient, open_model) -> None:
    document = open_model(GOOD.replace("    component Wheel", "component     Wheel"))
    options = types.FormattingOptions(4, True)
    (edit,) = await client.text_document_formatting_async(
        types.DocumentFormattingParams(document.id, options)
    )
    assert "    component Wheel {" in edit.new_text
    document.write(MODEL)
    refused = await client.text_document_formatting_async(
        types.DocumentFormattingParams(document.id, options)
    )
    assert refused is None


@pytest.mark.asyncio
async def test_tokens(client: LanguageClient, open_model) -> None:
    document = open_model(GOOD)
    found = await client.text_document_semantic_tokens_full_async(
        types.SemanticTokensParams(document.id)
    )
    assert len(found.data) % 5 == 0 and len(found.data) > 500
    assert min(found.data) >= 0


@pytest.mark.asyncio
async def test_settings(client: LanguageClient, open_model, tmp_path: Path) -> None:
    """Libraries in another folder are found as soon as that is among the settings."""
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "arms.rscd").rename(tmp_path / "elsewhere" / "arms.rscd")
    document = open_model(GOOD)
    await document.codes({"library-not-found"})
    client.workspace_did_change_configuration(
        types.DidChangeConfigurationParams({"robosc": {"libraryPath": ["elsewhere"]}})
    )
    await document.codes(WARNINGS)


@pytest.mark.asyncio
async def test_documents_that_are_no_files(client: LanguageClient) -> None:
    uri = "untitled:Untitled-1"
    item = types.TextDocumentItem(uri, "rscd", 1, "robot R { component Arm }")
    client.text_document_did_open(types.DidOpenTextDocumentParams(item))
    while not client.diagnostics.get(uri):
        await asyncio.wait_for(
            client.wait_for_notification(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS), 30
        )
    identifier = types.TextDocumentIdentifier(uri)
    hover = await client.text_document_hover_async(
        types.HoverParams(identifier, types.Position(0, 6))
    )
    assert "R" in hover.contents.value
    client.text_document_did_close(types.DidCloseTextDocumentParams(identifier))
