"""The page and its stream over HTTP: Python's own server, one thread for each browser.

A stream is one of Server-Sent Events (HTML standard, section 9.2). Nothing that a browser asks
changes anything but the source's own play: there is no way from here into ROS.
"""

from __future__ import annotations

import errno
import ipaddress
import json
import time
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import urlsplit

from robosc.errors import UsageError
from robosc.view.hub import Hub, compact

__all__ = ["DEFAULT_PORT", "Answers", "PageServer", "Unable"]

DEFAULT_PORT = 8642

PAGE = Path(__file__).with_name("page")
_FILES = {
    "/": ("index.html", "text/html"),
    "/view.css": ("view.css", "text/css"),
    "/view.js": ("view.js", "text/javascript"),
}
_PERIOD = 1 / 30
"""Seconds between two pieces of a stream: more than a screen shows would be lost on it."""
_SILENCE = 10.0
"""Seconds after which a stream without news says so, or finds that nobody reads it."""
_LONGEST = 100_000

Answers: TypeAlias = Mapping[str, Callable[[Any], Any]]
"""Path to what answers a JSON document that is posted there."""


class Unable(Exception):
    """What a browser asked for cannot be done; the message is for whoever sits before it."""


class PageServer(ThreadingHTTPServer):
    """Serves until it is told to end. Raises UsageError if it cannot listen there.

    ``port`` None takes the usual one, or any other if that is taken.
    """

    daemon_threads = True
    # A browser that reloads often must not find the door closed.
    request_queue_size = 64

    def __init__(self, host: str, port: int | None, hub: Hub, answers: Answers) -> None:
        self.hub = hub
        self.answers = answers
        self._host = host
        if ":" in host:
            import socket

            self.address_family = socket.AF_INET6
        try:
            super().__init__((host, DEFAULT_PORT if port is None else port), _Handler)
        except OSError as error:
            if port is not None or error.errno != errno.EADDRINUSE:
                reason = error.strerror or str(error)
                raise UsageError(f"cannot listen on {host}, port {port}: {reason}") from error
            super().__init__((host, 0), _Handler)

    @property
    def url(self) -> str:
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"http://{host}:{self.server_address[1]}/"

    def welcomes(self, host: str | None) -> bool:
        """Whether a request may name its host so.

        A page from elsewhere can have its own name lead to this machine (DNS rebinding); it then
        still asks for that name.
        """
        if not _is_local(self._host):
            return True
        return host is not None and _is_local(urlsplit(f"//{host}").hostname or "")

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away is no fault; there is nobody to tell of others."""


class _Handler(BaseHTTPRequestHandler):
    server: PageServer

    def do_GET(self) -> None:
        path = urlsplit(self.path).path
        if not self.server.welcomes(self.headers.get("Host")):
            self._send(403, "text/plain", b"this server is for its own machine\n")
        elif path == "/stream":
            self._stream()
        elif path in _FILES:
            name, kind = _FILES[path]
            self._send(200, f"{kind}; charset=utf-8", (PAGE / name).read_bytes())
        elif path == "/favicon.ico":
            self._send(204, "text/plain", b"")
        else:
            self._send(404, "text/plain", b"there is no such page\n")

    def do_POST(self) -> None:
        answer = self.server.answers.get(urlsplit(self.path).path)
        # Pages from elsewhere cannot post this type without asking first, which nobody answers.
        foreign = self.headers.get_content_type() != "application/json"
        if foreign or not self.server.welcomes(self.headers.get("Host")):
            self._reply(403, {"message": "only this server's own page may ask this"})
            return
        if answer is None:
            self._reply(404, {"message": "this source has no such thing"})
            return
        try:
            length = int(self.headers.get("Content-Length") or 0)
            if not 0 <= length <= _LONGEST:
                raise ValueError("too long")
            document = json.loads(self.rfile.read(length))
        except (ValueError, RecursionError) as error:
            self._reply(400, {"message": f"this is no JSON: {error}"})
            return
        try:
            self._reply(200, answer(document))
        except Unable as fault:
            self._reply(409, {"message": str(fault)})

    def _stream(self) -> None:
        self._head(200, "text/event-stream; charset=utf-8", None)
        follower = self.server.hub.follow()
        try:
            while True:
                text = follower.take(_SILENCE)
                self.wfile.write(f"data:{text}\n\n".encode() if text else b":\n\n")
                self.wfile.flush()
                time.sleep(_PERIOD)
        except OSError:
            self.close_connection = True

    def _reply(self, code: int, document: Any) -> None:
        self._send(code, "application/json", compact(document).encode())

    def _send(self, code: int, kind: str, body: bytes) -> None:
        self._head(code, kind, len(body))
        self.wfile.write(body)

    def _head(self, code: int, kind: str, length: int | None) -> None:
        self.send_response(code)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Content-Security-Policy", "default-src 'self'; frame-ancestors 'none'")
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Who looks at what is nobody's business."""


def _is_local(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
