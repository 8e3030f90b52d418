"""The poses along chains of links: as those of tf2, and as the links say."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from robosc.runtime.core.transforms import FORGOTTEN, MOST_FRAMES, Transforms

RATE = 0.05


def parts(**values: Any) -> SimpleNamespace:
    return SimpleNamespace(**values)


def link(
    parent: str,
    child: str,
    at: Sequence[float] = (0.0, 0.0, 0.0),
    turned: Sequence[float] = (0.0, 0.0, 0.0, 1.0),
    stamp: tuple[int, int] = (1, 0),
) -> Any:
    """A message of type geometry_msgs/TransformStamped."""
    return parts(
        header=parts(frame_id=parent, stamp=parts(sec=stamp[0], nanosec=stamp[1])),
        child_frame_id=child,
        transform=parts(
            translation=parts(**dict(zip("xyz", at, strict=True))),
            rotation=parts(**dict(zip("xyzw", turned, strict=True))),
        ),
    )


def numbers(message: Any) -> tuple[float, ...]:
    at, turned = message.transform.translation, message.transform.rotation
    return at.x, at.y, at.z, turned.x, turned.y, turned.z, turned.w


class Tree:
    """The transforms of a node that asks for some; time passes when it is told so."""

    def __init__(self, *rows: tuple[str, str], period: float = 0.0) -> None:
        self.time = 0.0
        self._tree = Transforms([(a, b, (f"{a} {b}",)) for a, b in rows], lambda key: period)

    def take(self, *links: Any, static: bool = False, by: str = "/robot") -> dict[str, Any]:
        """What comes of the links, by the frames."""
        found = self._tree.take(links, static, lambda: by, self.time, 100.0 + self.time)
        return self._told(found)

    def wait(self, seconds: float) -> dict[str, Any]:
        """What comes until then of what waits."""
        end, told = self.time + seconds, {}
        while (due := self._tree.next()) is not None and due <= end:
            self.time = due
            told |= self._told(self._tree.due(due))
        self.time = end
        return told

    @property
    def faults(self) -> list[str]:
        return self._tree.faults()

    @staticmethod
    def _told(found: Iterable[tuple[tuple[str, ...], Any]]) -> dict[str, Any]:
        return {key: message for (key,), message in found}


def rotations(chance: random.Random) -> list[float]:
    turned = [chance.gauss(0.0, 1.0) for _ in range(4)]
    return [part / math.hypot(*turned) for part in turned]


@pytest.mark.parametrize("seed", range(40))
def test_poses_are_those_of_tf2(seed: int) -> None:
    tf2 = pytest.importorskip("tf2_ros", reason="no python3-tf2-ros")
    rospy = pytest.importorskip("rospy")
    from geometry_msgs.msg import TransformStamped

    chance = random.Random(seed)
    frames = [f"f{number}" for number in range(chance.randint(2, 12))]
    buffer = tf2.BufferCore(rospy.Duration(10.0))
    rows = [(a, b) for a in frames for b in frames if a != b]
    tree = Tree(*rows)
    told: dict[str, Any] = {}
    links = []
    for number, child in enumerate(frames[1:]):
        one = TransformStamped()
        one.header.frame_id, one.child_frame_id = chance.choice(frames[: number + 1]), child
        one.header.stamp = rospy.Time(1000)
        at, turned = one.transform.translation, one.transform.rotation
        at.x, at.y, at.z = (chance.uniform(-10.0, 10.0) for _ in range(3))
        turned.x, turned.y, turned.z, turned.w = rotations(chance)
        links.append((one, chance.random() < 0.3))
    chance.shuffle(links)
    for one, is_static in links:
        set_transform = buffer.set_transform_static if is_static else buffer.set_transform
        set_transform(one, "peer")
        told |= tree.take(one, static=is_static)
    assert len(told) == len(rows)
    for a, b in rows:
        peer = buffer.lookup_transform_core(a, b, rospy.Time(0))
        message = told[f"{a} {b}"]
        assert (message.header.frame_id, message.child_frame_id) == (a, b)
        ours, theirs = numbers(message), numbers(peer)
        # A rotation and its opposite are one.
        sign = 1.0 if sum(p * q for p, q in zip(ours[3:], theirs[3:], strict=True)) > 0 else -1.0
        theirs = (*theirs[:3], *(sign * part for part in theirs[3:]))
        assert ours == pytest.approx(theirs, abs=1e-9)


ODD = [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0), (math.nan, 0.0, 0.0, 1.0), (0.6, 0.6, 0.6, 0.6)]


@pytest.mark.parametrize("turned", [*ODD, (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.004)])
@pytest.mark.parametrize("place", range(3))
def test_what_tf2_takes_for_no_rotation_is_a_fault(place: int, turned: Sequence[float]) -> None:
    """Put together with others, one of zeros would make all behind it as near as can be."""
    tf2 = pytest.importorskip("tf2_ros", reason="no python3-tf2-ros")
    rospy = pytest.importorskip("rospy")
    from geometry_msgs.msg import Quaternion, TransformStamped, Vector3

    frames = ("map", "odom", "base", "camera")
    tree, buffer = Tree(("map", "camera"), ("camera", "odom")), tf2.BufferCore()
    for number in range(3):
        rotation = turned if number == place else (0.0, 0.0, 0.0, 1.0)
        one = TransformStamped()
        one.header.frame_id, one.child_frame_id = frames[number : number + 2]
        one.header.stamp = rospy.Time(1)
        one.transform.translation = Vector3(1.0, 0.0, 0.0)
        one.transform.rotation = Quaternion(*rotation)
        buffer.set_transform(one, "peer")
        told = tree.take(one, by=f"/n{number}")
    for a, b in (("map", "camera"), ("camera", "odom")):
        taken = buffer.can_transform_core(a, b, rospy.Time(0))[0]
        assert (f"{a} {b}" in told) == taken
        fault = f"no transform from {a} to {b}: the length of a rotation is not 1, or a number is"
        fault += f" not finite: {frames[place + 1]} (from /n{place})"
        assert (fault in tree.faults) == (not taken)


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_what_is_nowhere_is_a_fault_until_it_is_somewhere(number: float) -> None:
    tree = Tree(("map", "base"))
    tree.take(link("map", "odom"))
    assert "map base" in tree.take(link("odom", "base", (1.0, 0.0, 0.0)))
    for at in ((number, 0.0, 0.0), (0.0, 0.0, number)):
        assert tree.take(link("odom", "base", at)) == {}
        assert "not finite: base (from /robot)" in tree.faults[0]
        assert tree.take(link("map", "odom")) == {}
        assert numbers(tree.take(link("odom", "base", (2.0, 0.0, 0.0)))["map base"])[0] == 2.0
        assert tree.faults == []


def test_a_single_link_is_told_as_it_came() -> None:
    odd = (math.nan, math.inf, -0.0)
    told = Tree(("map", "base")).take(link("/map", "base", odd, (0.0, 0.0, 0.0, 0.0)))
    assert repr(numbers(told["map base"])) == repr((*odd, 0.0, 0.0, 0.0, 0.0))


def test_it_comes_with_each_of_its_links_once_the_chain_is_complete() -> None:
    tree = Tree(("map", "base"))
    assert tree.take(link("odom", "base", (1.0, 0.0, 0.0))) == {}
    assert numbers(tree.take(link("map", "odom", (2.0, 0.0, 0.0)))["map base"])[0] == 3.0
    assert tree.take(link("base", "camera"), link("world", "map"), link("x", "y")) == {}
    told = tree.take(link("odom", "base", (5.0, 0.0, 0.0)), link("map", "odom", (1.0, 0.0, 0.0)))
    assert numbers(told["map base"])[0] == 6.0


def test_the_stamp_is_that_of_the_oldest_link_that_moves() -> None:
    def stamp(told: dict[str, Any]) -> tuple[int, int]:
        found = told["map camera"].header.stamp
        return found.sec, found.nanosec

    tree = Tree(("map", "camera"))
    assert tree.take(link("base", "camera", stamp=(1, 0)), static=True) == {}
    tree.take(link("odom", "base", stamp=(7, 5)))
    assert stamp(tree.take(link("map", "odom", stamp=(7, 4)))) == (7, 4)
    assert stamp(tree.take(link("map", "odom", stamp=(9, 0)))) == (7, 5)
    still = Tree(("map", "camera"))
    still.take(link("base", "camera", stamp=(1, 0)), static=True)
    still.time = 2.5
    assert stamp(still.take(link("map", "base", stamp=(2, 0)), static=True)) == (102, 500000000)


def test_two_parents_are_a_fault_that_names_who_tells_of_them() -> None:
    tree = Tree(("map", "base"), ("map", "wheel"), ("base", "wheel"))
    tree.take(link("map", "base"), by="/amcl")
    tree.take(link("base", "wheel"), by="/state")
    tree.time = 1.0
    assert tree.take(link("odom", "base"), by="/ekf") == {}
    what = "frame base has two parents, map (from /amcl) and odom (from /ekf)"
    assert tree.faults == [f"no transform from map to {to}: {what}" for to in ("base", "wheel")]
    assert [*tree.take(link("base", "wheel"))] == ["base wheel"]
    assert tree.take(link("map", "base"), by="/amcl") == {}
    # It ends when one of them is told of no more.
    tree.time = 1.0 + FORGOTTEN
    assert [*tree.take(link("map", "base"), by="/amcl")] == ["map base", "map wheel"]
    assert tree.faults == []


def test_what_is_static_stays_a_parent() -> None:
    tree = Tree(("map", "base"))
    tree.take(link("map", "base"), static=True, by="/a")
    tree.time = 10 * FORGOTTEN
    assert tree.take(link("odom", "base"), by="/b") == {}
    assert "map (from /a) and odom (from /b)" in tree.faults[0]


@pytest.mark.parametrize("count", range(1, 5))
def test_a_circle_is_a_fault(count: int) -> None:
    tree = Tree(("f0", "other"))
    tree.take(link("f0", "other"))
    for number in range(count):
        told = tree.take(link(f"f{number}", f"f{(number + 1) % count}"), by=f"/n{number}")
        assert told == {}
    (fault,) = tree.faults
    assert "circle" in fault
    assert all(f"f{n} (from /n{(n - 1) % count})" in fault for n in range(count))
    # The one that closed it tells better now; the frame's other parent is forgotten.
    tree.time = 2 * FORGOTTEN
    tree.take(link("map", "f0"), by="/n0")
    assert (tree.faults, [*tree.take(link("f0", "other"))]) == ([], ["f0 other"])


def test_it_comes_at_most_at_its_rate_and_the_last_one_comes() -> None:
    tree = Tree(("map", "base"), period=RATE)

    def told(seconds: float, x: float) -> list[float]:
        found = tree.wait(seconds) | tree.take(link("map", "base", (x, 0.0, 0.0)))
        return [numbers(message)[0] for message in found.values()]

    assert told(0.0, 1.0) == [1.0]
    assert told(0.01, 2.0) == []
    assert told(0.01, 3.0) == []
    assert [numbers(m)[0] for m in tree.wait(1.0).values()] == [3.0]
    assert tree.wait(1.0) == {}
    assert told(0.0, 4.0) == [4.0]


def test_a_clock_that_goes_back_holds_nothing_up() -> None:
    tree = Tree(("map", "base"), period=RATE)
    tree.time = 50.0
    assert tree.take(link("map", "base"))
    tree.time = 1.0
    assert tree.take(link("map", "base"))


def test_frames_that_are_made_up_for_ever_are_forgotten() -> None:
    tree = Tree(("map", "base"))
    for number in range(MOST_FRAMES + 100):
        tree.take(link("map", f"tag{number}"))
    assert len(tree._tree._parents) == MOST_FRAMES
    assert [*tree.take(link("map", "base"))] == ["map base"]


@pytest.mark.parametrize("seed", range(20))
def test_random_links_never_raise(seed: int) -> None:
    """Whatever comes, what is told is that of a walk along the links, and faults are told."""
    chance = random.Random(seed)
    frames = ["a", "b", "c", "d", "/a", ""]
    tree = Tree(*((a, b) for a in "abcd" for b in "abcd" if a != b))
    for _ in range(300):
        tree.time += chance.choice([0.0, 0.1, 3.0])
        pair = chance.choices(frames, k=2)
        told = tree.take(link(*pair), static=chance.random() < 0.05)
        broken = {fault.split(":")[0] for fault in tree.faults}
        for key in told:
            source, target = key.split()
            assert f"no transform from {source} to {target}" not in broken
