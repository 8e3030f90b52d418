"""The protocol as pygls has it, but for requests that are faulty or refused.

pygls answers no request whose parameters it cannot read, and writes a traceback for each request
that is refused. A client waits for every answer, and a refusal is none of the server's faults.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

from pygls.exceptions import JsonRpcInvalidParams
from pygls.protocol import LanguageServerProtocol

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
            return super().structure_message(data)
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
