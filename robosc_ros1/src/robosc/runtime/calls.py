"""The life of a request to a service or an action: exactly one end for each.

A request gets a token when it begins. What comes back carries the token, and counts only while the
token is current; so an answer after the deadline or after a cancel is dropped, and no request ends
twice. Deadlines are seconds on the steady clock of the machine, not ROS time.
"""

from __future__ import annotations

from typing import Callable, Dict, Iterator, List, Optional, Tuple

__all__ = ["Calls"]


class _Call:
    __slots__ = ("accepted", "deadline", "token", "watch")

    def __init__(self, token: int, deadline: float) -> None:
        self.token = token
        self.deadline: Optional[float] = deadline
        self.accepted = False
        self.watch: Optional[float] = None  # when to look at the server's silence next


class Calls:
    """All requests that are under way, at most one per communication."""

    def __init__(
        self,
        timeout: Callable[[str], float],
        goal_timeout: Callable[[str], Optional[float]],
        lost_after: float,
        silence: Callable[[str], Optional[float]],
    ) -> None:
        self._timeout = timeout
        self._goal_timeout = goal_timeout
        self._lost_after = lost_after
        self._silence = silence
        self._calls: Dict[str, _Call] = {}
        self._last_token = 0
        self.earliest: Optional[float] = None
        """When :meth:`expired` is to be asked next; None while nothing can expire."""

    def begin(self, key: str, now: float) -> int:
        self._last_token += 1
        self._calls[key] = _Call(self._last_token, now + self._timeout(key))
        self._plan()
        return self._last_token

    def end(self, key: str) -> Optional[int]:
        """Forget the request; its token, if there was one."""
        call = self._calls.pop(key, None)
        self._plan()
        return None if call is None else call.token

    def accept(self, key: str, token: int, now: float) -> None:
        """The server took the goal: from now on other deadlines hold."""
        call = self._calls.get(key)
        if call is None or call.token != token or call.accepted:
            return
        call.accepted = True
        limit = self._goal_timeout(key)
        call.deadline = None if limit is None else now + limit
        call.watch = now + self._lost_after
        self._plan()

    def is_current(self, key: str, token: int) -> bool:
        call = self._calls.get(key)
        return call is not None and call.token == token

    def running(self) -> Iterator[Tuple[str, int]]:
        return iter([(key, call.token) for key, call in self._calls.items()])

    def expired(self, now: float) -> List[Tuple[str, str]]:
        """The requests that are to end as errors now, each with the reason. Does not end them."""
        result = []
        for key, call in self._calls.items():
            if call.deadline is not None and call.deadline <= now:
                result.append((key, "deadline exceeded" if call.accepted else "no answer in time"))
            elif call.watch is not None and call.watch <= now:
                silence = self._silence(key)
                if silence is not None and silence >= self._lost_after:
                    result.append((key, "server lost: silent for %.1f s" % silence))
                else:
                    call.watch = now + max(0.05, self._lost_after - (silence or 0.0))
        self._plan()
        return result

    def _plan(self) -> None:
        times = [
            time
            for call in self._calls.values()
            for time in (call.deadline, call.watch)
            if time is not None
        ]
        self.earliest = min(times) if times else None
