"""An agent that does as it is told, in a process that has the SDK.

Its arguments are the command of the server. Each line of its input is a JSON document:
``{"call": TOOL, "arguments": {…}}``, with ``"cancel_after": N`` to cancel it after N reports of
progress; ``{"read": URI}``, ``{"tools": true}``, or ``{"end": true}``. It answers with a line each,
and with a line for each report of progress.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

import anyio
import anyio.to_thread
import mcp_types as types
from mcp.client.client import Client
from mcp.client.stdio import StdioServerParameters, stdio_client
from mcp.client.streamable_http import streamable_http_client


def say(document: Any) -> None:
    print(json.dumps(document), flush=True)


async def call(client: Client, order: Any) -> None:
    reports = 0
    with anyio.CancelScope() as scope:

        async def progress(done: float, total: float | None, message: str | None) -> None:
            nonlocal reports
            reports += 1
            say({"progress": json.loads(message or "null")})
            if reports == order.get("cancel_after"):
                scope.cancel()

        result = await client.call_tool(
            order["call"], order.get("arguments", {}), progress_callback=progress
        )
        say({"error": result.is_error, **result.structured_content})
    if scope.cancelled_caught:
        say({"gave_up": True})


async def main() -> None:
    if sys.argv[1].startswith("http"):
        import httpx2

        headers = {"Authorization": f"Bearer {sys.argv[2]}"}
        transport = streamable_http_client(
            sys.argv[1], http_client=httpx2.AsyncClient(headers=headers)
        )
    else:
        server = StdioServerParameters(command=sys.argv[1], args=sys.argv[2:], env=dict(os.environ))
        transport = stdio_client(server)
    who = types.Implementation(name=os.environ.get("AGENT_NAME", "agent"), version="1")
    async with Client(transport, client_info=who) as client:
        while line := await anyio.to_thread.run_sync(sys.stdin.readline):
            order = json.loads(line)
            if "call" in order:
                await call(client, order)
            elif "read" in order:
                say(json.loads((await client.read_resource(order["read"])).contents[0].text))
            elif "tools" in order:
                found = await client.list_tools()
                say({tool.name: tool.input_schema for tool in found.tools})
            else:
                break


anyio.run(main)
