"""What a user of an editor sees, asked for through the protocol."""

from __future__ import annotations

import asyncio
import itertools
import random
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_lsp
from lsp_models import LARGE, MODEL, place
from lsp_session import CONFIG, GOOD, WARNINGS, session
from lsprotocol import types
from pytest_lsp import LanguageClient

from robosc.codes import CODES
from robosc.lsp import protocol
from robosc.lsp.analysis import Workspace

# One server for all of them: to start one takes longer than most of what they ask it.
pytestmark = pytest.mark.asyncio(loop_scope="module")

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


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("session")


_NUMBERS = itertools.count()


@pytest.fixture
def name() -> str:
    return f"model{next(_NUMBERS)}.rscd"


@pytest_lsp.fixture(config=CONFIG, scope="module")
async def client(lsp_client: LanguageClient, folder: Path) -> AsyncIterator[None]:
    async for _ in session(lsp_client, folder):
        yield


async def test_diagnostics_follow_the_text(client: LanguageClient, open_model) -> None:
    document = open_model(MODEL)
    (wrong,) = await document.codes({"syntax"})
    assert wrong.range.start == document.at("never Wheel.moving =>")
    document.write(GOOD.replace("Eye.last = far", "Eye.last = fur"))
    (wrong,) = await document.codes({"unknown-name"})
    start = document.at("fur and")
    assert wrong.range == types.Range(start, types.Position(start.line, start.character + 3))
    assert "did you mean 'far'?" in wrong.message


async def test_codes_and_keywords_are_explained(client: LanguageClient, open_model) -> None:
    document = open_model(MODEL)
    (wrong,) = await document.codes({"syntax"})
    assert wrong.code_description.href.startswith("file://")
    assert wrong.code_description.href.endswith("/docs/diagnostics.md#syntax")
    hover = await client.text_document_hover_async(
        types.HoverParams(document.id, document.at("never Wheel"))
    )
    assert hover.contents.value.startswith("`never`: ")
    client.workspace_did_change_configuration(
        types.DidChangeConfigurationParams({"robosc": {"documentation": "https://docs.invalid/"}})
    )
    document.write(GOOD.replace("Eye.last = far", "Eye.last = fur"))
    (wrong,) = await document.codes({"unknown-name"})
    assert wrong.code_description.href == "https://docs.invalid/diagnostics/#unknown-name"
    client.workspace_did_change_configuration(
        types.DidChangeConfigurationParams({"robosc": {"documentation": ""}})
    )
    document.write(GOOD.replace("Eye.last = far and", "Eye.last = far and and"))
    (wrong,) = await document.codes({"syntax"})
    assert wrong.code_description.href.startswith("file://")


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
    await asyncio.wait(requests, timeout=60)
    assert all(request.done() for request in requests)
    await document.codes(WARNINGS)


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


async def test_calls_and_hints(client: LanguageClient, open_model) -> None:
    text = GOOD.replace("requirement drive needs", "requirement drive needs min(1, 2) = 1 and")
    document = open_model(text)
    found = await client.text_document_signature_help_async(
        types.SignatureHelpParams(document.id, document.at("2) = 1"))
    )
    assert found.signatures[0].label.startswith("min(number, number, …)")
    assert found.active_parameter == 1
    lines = len(text.splitlines())
    hints = await client.text_document_inlay_hint_async(
        types.InlayHintParams(
            document.id, types.Range(types.Position(0, 0), types.Position(lines, 0))
        )
    )
    assert all(hint.label.startswith("std_msgs/") for hint in hints) and hints


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


async def test_tokens(client: LanguageClient, open_model) -> None:
    document = open_model(GOOD)
    found = await client.text_document_semantic_tokens_full_async(
        types.SemanticTokensParams(document.id)
    )
    assert len(found.data) % 5 == 0 and len(found.data) > 500
    assert min(found.data) >= 0


async def test_keys_in_a_long_text(client: LanguageClient, open_model) -> None:
    """Single keys are enough, and a request waits until the text is read with all of them."""
    document = open_model(GOOD + "// " + "." * 40_000 + "\n")
    await document.codes(WARNINGS)
    for key in "x🤖":
        document.insert(place(document.text, "...."), key)
    document.insert(place(document.text, "Eye.last = far", len("Eye.last = f")), "u")
    document.insert(place(document.text, "Eye.last = fuar", len("Eye.last = fua")), "r")
    await document.codes({"unknown-name"}, "'fuarr'")
    document.insert(place(document.text, "component Wheel"), "component Fresh {}\n    ")
    (found,) = await client.text_document_document_symbol_async(
        types.DocumentSymbolParams(document.id)
    )
    assert [child.name for child in found.children][:3] == ["Eye", "Fresh", "Wheel"]
    pending = asyncio.ensure_future(
        client.text_document_document_symbol_async(types.DocumentSymbolParams(document.id))
    )
    document.close()
    await asyncio.wait_for(pending, 30)


async def test_every_declaration_is_in_the_outline(client: LanguageClient, open_model) -> None:
    text = """\
robot R {
    constant most: integer = 3
    condition calm = Gate.shut
    component Gate { behaviour { initial marked state shut {} } }
    component Cell[1..2] { incoming message go with type: none }
    component Other { incoming message halt with type: none }
    for i in 1..2 { requirement Cell[i].go needs calm }
    prefer halt over Cell[1].go
}
"""
    document = open_model(text)
    (found,) = await client.text_document_document_symbol_async(
        types.DocumentSymbolParams(document.id)
    )
    assert [child.name for child in found.children] == [
        "most", "calm", "Gate", "Cell", "Other", "for i in 1..2", "prefer halt over Cell[1].go",
    ]  # fmt: skip


async def test_names_of_the_workspace(client: LanguageClient, open_model) -> None:
    open_model(GOOD)
    found = await client.workspace_symbol_async(types.WorkspaceSymbolParams("arm"))
    assert [(s.name, s.location.uri.rsplit("/", 1)[1]) for s in found] == [
        ("Arms", "arms.rscd"), ("Arm", "arms.rscd"),
    ]  # fmt: skip


async def test_definitions(client: LanguageClient, open_model, name: str) -> None:
    document = open_model(GOOD)

    async def target(words: str, inside: int = 0) -> tuple[str, int]:
        found = await client.text_document_definition_async(
            types.DefinitionParams(document.id, document.at(words, inside))
        )
        return Path(found.uri).name, found.range.start.line + 1

    assert await target("closing and") == ("arms.rscd", 6)
    assert await target("grip }") == ("arms.rscd", 3)
    assert await target("Hand from") == ("arms.rscd", 2)
    assert await target("far and") == (name, GOOD[: GOOD.index("-> far")].count("\n") + 1)


async def test_rename_goes_through_all_files(client: LanguageClient, open_model, name: str) -> None:
    document = open_model(GOOD)
    edit = await client.text_document_rename_async(
        types.RenameParams(document.id, document.at("closing and"), "state")
    )
    assert sorted(Path(uri).name for uri in edit.changes) == ["arms.rscd", name]
    with pytest.raises(Exception, match="clash"):
        await client.text_document_rename_async(
            types.RenameParams(document.id, document.at("far and"), "near")
        )


@pytest.mark.parametrize("name", ["a b.rscd", "50%20.rscd", "a;b#c?d é🤖.rscd"])
async def test_any_name_of_a_file(client: LanguageClient, open_model, name: str) -> None:
    """The client gets its own URI back, to the letter."""
    document = open_model(GOOD, name)
    await document.codes(WARNINGS)
    edit = await client.text_document_rename_async(
        types.RenameParams(document.id, document.at("Wheel"), "Roller")
    )
    assert list(edit.changes) == [document.uri]


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


async def test_a_long_text_is_told_as_a_fresh_reading_finds_it(
    client: LanguageClient, open_model, folder: Path, name: str
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
        workspace = Workspace()
        workspace.put(str(folder / name), document.text)
        fresh = workspace.analysis(str(folder / name))
        assert fresh is not None
        expected = protocol.diagnostics_for(fresh.source, fresh.diagnostics, "utf-16", None)
        assert _places(client.diagnostics[document.uri]) == _places(expected)
        if number % 15 == 0:
            document.write(before + GOOD)
