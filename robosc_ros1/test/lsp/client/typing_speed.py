"""Types at the end of a long model through a real client, and prints what each answer took.

Run by the benchmark of the language server with the Python of the tests' client, as
``typing_speed.py FOLDER LINES``; a JSON document on standard output: for each kind of answer the
milliseconds that passed (``elapsed``), and those that the server computed (``processor``), which do
not depend on what else the machine does.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
import time
from pathlib import Path
from urllib.parse import unquote, urlsplit

from large_model import large_model
from lsprotocol import types
from pygls.lsp.client import LanguageClient

KEYS = "\n    constant a: integer "
"""What is typed: it leaves an error behind, so that the diagnostics are known by their version."""

BETWEEN_KEYS = 0.08


class Typist:
    """A client that notes when the diagnostics of each version of a document came."""

    def __init__(self) -> None:
        self.client = LanguageClient("typist", "1")
        self.told: dict[int, float] = {}
        self.news = asyncio.Event()

        @self.client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def _(params: types.PublishDiagnosticsParams) -> None:
            if params.version is not None:
                self.told[params.version] = time.perf_counter()
                self.news.set()

    async def diagnostics(self, version: int) -> float:
        """When those of a version came."""
        while version not in self.told:
            self.news.clear()
            await asyncio.wait_for(self.news.wait(), 120)
        return self.told[version]

    def processor(self) -> float:
        """Milliseconds that the server has computed, itself and not the process for synthesis."""
        assert self.client._server is not None
        stat = Path(f"/proc/{self.client._server.pid}/stat").read_text()
        ticks = stat.rpartition(")")[2].split()[11:13]
        return 1000 * sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")


async def measure(folder: Path, lines: int) -> dict[str, dict[str, list[float]]]:
    typist = Typist()
    client = typist.client
    await client.start_io(sys.executable, "-m", "robosc", "lsp")
    await client.initialize_async(
        types.InitializeParams(types.ClientCapabilities(), root_uri=folder.as_uri())
    )
    client.initialized(types.InitializedParams())
    text = large_model(lines // 20)
    path = folder / "model.rscd"
    path.write_text(text)
    uri = path.as_uri()
    assert unquote(urlsplit(uri).path) == str(path)
    client.text_document_did_open(
        types.DidOpenTextDocumentParams(types.TextDocumentItem(uri, "rscd", 0, text))
    )
    await typist.diagnostics(0)
    found: dict[str, dict[str, list[float]]] = {}
    line = text[: text.rindex("}")].count("\n")
    document = types.TextDocumentIdentifier(uri)

    async def timed(name: str, request: object) -> None:
        begin, computed = time.perf_counter(), typist.processor()
        await request  # type: ignore[misc]
        rows = found.setdefault(name, {"elapsed": [], "processor": []})
        rows["elapsed"].append(1000 * (time.perf_counter() - begin))
        rows["processor"].append(typist.processor() - computed)

    place = types.Position(line, 0)
    pending = []
    for version, key in enumerate(KEYS, 1):
        change = types.TextDocumentContentChangePartial(types.Range(place, place), key)
        client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(version, uri), [change]
            )
        )
        end = key == "\n"
        place = types.Position(place.line + end, 0 if end else place.character + 1)
        params = types.CompletionParams(document, place)
        pending.append(
            asyncio.create_task(timed("completion", client.text_document_completion_async(params)))
        )
        last, computed = time.perf_counter(), typist.processor()
        await asyncio.sleep(BETWEEN_KEYS)
    found["diagnostics"] = {
        "elapsed": [1000 * (await typist.diagnostics(len(KEYS)) - last)],
        "processor": [typist.processor() - computed],
    }
    await asyncio.gather(*pending)
    begin = types.Position(line + 1, 0)
    client.text_document_did_change(
        types.DidChangeTextDocumentParams(
            types.VersionedTextDocumentIdentifier(len(KEYS) + 1, uri),
            [types.TextDocumentContentChangePartial(types.Range(begin, place), "// done")],
        )
    )
    await typist.diagnostics(len(KEYS) + 1)
    options = types.FormattingOptions(4, True)
    await timed(
        "formatting",
        client.text_document_formatting_async(types.DocumentFormattingParams(document, options)),
    )
    name = text.index("component Sensor1 ") + len("component ")
    at = types.Position(text.count("\n", 0, name), name - text.rindex("\n", 0, name) - 1)
    await timed(
        "rename",
        client.text_document_rename_async(types.RenameParams(document, at, "Renamed")),
    )
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()
    return found


if __name__ == "__main__":
    print(json.dumps(asyncio.run(measure(Path(sys.argv[1]), int(sys.argv[2])))))
