"""The operator's hand: only who has the token, from the server's own page, on this machine."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from view.watching import ask, serving

from robosc.errors import UsageError
from robosc.view.hub import Hub
from robosc.view.operating import OperatorDesk, awaited
from robosc.view.server import PageServer, Unable, Where

TOKEN = "a-token"
MODEL = {
    "communications": [
        {"name": "go", "component": "Operator", "kind": "outgoing message"},
        {"name": "unheard", "component": "Operator", "kind": "outgoing message"},
        {"name": "scan", "component": "Laser", "kind": "outgoing message"},
        {"name": "move", "component": "Operator", "kind": "incoming message"},
    ],
    "topics": {"go": "/want", "scan": "/scan"},
}


class Noted:
    """A hand that notes what it does."""

    def __init__(self) -> None:
        self.done: list[Any] = []

    def order(self, word: str) -> None:
        self.done.append(word)

    def publish(self, topic: str, data: Any) -> None:
        if data == "unfit":
            raise Unable("it does not fit")
        self.done.append((topic, data))


@pytest.fixture
def hand() -> Noted:
    return Noted()


@pytest.fixture
def log() -> list[str]:
    return []


@pytest.fixture
def server(hand: Noted, log: list[str]) -> Iterator[PageServer]:
    operating = OperatorDesk(hand, ["Operator"], lambda: MODEL, log.append)
    with serving(Hub(), operating.answers, TOKEN) as running:
        yield running


def operate(server: PageServer, document: Any, token: str | None = TOKEN, **more: str) -> int:
    headers = {} if token is None else {"Authorization": f"Bearer {token}"}
    return ask(server, "/operate", document, **headers, **more)[0]


def test_orders_and_messages_of_persons_are_passed_on_and_logged(
    server: PageServer, hand: Noted, log: list[str]
) -> None:
    for word in ("hold", "step", "release"):
        assert operate(server, {"order": word}) == 200
    assert operate(server, {"send": "go", "text": "true"}) == 200
    assert operate(server, {"send": "go", "text": '{"x": 1, "y": [2]}'}) == 200
    assert operate(server, {"send": "go", "text": ""}) == 200
    data = [("/want", True), ("/want", {"x": 1, "y": [2]}), ("/want", {})]
    assert hand.done == ["hold", "step", "release", *data]
    assert [line.partition("operator: ")[2] for line in log] == [
        "hold", "step", "release", "go true", 'go {"x": 1, "y": [2]}', "go"
    ]  # fmt: skip


@pytest.mark.parametrize("token", [None, "", "another", TOKEN[:-1], TOKEN + "x", "\xe4"])
def test_who_has_no_token_may_do_nothing(
    server: PageServer, hand: Noted, token: str | None
) -> None:
    assert operate(server, {"order": "hold"}, token) == 403
    assert hand.done == []


def test_nothing_is_sent_before_the_model_is_known(hand: Noted, log: list[str]) -> None:
    desk = OperatorDesk(hand, ["Operator"], lambda: None, log.append)
    with pytest.raises(Unable, match="has not told its model yet"):
        desk.do({"send": "go", "text": "true"})
    assert hand.done == []


@pytest.mark.parametrize(
    "headers",
    [{"Origin": "http://evil.example"}, {"Host": "evil.example"}, {"Sec-Fetch-Site": "cross-site"},
     {"Content-Type": "text/plain"}],
)  # fmt: skip
def test_pages_from_elsewhere_may_do_nothing_even_with_the_token(
    server: PageServer, hand: Noted, headers: dict[str, str]
) -> None:
    assert operate(server, {"order": "hold"}, **headers) == 403
    assert hand.done == []


@pytest.mark.parametrize(
    "document",
    [{"order": "dance"}, {"order": ["hold"]}, {"send": "scan", "text": "1"}, {"send": "move", "text": "1"},
     {"send": "nothing", "text": "1"}, {"send": "unheard", "text": "1"}, {"send": "go", "text": "{"},
     {"send": "go", "text": "unfit"}, {}, [], "hold"],
)  # fmt: skip
def test_nothing_else_can_be_asked(server: PageServer, hand: Noted, document: Any) -> None:
    assert operate(server, document) == 409
    assert hand.done == []


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.0.7", "::", "robot.local"])
def test_an_operator_sits_at_this_machine(host: str) -> None:
    with pytest.raises(UsageError, match="can be reached from other machines"):
        PageServer(Where(host, 0), Hub(), {}, TOKEN)


def test_the_token_stands_in_the_printed_address_where_browsers_keep_it(server: PageServer) -> None:
    assert server.url.endswith(f"/#token={TOKEN}")


def test_who_hears_a_topic_may_be_known_late() -> None:
    seen = iter([None, 0, [], "std_msgs/msg/String"])
    assert awaited("/node/operate", lambda: next(seen)) == "std_msgs/msg/String"
