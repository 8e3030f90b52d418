"""The page and its stream over HTTP: Python's own server, one thread for each browser.

A stream is one of Server-Sent Events (HTML standard, section 9.2). Nothing that a browser asks
changes anything but the source's own play: there is no way from here into ROS, except for who has
the token of a server that an operator started for that (:mod:`~robosc.view.operating`).
"""

from __future__ import annotations

import contextlib
import errno
import hmac
import ipaddress
import json
import socket
import sys
import time
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import urlsplit

from robosc import errors, limits
from robosc.lazy_dataclasses import dataclass
from robosc.view.hub import Hub, compact, utf8

DEFAULT_PORT = 8642

PAGE = Path(__file__).with_name("page")
_KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}
_FILES = {f"/{file.name}": file for file in PAGE.iterdir() if file.suffix in _KINDS}
_FILES["/"] = _FILES.pop("/index.html")
_PERIOD = 1 / 30
"""Seconds between two pieces of a stream: more than a screen shows would be lost on it."""
_SILENCE = 2.0
"""Seconds after which a stream without news says so: the page takes silence for a broken link."""
_POLICY = (
    "default-src 'self'; img-src 'self' data:; object-src 'none'; base-uri 'none';"
    " form-action 'none'; frame-ancestors 'none'"
)

Answers: TypeAlias = Mapping[str, Callable[[Any], Any]]
"""Path to what answers a JSON document that is posted there."""


class Unable(Exception):
    """What a browser asked for cannot be done; the message is for whoever sits before it."""


@dataclass(frozen=True)
class Where:
    """Where to listen; ``port`` None is the usual one, or any other if that is taken."""

    host: str = "127.0.0.1"
    port: int | None = None


class PageServer(ThreadingHTTPServer):
    """Serves until it is stopped. Raises UsageError if it cannot listen there."""

    daemon_threads = True
    # A browser that reloads often must not find the door closed.
    request_queue_size = 64

    def __init__(self, where: Where, hub: Hub, answers: Answers, token: str | None = None) -> None:
        """``token``: whoever posts must have it; only for browsers of this machine."""
        if token is not None and not _is_local(where.host):
            raise errors.UsageError(
                f"{where.host} can be reached from other machines: an operator sits at this one"
            )
        self.hub = hub
        self.token = token
        self.answers = answers
        self.coming: dict[socket.socket, float] = {}
        """Until when each request must have come that is not there yet."""
        host, port = where.host, where.port
        self._host = host
        try:
            valid = bool(host.encode("idna"))
        except UnicodeError:
            valid = False
        if not valid:
            raise errors.UsageError(f"{host!r} is not an address or the name of a host")
        if ":" in host:
            self.address_family = socket.AF_INET6
        try:
            super().__init__((host, DEFAULT_PORT if port is None else port), _Handler)
        except OSError as error:
            if port is not None or error.errno != errno.EADDRINUSE:
                reason = error.strerror or str(error)
                place = host if port is None else f"{host}, port {port}"
                raise errors.UsageError(f"cannot listen on {place}: {reason}") from error
            super().__init__((host, 0), _Handler)

    @property
    def address(self) -> str:
        """Where everyone finds the page who may look at it."""
        address = _address(self._host)
        # "All addresses" is none to go to.
        everywhere = address is not None and address.is_unspecified
        host = _own_address(self.address_family) if everywhere else self._host
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.server_address[1]}/"

    @property
    def url(self) -> str:
        """The address, with the token of whoever may operate."""
        # Behind the #, browsers keep it to themselves.
        return self.address + ("" if self.token is None else f"#token={self.token}")

    def run(self) -> None:
        """Tell where to look, and serve until interrupted."""
        print(self.url, flush=True)
        if not _is_local(self._host):
            can = "watch and play" if "/do" in self.answers else "watch"
            print(f"everyone who can reach this address can {can}", file=sys.stderr)
        print("Ctrl-C ends it", file=sys.stderr, flush=True)
        self.serve_forever(poll_interval=0.2)

    def welcomes(self, host: str | None) -> bool:
        """Whether a request may name its host so.

        A page from elsewhere can have its own name lead to this machine (DNS rebinding); it then
        still asks for that name. So there are addresses, and the names that this machine has.
        """
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if _is_local(self._host):
            return _is_local(name)
        own = socket.gethostname().lower()
        return (
            name in (self._host.lower(), "localhost", own, f"{own}.local")
            or _address(name) is not None
        )

    def service_actions(self) -> None:
        """Give up the requests that have not come in time."""
        now = time.monotonic()
        for connection, until in list(self.coming.items()):
            if now > until:
                with contextlib.suppress(OSError):
                    connection.shutdown(socket.SHUT_RDWR)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away is no fault; there is nobody to report others to."""


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    # Seconds for a request to come, and for each piece of a stream to go: a browser that reads no
    # more, but is not closed either, must not be kept for ever.
    timeout = 20

    def setup(self) -> None:
        super().setup()
        # The whole request, also one that comes byte by byte.
        self.server.coming[self.connection] = time.monotonic() + self.timeout

    def finish(self) -> None:
        self.server.coming.pop(self.connection, None)
        super().finish()

    def do_GET(self) -> None:
        path = urlsplit(self.path).path
        if not self.server.welcomes(self.headers.get("Host")):
            self._send(403, "text/plain", b"ask for this machine by its address or its own name\n")
        elif path == "/stream":
            if self._is_foreign():
                self._send(403, "text/plain", b"this is for this server's own page\n")
            else:
                self._stream()
        elif path in _FILES:
            file = _FILES[path]
            self._send(200, f"{_KINDS[file.suffix]}; charset=utf-8", file.read_bytes())
        elif path == "/favicon.ico":
            self._send(204, "text/plain", b"")
        else:
            self._send(404, "text/plain", b"there is no such page\n")

    def do_POST(self) -> None:
        answer = self.server.answers.get(urlsplit(self.path).path)
        # Pages from elsewhere cannot post this type without asking first, which nobody answers.
        is_json = self.headers.get_content_type() == "application/json"
        welcome = self.server.welcomes(self.headers.get("Host")) and not self._is_foreign()
        if not (is_json and welcome):
            self._reply(403, {"message": "only this server's own page may ask this"})
            return
        if not self._has_token():
            self._reply(403, {"message": "open the page by the whole address, with its token"})
            return
        if answer is None:
            self._reply(404, {"message": "this source does not offer that"})
            return
        try:
            length = int(self.headers.get("Content-Length") or 0)
            if not 0 <= length <= limits.REQUEST_BYTES:
                raise ValueError("too long")
            document = json.loads(self.rfile.read(length))
        except (ValueError, RecursionError) as error:
            self._reply(400, {"message": f"this is not JSON: {error}"})
            return
        try:
            self._reply(200, answer(document))
        except Unable as fault:
            self._reply(409, {"message": str(fault)})

    def _is_foreign(self) -> bool:
        """Whether a browser says that a page from elsewhere asks; other programs say nothing."""
        origin = self.headers.get("Origin")
        try:
            own = origin is None or urlsplit(origin).netloc == self.headers.get("Host", "").lower()
        except ValueError:
            own = False
        if not own:
            return True
        return self.headers.get("Sec-Fetch-Site", "none") not in ("same-origin", "none")

    def _has_token(self) -> bool:
        token = self.server.token
        given = self.headers.get("Authorization", "").encode()
        return token is None or hmac.compare_digest(given, f"Bearer {token}".encode())

    def _stream(self) -> None:
        self._head(200, "text/event-stream; charset=utf-8", None)
        follower = self.server.hub.follow()
        try:
            while True:
                text = follower.take(_SILENCE)
                self.wfile.write(utf8(f"data:{text or '{}'}\n\n"))
                self.wfile.flush()
                time.sleep(_PERIOD)
        except OSError:
            self.close_connection = True

    def _reply(self, code: int, document: Any) -> None:
        self._send(code, "application/json", utf8(compact(document)))

    def _send(self, code: int, kind: str, body: bytes) -> None:
        self._head(code, kind, len(body))
        self.wfile.write(body)

    def _head(self, code: int, kind: str, length: int | None) -> None:
        self.server.coming.pop(self.connection, None)
        self.send_response(code)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Content-Security-Policy", _POLICY)
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Who looks at what is nobody's business."""


def _is_local(host: str) -> bool:
    address = _address(host)
    return host == "localhost" or (address is not None and address.is_loopback)


def _own_address(family: int) -> str:
    """Return the address that other machines reach this one by, or its name if it has none.

    Connecting a socket for datagrams chooses a route, and with it an address, but sends nothing;
    the destinations are those for documentation (RFC 5737 and RFC 3849).
    """
    away = "2001:db8::1" if family == socket.AF_INET6 else "192.0.2.1"
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((away, 9))
            return str(probe.getsockname()[0])
    except OSError:
        return socket.gethostname()


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None
