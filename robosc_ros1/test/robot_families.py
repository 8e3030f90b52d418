"""Families of models that no engine was tuned for, as model text. Each grows with its numbers."""

from __future__ import annotations

from families import robot_text

__all__ = [
    "chargers", "dining", "grid", "halls", "lift", "quotas", "riders", "ring", "served_copies",
    "track", "warehouse", "zones", "zones_by_hand",
]  # fmt: skip


def ring(n: int, most: int) -> str:
    """A token among n nodes that count their passes, of which the first two may not both be full."""
    parts = [
        f"  component Node{i} {{\n"
        f"    incoming message pass{i} with type: none\n"
        f"    incoming message reset{i} with type: none\n"
        f"    outgoing message lost{i} with type: none\n"
        "    behaviour {\n"
        f"      variable have: boolean = {'true' if i == 0 else 'false'}\n"
        f"      variable passes: integer(0..{most}) = 0\n"
        "      initial marked state s {\n"
        f"        on request to pass{i} if have do have := false, passes := passes + 1\n"
        f"        on request to pass{(i - 1) % n} do have := true\n"
        f"        on request to reset{i} do passes := 0\n"
        f"        on response from lost{i} if have and passes > 0 do passes := passes - 1\n"
        "      }\n"
        "    }\n"
        "  }\n"
        for i in range(n)
    ]
    parts.append(f"  requirement never Node0.passes = {most} and Node1.passes = {most}\n")
    parts.append(f"  requirement reset0 needs Node{n - 1}.have\n")
    return robot_text("Ring", parts)


def dining(n: int) -> str:
    """n robots that take two tools in turn; every second one may not work at the same time."""
    parts = [
        f"  component Tool{i} {{ behaviour {{\n"
        "    initial marked state free {\n"
        f"      on request to left{i} goto used\n"
        f"      on request to right{(i - 1) % n} goto used\n"
        "    }\n"
        "    state used {\n"
        f"      on response from done{i} goto free\n"
        f"      on response from done{(i - 1) % n} goto free\n"
        "    }\n"
        "  } }\n"
        f"  component Robot{i} {{\n"
        f"    incoming message left{i} with type: none\n"
        f"    incoming message right{i} with type: none\n"
        f"    outgoing message done{i} with type: none\n"
        "    behaviour {\n"
        f"      initial marked state waits {{ on request to left{i} goto one }}\n"
        f"      state one {{ on request to right{i} goto works }}\n"
        f"      state works {{ on response from done{i} goto waits }}\n"
        "    }\n"
        "  }\n"
        for i in range(n)
    ]
    working = " and ".join(f"Robot{i}.works" for i in range(0, n, 2))
    return robot_text("Dining", [*parts, f"  requirement never {working}\n"])


def halls(n: int, floors: int) -> str:
    """n lifts with a call button on each floor; no two are open there, and none without a call."""
    parts = []
    for j in range(floors):
        answered = "".join(
            f"      on response from opened{i} if Lift{i}.floor = {j} goto off\n" for i in range(n)
        )
        parts.append(f"""  component Call{j} {{
    outgoing message call{j} with type: none
    behaviour {{
      initial marked state off {{ on response from call{j} goto lit }}
      state lit {{
{answered}      }}
    }}
  }}
""")
    for i in range(n):
        called = " or ".join(f"Call{j}.lit and Lift{i}.floor = {j}" for j in range(floors))
        parts.append(f"""  component Lift{i} {{
    incoming message up{i} with type: none
    incoming message down{i} with type: none
    incoming message open{i} with type: none
    incoming message close{i} with type: none
    outgoing message arrived{i} with type: none
    outgoing message opened{i} with type: none
    outgoing message closed{i} with type: none
    behaviour {{
      variable floor: integer(0..{floors - 1}) = {i % floors}
      initial marked state shut {{
        on request to up{i} do floor := floor + 1 goto moving
        on request to down{i} do floor := floor - 1 goto moving
        on request to open{i} goto opening
      }}
      state moving {{ on response from arrived{i} goto shut }}
      state opening {{ on response from opened{i} goto open }}
      state open {{ on request to close{i} goto closing }}
      state closing {{ on response from closed{i} goto shut }}
    }}
  }}
  requirement open{i} needs {called}
""")
    parts += [
        f"  requirement never Lift{i}.open and Lift{q}.open and Lift{i}.floor = Lift{q}.floor\n"
        for i in range(n)
        for q in range(i)
    ]
    return robot_text("Halls", parts)


def lift(n: int, most: int) -> str:
    """A cabin for ``most`` persons and n floors with doors; full, it may not move."""
    parts = [
        "  component Cabin {\n"
        "    incoming message up with type: none\n"
        "    incoming message down with type: none\n"
        "    outgoing message arrived with type: none\n"
        "    outgoing message enter with type: none\n"
        "    outgoing message leave with type: none\n"
        "    behaviour {\n"
        f"      variable floor: integer(0..{n - 1}) = 0\n"
        f"      variable load: integer(0..{most}) = 0\n"
        "      variable rising: boolean = false\n"
        "      initial marked state stands {\n"
        "        on request to up do rising := true goto moves\n"
        "        on request to down do rising := false goto moves\n"
        f"        on response from enter if load < {most} do load := load + 1\n"
        "        on response from leave if load > 0 do load := load - 1\n"
        "      }\n"
        "      state moves {\n"
        "        on response from arrived if rising do floor := floor + 1 goto stands\n"
        "        on response from arrived if !rising do floor := floor - 1 goto stands\n"
        "      }\n"
        "    }\n"
        "  }\n"
        f"  requirement never Cabin.load = {most} and Cabin.moves\n"
    ]
    parts += [
        f"  component Door{i} {{\n"
        f"    outgoing message call{i} with type: none\n"
        f"    incoming message open{i} with type: none\n"
        f"    outgoing message closed{i} with type: none\n"
        "    behaviour {\n"
        "      variable called: boolean = false\n"
        "      initial marked state shut {\n"
        f"        on response from call{i} do called := true\n"
        f"        on request to open{i} do called := false goto open\n"
        "      }\n"
        f"      state open {{ on response from closed{i} goto shut }}\n"
        "    }\n"
        "  }\n"
        f"  requirement open{i} needs Cabin.floor = {i} and Cabin.stands\n"
        f"  requirement Door{i}.open disables up\n"
        f"  requirement Door{i}.open disables down\n"
        for i in range(n)
    ]
    return robot_text("Lift", parts)


def riders(n: int, floors: int) -> str:
    """n robots that ride with one lift, one at a time: its diagram grows in one order only."""
    moves = "".join(
        f"  incoming message {name} with type: none\n" for name in ("up", "down", "open", "close")
    ) + "".join(
        f"  outgoing message {name} with type: none\n" for name in ("arrived", "opened", "closed")
    )
    parts = [
        f"  component Cabin {{\n{moves}"
        "    behaviour {\n"
        f"      variable floor: integer(0..{floors - 1}) = 0\n"
        "      initial marked state shut {\n"
        "        on request to up do floor := floor + 1 goto moving\n"
        "        on request to down do floor := floor - 1 goto moving\n"
        "        on request to open goto opening\n"
        "      }\n"
        "      state moving { on response from arrived goto shut }\n"
        "      state opening { on response from opened goto free }\n"
        "      state free { on request to close goto closing }\n"
        "      state closing { on response from closed goto shut }\n"
        "    }\n"
        "  }\n"
    ]
    parts += [
        f"  component Robot{i} {{\n"
        f"    incoming message enter{i} with type: none\n"
        f"    incoming message leave{i} with type: none\n"
        f"    outgoing message inside{i} with type: none\n"
        f"    outgoing message outside{i} with type: none\n"
        f"    outgoing message want{i} with type: integer(0..{floors - 1})\n"
        "    behaviour {\n"
        f"      variable at: integer(0..{floors - 1}) = {i % floors}\n"
        f"      variable to: integer(0..{floors - 1}) = {i % floors}\n"
        f"      on response from want{i} do to := value\n"
        f"      initial marked state rests {{ on request to enter{i} goto enters }}\n"
        f"      state enters {{ on response from inside{i} goto rides }}\n"
        f"      state rides {{ on request to leave{i} do at := Cabin.floor goto leaves }}\n"
        f"      state leaves {{ on response from outside{i} goto rests }}\n"
        "    }\n"
        "  }\n"
        f"  requirement enter{i} needs Cabin.free and Cabin.floor = Robot{i}.at"
        f" and Robot{i}.at != Robot{i}.to\n"
        f"  requirement leave{i} needs Cabin.free and Cabin.floor = Robot{i}.to\n"
        for i in range(n)
    ]
    parts += [
        f"  requirement never !Robot{i}.rests and !Robot{j}.rests\n"
        for i in range(n)
        for j in range(i)
    ]
    still = " and ".join(f"!Robot{i}.enters and !Robot{i}.leaves" for i in range(n))
    return robot_text("Riders", [*parts, f"  requirement close needs {still}\n"])


def zones(n: int, z: int) -> str:
    """n robots on a ring of z zones, each of which holds one: few states of very many."""
    parts = [
        f"  component Robot{i} {{\n"
        f"    incoming message go{i} with type: none\n"
        f"    outgoing message there{i} with type: none\n"
        f"    outgoing message failed{i} with type: none\n"
        "    behaviour {\n"
        f"      variable zone: integer(0..{z - 1}) = {i}\n"
        f"      variable next: integer(0..{z - 1}) = {i}\n"
        "      initial marked state stands {\n"
        f"        on request to go{i} if zone < {z - 1} do next := zone + 1 goto drives\n"
        f"        on request to go{i} if zone = {z - 1} do next := 0 goto drives\n"
        "      }\n"
        "      state drives {\n"
        f"        on response from there{i} do zone := next goto stands\n"
        f"        on response from failed{i} do next := zone goto stands\n"
        "      }\n"
        "    }\n"
        "  }\n"
        for i in range(n)
    ]
    parts += [
        f"  requirement never Robot{i}.{one} = Robot{j}.{other}\n"
        for i in range(n)
        for j in range(i)
        for one in ("zone", "next")
        for other in ("zone", "next")
    ]
    return robot_text("Zones", parts)


def zones_by_hand(n: int, z: int) -> tuple[int, int]:
    """Return the states and steps of :func:`zones` under control, searched as one would by hand.

    A state is the zone and the next zone of each robot. None is lost to blocking: whoever drives
    may fail, and then all stand. The messages of one that stands change nothing, but may come.
    """
    first = tuple((i, i) for i in range(n))
    states, left, steps = {first}, [first], 0
    for state in left:  # appended to below
        taken = {place for places in state for place in places}
        for i, (zone, after) in enumerate(state):
            ahead = (zone + 1) % z
            if zone != after:
                moves = [(after, after), (zone, zone)]
            else:
                moves = [] if ahead in taken else [(zone, ahead)]
                steps += 2
            for move in moves:
                steps += 1
                other = (*state[:i], move, *state[i + 1 :])
                if other not in states:
                    states.add(other)
                    left.append(other)
    return len(states), steps


def track(n: int, blocks: int) -> str:
    """n vehicles on a ring of blocks, which take part in every step: events read all of them."""
    ring = range(blocks)
    parts = [
        f"  component Block{b} {{ behaviour {{\n"
        f"    {'' if b < n else 'initial '}marked state free {{\n"
        + "".join(f"      on request to go{i}_{b} goto taken\n" for i in range(n))
        + f"    }}\n    {'initial ' if b < n else ''}marked state taken {{\n"
        + "".join(
            f"      on response from left{i} if Vehicle{i}.behind = {b} and !Vehicle{i}.stands"
            " goto free\n"
            for i in range(n)
        )
        + "    }\n  } }\n"
        for b in ring
    ]
    parts += [
        f"  component Vehicle{i} {{\n"
        + "".join(f"    incoming message go{i}_{b} with type: none\n" for b in ring)
        + f"    outgoing message left{i} with type: none\n"
        "    behaviour {\n"
        f"      variable at: integer(0..{blocks - 1}) = {i}\n"
        f"      variable behind: integer(0..{blocks - 1}) = {i}\n"
        "      initial marked state stands {\n"
        + "".join(
            f"        on request to go{i}_{b} if at = {(b - 1) % blocks} do at := {b} goto drives\n"
            for b in ring
        )
        + "      }\n"
        f"      state drives {{ on response from left{i} do behind := at goto stands }}\n"
        "    }\n"
        "  }\n"
        for i in range(n)
    ]
    return robot_text("Track", parts)


def grid(width: int, height: int, n: int) -> str:
    """n robots on a grid that step to the next place, of which each holds one."""
    parts = [
        f"""  component Bot{i} {{
    incoming message east{i} with type: none
    incoming message west{i} with type: none
    incoming message north{i} with type: none
    incoming message south{i} with type: none
    outgoing message there{i} with type: none
    behaviour {{
      variable x: integer(0..{width - 1}) = {i % width}
      variable y: integer(0..{height - 1}) = {i // width}
      initial marked state stands {{
        on request to east{i} do x := x + 1 goto moves
        on request to west{i} do x := x - 1 goto moves
        on request to north{i} do y := y + 1 goto moves
        on request to south{i} do y := y - 1 goto moves
      }}
      state moves {{ on response from there{i} goto stands }}
    }}
  }}
"""
        for i in range(n)
    ]
    parts += [
        f"  requirement never Bot{i}.x = Bot{j}.x and Bot{i}.y = Bot{j}.y\n"
        for i in range(n)
        for j in range(i)
    ]
    return robot_text("Grid", parts)


def warehouse(width: int, carts: int) -> str:
    """Carts on a square grid that never meet, and of which each may be pushed in one column."""
    pairs = [(a, b) for a in range(1, carts + 1) for b in range(a + 1, carts + 1)]
    steps = {
        "east": "x := x + 1",
        "west": "x := x - 1",
        "north": "y := y + 1",
        "south": "y := y - 1",
    }
    return robot_text(
        "Warehouse",
        [
            f"  component Cart[1..{carts}] {{\n",
            *(
                f'    incoming message {name} with identifier: "/c{{index}}/{name}", type: none\n'
                for name in steps
            ),
            '    outgoing message pushed with identifier: "/c{index}/pushed", type: none\n'
            "    behaviour {\n"
            f"      variable x: integer(0..{width - 1}) = index - 1\n"
            f"      variable y: integer(0..{width - 1}) = 0\n"
            "      initial marked state s {\n",
            *(f"        on request to {name} do {update}\n" for name, update in steps.items()),
            f"        on response from pushed if y > 0 and x = {width // 2} do y := y - 1\n"
            "      }\n"
            "    }\n"
            "  }\n",
            *(
                f"  requirement never Cart[{a}].x = Cart[{b}].x and Cart[{a}].y = Cart[{b}].y\n"
                for a, b in pairs
            ),
        ],
    )


def quotas(n: int, most: int) -> str:
    """n users with numbers of their own, of which ``most`` may have more than two units."""
    return f"""robot Quotas {{
  component User[1..{n}] {{
    incoming message take with identifier: "/u{{index}}/take", type: none
    outgoing message spill with identifier: "/u{{index}}/spill", type: none
    outgoing message done with identifier: "/u{{index}}/done", type: none
    behaviour {{
      variable used: integer(0..4) = 0
      initial marked state s {{
        on request to take do used := used + 1
        on response from spill if used = 2 do used := 3
        on response from done do used := 0
      }}
    }}
  }}
  requirement never count(u.used > 2 for u in User) > {most}
  requirement always all(u.used < 4 for u in User)
}}
"""


def served_copies(n: int, most: int) -> str:
    """n stations, each of which may be served only while fewer than ``most`` are."""
    return f"""robot Copies {{
  component Station[1..{n}] {{
    outgoing message button with identifier: "/s{{index}}/button", type: none
    incoming message serve with identifier: "/s{{index}}/serve", type: none
    outgoing message served with identifier: "/s{{index}}/served", type: none
    behaviour {{
      initial marked state idle {{ on response from button goto waiting }}
      state waiting {{ on request to serve goto busy }}
      state busy {{ on response from served goto idle }}
    }}
  }}
  for i in 1..{n} {{
    requirement Station[i].serve needs count(s.busy for s in Station) < {most}
  }}
}}
"""


def chargers(n: int, most: int) -> str:
    """Robots that share chargers and a table, and whose work takes one of four units of charge."""
    parts = []
    for i in range(n):
        plugs = "".join(f"    incoming message plug{i}_{j} with type: none\n" for j in range(most))
        charges = "".join(
            f"        on request to plug{i}_{j} do at := {j + 1} goto charges\n"
            for j in range(most)
        )
        parts.append(f"""
  component Bot{i} {{
    incoming message work{i} with type: none
    incoming message hand{i} with type: none
    incoming message leave{i} with type: none
    outgoing message worked{i} with type: none
    outgoing message taken{i} with type: none
    outgoing message charged{i} with type: none
{plugs}    behaviour {{
      variable level: integer(0..4) = 4
      variable at: integer(0..{most}) = 0
      initial marked state free {{
        on request to work{i} goto works
        on request to hand{i} goto hands
{charges}      }}
      state works {{ on response from worked{i} if level > 0 do level := level - 1 goto free }}
      state hands {{ on response from taken{i} if level > 0 do level := level - 1 goto free }}
      state charges {{
        on response from charged{i} if level < 4 do level := level + 1
        on request to leave{i} do at := 0 goto free
      }}
    }}
  }}
  requirement never Bot{i}.level = 0 and !Bot{i}.charges""")
        parts += [
            f"""
  requirement never Bot{i}.at != 0 and Bot{i}.at = Bot{j}.at
  requirement never Bot{i}.hands and Bot{j}.hands"""
            for j in range(i)
        ]
    return robot_text("Chargers", parts)
