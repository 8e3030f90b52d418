"""An element of an array that is an object is kept and sent as a whole, where it has arrived."""

from __future__ import annotations

from synthesis.plants import supervisor_of

from robosc.synthesis.explore import explore

MODEL = """
    interface batch use Batch from own_msgs
    datatype object Item { small: integer label: string }
    datatype object Load { items: array(Item) }
    component First {
        outgoing message load with type: Load links batch
        incoming message one with type: Item links batch
        behaviour {
            variable last: Item
            initial marked state ready { on response from load do last := value.items[2] }
        }
    }
    provide one with First.last
"""


def test_an_element_is_there_once_it_has_arrived() -> None:
    supervisor = supervisor_of(MODEL)
    states = explore(supervisor).states
    assert len(states) == 2  # before it has arrived, and from then on
    (event,) = (e for e in supervisor.plant.events if e.name == "load")
    (element,) = event.parameters
    assert (element.path, len(element.values)) == (("items", 2), 2)
