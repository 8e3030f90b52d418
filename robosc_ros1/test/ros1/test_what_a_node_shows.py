"""What a running node tells, by its schemas, and what ROS's own tools make of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
from ros1.stage import Puppet, Stage, event
from ros_support import Completed, Master, Workspace, await_condition
from runtime.schemas import validate

from robosc.simulate.event_log import read_log

INT = "std_msgs/Int16"
RUN = {"name": "/run", "type": "gauntlet_interfaces/ReachAction"}
ASK = {"name": "/ask", "type": "gauntlet_interfaces/SetLevel"}


def play(puppet: Puppet, ear: Puppet, stage: Stage, **parameters: object) -> None:
    puppet.do("action", **RUN, mode="succeed", feedback=1)
    puppet.do("service", **ASK, mode="answer")
    ear.do("listen", topic="/probe_controller/model", type="std_msgs/String")
    with stage.controller(ear, **parameters) as node:
        puppet.publish("/level", INT, 9)
        puppet.publish("/run_wanted", "std_msgs/Bool", True)
        puppet.publish("/ask_wanted", "std_msgs/Bool", True)
        node.tells(event("response", "run"))
        node.tells(event("response", "ask"))
        puppet.publish("/level", INT, 99)
        node.tells(event("response", "level", outcome="mismatch"))
        node.shows(lambda s: s["counters"]["mismatches"] == 1)


def test_all_documents_follow_their_schemas(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    play(puppet, ear, stage)
    # Latched, so whoever connects twice gets it twice, as rospy may.
    models = ear.all_heard("/probe_controller/model")
    assert models and all(model == models[0] for model in models)
    validate(models[0], "model")
    events = ear.all_heard("/probe_controller/events")
    for document in events:
        validate(document, "event")
    for document in ear.all_heard("/probe_controller/state"):
        validate(document, "state")
    numbers = [e["number"] for e in events]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def test_a_command_that_is_not_enabled_names_the_requirement_and_its_line(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear) as node:
        puppet.publish("/level", INT, 3)
        puppet.publish("/reading", "std_msgs/Float32", 99.0)
        state = node.shows(lambda s: s["variables"]["Switches.reading"] == "warm")
        blocked = {c["event"]["name"]: c["blocked_by"] for c in state["commands"]}
        assert [reason["text"] for reason in blocked["blow"]] == [
            "requirement blow needs Switches.height > loud"
        ]
        (reason,) = blocked["halt"]
        assert reason["text"] == "requirement Switches.reading = warm disables halt"
        file, _, line = reason["place"].partition(":")
        source = (stage.model_folder / file).read_text(encoding="utf-8").splitlines()
        assert "Switches.reading = warm disables halt" in source[int(line) - 1]
        puppet.publish("/run_wanted", "std_msgs/Bool", True)  # nobody answers
        state = node.shows(lambda s: s["components"]["Runner"] == "running")
        run, cancel = (c["blocked_by"] for c in state["commands"] if c["event"]["name"] == "run")
        assert [reason["text"] for reason in run] == [
            "it is busy", "blocked by Runner in running",
        ]  # fmt: skip
        (reason,) = cancel
        assert reason["text"] == "this requirement holds: requirement run needs Switches.run"
        assert "run needs Switches.run" in source[int(reason["place"].partition(":")[2]) - 1]


@pytest.mark.once
def test_values_are_published_for_tools_that_plot(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    values = "/thermostat_controller/values"
    for name, type_ in {
        "Sensor/degrees": "Float64", "Sensor/season": "String", "Heater/level": "Int64",
        "Heater": "Int32",
    }.items():  # fmt: skip
        ear.do("listen", topic=f"{values}/{name}", type=f"std_msgs/{type_}", connected=False)
    with stage.controller(ear, "thermostat_controller", publish_values=True):
        puppet.do("listen", topic="/heat", type="std_msgs/Float32")
        assert ear.hears(f"{values}/Heater")["data"] == 0
        assert ear.hears(f"{values}/Sensor/season")["data"] == "winter"
        puppet.publish("/reading", "std_msgs/Float32", -3.5)
        ear.hears(f"{values}/Sensor/degrees", lambda m: m["data"] == -3.5)
        ear.hears(f"{values}/Heater/level", lambda m: m["data"] == 2)
        ear.hears(f"{values}/Heater", lambda m: m["data"] == 1)


def test_the_state_is_latched(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.controller(ear), stage.puppet() as late:
        for topic in ("state", "model"):
            late.do("listen", topic=f"/probe_controller/{topic}", type="std_msgs/String")
            late.hears(f"/probe_controller/{topic}")


def test_what_is_shown_can_be_chosen(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    ear.do("listen", topic="/state", type="std_msgs/String")
    shown = {"publish_events": "false", "legacy_state_topic": "/state", "state_rate": 2.0}
    with stage.controller(ear, **shown) as node:
        puppet.publish("/level", INT, 3, times=50, rate=50.0)
        node.shows(lambda s: s["counters"]["inputs"] == 50)
        times = [state["time"] for state in ear.all_heard("/probe_controller/state")]
        assert all(late - soon > 0.49 for soon, late in pairwise(times))
        ear.hears("/state", lambda m: "message_level.u_response" in m["transitions"])
        legacy = ear.hears(
            "/state", lambda m: m["current"]["Switches"]["variables"]["height"] == "3"
        )
        states = {name: told["state"] for name, told in legacy["current"].items()}
        assert states == {"Switches": "on", "Oracle": "resting", "Runner": "resting"}
        assert legacy["definition"]["name"] == "Probe"
        _, _, (publications, _, _) = ServerProxy(stage.master.uri).getSystemState("/test")  # type: ignore
        topics = {topic for topic, nodes in publications if "/probe_controller" in nodes}
        assert "/probe_controller/events" not in topics
        assert {"/state", "/probe_controller/state", "/probe_controller/model"} <= topics


def play_everything(puppet: Puppet, ear: Puppet, stage: Stage, **parameters: object) -> None:
    """Each sort of event, and an end by SIGINT within a goal."""
    puppet.do("action", **RUN, mode="hold", feedback=2)
    puppet.do("service", **ASK, mode="throw")
    with stage.controller(ear, stop_command="halt", **parameters) as node:
        puppet.publish("/level", INT, 9)
        for value in ("NaN", "Infinity", 31.5):
            puppet.publish("/reading", "std_msgs/Float32", float(value))
        puppet.publish("/ask_wanted", "std_msgs/Bool", True)
        node.tells(event("error", "ask"))
        puppet.do("service", **ASK, mode="answer")
        node.tells(event("response", "ask"))
        puppet.publish("/run_wanted", "std_msgs/Bool", True)
        node.tells(event("feedback", "run"))
        puppet.publish("/run_wanted", "std_msgs/Bool", False)
        node.tells(event("cancel", "run"))
        node.tells(event("cancelled", "run"))
        puppet.do("action", **RUN, mode="succeed")
        puppet.publish("/run_wanted", "std_msgs/Bool", True)
        node.tells(event("response", "run"))
        puppet.publish("/level", INT, 99)
        node.tells(event("response", "level", outcome="mismatch"))
        puppet.do("action", **RUN, mode="hold")
        node.shows(lambda s: s["communications"]["run"] == "busy", since=ear.mark)


def test_a_node_s_own_log_follows_its_model(
    stage: Stage, puppet: Puppet, ear: Puppet, tmp_path: Path, robosc: Callable[..., Completed]
) -> None:
    log = tmp_path / "events.jsonl"
    limits = {"event_log_size": 0.005, "event_log_files": 1000}
    for _ in range(2):
        play_everything(puppet, ear, stage, event_log=log, **limits)
    assert (tmp_path / "events.jsonl.1").exists()
    assert all(path.stat().st_size < 5500 for path in tmp_path.glob("events.jsonl*"))

    entries = [entry.document for entry in read_log(str(log))]
    for document in entries:
        validate(document, "event")
    heard = ear.all_heard("/probe_controller/events")
    assert len(heard) > 20
    assert all(document in entries for document in heard)
    assert [e["detail"] for e in entries].count("stop command") == 2
    told = {(e["event"]["kind"], e["event"]["name"]) for e in entries}
    assert told == {
        *(("response", name) for name in ("level", "reading", "ask_wanted", "run_wanted")),
        *((kind, "ask") for kind in ("request", "response", "error")),
        *((kind, "run") for kind in ("request", "response", "feedback", "cancel", "cancelled")),
        ("request", "blow"), ("request", "halt"),
    }  # fmt: skip

    model = str(stage.model_folder / "probe.rscd")
    done = robosc("replay", str(log), model)
    assert done.stdout == (
        f"Probe: 2 runs, {len(entries)} events, 2 mismatches reported: follows the model\n"
    )
    # The last answer of the service was not what the node says it was.
    answers = [(e["event"]["kind"], e["event"]["name"]) == ("response", "ask") for e in entries]
    number = max(n for n, answer in enumerate(answers) if answer)
    entries[number]["event"]["value"] = {"success": "yes"}
    (tmp_path / "forged").write_text("".join(json.dumps(e) + "\n" for e in entries))
    done = robosc("replay", "forged", model)
    assert done.returncode == 1
    assert done.stdout.startswith(f"forged:{number + 1}: event ")


INPUTS = (
    ("/level", INT, 3),
    ("/reading", "std_msgs/Float32", 1.0),
    ("/ask_wanted", "std_msgs/Bool", False),
    ("/run_wanted", "std_msgs/Bool", False),
)
OUTPUTS = (
    ("/blow", INT),
    ("/halt", "std_msgs/Empty"),
    ("/diagnostics", "diagnostic_msgs/DiagnosticArray"),
    ("/probe_controller/model", "std_msgs/String"),
)


def test_tools_of_ros_have_no_complaint(
    generated_workspace: Workspace, roscore: Master, tmp_path: Path
) -> None:
    # A master of its own: others have killed nodes, which roswtf complains of.
    stage = Stage(generated_workspace, roscore)
    bag = tmp_path / "run.bag"
    topics = ["/probe_controller/events", "/probe_controller/state", "/level", "/blow"]

    def tool(*command: str, check: bool = True) -> str:
        return stage.workspace.run(*command, master=roscore, check=check).stdout

    with stage.puppet() as puppet, stage.puppet() as ear, stage.controller(ear) as node:
        # Everybody is there to whom the node listens or talks.
        puppet.do("action", **RUN, mode="succeed")
        puppet.do("service", **ASK, mode="answer")
        for topic, type_, value in INPUTS:
            puppet.publish(topic, type_, value)
        for topic, type_ in OUTPUTS:
            ear.do("listen", topic=topic, type=type_)
        with stage.workspace.recording(bag, *topics, master=roscore):
            recorder = await_condition(lambda: recorder_of(roscore, topics), "the recorder")
            roscore.await_links(recorder)
            puppet.publish("/level", INT, 9)
            node.tells(event("request", "blow"))
            assert "probe_controller: controller" in tool(
                "rostopic", "echo", "-n", "1", "/diagnostics"
            )
            assert "/blow [std_msgs/Int16]" in tool("rosnode", "info", "/probe_controller")
        problems = tool("roswtf", check=False)
        assert "probe_controller" not in problems, problems
        mark = ear.mark
        tool("rosbag", "play", "--wait-for-subscribers", str(bag), "--topics", "/level")
        node.tells(event("response", "level"), since=mark)


ANALYSERS = """\
pub_rate: 5.0
analyzers:
  robots: {type: diagnostic_aggregator/GenericAnalyzer, path: Robots, contains: ": controller"}
"""


def test_the_diagnostic_aggregator_shows_the_node(
    stage: Stage, puppet: Puppet, ear: Puppet, tmp_path: Path
) -> None:
    if stage.workspace.run("rospack", "find", "diagnostic_aggregator", check=False).returncode:
        pytest.skip("diagnostic_aggregator is not installed (./dev setup installs it)")
    analysers = tmp_path / "analysers.yaml"
    analysers.write_text(ANALYSERS)
    stage.workspace.run("rosparam", "load", str(analysers), "/aggregator", master=stage.master)
    ear.do("listen", topic="/diagnostics_agg", type="diagnostic_msgs/DiagnosticArray")

    def shown(level: int, message: str) -> None:
        def condition(array: dict[str, Any]) -> bool:
            states = {s["name"]: s for s in array["status"]}
            group = states.get("/Robots", {"level": None})
            one = states.get("/Robots/probe_controller: controller", {"message": ""})
            return group["level"] == level and message in one["message"]

        ear.hears("/diagnostics_agg", condition)

    aggregator = ("rosrun", "diagnostic_aggregator", "aggregator_node", "__name:=aggregator")
    with (
        stage.workspace.start(*aggregator, master=stage.master),
        stage.controller(ear, on_mismatch="stop", timeout__ask=0.1),
    ):
        shown(0, "running")
        puppet.publish("/ask_wanted", "std_msgs/Bool", True)
        shown(1, "new errors")
        puppet.publish("/level", INT, 99)
        shown(2, "safe stop: mismatch: the value is 99, outside 0..9")


def recorder_of(master: Master, topics: list[str]) -> str | None:
    """The name of the node that records topics, once it listens to all of them."""
    _, _, (_, subscriptions, _) = ServerProxy(master.uri).getSystemState("/test")  # type: ignore
    heard = {(topic, node) for topic, nodes in subscriptions for node in nodes}
    names = {node for _, node in heard if node.startswith("/record")}
    return next((n for n in names if heard >= {(topic, n) for topic in topics}), None)
