"""What ``ros2 run robosc VERB`` starts: setup.py makes an entry point of each, named as in
robosc_ros1/scripts, which ``rosrun`` starts."""

from collections.abc import Callable
from functools import partial

from robosc.start import run


def __getattr__(verb: str) -> Callable[[], int]:
    if verb.startswith("_"):
        raise AttributeError(verb)
    return run if verb == "robosc" else partial(run, verb)
