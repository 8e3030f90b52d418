"""Whatever users call things, generated code is legal Python and keeps them apart."""

from __future__ import annotations

from emit.generated_code import controller_class, supervisor_of

from robosc.runtime.core.model import Controller

MODEL = """
robot Controller {
    component A {
        outgoing message b_c with type: integer(0..3)
        incoming message go with type: integer
        behaviour {
            variable b_c: integer(0..3)
            initial marked state None { on response from A.b_c do b_c := value }
        }
    }
    component A_b {
        outgoing message c with type: integer(0..3)
        behaviour {
            variable c: integer(0..3)
            initial marked state ^self { on response from A_b.c do c := value }
        }
    }
    component ^Divide {
        outgoing message divide with type: Value
        behaviour {
            variable value_: Value
            initial marked state lambda { on response from divide do value_ := value }
        }
    }
    component Class {
        outgoing message class with type: boolean
        incoming message import with type: none
        behaviour {
            variable def: boolean
            variable message: boolean
            initial marked state yield {
                on response from class do def := value, message := def
            }
        }
    }
    component On {
        service on_response_of_class with request: R, response: none links trigger
        behaviour { initial marked state components {} }
    }
    requirement go needs A.b_c > A_b.c
    requirement import needs Class.def and Class.message and Divide.value_ = low
    requirement on_response_of_class needs On.components
    provide go with A.b_c - A_b.c
    interface trigger use SetBool from std_srvs
    datatype object R { data: boolean }
    datatype enum Value from double to { value / 2 > 3 -> high default -> low }
}
"""


class Message:
    def __init__(self, data: object) -> None:
        self.data = data


def test_names_that_collide_or_are_words_of_python() -> None:
    make, _ = controller_class(supervisor_of(MODEL))
    controller = make()
    inputs = {i.key: i for i in controller.INPUTS if i.kind == "response"}
    commands = {c.key: c for c in controller.COMMANDS}

    def hear(key: str, data: object) -> None:
        value = inputs[key].read(controller, Message(data))
        inputs[key].apply(controller, value)

    def allowed(key: str) -> bool:
        return bool(commands[key].guard(controller))

    hear("A.b_c", 3)
    hear("A_b.c", 1)
    assert allowed("A.go")
    assert commands["A.go"].data(controller) == {"data": 2}
    hear("A_b.c", 3)
    assert not allowed("A.go")
    hear("Class.class", True)
    assert not allowed("Class.import"), "assignments see the state before the event"
    hear("Class.class", True)
    assert allowed("Class.import")
    hear("Divide.divide", 6.5)
    assert controller.variables()["Divide.value_"] == "high"
    assert not allowed("Class.import")
    assert controller.components() == {
        "A": "None", "A_b": "self", "Divide": "lambda", "Class": "yield", "On": "components",
    }  # fmt: skip


def test_a_parameter_may_be_called_as_what_the_runtime_asks_of_a_controller() -> None:
    """``phase`` was replaced by its value."""
    asked = sorted(name for name in dir(Controller) if not name.startswith("_"))
    words = "".join(f"parameter ^{name}: double = 2.5\n" for name in asked)
    needs = " + ".join(f"^{name}" for name in asked)
    model = f"robot R {{ {words} component A {{ incoming message go with type: double }}"
    make, _ = controller_class(supervisor_of(f"{model} provide go with {needs} }}"))
    controller = make()
    assert controller.parameters() == dict.fromkeys(asked, 2.5)
    for name in asked:
        assert type(getattr(controller, name)) is not float, name
    (command,) = controller.COMMANDS
    assert command.data(controller) == {"data": 2.5 * len(asked)}
