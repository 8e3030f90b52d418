"""How ``controller.py`` tells the engine what there is: its tables of events.

The tables name methods of the controller class; the engine binds them once. A *key* is
``Component.communication``; a *name* is what people see, the bare communication where that is
unambiguous.
"""

from __future__ import annotations

from typing import Any, Dict, NamedTuple, Optional, Tuple

__all__ = ["Command", "Communication", "Controller", "Input", "Requirement", "Tau"]


class Communication(NamedTuple):
    """A message, service or action; ``sort`` is "incoming", "outgoing", "service" or "action"."""

    key: str
    name: str
    sort: str


class Input(NamedTuple):
    """Something that the robot does: "response", "feedback" or "error" of a communication.

    ``read`` takes the ROS message and gives the event's value (None: it has none); ``apply`` takes
    the value and changes the state, or raises :class:`~.values.Mismatch` and changes nothing.
    """

    key: str
    kind: str
    read: Optional[str]
    apply: str


class Command(NamedTuple):
    """Something that the controller may do: "request" of a communication or "cancel" of an action.

    ``guard`` tells whether requirements and synthesis allow it, ``consent`` whether the components
    that mention it accept it now (None: always); neither looks at the communication's own phase,
    which is the attribute ``busy`` (None: a message has none). ``data`` gives the fields to send,
    ``apply`` changes the state. ``requirements`` are indexes into the table of requirements;
    ``reason`` is why synthesis forbids more than they do (None: it does not).
    """

    key: str
    kind: str
    guard: str
    consent: Optional[str]
    busy: Optional[str]
    data: Optional[str]
    apply: Optional[str]
    requirements: Tuple[int, ...]
    reason: Optional[str] = None


class Tau(NamedTuple):
    """A component's own step. ``step`` takes it and tells ``"from->to"``, or None if it cannot."""

    component: str
    number: int
    step: str


class Requirement(NamedTuple):
    """A requirement as written, where, and the method that tells whether it is met."""

    text: str
    place: str
    holds: str


class Controller:
    """What every generated controller has; its state is its attributes, all plain values."""

    ROBOT: str
    SOURCE: str
    COMMUNICATIONS: Tuple[Communication, ...]
    INPUTS: Tuple[Input, ...]
    COMMANDS: Tuple[Command, ...]
    TAUS: Tuple[Tau, ...]
    REQUIREMENTS: Tuple[Requirement, ...]
    SETTLE_BOUND: int
    """More steps of settling than this mean a cycle; each step within it reaches a new state."""

    undefined: Dict[str, int]
    """How often an expression was undefined, by place in the model. Shared by all copies."""

    def components(self) -> Dict[str, str]:
        """The current state of each component with behaviour."""
        raise NotImplementedError

    def variables(self) -> Dict[str, Any]:
        """The current value of each variable, by ``Component.variable``."""
        raise NotImplementedError

    def copy(self) -> Controller:
        """A controller in the same state, for others to look at."""
        twin = type(self).__new__(type(self))
        twin.__dict__.update(self.__dict__)
        return twin

    def count_undefined(self, place: str) -> None:
        self.undefined[place] = self.undefined.get(place, 0) + 1
