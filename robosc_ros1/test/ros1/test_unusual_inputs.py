"""Messages that the model does not expect, and clocks that do not run as usual."""

from __future__ import annotations

import signal

import pytest
from ros1.stage import Puppet, Stage, event
from ros_support import await_condition

INT = "std_msgs/Int16"
BOOL = "std_msgs/Bool"


def test_a_value_out_of_range_is_told_and_ignored(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    ear.do("listen", topic="/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    with stage.controller(ear) as node:
        puppet.publish("/level", INT, 12)
        told = node.tells(event("response", "level", outcome="mismatch"))
        assert "outside 0..9" in told["detail"]
        state = node.shows(lambda s: s["counters"]["mismatches"] == 1)
        assert state["variables"]["Switches.height"] == 0
        ear.hears("/diagnostics", lambda m: m["status"][0]["level"] == 1)
        assert "outside 0..9" in node.log
        puppet.publish("/level", INT, 9)
        node.tells(event("request", "blow"))


def test_what_is_assumed_away_is_told_and_shown(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    number = "std_msgs/Float32"
    with stage.controller(ear, "hoist_controller") as node:
        for command in ("rise", "hold"):
            puppet.do("listen", topic=f"/hoist/{command}", type="std_msgs/Empty")
        puppet.steadily("/hoist/height", number, 0.5)
        node.tells(event("request", "rise"))
        puppet.publish("/hoist/door", BOOL, True)
        told = node.tells(event("response", "door", outcome="mismatch"))
        assert told["detail"].startswith("assume never Cabin.moving and Cabin.open (")
        state = node.shows(lambda s: any("assume never" in fault for fault in s["faults"]))
        assert state["variables"]["Cabin.open"] is False
        # What counts as not arrived does not keep a message fresh.
        puppet.steadily("/hoist/height", number, -1.0)
        node.tells(event("response", "height", outcome="mismatch"))
        node.tells(event("timeout", "height"))
        node.tells(event("request", "hold"))


def test_the_policy_stop_makes_a_safe_stop(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("listen", topic="/halt", type="std_msgs/Empty")
    ear.do("listen", topic="/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    with stage.controller(ear, on_mismatch="stop", stop_command="halt") as node:
        puppet.publish("/level", INT, 9)
        node.tells(event("request", "blow"))
        mark = puppet.mark
        puppet.publish("/level", INT, 12)
        puppet.hears("/halt", since=mark)
        assert "outside 0..9" in node.shows(lambda s: s["stopped"])["stopped"]
        ear.hears("/diagnostics", lambda m: m["status"][0]["level"] == 2)
        before = len(node.events(event("request", "blow")))
        puppet.publish("/level", INT, 8)
        node.tells(event("response", "level", value=8))  # still followed
        assert len(node.events(event("request", "blow"))) == before
        assert node.process.poll() is None


def test_a_safe_stop_may_end_the_node(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.controller(ear, on_mismatch="stop", exit_on_stop="true") as node:
        puppet.publish("/level", INT, 12)
        assert node.process.wait(60) == 1


@pytest.mark.parametrize(
    ("number", "value"), [(float("nan"), "cool"), (float("inf"), "warm"), (-float("inf"), "cool")]
)
def test_numbers_that_are_none_take_the_rules_as_they_are(
    stage: Stage, puppet: Puppet, ear: Puppet, number: float, value: str
) -> None:
    with stage.controller(ear) as node:
        puppet.publish("/reading", "std_msgs/Float32", number)
        assert node.tells(event("response", "reading"))["event"]["value"] == value


def test_numbers_that_are_none_may_be_data(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    run = {"name": "/run", "type": "gauntlet_interfaces/ReachAction"}
    puppet.do("action", **run, mode="hold", feedback=[float("inf"), float("nan")])
    with stage.controller(ear) as node:
        puppet.publish("/run_wanted", BOOL, True)
        node.tells(event("feedback", "run", value="Infinity"))
        node.tells(event("feedback", "run", value="NaN"))
        node.shows(lambda s: s["variables"]["Runner.progress"] == "NaN")


def test_arrays_that_are_too_short(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    scan = {"type": "gauntlet_interfaces/Scan"}
    ear.do("listen", topic="/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    with stage.controller(ear, "gauntlet_controller") as node:
        full = {"ranges": [0.1, 0.2, 3.0], "label": "full"}
        for topic in ("/scan", "/spots"):
            puppet.do("publish", topic=topic, **scan, fields=full)
        node.tells(event("response", "scan", value="near"))
        node.shows(lambda s: s["variables"]["Eye.lambda"] == "full")
        mark = ear.mark
        for topic in ("/scan", "/spots"):
            puppet.do("publish", topic=topic, **scan, fields={"label": "empty"})
        node.tells(event("response", "scan", value="unknown"))
        state = node.shows(lambda s: s["variables"]["Eye.lambda"] == "empty", since=mark)
        # What did not come changes nothing; the rest does.
        assert state["variables"]["Eye.nearest"] == 1.5
        assert state["counters"]["undefined"] >= 3
        ear.hears("/diagnostics", lambda m: "new undefined" in m["status"][0]["message"])
        assert "an array was too short" in node.log


def test_neighbours_of_other_types_are_not_heard_but_told(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    ear.do("listen", topic="/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    with stage.controller(ear, timeout__run=0.5) as node:
        with stage.puppet() as stranger:
            stranger.publish("/reading", "std_msgs/String", "very warm", connected=False)
            stranger.publish("/ask_wanted", BOOL, True, connected=False, md5="0" * 32)
            stranger.do("listen", topic="/halt", type="std_msgs/String", connected=False)
            stranger.do("action", name="/run", type="actionlib/TestAction")
            faults = node.shows(lambda s: len(s["faults"]) == 6)["faults"]
            expected = (
                "publishes /reading as std_msgs/String, but this node has std_msgs/Float32 there",
                "publishes /ask_wanted, but cannot connect to this node: build both with the same"
                " definition of std_msgs/Bool",
                "subscribes to /halt as std_msgs/String, but this node has std_msgs/Empty there",
                "subscribes to /run/goal as actionlib/TestActionGoal",
                "publishes /run/result as actionlib/TestActionResult",
            )
            for text in expected:
                assert any(text in fault for fault in faults), (text, faults)
            await_condition(lambda: all(text in node.log for text in expected), "the warnings")
            ear.hears("/diagnostics", lambda m: m["status"][0]["message"] == ", ".join(faults))
            # All that fits goes on.
            puppet.publish("/level", INT, 9)
            node.tells(event("request", "blow"))
            puppet.publish("/run_wanted", BOOL, True)
            missing = "no server of /run is connected"
            assert node.tells(event("error", "run"))["detail"] == missing
            assert node.events(event("response", "reading")) == []
            mark = ear.mark
        node.shows(lambda s: all(missing in fault for fault in s["faults"]), since=mark)


def test_a_second_publisher_of_a_command_is_told(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    ear.do("listen", topic="/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    with stage.controller(ear) as node:
        with stage.puppet() as stranger:
            stranger.publish("/blow", INT, 1, connected=False)
            (fault,) = node.shows(lambda s: s["faults"])["faults"]
            assert "also publishes /blow" in fault
            ear.hears("/diagnostics", lambda m: m["status"][0]["message"] == fault)
            await_condition(lambda: fault in node.log, "the warning")
            mark = ear.mark
        node.shows(lambda s: s["faults"] == [], since=mark)


def test_who_was_killed_is_missed(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    """The master goes on naming it."""
    missing = "nobody publishes /reading"
    with stage.controller(ear) as node:
        with stage.puppet() as stranger:
            stranger.publish("/reading", "std_msgs/Float32", 1.0)
            # Not before the first look around, which finds nobody at another topic.
            node.shows(lambda s: s["unconnected"] and missing not in s["unconnected"])
            mark = ear.mark
        node.shows(lambda s: missing in s["unconnected"], since=mark)


def test_two_thousand_messages_are_all_taken_in_order(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear) as node:
        puppet.publish("/level", INT, 3, times=1000, rate=2000)
        puppet.publish("/level", INT, 4, times=1000, rate=2000)
        state = node.shows(lambda s: s["counters"]["inputs"] == 2000)
        node.tells(lambda e: e["number"] == state["number"])  # another topic, perhaps later
        values = [e["event"]["value"] for e in node.events(event("response", "level"))]
        assert values == [3] * 1000 + [4] * 1000


def test_simulated_time_stops_starts_and_jumps(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.simulated_time(), stage.controller(ear, rate=10.0, timeout__ask=0.5) as node:

        def commands() -> int:
            return len(node.events(event("request", "blow")))

        def step(seconds: float, at_least: int) -> None:
            """Set the clock until the controller has sent its command again."""
            mark = ear.mark
            puppet.do("clock", seconds=seconds, to=node.name)
            for _ in range(at_least):
                node.tells(event("request", "blow"), since=mark)

        # The clock stands at 0: edges work, nothing repeats.
        puppet.publish("/level", INT, 9)
        node.tells(event("request", "blow"))
        puppet.publish("/reading", "std_msgs/Float32", 99.0)
        node.tells(event("response", "reading"))
        assert commands() == 1
        # It runs from 0.
        step(0.11, 1)
        step(0.25, 1)
        # It jumps back, and goes on.
        step(500.0, 1)
        before = commands()
        puppet.do("clock", seconds=1.0, to=node.name)
        puppet.publish("/reading", "std_msgs/Float32", 9.0)
        node.tells(event("response", "reading", value="cool"))
        assert commands() == before
        step(1.11, 1)
        # It stands still: deadlines run by wall time all the same.
        puppet.publish("/ask_wanted", BOOL, True)
        missing = "no server of /ask is connected"
        assert node.tells(event("error", "ask"))["detail"] == missing
        # And so does the end.
        node.process.send_signal(signal.SIGINT)
        assert node.process.wait(60) == 0
