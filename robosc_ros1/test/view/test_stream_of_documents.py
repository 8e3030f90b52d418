"""What a browser gets over HTTP, from hub and server, without a browser."""

from __future__ import annotations

import json
import re

import pytest
from view.watching import Watcher, ask, serving

from robosc.errors import UsageError
from robosc.view.hub import Hub, compact
from robosc.view.server import PAGE, PageServer, Unable, Where


def test_a_late_follower_gets_the_latest_documents_and_events() -> None:
    hub = Hub()
    hub.put("state", "1")
    hub.put("state", "2")
    hub.add(str(n) for n in range(1000))
    news = json.loads(hub.follow().take(1) or "")
    assert news == {"state": 2, "events": list(range(800, 1000))}


def test_states_replace_one_another_and_events_do_not() -> None:
    hub = Hub()
    follower = hub.follow()
    assert follower.take(0) is None
    for n in range(5):
        hub.put("state", str(n))
        hub.add([str(n)])
    assert json.loads(follower.take(1) or "") == {"state": 4, "events": [0, 1, 2, 3, 4]}
    hub.put("state", "4")  # the same again
    assert follower.take(0) is None


def test_who_falls_far_behind_is_told_how_many_events_were_missed() -> None:
    hub = Hub()
    hub.add(["0"])
    follower = hub.follow()
    follower.take(1)
    hub.add(str(n) for n in range(1, 7001))
    news = json.loads(follower.take(1) or "")
    assert news["dropped"] == 2000
    assert news["events"] == list(range(2001, 7001))


def test_another_run_forgets_events_that_were_not_told_yet() -> None:
    hub = Hub()
    follower = hub.follow()
    hub.add(["1", "2"])
    hub.clear()
    hub.add(["3"])
    news = json.loads(follower.take(1) or "")
    assert (news["events"], "run" in news, "dropped" in news) == ([3], True, False)


def test_many_watch_one_hub() -> None:
    hub = Hub()
    with serving(hub) as server:
        hub.put("ready", "true")
        watchers = [Watcher(server.server_port) for _ in range(12)]
        for watcher in watchers:  # who comes late is not told of all events
            watcher.until(lambda w: "ready" in w.seen)
        for n in range(500):
            hub.put("state", f'{{"number":{n}}}')
            hub.add([str(n)])
        for watcher in watchers:
            watcher.until(lambda w: w.seen.get("state") == {"number": 499} and len(w.events) == 500)
            assert watcher.events == list(range(500))
            watcher.close()


def test_half_of_a_surrogate_pair_does_not_end_the_stream() -> None:
    """As a string in an event log may have it, written as an escape."""
    hub, half = Hub(), {"value": "\ud800 and more"}
    with serving(hub, {"/echo": lambda document: document}) as server:
        hub.add([compact(half)])
        watcher = Watcher(server.server_port)
        watcher.until(lambda w: w.events == [half])
        watcher.close()
        code, _, body = ask(server, "/echo", half)
        assert (code, json.loads(body)) == (200, half)


def test_the_page_needs_nothing_from_elsewhere() -> None:
    with serving(Hub()) as server:
        code, _, body = ask(server, "/")
        used = re.findall(r'(?:src|href)="([\w.]+)"', body.decode())
        assert sorted(["index.html", *used]) == sorted(file.name for file in PAGE.iterdir())
        for path in ("/", *(f"/{name}" for name in used)):
            code, headers, body = ask(server, path)
            assert code == 200
            assert headers["Content-Security-Policy"].startswith("default-src 'self'")
            text = re.sub(
                rb"/\*!.*?\*/", b"", body, flags=re.DOTALL
            )  # libraries say whose they are
            addresses = set(re.findall(rb"https?://[^\s\"']+", text))
            assert addresses <= {b"http://www.w3.org/2000/svg"}, path


@pytest.mark.parametrize("path", ["/nothing", "/../server.py", "/page/view.js", "//etc/passwd"])
def test_there_is_nothing_else_to_get(path: str) -> None:
    with serving(Hub()) as server:
        assert ask(server, path)[0] == 404


def test_what_cannot_be_done_is_told() -> None:
    def refuse(_: object) -> None:
        raise Unable("not today")

    with serving(Hub(), {"/do": refuse}) as server:
        code, _, body = ask(server, "/do", {})
        assert (code, json.loads(body)) == (409, {"message": "not today"})
        assert ask(server, "/other", {})[0] == 404
        assert ask(server, "/do", "[" * 60_000)[0] == 409  # a string is JSON, too
        assert ask(server, "/do", "x" * 200_000)[0] == 400


def test_a_port_that_is_taken_is_an_error_only_where_it_was_asked_for() -> None:
    with serving(Hub()) as server:
        port = server.server_address[1]
        with pytest.raises(UsageError, match=f"port {port}"):
            PageServer(Where(port=int(port)), Hub(), {})
    with (
        PageServer(Where(), Hub(), {}) as one,
        PageServer(Where(), Hub(), {}) as two,
    ):
        assert one.url != two.url


def test_a_host_that_is_not_this_machines_is_an_error() -> None:
    with pytest.raises(UsageError, match=r"203\.0\.113\.7"):
        PageServer(Where("203.0.113.7", 0), Hub(), {})
