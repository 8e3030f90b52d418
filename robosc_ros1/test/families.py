"""Families of models that grow with a number, as model text: for tests of engines and benchmarks.

Sizes are known in closed form where the functions beside the texts say so.
"""

from __future__ import annotations

__all__ = [
    "action_robot", "hands", "hands_states", "line_states", "philosophers", "robot_text",
    "services_hands", "switches", "transfer_line",
]  # fmt: skip


def hands(n: int) -> str:
    """n hands in a ring, each with a sensor: one starts if its sensor is open and the next rests.

    A hand is driven by an incoming message and an outgoing one, a sensor by two outgoing ones. All
    of the product is reached, but for all hands being busy at once.
    """
    parts = []
    for i in range(n):
        parts.append(
            f"  component Hand{i} {{\n"
            f"    incoming message start{i} with type: none\n"
            f"    outgoing message done{i} with type: none\n"
            "    behaviour {\n"
            f"      initial marked state idle {{ on request to start{i} goto busy }}\n"
            f"      state busy {{ on response from done{i} goto idle }}\n"
            "    }\n"
            "  }\n"
        )
        parts.append(_sensor(i))
    parts.extend(
        f"  requirement start{i} needs Sensor{i}.open and Hand{(i + 1) % n}.idle\n"
        for i in range(n)
    )
    return robot_text("Hands", parts)


def hands_states(n: int) -> int:
    """The reachable states of ``hands(n)`` and ``services_hands(n)`` under control, n > 1."""
    sensors = hands_ = 2**n
    return sensors * (hands_ - 1)


def services_hands(n: int) -> str:
    """The same with services; each hand mirrors its service's phase, which doubles the product."""
    parts = ["  interface work use Empty from std_srvs\n"]
    for i in range(n):
        parts.append(
            f"  component Hand{i} {{\n"
            f"    service act{i} with request: none, response: none links work\n"
            "    behaviour {\n"
            f"      initial marked state idle {{ on request to act{i} goto busy }}\n"
            "      state busy {\n"
            f"        on response from act{i} goto idle\n"
            f"        on error from act{i} goto idle\n"
            "      }\n"
            "    }\n"
            "  }\n"
        )
        parts.append(_sensor(i))
    parts.extend(
        f"  requirement act{i} needs Sensor{i}.open and Hand{(i + 1) % n}.idle\n" for i in range(n)
    )
    return robot_text("ServicesHands", parts)


def transfer_line(n: int, k: int) -> str:
    """n machines in a row with buffers of k parts between them, which must not overflow.

    Only synthesis finds out that a machine must not start while its part may find no room.
    """
    parts = ["  interface work use Empty from std_srvs\n"]
    for i in range(n):
        parts.append(
            f"  component Machine{i} {{\n"
            f"    service work{i} with request: none, response: none links work\n"
            "  }\n"
        )
        if i < n - 1:
            parts.append(
                f"  component Buffer{i} {{\n"
                "    behaviour {\n"
                f"      variable level: integer(0..{k}) = 0\n"
                "      initial marked state counting {\n"
                f"        on response from work{i} do level := level + 1\n"
                f"        on request to work{i + 1} do level := level - 1\n"
                "      }\n"
                "    }\n"
                "  }\n"
            )
    parts.extend(f"  requirement work{i + 1} needs Buffer{i}.level > 0\n" for i in range(n - 1))
    return robot_text("TransferLine", parts)


def line_states(n: int, k: int) -> int:
    """The states of ``transfer_line(n, k)`` under control."""
    return 2 * (2 * k + 1) ** (n - 1)


def action_robot(n: int) -> str:
    """n arms with actions, feedback, errors, cancels, a repair step, and one emergency stop."""
    parts = [
        "  interface move use Test from actionlib\n",
        "  datatype enum Progress from integer to {\n"
        "    value > 90 -> near\n"
        "    value > 0 -> far\n"
        "    default -> unknown\n"
        "  }\n",
        "  component Stop {\n"
        "    outgoing message pressed with type: boolean\n"
        "    behaviour {\n"
        "      variable active: boolean = false\n"
        "      initial marked state listening { on response from pressed do active := value }\n"
        "    }\n"
        "  }\n",
    ]
    for i in range(n):
        parts.append(
            f"  component Arm{i} {{\n"
            f"    action reach{i} with request: integer, response: integer, feedback: Progress"
            " links move\n"
            "    behaviour {\n"
            "      variable place: Progress = unknown\n"
            "      variable tries: integer(0..2) = 0\n"
            f"      initial marked state home {{ on request to reach{i} goto moving }}\n"
            "      state moving {\n"
            f"        on feedback from reach{i} do place := value\n"
            f"        on response from reach{i} do place := unknown, tries := 0 goto home\n"
            f"        on cancelled to reach{i} do place := unknown goto home\n"
            f"        on error from reach{i} if tries < 2 do tries := tries + 1 goto failed\n"
            f"        on error from reach{i} if tries = 2 do place := unknown goto failed\n"
            "      }\n"
            "      state failed { transition goto home }\n"
            "    }\n"
            "  }\n"
        )
    for i in range(n):
        parts.append(f"  requirement reach{i} needs !Stop.active\n")
        if n > 1:
            neighbour = f"Arm{(i + 1) % n}"
            parts.append(
                f"  requirement {neighbour}.moving and {neighbour}.place != near"
                f" disables reach{i}\n"
            )
    return robot_text("ActionRobot", parts)


def philosophers(n: int) -> str:
    """n philosophers in a ring with a fork between each two; what they take they keep until both.

    Synthesis has to keep them from all holding their first fork at once, a condition over all.
    """
    parts = []
    for i in range(n):
        parts.append(
            f"  component Phil{i} {{\n"
            f"    incoming message first{i} with type: none\n"
            f"    incoming message second{i} with type: none\n"
            f"    outgoing message done{i} with type: none\n"
            "    behaviour {\n"
            f"      initial marked state thinking {{ on request to first{i} goto waiting }}\n"
            f"      state waiting {{ on request to second{i} goto eating }}\n"
            f"      state eating {{ on response from done{i} goto thinking }}\n"
            "    }\n"
            "  }\n"
        )
    for i in range(n):
        left, right = f"Phil{(i - 1) % n}", f"Phil{(i + 1) % n}"
        parts.append(f"  requirement first{i} needs !{left}.eating\n")
        parts.append(f"  requirement second{i} needs {right}.thinking\n")
    return robot_text("Philosophers", parts)


def switches(n: int) -> str:
    """Declarations of n components S0, S1, ... with a boolean x that messages set freely."""
    return "".join(
        f"component S{i} {{ outgoing message m{i} with type: boolean behaviour {{"
        " variable x: boolean initial marked state s {"
        f" on response from m{i} do x := value }} }} }}\n"
        for i in range(n)
    )


def _sensor(i: int) -> str:
    return (
        f"  component Sensor{i} {{\n"
        f"    outgoing message opened{i} with type: none\n"
        f"    outgoing message closed{i} with type: none\n"
        "    behaviour {\n"
        f"      initial marked state open {{ on response from closed{i} goto shut }}\n"
        f"      marked state shut {{ on response from opened{i} goto open }}\n"
        "    }\n"
        "  }\n"
    )


def robot_text(name: str, parts: list[str]) -> str:
    """A robot of these declarations."""
    return f"robot {name} {{\n" + "".join(parts) + "}\n"
