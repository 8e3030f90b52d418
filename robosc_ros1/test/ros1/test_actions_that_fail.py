"""Whatever an action server does, each goal ends in exactly one response, error or cancelled."""

from __future__ import annotations

import os
import signal

import pytest
from ros1.stage import Node, Puppet, Stage, event
from ros_support import stopped

RUN = {"name": "/run", "type": "gauntlet_interfaces/ReachAction"}
BOOL = "std_msgs/Bool"


def want(puppet: Puppet, wanted: bool) -> None:
    puppet.publish("/run_wanted", BOOL, wanted)


def await_acceptance(ear: Puppet) -> None:
    """Until the server has told twice that the goal is active: the controller has heard the first."""
    ear.do("listen", topic="/run/status", type="actionlib_msgs/GoalStatusArray")
    for _ in range(2):
        ear.hears(
            "/run/status",
            lambda message: any(goal["status"] == 1 for goal in message["status_list"]),
            since=ear.mark,
        )


def goals_end_once(node: Node) -> bool:
    kinds = [e["event"]["kind"] for e in node.events() if e["event"]["name"] == "run"]
    kinds = [kind for kind in kinds if kind not in ("feedback", "cancel")]
    return all(kind == "request" for kind in kinds[::2]) and all(
        kind in ("response", "error", "cancelled") for kind in kinds[1::2]
    )


@pytest.mark.once
def test_a_goal_that_succeeds(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("action", **RUN, mode="hold", feedback=3)
    with stage.controller(ear) as node:
        puppet.publish("/level", "std_msgs/Int16", 7)
        want(puppet, True)
        asked = puppet.wait(lambda line: line.get("asked") == "/run", "the goal")
        assert asked["message"]["height"] == 7
        node.tells(
            event("feedback", "run", value=2.0)
        )  # another topic, which the result may overtake
        puppet.do("finish", name="/run", mode="succeed")
        node.tells(event("response", "run"))
        assert [e["event"]["value"] for e in node.events(event("feedback", "run"))][:3] == [0, 1, 2]
        assert goals_end_once(node)


@pytest.mark.parametrize(
    ("mode", "reason", "quality"),
    [
        ("abort", "aborted: did not work", 7),
        ("reject", "rejected", None),
        ("recall", "recalled", None),
        ("preempt", "preempted: somebody else was quicker", 7),
    ],
)
def test_a_goal_that_does_not_succeed(
    stage: Stage, puppet: Puppet, ear: Puppet, mode: str, reason: str, quality: int | None
) -> None:
    puppet.do("action", **RUN, mode=mode, fields={"quality": 7})
    with stage.controller(ear) as node:
        want(puppet, True)
        error = node.tells(event("error", "run"))
        assert error["detail"] == reason
        assert error["event"]["value"] == {"quality": quality}
        puppet.do("action", **RUN, mode="succeed")
        node.tells(event("response", "run"))
        assert goals_end_once(node)


def test_a_server_that_is_absent_and_comes_later(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.controller(ear, timeout__run=0.5) as node:
        want(puppet, True)
        missing = "no server of /run is connected"
        assert node.tells(event("error", "run"))["detail"] == missing
        node.shows(lambda s: missing in s["unconnected"] and missing in str(s["faults"]))
        puppet.publish("/level", "std_msgs/Int16", 9)
        node.tells(event("request", "blow"))  # meanwhile, all else goes on
        puppet.do("action", **RUN, mode="succeed")
        node.tells(event("response", "run"))
        node.shows(lambda s: missing not in s["unconnected"] and missing not in str(s["faults"]))
        assert goals_end_once(node)


def test_a_goal_that_is_never_accepted(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("action", **RUN, mode="ignore")
    with stage.controller(ear, timeout__run=0.5) as node:
        want(puppet, True)
        assert node.tells(event("error", "run"))["detail"] == "no answer in time"
        puppet.wait(lambda line: line.get("cancelled") == "/run", "the cancel of the goal")
        assert goals_end_once(node)


def test_a_goal_that_takes_too_long(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("action", **RUN, mode="hold")
    with stage.controller(ear, goal_timeout__run=0.5) as node:
        want(puppet, True)
        assert node.tells(event("error", "run"))["detail"] == "deadline exceeded"
        puppet.wait(lambda line: line.get("cancelled") == "/run", "the cancel of the goal")
        assert goals_end_once(node)


def test_a_server_that_is_killed_with_the_goal(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    with stage.controller(ear, server_lost_after=1.0) as node:
        with stage.puppet() as victim:
            victim.do("action", **RUN, mode="hold")
            want(puppet, True)
            await_acceptance(ear)
            os.kill(victim.process.pid, signal.SIGKILL)
        assert node.tells(event("error", "run"))["detail"].startswith("server lost")
        puppet.do("action", **RUN, mode="succeed")
        node.tells(event("response", "run"))
        assert goals_end_once(node)


def test_a_server_that_stood_still_answers_for_a_goal_that_is_over(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    puppet.do("action", **RUN, mode="deaf")
    with stage.controller(ear, server_lost_after=1.0) as node:
        want(puppet, True)
        await_acceptance(ear)
        with stage.puppet() as other, stopped(puppet.process.pid):
            assert node.tells(event("error", "run"))["detail"].startswith("server lost")
            mark = ear.mark
            want(other, False)
            node.shows(lambda s: s["variables"]["Switches.run"] is False, since=mark)
        puppet.wait(lambda line: line.get("cancelled") == "/run", "the cancel")
        puppet.do("action", **RUN, mode="succeed")
        want(puppet, True)
        node.tells(event("response", "run"))
        assert goals_end_once(node)


def test_a_server_that_is_restarted_forgets_the_goal(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    with stage.controller(ear, server_lost_after=60.0) as node:
        with stage.puppet() as victim:
            victim.do("action", **RUN, mode="hold")
            want(puppet, True)
            await_acceptance(ear)
            os.kill(victim.process.pid, signal.SIGKILL)
        puppet.do("action", **RUN, mode="succeed")
        assert node.tells(event("error", "run"))["detail"] == "lost by the server"
        node.tells(event("response", "run"))
        assert goals_end_once(node)


@pytest.mark.parametrize(("mode", "end"), [("hold", "cancelled"), ("deaf", "response")])
def test_a_cancelled_goal_ends_as_its_server_answers(
    stage: Stage, puppet: Puppet, ear: Puppet, mode: str, end: str
) -> None:
    puppet.do("action", **RUN, mode=mode)
    with stage.controller(ear) as node:
        want(puppet, True)
        puppet.wait(lambda line: line.get("asked") == "/run", "the goal")
        want(puppet, False)
        node.tells(event("cancel", "run"))
        puppet.wait(lambda line: line.get("cancelled") == "/run", "the cancel")
        node.tells(event(end, "run"))
        mark = ear.mark
        puppet.do("action", **RUN, mode="succeed")
        want(puppet, True)
        node.tells(event("response", "run"), since=mark)
        assert node.events(event("error", "run")) == []
        assert [e["outcome"] for e in node.events() if e["outcome"] != "applied"] == []
        assert goals_end_once(node)


@pytest.mark.parametrize("end", ["succeed", "abort", "preempt"])
def test_a_cancelled_goal_that_goes_on_is_a_fault_and_holds_the_next(
    stage: Stage, puppet: Puppet, ear: Puppet, end: str
) -> None:
    puppet.do("action", **RUN, mode="go on")
    ear.do("listen", topic="/run/cancel", type="actionlib_msgs/GoalID")
    with stage.controller(ear, timeout__run=60.0) as node:
        want(puppet, True)
        asked = puppet.wait(lambda line: line.get("asked") == "/run", "the goal")
        want(puppet, False)
        node.tells(event("cancel", "run"))
        mark, heard = puppet.mark, ear.mark
        want(puppet, True)
        told = node.shows(lambda s: any("run: a goal goes on" in fault for fault in s["faults"]))
        assert told["communications"]["run"] == "cancelling"
        # The server is asked again.
        ear.hears("/run/cancel", lambda message: message["id"] == asked["id"], since=heard)
        puppet.do("finish", name="/run", mode=end)
        again = puppet.wait(lambda line: line.get("asked") == "/run", "another goal", since=mark)
        assert again["running"] == 0
        node.tells(event({"succeed": "response", "abort": "error"}.get(end, "cancelled"), "run"))
        node.shows(lambda s: s["faults"] == [], since=ear.mark)
        assert [e["outcome"] for e in node.events() if e["outcome"] != "applied"] == []


@pytest.mark.once
def test_two_servers_of_one_action_are_a_fault(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    """A goal goes to both, and the node takes it for ended when one of them says so."""
    puppet.do("action", **RUN, mode="hold")
    with stage.puppet() as other, stage.controller(ear) as node:
        other.do("action", **RUN, mode="hold")
        node.shows(lambda s: any("all publish /run/status: a goal goes" in f for f in s["faults"]))
        other.process.kill()
        node.shows(lambda s: s["faults"] == [], since=ear.mark)


def test_nothing_is_asked_of_a_server_while_another_of_its_actions_goes_on(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    name = "/navigate"
    puppet.do("action", name=name, type="robot_common/NavigateAction", mode="go on")
    with (
        stage.puppet() as other,
        stage.controller(
            ear, "shared_controller", server_lost_after=1.0, timeout__home=60.0
        ) as node,
    ):
        other.do("service", name="/switch", type="std_srvs/SetBool", fields={"success": True})
        place = {"pose": {"position": {"x": 3.0}}}
        other.do("publish", topic="/target", type="geometry_msgs/PoseStamped", fields=place)
        puppet.wait(lambda line: line.get("asked") == name, "the goal")
        node.enters("Base", "driving")
        with stopped(puppet.process.pid):
            node.shows(lambda s: s["communications"]["home"] == "busy")
        mark = puppet.mark
        puppet.wait(lambda line: line.get("cancelled") == name, "the cancel")
        puppet.do("finish", name=name, mode="succeed", fields={"distance": 0.1})
        home = puppet.wait(lambda line: line.get("asked") == name, "home", since=mark)
        assert (home["message"]["x"], home["running"]) == (0.0, 0)
        puppet.do("finish", name=name, mode="succeed")
        node.tells(event("response", "home"))


def test_goals_of_a_controller_that_came_again_while_the_clock_stands(
    stage: Stage, puppet: Puppet, ear: Puppet
) -> None:
    """They are others than those of its former lifecycle, which the server still knows."""
    asked = []
    puppet.do("action", **RUN, mode="succeed")
    with stage.simulated_time():
        for _ in range(2):
            mark = puppet.mark
            # Another publisher each time, which the new controller alone is connected to.
            with stage.controller(ear) as node, stage.puppet() as other:
                want(other, True)
                asked.append(
                    puppet.wait(lambda line: line.get("asked") == "/run", "the goal", since=mark)
                )
                node.process.kill()
                node.process.wait()
    assert asked[0]["id"] != asked[1]["id"]


def test_a_simple_action_server_takes_goals_after_a_step_back_of_time(stage: Stage) -> None:
    """It recalls those with a stamp before that of its last goal, as after a simulation's reset."""
    script = """
import queue, rospy, time
from actionlib import SimpleActionServer
from gauntlet_interfaces.msg import ReachAction
from rosgraph_msgs.msg import Clock
from probe_controller.ros_actions import Action
from probe_controller.ros_connections import send_promptly
send_promptly()
rospy.init_node("reset")
clock = rospy.Publisher("/clock", Clock, queue_size=1)
def be(seconds):
    while rospy.get_time() != seconds:
        clock.publish(rospy.Time(seconds))
        time.sleep(0.01)
be(100)
server = SimpleActionServer("/run", ReachAction, lambda goal: server.set_succeeded(), False)
server.start()
action, told = Action("/run", ReachAction), queue.Queue()
action.report = lambda token, kind, payload=None: told.put((token, kind))
action.look = lambda: None
for token, seconds in ((1, 100), (2, 50)):
    be(seconds)
    while not action.ready():
        time.sleep(0.01)
    action.start({}, token)
    ends = [(token, kind) for kind in ("response", "error", "cancelled")]
    print("ended:", next(end for end in iter(lambda: told.get(timeout=60), None) if end in ends))
rospy.signal_shutdown("done")  # a thread of the server would keep the process
"""
    with stage.simulated_time():
        done = stage.workspace.run("python3", "-c", script, master=stage.master)
    ends = [line for line in done.stdout.splitlines() if line.startswith("ended")]
    assert ends == ["ended: (1, 'response')", "ended: (2, 'response')"]


def test_a_goal_that_is_over_is_forgotten(stage: Stage, puppet: Puppet) -> None:
    """Else all of them would be looked through at each status."""
    puppet.do("action", **RUN, mode="succeed")
    script = """
import queue, rospy, time
from gauntlet_interfaces.msg import ReachAction
from probe_controller.ros_actions import Action
from probe_controller.ros_connections import send_promptly
send_promptly()
rospy.init_node("many_goals")
action, told = Action("/run", ReachAction), queue.Queue()
action.report = lambda token, kind, payload=None: told.put((token, kind))
action.look = lambda: None
for token in range(1, 21):
    while not action.ready():
        time.sleep(0.01)
    action.start({}, token)
    while told.get(timeout=60) != (token, "response"):
        pass
    action.abandon(token)
print("remembered:", len(action._goals))
"""
    done = stage.workspace.run("python3", "-c", script, master=stage.master)
    assert int(done.stdout.rpartition("remembered: ")[2]) == 0


def test_a_goal_waits_until_the_server_has_heard_of_every_connection(
    stage: Stage, puppet: Puppet
) -> None:
    """rospy greets a subscriber before it sends to it: an instant result would be lost meanwhile."""
    # Here the server's node tells of the connection that brings results only when it is let.
    puppet.do("action", **RUN, mode="succeed")
    script = """
import rospy, time
from actionlib_msgs.msg import GoalStatusArray
from gauntlet_interfaces.msg import ReachAction
from probe_controller import ros_actions
from probe_controller.ros_connections import send_promptly
send_promptly()
rospy.init_node("careful")
ros_actions.SETTLED = float("inf")
ask, hidden = ros_actions.ask, {"/run/result"}
ros_actions.ask = lambda *question: [link for link in ask(*question) if link[4] not in hidden]
action = ros_actions.Action("/run", ReachAction)
told = []
action.report = lambda token, kind, payload=None: told.append(kind)
action.look = lambda: None
while not all(action._ends._links()):
    time.sleep(0.01)
early = [action.ready()]
for _ in range(2):  # the action hears them, too, and looks again
    rospy.wait_for_message("/run/status", GoalStatusArray)
early.append(action.ready())
hidden.clear()
while not action.ready():
    time.sleep(0.01)
action.start({}, 1)
while "response" not in told:
    time.sleep(0.01)
print("early:", early)
"""
    done = stage.workspace.run("python3", "-c", script, master=stage.master)
    assert done.stdout.endswith("early: [False, False]\n")


def test_somebody_else_cancels_all(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("action", **RUN, mode="hold")
    with stage.controller(ear) as node:
        want(puppet, True)
        await_acceptance(ear)
        puppet.do("action", **RUN, mode="succeed")  # the next goal, which may come at once
        puppet.do("cancel_all", name="/run")
        assert node.tells(event("error", "run"))["detail"] == "preempted"
        node.tells(event("response", "run"))
        assert goals_end_once(node)


def test_goals_of_others_and_a_storm_of_feedback(stage: Stage, puppet: Puppet, ear: Puppet) -> None:
    puppet.do("action", **RUN, mode="hold", feedback=2000)
    with stage.controller(ear) as node:
        want(puppet, True)
        puppet.wait(lambda line: line.get("asked") == "/run", "the goal")
        puppet.do("shout", name="/run", count=3)
        node.tells(event("feedback", "run", value=1999.0))
        assert len(node.events(event("feedback", "run"))) == 2000
        assert node.events(event("response", "run")) == []
        assert goals_end_once(node)
