"""Files: libraries, folders, names, documents that are not saved."""

from __future__ import annotations

import asyncio
import random
from pathlib import Path

import pytest
from lsp_models import LIBRARY
from lsp_session import GOOD, WARNINGS
from lsprotocol import types
from pytest_lsp import LanguageClient

from robosc.codes import CODES
from robosc.lsp import wire
from robosc.lsp.analysis import Desk


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


def _places(found: list[types.Diagnostic]) -> list[tuple[str, int, int]]:
    """What is told without synthesis, and where."""
    starts = [(d.code, d.range.start) for d in found if not CODES[d.code].needs_plant]
    return sorted((code, start.line, start.character) for code, start in starts)


@pytest.mark.asyncio
async def test_a_long_text_is_told_as_a_fresh_reading_finds_it(
    client: LanguageClient, open_model, tmp_path: Path
) -> None:
    """Whatever was typed while it was read, and what completion was asked for meanwhile."""
    before = "// " + "." * 40_000 + "\n"
    document = open_model(before + GOOD)
    chance = random.Random(17)
    for number in range(1, 61):
        text = document.text
        at = chance.randrange(len(before), len(text))
        typed = chance.choice(["x", " ", "}", "{", "\n", "state ", ""])
        document.write(text[:at] + typed + text[at + chance.randrange(3) :])
        if number % 4 == 0:
            await client.text_document_completion_async(
                types.CompletionParams(document.id, types.Position(1 + number % 30, 4))
            )
        if number % 3:
            continue
        await client.text_document_document_symbol_async(types.DocumentSymbolParams(document.id))
        desk = Desk()
        desk.put(str(tmp_path / "model.rscd"), document.text)
        fresh = desk.analysis(str(tmp_path / "model.rscd"))
        assert fresh is not None
        expected = wire.diagnostics_for(fresh.source, fresh.diagnostics, "utf-16", None)
        assert _places(client.diagnostics[document.uri]) == _places(expected)
        if number % 15 == 0:
            document.write(before + GOOD)
