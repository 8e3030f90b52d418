"""Whatever a service does, each request ends in exactly one response or error."""

from __future__ import annotations

import pytest
from ros1.broken_service import BrokenService
from ros1.stage import Puppet, Stage, event, master_pid
from ros_support import await_condition, stopped

ASK = {"name": "/ask", "type": "gauntlet_interfaces/SetLevel"}
BOOL = "std_msgs/Bool"


def one_end_per_request(events: list[dict]) -> bool:  # type: ignore[type-arg]
    """Whether requests and ends of ``ask`` alternate."""
    kinds = [e["event"]["kind"] for e in events if e["event"]["name"] == "ask"]
    return all(kind == "request" for kind in kinds[::2]) and all(
        kind in ("response", "error") for kind in kinds[1::2]
    )


@pytest.mark.parametrize(("success", "delay"), [(True, 0.0), (False, 0.3)])
def test_a_service_that_answers(
    stage: Stage, puppet: Puppet, ear: Puppet, success: bool, delay: float
) -> None:
    puppet.do("service", **ASK, mode="answer", fields={"success": success}, delay=delay)
    with stage.controller(ear) as node:
        puppet.publish("/level", "std_msgs/Int16", 3)
        puppet.publish("/ask_wanted", BOOL, True)
        asked = puppet.wait(lambda line: line.get("asked") == "/ask", "the request")
        assert asked["message"] == {"level": 3}
        told = node.tells(event("response", "ask"))
        assert told["event"]["value"] == {"success": success}
        for _ in range(3):  # and again, and again
            mark = ear.mark
            node.tells(event("response", "ask"), since=mark)
        assert one_end_per_request(node.events())


@pytest.mark.parametrize(
    ("mode", "reason"), [("fail", "returned None"), ("throw", "thrown by the server")]
)
def test_a_service_that_refuses(
    stage: Stage, puppet: Puppet, ear: Puppet, mode: str, reason: str
) -> None:
    puppet.do("service", **ASK, mode=mode)
    with stage.controller(ear) as node:
        puppet.publish("/ask_wanted", BOOL, True)
        assert reason in node.tells(event("error", "ask"))["detail"]
        node.enters("Oracle", "resting")
        puppet.do("service", **ASK, mode="answer")
        node.tells(event("response", "ask"))
        assert one_end_per_request(node.events())


def test_a_service_that_is_absent_and_comes_later(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear, timeout__ask=0.5) as node:
        puppet.publish("/ask_wanted", BOOL, True)
        missing = "no server of /ask is connected"
        assert node.tells(event("error", "ask"))["detail"] == missing
        node.shows(lambda s: missing in s["unconnected"] and missing in str(s["faults"]))
        puppet.publish("/level", "std_msgs/Int16", 9)
        node.tells(event("request", "blow"))  # meanwhile, all else goes on
        await_condition(lambda: "]: " + missing in node.log, "the warning")
        puppet.do("service", **ASK, mode="answer")
        node.tells(event("response", "ask"))
        node.shows(lambda s: missing not in s["unconnected"] and missing not in str(s["faults"]))
        await_condition(lambda: "no longer: " + missing in node.log, "that it is back")
        assert node.log.count("]: " + missing) == 1
        assert one_end_per_request(node.events())


def test_waiting_for_a_server_counts_into_the_deadline_and_start_order_does_not_matter(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear, timeout__ask=30.0) as node:
        puppet.publish("/ask_wanted", BOOL, True)
        node.tells(event("request", "ask"))
        puppet.do("service", **ASK, mode="answer")
        node.tells(event("response", "ask"))
        assert node.events(event("error", "ask")) == []


@pytest.mark.parametrize("mode", ["hang", "slow"])
def test_a_service_that_answers_too_late(
    stage: Stage, puppet: Puppet, ear: Puppet, mode: str
) -> None:
    if mode == "hang":
        puppet.do("service", **ASK, mode="hang")
    else:
        puppet.do("service", **ASK, mode="answer", delay=3.0)
    with stage.controller(ear, timeout__ask=1.0) as node:
        puppet.publish("/ask_wanted", BOOL, True)
        for _ in range(12):  # more than may hang at one time
            mark = ear.mark
            assert node.tells(event("error", "ask"), since=mark)["detail"] == "no answer in time"
        puppet.publish("/ask_wanted", BOOL, False)
        node.tells(event("response", "ask_wanted", value=False))
        node.enters("Oracle", "resting")
        assert one_end_per_request(node.events())
        assert node.events(event("response", "ask")) == []


def test_a_server_that_dies_in_the_call(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.puppet() as victim, stage.controller(ear) as node:
        victim.do("service", **ASK, mode="die", delay=0.3)
        puppet.publish("/ask_wanted", BOOL, True)
        node.tells(event("error", "ask"))
        # A killed server stays registered; a new one takes its place.
        puppet.do("service", **ASK, mode="answer")
        node.tells(event("response", "ask"))
        assert one_end_per_request(node.events())


def test_a_server_that_stands_still(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    """It is there and takes connections, but the process does nothing: not even shake hands."""

    def want(wanted: bool) -> None:
        puppet.publish("/ask_wanted", BOOL, wanted)

    def rest() -> None:
        mark = ear.mark
        want(False)
        node.shows(
            lambda s: not s["variables"]["Switches.ask"] and s["communications"]["ask"] == "idle",
            since=mark,
        )

    def call(level: int) -> None:
        """As another client; what came before is done, too."""
        mark = puppet.mark
        puppet.do("call", name="/ask", type=ASK["type"], fields={"level": level})
        puppet.wait(lambda line: line.get("answered") == "/ask", "the answer", since=mark)
        victim.wait(lambda line: line.get("message") == {"level": level}, "the request")

    with stage.puppet() as victim, stage.controller(ear, timeout__ask=0.2) as node:
        victim.do("service", **ASK, mode="answer")
        want(True)
        node.tells(event("response", "ask"))
        rest()
        call(6)
        with stopped(victim.process.pid):
            before = len(node.events(event("error", "ask")))
            want(True)
            node.shows(lambda s: s["counters"]["errors"] >= before + 10)
            rest()
            mark = victim.mark
        # What nobody waits for is not done when the server goes on.
        call(7)
        asked = [line["message"]["level"] for line in victim.lines[mark:] if "asked" in line]
        assert asked == [7]
        mark = ear.mark
        want(True)
        node.tells(event("response", "ask"), since=mark)
        assert one_end_per_request(node.events())


def test_a_master_that_stands_still(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    """Nobody tells where the server is, so no call is sent until then."""
    puppet.do("service", **ASK, mode="answer")
    with stage.controller(ear, timeout__ask=0.1, rate=100) as node:
        puppet.publish("/ask_wanted", BOOL, False)
        with stopped(master_pid(stage.master)):
            puppet.publish("/ask_wanted", BOOL, True)
            absent = event("error", "ask", detail="no server has taken it", reason="absent")
            node.tells(absent)
            mark = ear.mark
            node.tells(absent, since=mark)
        node.tells(event("response", "ask"), since=mark)
        assert one_end_per_request(node.events())
        assert node.shows(lambda s: s["counters"]["errors"] > 1)["counters"]["failed"] == 0


def test_a_service_that_breaks_the_protocol(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    faults = {
        "hang up": "no server has taken it",
        "nonsense": "no server has taken it",
        "hang up in the call": "unable to receive",
        "reset": "transport error",
        "part": "unable to receive",
        "nothing": "cannot deserialize",
        "too much": "cannot deserialize",
        "endless": "no answer in time",
        "refusal without a reason": "responded with an error",
        "refusal in no language": "responded with an error",
        "two answers": "cannot deserialize",
    }
    with (
        BrokenService.at(stage.master, "/ask") as broken,
        stage.controller(ear, timeout__ask=0.5) as node,
    ):
        puppet.publish("/ask_wanted", BOOL, True)
        for fault, reason in faults.items():
            broken.fault = fault
            mark = ear.mark
            node.tells(
                lambda e, reason=reason: e["event"]["kind"] == "error" and reason in e["detail"],
                since=mark,
            )
        assert one_end_per_request(node.events())
        assert "Traceback" not in node.log


def test_a_service_of_another_type(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("service", name="/ask", type="std_srvs/SetBool")
    with stage.controller(ear) as node:
        puppet.publish("/ask_wanted", BOOL, True)
        assert "md5sum" in node.tells(event("error", "ask"))["detail"]
        assert node.process.poll() is None
