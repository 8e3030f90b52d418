#!/bin/sh
# pygls 2.1.1 leaves requests of JSON-RPC without an answer, for which a client waits for ever: each
# whose parameters do not have the form of its method, and one of a method that is unknown if it has
# no "params", which JSON-RPC lets a client omit. It shows the user a message instead ("Error in
# server: Invalid Params", "Internal Error"), which names no request. The same unknown method with
# "params": null is answered with the error that LSP has for it.
# Seen: "asked 1 2 3 4 5, answered 1 4 5", in one line: 2 is a hover without a document, 3 and 4 are
# unknown without params and with null, 5 is shutdown.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pygls==2.1.1 lsprotocol==2025.0.0
cat > "$folder/server.py" <<'END'
from lsprotocol.types import TEXT_DOCUMENT_HOVER
from pygls.lsp.server import LanguageServer

server = LanguageServer("finding", "1")
server.feature(TEXT_DOCUMENT_HOVER)(lambda parameters: None)
server.start_io()
END
cat > "$folder/run.py" <<'END'
import json
import subprocess
import sys

START = {"capabilities": {}, "processId": None, "rootUri": None}
asked = [
    {"method": "initialize", "params": START},
    {"method": "textDocument/hover", "params": {}},
    {"method": "finding/unknown"},
    {"method": "finding/unknown", "params": None},
    {"method": "shutdown"},
]
messages = [{"jsonrpc": "2.0", "id": number, **one} for number, one in enumerate(asked, 1)]
command = [sys.executable, "server.py"]
server = subprocess.Popen(
    command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
)
for message in [*messages, {"jsonrpc": "2.0", "method": "exit"}]:
    text = json.dumps(message).encode()
    server.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(text), text))
    server.stdin.flush()
answered = []
while line := server.stdout.readline():  # until it has ended, and said all
    length = int(line.split()[1])
    while server.stdout.readline().strip():
        pass
    answer = json.loads(server.stdout.read(length))
    answered += [answer["id"]] if "id" in answer else []
ids = " ".join(str(message["id"]) for message in messages)
print(f"asked {ids}, answered {' '.join(map(str, sorted(answered)))}")
END
cd "$folder"
seen=$("$folder/venv/bin/python" run.py)
echo "$seen"
[ "$seen" = "asked 1 2 3 4 5, answered 1 4 5" ]
