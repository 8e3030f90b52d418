"""Only the server's own page gets anything from it, and may do anything; and only who reads is served."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from ros_support import await_condition
from view.browser import Browser
from view.watching import Watcher, ask, serving

from robosc.view import server as server_module
from robosc.view.hub import Hub
from robosc.view.server import PageServer, Where

Done = list[Any]


@pytest.fixture
def done() -> Done:
    """What was asked for and done."""
    return []


@pytest.fixture
def server(done: Done) -> Iterator[PageServer]:
    hub = Hub()
    hub.put("state", '"secret"')
    with serving(hub, {"/do": lambda document: done.append(document) or {}}) as running:
        yield running


def host_of(server: PageServer) -> str:
    return f"127.0.0.1:{server.server_address[1]}"


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:80", "127.0.0.1.evil.example", "localhost.evil.example", "[", "",
     "192.168.0.7", "127.0.0.1@evil.example", "evil.example#127.0.0.1"],
)  # fmt: skip
def test_names_that_lead_here_from_elsewhere_are_refused(
    host: str, server: PageServer, done: Done
) -> None:
    for path in ("/", "/stream", "/view.js"):
        code, _, body = ask(server, path, Host=host)
        assert (code, b"secret" in body) == (403, False)
    assert ask(server, "/do", {}, Host=host)[0] == 403
    assert done == []


@pytest.mark.parametrize(
    "headers",
    [
        {"Content_Type": "text/plain"},
        {"Content_Type": "application/x-www-form-urlencoded"},
        {"Origin": "http://evil.example"},
        {"Origin": "http://127.0.0.1:1"},
        {"Origin": "null"},
        {"Origin": "http://["},
        {"Sec_Fetch_Site": "cross-site"},
        {"Sec_Fetch_Site": "same-site"},
    ],
)
def test_orders_of_other_pages_are_refused(
    headers: dict[str, str], server: PageServer, done: Done
) -> None:
    assert ask(server, "/do", {"a": 1}, **headers)[0] == 403
    if "Content_Type" not in headers:
        assert ask(server, "/stream", **headers)[0] == 403
    assert done == []


def test_its_own_page_and_other_programs_may(server: PageServer, done: Done) -> None:
    own = {"Origin": f"http://{host_of(server)}", "Sec_Fetch_Site": "same-origin"}
    assert ask(server, "/do", {"a": 1}, Host=host_of(server), **own)[0] == 200
    assert ask(server, "/do", {"b": 2}, Host="localhost:1")[0] == 200
    assert done == [{"a": 1}, {"b": 2}]


@pytest.mark.parametrize("host", ["0.0.0.0", "robot.lab"])
def test_a_server_for_others_is_asked_by_address_or_its_own_name(host: str) -> None:
    # Nothing is resolved for this; a server that listens at that name would welcome the same.
    server = PageServer(Where("0.0.0.0", 0), Hub(), {})
    with server:
        server._host = host
        own = socket.gethostname()
        for name in ("192.168.0.7", "[fe80::1]:8642", "localhost", own, f"{own.upper()}.local:80"):
            assert server.welcomes(name), name
        assert server.welcomes("robot.lab") is (host == "robot.lab")
        for name in ("evil.example", "", None, "["):
            assert not server.welcomes(name), name


def test_who_listens_everywhere_tells_an_address_and_who_can_look(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(PageServer, "serve_forever", lambda *_, **__: None)
    for host, answers, told in (
        ("0.0.0.0", {}, "everyone who can reach this address can watch\n"),
        (
            "0.0.0.0",
            {"/do": lambda _: {}},
            "everyone who can reach this address can watch and play\n",
        ),
        ("127.0.0.1", {}, ""),
    ):
        with PageServer(Where(host, 0), Hub(), answers) as server:
            server.run()
            port = server.server_address[1]
        out, err = capsys.readouterr()
        assert err == f"{told}Ctrl-C ends it\n"
        assert "0.0.0.0" not in out
        # It leads back to this server: an address or a name that this machine has.
        name = out.removeprefix("http://").removesuffix(f":{port}/\n")
        assert socket.gethostbyname(name)
        assert (name == "127.0.0.1") is (host == "127.0.0.1")


ATTACK = b"""<!doctype html><title>elsewhere</title><script>
window.seen = [];
const target = location.search.slice(1);
const tries = [
  () => fetch(target + "do", {method: "POST", mode: "no-cors", body: '{"evil": 1}'}),
  () => fetch(target + "do", {method: "POST", body: '{"evil": 2}',
                              headers: {"Content-Type": "application/json"}}),
  () => fetch(target + "stream").then((r) => r.text()).then((t) => seen.push(t)),
  () => fetch(target).then((r) => r.text()).then((t) => seen.push(t)),
  () => new Promise((end) => {
    const source = new EventSource(target + "stream");
    source.onmessage = (m) => seen.push(m.data);
    source.onerror = () => { source.close(); end(); };
  }),
  () => new Promise((end) => {
    const frame = document.createElement("iframe");
    frame.src = target;
    frame.onload = () => { try { seen.push(frame.contentDocument?.body.textContent || ""); } catch {} end(); };
    document.body.append(frame);
  }),
  () => new Promise((end) => {
    const form = document.createElement("form");
    Object.assign(form, {method: "post", action: target + "do", enctype: "text/plain", target: "pane"});
    const pane = Object.assign(document.createElement("iframe"), {name: "pane"});
    pane.onload = () => end();
    form.append(Object.assign(document.createElement("input"), {name: '{"evil": "', value: '"}'}));
    document.body.append(pane, form);
    form.submit();
  }),
];
(async () => {
  for (const attempt of tries) await Promise.resolve(attempt()).catch(() => {});
  window.finished = true;
})();
</script><body></body>"""


def test_a_page_from_elsewhere_learns_nothing_and_does_nothing(
    server: PageServer, done: Done, browser: Browser
) -> None:
    class Elsewhere(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(ATTACK)

        def log_message(self, format: str, *args: Any) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere) as evil:
        thread = threading.Thread(target=evil.serve_forever, args=(0.01,))
        thread.start()
        try:
            # Another port is another origin; another name would be another site, too.
            for name in ("127.0.0.1", "localhost"):
                browser.open(f"http://{name}:{evil.server_address[1]}/?http://{host_of(server)}/")
                browser.sees("window.finished")
                assert "".join(browser.run("return seen")) == ""
        finally:
            evil.shutdown()
            thread.join()
    assert done == []
    browser.complaints()  # of what was refused


def streams(server: PageServer, count: int) -> list[socket.socket]:
    """Connections that ask for the stream and then read nothing of it, with little room for it."""
    opened = []
    for _ in range(count):
        connection = socket.socket()
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        connection.connect(server.server_address[:2])
        connection.sendall(f"GET /stream HTTP/1.1\r\nHost: {host_of(server)}\r\n\r\n".encode())
        opened.append(connection)
    return opened


def memory() -> float:
    """Megabytes that this process has in RAM."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * 4096 / 1e6


@pytest.mark.slow
def test_browsers_that_do_not_read_cost_no_memory_and_hold_up_nobody(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert server_module._Handler.timeout  # without, they would stay for ever
    monkeypatch.setattr(server_module._Handler, "timeout", 2.0)
    hub = Hub()
    others, before, most = set(threading.enumerate()), memory(), 0.0

    def own() -> int:
        """The threads that came since, for those of other tests may still be ending."""
        return len(set(threading.enumerate()) - others)

    def last_state(watcher: Watcher) -> bool:
        watcher.events.clear()
        return bool(watcher.seen["state"][0] == 250)

    with serving(hub) as server, ThreadPoolExecutor() as reader:
        asleep = streams(server, 30)
        await_condition(lambda: own() >= 31, "their threads")
        watcher = Watcher(server.server_port)
        hub.put("state", "[0]")
        watcher.until(lambda w: "state" in w.seen)
        read = reader.submit(watcher.until, last_state)
        for number in range(1, 251):  # 500 MB go by
            hub.add([f'"{number}.{event}{"x" * 2000}"' for event in range(1000)])
            hub.put("state", json.dumps([number, "y" * 100_000]))
            most = max(most, memory())
        read.result(60)
        # Each may be stuck with one document, less than 10 MB in all its forms.
        assert most - before < 30 * 10
        # They are given up, and with them what they still were to be sent.
        await_condition(lambda: own() <= 3, "the end of their threads")
        watcher.close()
        for connection in asleep:
            connection.close()


def test_an_event_may_carry_a_whole_map() -> None:
    hub = Hub()
    hub.add(["0"])
    follower = hub.follow()
    follower.take(0)
    for number in range(1, 21):
        hub.add([f'["{"m" * 300_000}",{number}]'])
    news = json.loads(follower.take(0) or "")
    kept = [number for _, number in news["events"]]
    assert kept == list(range(21 - len(kept), 21)) and 0 < len(kept) < 6
    assert news["dropped"] == 20 - len(kept)


@pytest.mark.parametrize(
    "start",
    [
        b"",
        b"GET / HT",
        b"POST /do HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99\r\n"
        b"Content-Type: application/json\r\n\r\n{",
    ],
)
def test_a_request_that_never_ends_is_given_up(
    start: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server_module._Handler, "timeout", 0.3)
    with (
        serving(Hub(), {"/do": lambda document: {}}) as server,
        socket.create_connection(server.server_address[:2], timeout=600) as connection,
    ):
        connection.sendall(start)
        assert b"200" not in connection.recv(1000)


def test_a_request_that_comes_byte_by_byte_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server_module._Handler, "timeout", 0.5)
    with (
        serving(Hub(), {}) as server,
        socket.create_connection(server.server_address[:2], timeout=0.05) as connection,
    ):
        connection.sendall(b"GET / HTTP/1.1\r\nX: ")

        def is_given_up() -> bool:
            try:
                connection.sendall(b"x")
                return b"200" not in connection.recv(1000)
            except TimeoutError:
                return False
            except OSError:
                return True

        await_condition(is_given_up, "the end of the connection")
