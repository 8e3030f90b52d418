"""The floor with its two robots, and who stands where. No ROS, and nothing of robosc, in here.

Time is simulated, in seconds. A job of a robot occupies where it begins and where it leads until it
has ended.
"""

import random

__all__ = ["Floor", "Robot"]

SECONDS = {"cross": 20.0, "dock": 5.0, "undock": 5.0}
CHARGE = {"cross": 0.05, "dock": 0.01, "undock": 0.01}
"""What a job takes of the battery, of which 1 is all."""

CHARGING = 0.01
"""What a robot at the charger gains per second."""

JOBS = {
    ("right", "cross"): ("corridor", "left"),
    ("left", "cross"): ("corridor", "right"),
    ("left", "dock"): ("left", "charger"),
    ("charger", "undock"): ("charger", "left"),
}
"""By where a robot stands, and what it does: what it occupies on its way, and where it comes to."""

TAKES_ONE = ("corridor", "left", "charger")


class Robot:
    def __init__(self, chance):
        self.place = "right"
        self.battery = chance.uniform(0.5, 1.0)
        self.occupies = {"right"}
        self.held = False
        self.counts = {"cross": 0, "dock": 0, "undock": 0, "failed": 0}
        self._chance = chance
        self._fails = False
        self._left = 0.0
        self._end = ""

    def begin(self, job):
        """Whether a job can begin where the robot stands; one that was held goes on."""
        if self.held and job == "cross":
            self.held = False
            return True
        if self.held or (self.place, job) not in JOBS:
            return False
        way, self._end = JOBS[self.place, job]
        self.occupies = {way} if way == "corridor" else {self.place, self._end}
        self._left = SECONDS[job]
        self._fails = self._chance.random() < 0.1
        return True

    def step(self, job, seconds):
        """Go on with a job; "done", "failed", or None while it lasts."""
        self.battery = max(0.0, self.battery - CHARGE[job] * seconds / SECONDS[job])
        self._left -= seconds
        if self._left > 0.0:
            return None
        if not self._fails:
            self.place = self._end
        self.occupies = {self.place}
        self.counts["failed" if self._fails else job] += 1
        return "failed" if self._fails else "done"

    def stop(self, job):
        """Give a job up: in the corridor the robot stays, from elsewhere it returns at once."""
        self.held = job == "cross"
        if not self.held:
            self.occupies = {self.place}

    def rest(self, seconds):
        if self.place == "charger":
            self.battery = min(1.0, self.battery + CHARGING * seconds)


class Floor:
    """Both robots, and how often something stood where it must not."""

    def __init__(self, seed):
        chance = random.Random(seed)
        self.robots = [Robot(chance), Robot(chance)]
        self.jobs = [None, None]
        self.time = 0.0
        self.longest_rest = 0.0
        self.violations = dict.fromkeys((*TAKES_ONE, "empty battery", "impossible job"), 0)
        self._busy_at = 0.0

    def begin(self, number, job):
        """Give a robot (0 or 1) a job."""
        if self.jobs[number] is None and self.robots[number].begin(job):
            self.jobs[number] = job
        else:
            self.violations["impossible job"] += 1
        self._judge()

    def stop(self, number):
        """Have a robot give up its job."""
        job, self.jobs[number] = self.jobs[number], None
        if job is not None:
            self.robots[number].stop(job)

    def step(self, seconds):
        """Let time pass; by number, how those jobs went that ended: "done" or "failed"."""
        self.time += seconds
        ended = {}
        for number, robot in enumerate(self.robots):
            job = self.jobs[number]
            if job is None:
                robot.rest(seconds)
                continue
            self._busy_at = self.time
            self.violations["empty battery"] += robot.battery <= 0.0
            how = robot.step(job, seconds)
            if how is not None:
                self.jobs[number] = None
                ended[number] = how
        charging = any(r.place == "charger" and r.battery < 1.0 for r in self.robots)
        if charging:
            self._busy_at = self.time
        self.longest_rest = max(self.longest_rest, self.time - self._busy_at)
        return ended

    def _judge(self):
        one, other = (robot.occupies for robot in self.robots)
        for place in TAKES_ONE:
            self.violations[place] += place in one and place in other

    def report(self):
        return {
            "seconds": self.time,
            "longest_rest": self.longest_rest,
            "violations": self.violations,
            "robots": [robot.counts for robot in self.robots],
        }
