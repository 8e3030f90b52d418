"""A generated node whose engine is slow with its first goal: slow_engine_node.py PACKAGE WHEN …

WHEN is ``before``: the engine is busy when the goal comes, or ``meanwhile``: it takes as long to
decide on it. Both take longer than rclpy's thread waits for what the engine decides. Runs under the
test bed's Python.
"""

import importlib
import sys
import time


def main(package, when, *arguments):
    engine = importlib.import_module(f"{package}._runtime.core.engine").Engine
    actions = importlib.import_module(f"{package}.ros_served_actions")
    delays = [actions.DECISION + 1.0]

    def wait():
        if delays:
            time.sleep(delays.pop())

    serve, claim = engine.serve, actions._Call.claim

    def serve_late(self, *goal):
        self.invoke(wait)
        serve(self, *goal)

    def claim_slowly(self):
        claimed = claim(self)
        wait()
        return claimed

    if when == "before":
        engine.serve = serve_late
    else:
        actions._Call.claim = claim_slowly
    sys.argv[1:] = arguments
    sys.exit(importlib.import_module(f"{package}.node").main())


main(*sys.argv[1:])
