"""The transforms of a model in a recording, from its messages on ``/tf`` and ``/tf_static``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from robosc.runtime.core import transforms
from robosc.runtime.core.settings import Settings
from robosc.runtime.judge import observation
from robosc.simulate.bags.bag_files import Bag

TOPICS = ("/tf", "/tf_static")
TYPE = "tf2_msgs/msg/TFMessage"
FORMER_TYPE = "tf/msg/tfMessage"
"""That of the first tf, with the same contents."""


class RecordedTransforms:
    """``now`` is the clock of the recording, ``post`` makes what takes the messages of some
    communications. ``faults`` are those that were found until now."""

    def __init__(
        self,
        chains: Mapping[tuple[str, str], transforms.Keys],
        settings: Settings,
        now: Callable[[], float],
        post: Callable[[Sequence[str]], Callable[[Any], None]],
    ) -> None:
        rows = [(*frames, keys) for frames, keys in chains.items()]
        self._transforms = transforms.Transforms(rows, transforms.period_by(settings.rates))
        self._posts = {keys: post(keys) for _, _, keys in rows}
        self._now = now
        self.next = self._transforms.next
        self.faults: dict[str, None] = {}

    def handler(self, bag: Bag, topic: str, is_static: bool) -> observation.Handler:
        """What takes the messages of a topic."""
        nodes = {c.node for c in bag.storage.channels.values() if c.topic == topic and c.node}
        publishers = " or ".join(sorted(nodes)) or f"whoever sends {topic}"

        def take(message: Any) -> None:
            now = self._now()
            told = partial(str, publishers)
            self._pass_on(self._transforms.take(message.transforms, is_static, told, now, now))
            self.faults |= dict.fromkeys(self._transforms.faults())

        return take

    def flush(self) -> None:
        """Pass on what has waited until now."""
        self._pass_on(self._transforms.due(self._now()))

    def _pass_on(self, messages: Sequence[tuple[transforms.Keys, Any]]) -> None:
        for keys, message in messages:
            self._posts[keys](message)
