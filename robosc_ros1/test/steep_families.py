"""Families of models that are steep for one engine or another, as model text.

Each grows with its numbers; what makes it hard is said beside it. For tests of the engines and for
the benchmark of ``auto``.
"""

from __future__ import annotations

from families import robot_text
from industrial_families import cluster_tool, conveyor, corridor_mesh, elevator, road

__all__ = [
    "allocation", "battery_swaps", "broad", "budget", "cat_and_mouse", "chain", "cluster_tool",
    "conveyor", "corridor_mesh", "crew", "elevator", "gauges", "not_all_busy", "one_tool_each",
    "priorities", "readings", "restless", "road", "tanks", "token", "two_tools_each", "unrelated",
]  # fmt: skip


def not_all_busy(n: int) -> str:
    """n machines of which not all may be busy at once: each guard reads all components."""
    parts = [_machine(i) for i in range(n)]
    busy = " and ".join(f"Machine{i}.busy" for i in range(n))
    return robot_text("NotAllBusy", [*parts, f"  requirement never {busy}\n"])


def budget(n: int, most: int) -> str:
    """n users of up to 3 units, of which ``most`` can be in use at once."""
    parts = [
        f"  component User{i} {{\n"
        f"    incoming message take{i} with type: none\n"
        f"    outgoing message done{i} with type: none\n"
        "    behaviour {\n"
        "      variable used: integer(0..3) = 0\n"
        "      initial marked state s {\n"
        f"        on request to take{i} do used := used + 1\n"
        f"        on response from done{i} do used := 0\n"
        "      }\n"
        "    }\n"
        "  }\n"
        for i in range(n)
    ]
    total = " + ".join(f"User{i}.used" for i in range(n))
    return robot_text("Budget", [*parts, f"  requirement always {total} <= {most}\n"])


def crew(n: int) -> str:
    """n jobs in a ring and n helpers; each job takes two helpers, one after the other.

    All jobs holding their first helper would block for good.
    """
    parts = [
        f"  component Job{j} {{\n"
        f"    incoming message first{j} with type: none\n"
        f"    incoming message second{j} with type: none\n"
        f"    outgoing message done{j} with type: none\n"
        "    behaviour {\n"
        f"      initial marked state waiting {{ on request to first{j} goto one }}\n"
        f"      state one {{ on request to second{j} goto both }}\n"
        f"      state both {{ on response from done{j} goto waiting }}\n"
        "    }\n"
        "  }\n"
        for j in range(n)
    ]
    for i in range(n):
        before = (i - 1) % n
        parts.append(
            f"  requirement first{i} needs !Job{before}.both\n"
            f"  requirement second{i} needs Job{(i + 1) % n}.waiting\n"
        )
    return robot_text("Crew", parts)


def allocation(n: int) -> str:
    """n products that pass through three of n machines, each of which holds one product."""
    parts = []
    for j in range(n):
        parts.append(
            f"  component Product{j} {{\n"
            + "".join(f"    incoming message step{j}_{k} with type: none\n" for k in range(4))
            + "    behaviour {\n"
            f"      initial marked state waiting {{ on request to step{j}_0 goto one }}\n"
            f"      state one {{ on request to step{j}_1 goto two }}\n"
            f"      state two {{ on request to step{j}_2 goto three }}\n"
            f"      state three {{ on request to step{j}_3 goto waiting }}\n"
            "    }\n"
            "  }\n"
        )
    stages = ("one", "two", "three")
    for j in range(n):
        for k in range(3):
            machine = (j * (1 if j % 2 else n - 1) + k) % n
            others = [
                f"Product{i}.{stages[s]}"
                for i in range(n)
                for s in range(3)
                if i != j and (i * (1 if i % 2 else n - 1) + s) % n == machine
            ]
            if others:
                parts.append(f"  requirement {' or '.join(others)} disables step{j}_{k}\n")
    return robot_text("Allocation", parts)


def cat_and_mouse(rooms: int, animals: int) -> str:
    """Cats and mice in a ring of rooms; one door for cats does not close."""
    parts = []
    for i in range(rooms):
        cats, mice = (animals, 0) if i == 0 else (0, animals if i == rooms // 2 else 0)
        way = "outgoing" if i == 0 else "incoming"
        parts.append(
            f"  component Room{i} {{\n"
            f"    {way} message cat{i} with type: none\n"
            f"    incoming message mouse{i} with type: none\n"
            "    behaviour {\n"
            f"      variable cats: integer(0..{animals}) = {cats}\n"
            f"      variable mice: integer(0..{animals}) = {mice}\n"
            "      initial marked state s {\n"
            f"        {_on('cat', i)} if cats > 0 do cats := cats - 1\n"
            f"        {_on('cat', (i - 1) % rooms)} {_arriving(i, rooms)}do cats := cats + 1\n"
            f"        on request to mouse{i} if mice > 0 do mice := mice - 1\n"
            f"        on request to mouse{(i - 1) % rooms} do mice := mice + 1\n"
            "      }\n"
            "    }\n"
            "  }\n"
        )
        parts.append(f"  requirement never Room{i}.cats > 0 and Room{i}.mice > 0\n")
    return robot_text("CatAndMouse", parts)


def _on(name: str, room: int) -> str:
    return (
        f"on response from {name}{room}"
        if room == 0 and name == "cat"
        else (f"on request to {name}{room}")
    )


def _arriving(room: int, rooms: int) -> str:
    return "if Room0.cats > 0 " if (room - 1) % rooms == 0 else ""


def token(n: int) -> str:
    """One token among n places, and one command that is refused while it is in the last one."""
    parts = [
        f"  component Place{i} {{\n"
        f"    incoming message pass{i} with type: none\n"
        "    behaviour {\n"
        f"      variable have: boolean = {'true' if i == 0 else 'false'}\n"
        "      initial marked state s {\n"
        f"        on request to pass{i} if have do have := false\n"
        f"        on request to pass{(i - 1) % n} do have := true\n"
        "      }\n"
        "    }\n"
        "  }\n"
        for i in range(n)
    ]
    parts.append(
        "  component Lamp {\n"
        "    incoming message light with type: none\n"
        "    outgoing message out with type: none\n"
        "    behaviour {\n"
        "      initial marked state dark { on request to light goto lit }\n"
        "      marked state lit { on response from out goto dark }\n"
        "    }\n"
        "  }\n"
        f"  requirement never Lamp.lit and Place{n - 1}.have\n"
    )
    return robot_text("Token", parts)


def gauges(size: int) -> str:
    """Two gauges of ``size`` values, and a command that needs them close together."""
    parts = [
        f"  component Gauge{i} {{\n"
        f"    outgoing message reading{i} with type: integer(0..{size - 1})\n"
        "    behaviour {\n"
        f"      variable level: integer(0..{size - 1}) = 0\n"
        f"      initial marked state s {{ on response from reading{i} do level := value }}\n"
        "    }\n"
        "  }\n"
        for i in range(2)
    ]
    parts.append(
        "  component Valve { incoming message open with type: none }\n"
        "  requirement open needs Gauge0.level - Gauge1.level <= 10"
        " and Gauge1.level - Gauge0.level <= 10\n"
    )
    return robot_text("Gauges", parts)


def tanks(size: int) -> str:
    """Two tanks of ``size`` levels, one pumped into the other; both leak, and share a limit."""
    parts = [
        f"  component Tank{i} {{\n"
        f"    incoming message pump{i} with type: none\n"
        f"    outgoing message drop{i} with type: none\n"
        "    behaviour {\n"
        f"      variable level: integer(0..{size - 1}) = 0\n"
        "      initial marked state s {\n"
        f"        on request to pump{i} do level := level + 1\n"
        f"        on response from drop{i} if level > 0 do level := level - 1\n"
        + ("        on request to pump1 if level > 0 do level := level - 1\n" if i == 0 else "")
        + "      }\n"
        "    }\n"
        "  }\n"
        f"  requirement never Tank{i}.level > {size - 3}\n"
        for i in range(2)
    ]
    parts.append(f"  requirement always Tank0.level + Tank1.level <= {size * 4 // 3}\n")
    return robot_text("Tanks", parts)


def readings(size: int) -> str:
    """Three integers below ``size`` that arrive in one message."""
    names = ("x", "y", "z")
    fields = " ".join(f"{name}: integer(0..{size - 1})" for name in names)
    variables = "".join(f"      variable {n}: integer(0..{size - 1}) = 0\n" for n in names)
    updates = ", ".join(f"{name} := value.{name}" for name in names)
    return robot_text(
        "Readings",
        [
            f"  datatype object Reading {{ {fields} }}\n"
            "  interface reading use Reading from readings_msgs\n"
            "  component Sensor {\n"
            "    outgoing message point with type: Reading links reading\n"
            "    behaviour {\n"
            f"{variables}"
            f"      initial marked state s {{ on response from point do {updates} }}\n"
            "    }\n"
            "  }\n"
            "  component Arm { incoming message grab with type: none }\n"
            "  requirement grab needs Sensor.x < Sensor.y and Sensor.y < Sensor.z\n"
        ],
    )


def chain(n: int) -> str:
    """n cells in a row through which parts move; machines at both ends."""
    parts = []
    for i in range(n):
        parts.append(
            f"  component Cell{i} {{\n"
            f"    incoming message move{i} with type: none\n"
            + ("    outgoing message left with type: none\n" if i == n - 1 else "")
            + "    behaviour {\n"
            f"      initial marked state empty {{ on request to move{i} goto full }}\n"
            "      state full { "
            + (
                f"on request to move{i + 1} goto empty"
                if i < n - 1
                else "on response from left goto empty"
            )
            + " }\n    }\n  }\n"
        )
    return robot_text("Chain", parts)


def broad(n: int) -> str:
    """One requirement that reads n components."""
    conditions = " and ".join(f"S{i}.x" for i in range(n))
    command = "  component Arm { incoming message go with type: none }\n"
    return robot_text("Broad", [*_switches(n), command, f"  requirement go needs {conditions}\n"])


def unrelated(n: int) -> str:
    """n components that share nothing, each with a command that synthesis restricts."""
    parts = [
        f"  component Tank{i} {{\n"
        f"    incoming message fill{i} with type: none\n"
        f"    outgoing message drop{i} with type: none\n"
        "    behaviour {\n"
        "      variable level: integer(0..4) = 0\n"
        "      initial marked state s {\n"
        f"        on request to fill{i} do level := level + 1\n"
        f"        on response from drop{i} if level > 0 do level := level - 1\n"
        "      }\n"
        "    }\n"
        "  }\n"
        f"  requirement never Tank{i}.level = 4\n"
        for i in range(n)
    ]
    return robot_text("Unrelated", parts)


def priorities(n: int) -> str:
    """A vehicle and n stations, of which each is served only while none before it waits."""
    return f"""robot Priorities {{
  component Vehicle {{
    incoming message drive with type: none
    outgoing message arrived with type: none
    behaviour {{
      initial marked state standing {{ on request to drive goto driving }}
      state driving {{ on response from arrived goto standing }}
    }}
  }}
  component Station[1..{n}] {{
    outgoing message button with identifier: "/s{{index}}/button", type: none
    incoming message serve with identifier: "/s{{index}}/serve", type: none
    outgoing message served with identifier: "/s{{index}}/served", type: none
    outgoing message failed with identifier: "/s{{index}}/failed", type: none
    behaviour {{
      initial marked state idle {{ on response from button goto waiting }}
      state waiting {{ on request to serve goto busy }}
      state busy {{
        on response from served goto idle
        on response from failed goto waiting
      }}
    }}
  }}
  for i in 2..{n} {{
    requirement Station[i].serve
      needs Vehicle.standing and !any(s.waiting for s in Station[1..i-1])
  }}
}}
"""


def restless(n: int) -> str:
    """n components whose internal transitions never end."""
    parts = [
        f"  component Clock{i} {{ behaviour {{\n"
        "    initial marked state tick { transition goto tock }\n"
        "    marked state tock { transition goto tick }\n"
        "  } }\n"
        for i in range(n)
    ]
    return robot_text("Restless", parts)


def _machine(i: int) -> str:
    return (
        f"  component Machine{i} {{\n"
        f"    incoming message start{i} with type: none\n"
        f"    outgoing message done{i} with type: none\n"
        "    behaviour {\n"
        f"      initial marked state idle {{ on request to start{i} goto busy }}\n"
        f"      state busy {{ on response from done{i} goto idle }}\n"
        "    }\n"
        "  }\n"
    )


def _switches(n: int) -> list[str]:
    return [
        f"  component S{i} {{ outgoing message m{i} with type: boolean behaviour {{"
        " variable x: boolean initial marked state s {"
        f" on response from m{i} do x := value }} }} }}\n"
        for i in range(n)
    ]


def battery_swaps(n: int) -> str:
    """n robots that go where they are ordered, and change their packs where two at a time may.

    What fails of its controller was looked for by breadth first search, 31 s for 8 robots.
    """
    packs = n // 4 + 1
    return f"""robot BatterySwaps {{
  interface move use Test from actionlib
  component Bot[1..{n}] {{
    outgoing message battery with identifier: "/b{{index}}/low", timeout: 10 s, type: boolean
    outgoing message order with identifier: "/b{{index}}/order", type: none
    action drive with identifier: "/b{{index}}/drive", request: none, response: none,
      feedback: none links move
    action swap with identifier: "/b{{index}}/swap", request: none, response: none,
      feedback: none links move
    behaviour {{
      variable low: boolean
      on response from battery do low := value
      initial marked state parked {{
        on response from order goto driving
        transition if low and battery.fresh goto swapping
      }}
      state driving performs drive then goto parked {{
        retry 3 times every 2 s else goto parked
      }}
      state swapping performs swap then goto parked {{ retry every 5 s }}
    }}
    requirement drive needs battery.fresh and !low
  }}
  component Rack {{
    outgoing message charged with type: none
    behaviour {{
      variable packs: integer(0..{packs}) = {packs}
      initial marked state s {{
        on response from charged if packs < {packs} do packs := packs + 1
{"".join(f"        on request to Bot[{i}].swap do packs := packs - 1{chr(10)}" for i in range(1, n + 1))}\
      }}
    }}
  }}
  requirement always count(b.swap.busy for b in Bot) <= 2
}}
"""


def two_tools_each(n: int) -> str:
    """n robots in a ring that take two of n tools in either order, and put both back in any order.

    Its controller was searched by breadth first search, without end for 12 robots.
    """
    parts = []
    for i in range(n):
        names = [f"{i}_{i}", f"{i}_{(i + 1) % n}"]
        users = [f"{i}_{i}", f"{(i - 1) % n}_{i}"]
        gets, puts = (
            "".join(f"      on request to {verb}{user} goto {state}\n" for user in users)
            for verb, state in (("get", "used"), ("put", "free"))
        )
        parts.append(
            f"  component Tool{i} {{ behaviour {{\n"
            f"    initial marked state free {{\n{gets}    }}\n    state used {{\n{puts}    }}\n"
            "  } }\n"
            f"  component Robot{i} {{\n"
            f"    outgoing message order{i} with type: none\n"
            f"    outgoing message done{i} with type: none\n"
            + "".join(
                f"    incoming message {verb}{name} with type: none\n"
                for verb in ("get", "put")
                for name in names
            )
            + f"    incoming message mill{i} with type: none\n"
            "    behaviour {\n"
            "      variable first: boolean\n"
            "      variable second: boolean\n"
            f"      initial marked state idle {{ on response from order{i} goto busy }}\n"
            "      state busy {\n"
            f"        on request to get{names[0]} if !first do first := true\n"
            f"        on request to get{names[1]} if !second do second := true\n"
            f"        on request to mill{i} if first and second goto mills\n"
            "      }\n"
            f"      state mills {{ on response from done{i} goto leaving }}\n"
            "      state leaving {\n"
            f"        on request to put{names[0]} if first do first := false\n"
            f"        on request to put{names[1]} if second do second := false\n"
            "        transition if !first and !second goto idle\n"
            "      }\n"
            "    }\n"
            "  }\n"
        )
    return robot_text("TwoToolsEach", parts)


def one_tool_each(n: int, tools: int) -> str:
    """n robots that hold one of some tools at a time, any of them; each tool is held by one.

    Taking a tool concerns one requirement of those that read what the robot holds.
    """
    numbers = range(1, tools + 1)
    takes = "".join(f"        on request to take{k} if held = 0 do held := {k}\n" for k in numbers)
    drops = "".join(f"        on request to drop{k} if held = {k} do held := 0\n" for k in numbers)
    parts = [
        f"  component Robot[1..{n}] {{\n"
        '    outgoing message done with identifier: "/r{index}/done", type: none\n'
        '    incoming message work with identifier: "/r{index}/work", type: none\n',
        *(
            f'    incoming message {verb}{k} with identifier: "/r{{index}}/{verb}{k}", type: none\n'
            for k in numbers
            for verb in ("take", "drop")
        ),
        f"    behaviour {{\n      variable held: integer(0..{tools}) = 0\n"
        f"      initial marked state rests {{\n{takes}{drops}"
        "        on request to work if held != 0 goto works\n"
        "      }\n"
        "      state works { on response from done goto rests }\n"
        "    }\n"
        "  }\n",
        *(f"  requirement always count(r.held = {k} for r in Robot) <= 1\n" for k in numbers),
    ]
    return robot_text("OneToolEach", parts)
