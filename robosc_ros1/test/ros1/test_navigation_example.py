"""The navigation example on ROS 1: the simulated base and its generated controller."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from ros1.stage import Puppet, Stage
from ros_support import Master, Workspace

NODE = "/navigation_controller"


@pytest.fixture
def person(example_workspace: Workspace, roscore: Master) -> Iterator[Puppet]:
    """Clicks, presses the stop, and watches; the first drive takes half the way for the whole, the next gets
    stuck."""
    stage = Stage(example_workspace, roscore)
    launch = ("roslaunch", "navigation_example", "navigation.launch", "speed:=10.0", "failures:=2")
    with stage.puppet() as puppet:
        puppet.do("listen", topic=f"{NODE}/state", type="std_msgs/String")
        puppet.do("listen", topic="/pose", type="geometry_msgs/Pose2D")
        with example_workspace.start(*launch, master=roscore):
            puppet.hears(f"{NODE}/state")
            puppet.do("listen", topic=f"{NODE}/events", type="std_msgs/String")
            yield puppet


def click(person: Puppet, x: float, y: float) -> None:
    fields = {"point": {"x": x, "y": y}}
    person.do("publish", topic="/clicked_point", type="geometry_msgs/PointStamped", fields=fields)


def arrives(person: Puppet, x: float, y: float) -> None:
    person.hears("/pose", lambda m: (m["x"], m["y"]) == (x, y))


def is_in(person: Puppet, component: str, state: str, since: int) -> None:
    person.hears(f"{NODE}/state", lambda s: s["components"][component] == state, since=since)


@pytest.mark.once
def test_it_drives_to_the_click_and_tries_again_after_an_error(person: Puppet) -> None:
    click(person, 3.0, 4.0)
    for reason in ("refused", "failed"):
        person.hears(f"{NODE}/events", lambda e, reason=reason: e.get("reason") == reason)
    arrives(person, 3.0, 4.0)
    person.hears(
        f"{NODE}/state",
        lambda s: s["counters"]["errors"] == 2 and s["components"]["Operator"] == "content",
    )


@pytest.mark.once
def test_the_emergency_stop_cancels_and_release_goes_on(person: Puppet) -> None:
    mark = person.mark
    click(person, 30.0, 40.0)
    is_in(person, "Navigator", "driving", mark)
    mark = person.mark
    person.publish("/press", "std_msgs/Bool", True)
    is_in(person, "Navigator", "resting", mark)
    click(person, 3.0, 0.0)
    person.publish("/press", "std_msgs/Bool", False)
    arrives(person, 3.0, 0.0)
