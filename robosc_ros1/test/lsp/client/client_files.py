"""Files: libraries, folders, names, documents that are not saved."""

from __future__ import annotations

from pathlib import Path

import pytest
from lsp_models import LIBRARY
from lsp_session import GOOD, WARNINGS
from lsprotocol import types
from pytest_lsp import LanguageClient


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
