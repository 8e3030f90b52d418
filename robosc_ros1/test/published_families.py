"""Scalable families of models from the literature on supervisory control, hard in different ways.

The bench measures whole commands on them; sizes are in :data:`SIZES`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

SIZES: Mapping[str, Sequence[tuple[int, ...]]] = {
    "rework": [(2, 2), (3, 3), (6, 3), (12, 4), (20, 5)],
    "breakdown": [(2, 2), (3, 2), (6, 3), (12, 4), (20, 4)],
    "locking": [(2,), (3,), (6,), (12,), (24,)],
    "interlocking": [(2,), (3,), (6,), (12,), (20,)],
    "elevators": [(1, 3), (2, 3), (2, 5), (3, 6), (4, 8)],
    "scheduler": [(3,), (5,), (10,), (20,), (60,)],
    "cells": [(1, 1), (1, 2), (2, 1), (3, 2), (6, 2), (12, 2)],
    "jacks": [(2, 2), (3, 3), (6, 7), (12, 15), (20, 15)],
    "hot": [(3, 1), (5, 2), (10, 4), (16, 8), (24, 12)],
    "fork_timers": [(2,), (4,), (10,), (25,), (50,)],
    "locks": [(1,), (2,), (4,), (8,), (16,)],
}


def rework(n: int, k: int) -> str:
    """A transfer line whose test units send failed parts back (Wonham)."""
    parts, needs = [], []
    for i in range(n):
        parts.append(machine(f"M{i}", f"start{i}", f"end{i}"))
        parts.append(machine(f"T{i}", f"test{i}", f"pass{i}", f"fail{i}"))
        filled = [(f"end{i}", f"M{i}.busy"), (f"fail{i}", f"T{i}.busy")]
        parts.append(buffer(f"B{i}", k, filled, [f"test{i}"]))
        needs.append(f"test{i} needs B{i}.level > 0")
        if i + 1 < n:
            parts.append(buffer(f"O{i}", 1, [(f"pass{i}", f"T{i}.busy")], [f"start{i + 1}"]))
            needs.append(f"start{i + 1} needs O{i}.level > 0")
    return robot(parts, needs)


def breakdown(n: int, k: int) -> str:
    """Queues in a row whose machines break down; one crew, which repairs the last machine first."""
    parts, rules = [], []
    for i in range(n):
        states = {
            "*!idle": [f"on request to start{i} goto busy"],
            "busy": [f"on response from end{i} goto idle", f"on response from break{i} goto down"],
            "down": [f"on request to repair{i} goto repairing"],
            "repairing": [f"on response from fixed{i} goto idle"],
        }
        messages = [f"end{i}", f"break{i}", f"fixed{i}"]
        parts.append(component(f"M{i}", [f"start{i}", f"repair{i}"], messages, states))
        others = " or ".join(f"M{j}.repairing" for j in range(n) if j != i)
        rules.append(f"({others}) disables repair{i}")
        if i < n - 1:
            rules.append(f"M{i + 1}.down disables repair{i}")
        if i:
            parts.append(buffer(f"B{i}", k, [(f"end{i - 1}", f"M{i - 1}.busy")], [f"start{i}"]))
            rules.append(f"start{i} needs B{i}.level > 0")
    return robot(parts, rules)


def locking(n: int) -> str:
    """Central locking of n doors with motors; a crash unlocks, a key locks."""
    key = {
        "*!open": ["on response from turn_lock goto shut", "on response from crash goto crashed"],
        "!shut": ["on response from turn_unlock goto open", "on response from crash goto crashed"],
        "!crashed": ["on response from reset goto open"],
    }
    parts = [component("Key", [], ["turn_lock", "turn_unlock", "crash", "reset"], key)]
    idle = " and ".join(f"!Door{j}.locking" for j in range(n))
    rules = []
    for i in range(n):
        door = {
            "*!free": [f"on request to lock{i} goto locking"],
            "locking": [
                f"on response from locked{i} goto fast",
                f"on response from jam{i} goto free",
            ],
            "!fast": [f"on request to unlock{i} goto unlocking"],
            "unlocking": [f"on response from unlocked{i} goto free"],
        }
        told = [f"locked{i}", f"unlocked{i}", f"jam{i}"]
        parts.append(component(f"Door{i}", [f"lock{i}", f"unlock{i}"], told, door))
        leaf = {
            "*!closed": [f"on response from opened{i} if Door{i}.free goto opened"],
            "!opened": [f"on response from closed{i} goto closed"],
        }
        parts.append(component(f"Leaf{i}", [], [f"opened{i}", f"closed{i}"], leaf))
        rules += [
            f"lock{i} needs Key.shut and Leaf{i}.closed",
            f"unlock{i} needs !Key.shut",
            f"unlock{i} needs {idle}",
        ]
    rules.append("never " + " and ".join(f"Door{i}.unlocking" for i in range(n)))
    return robot(parts, rules)


def interlocking(n: int) -> str:
    """The throat of a station: n tracks in a ladder of points, and routes that lock points."""
    parts, rules = [], []
    for i in range(n):
        point = {
            "*!n": [f"on request to throw{i} goto to_r"],
            "to_r": [f"on response from reverse{i} goto r"],
            "!r": [f"on request to restore{i} goto to_n"],
            "to_n": [f"on response from normal{i} goto n"],
        }
        commands, told = [f"throw{i}", f"restore{i}"], [f"reverse{i}", f"normal{i}"]
        parts.append(component(f"Point{i}", commands, told, point))
    for j in range(n + 1):
        release = f"on request to release{j} goto off"
        route = {
            "*!off": [f"on request to set{j} goto locked"],
            "locked": [f"on response from enter{j} goto used", release],
            "used": [f"on response from clear{j} goto passed"],
            "passed": [release],
        }
        commands, told = [f"set{j}", f"release{j}"], [f"enter{j}", f"clear{j}"]
        parts.append(component(f"Route{j}", commands, told, route))
        track = {
            "*!vacant": [f"on response from clear{j} if Route{j}.used goto occupied"],
            "!occupied": [f"on response from depart{j} goto vacant"],
        }
        parts.append(component(f"Track{j}", [], [f"depart{j}"], track))
        rules += [f"never !Route{j}.off and !Route{m}.off" for m in range(j + 1, n + 1)]
        way = [f"Point{i}.n" for i in range(j)] + [f"Point{j}.r"] * (j < n)
        rules.append(f"never !Route{j}.off and !({' and '.join(way)})")
        rules.append(f"never Track{j}.occupied and Route{j}.used")
    return robot(parts, rules)


def elevators(c: int, f: int) -> str:
    """c cabins over f floors that stay in order; doors open only where somebody called."""
    parts, rules = [], []
    for j in range(f):
        served = [
            f"on response from served{i}_{j} if Cabin{i}.opening and Cabin{i}.floor = {j} goto off"
            for i in range(c)
        ]
        call = {"*!off": [f"on response from press{j} goto lit"], "lit": served}
        parts.append(component(f"Call{j}", [], [f"press{j}"], call))
    for i in range(c):
        cabin = {
            "*!still": [
                f"on request to up{i} do floor := floor + 1 goto moving",
                f"on request to down{i} do floor := floor - 1 goto moving",
                f"on request to open{i} goto opening",
            ],
            "moving": [f"on response from arrived{i} goto still"],
            "opening": [
                f"on response from served{i}_{j} if floor = {j} goto open" for j in range(f)
            ],
            "open": [f"on request to close{i} goto still"],
        }
        commands = [f"{verb}{i}" for verb in ("up", "down", "open", "close")]
        told = [f"arrived{i}", *(f"served{i}_{j}" for j in range(f))]
        variables = [f"floor: integer(0..{f - 1}) = {min(i, f - 1)}"]
        parts.append(component(f"Cabin{i}", commands, told, cabin, variables))
        called = (f"(Cabin{i}.floor = {j} and Call{j}.lit)" for j in range(f))
        rules.append(f"open{i} needs {' or '.join(called)}")
        for m in range(i):
            rules.append(
                f"never Cabin{i}.floor = Cabin{m}.floor and !Cabin{i}.moving and !Cabin{m}.moving"
                f" and !Cabin{i}.still"
            )
        if i:
            rules.append(f"always Cabin{i}.floor >= Cabin{i - 1}.floor")
    return robot(parts, rules)


def scheduler(n: int) -> str:
    """Milner's cyclic scheduler: n tasks are started in turn, and end by themselves."""
    parts = []
    for i in range(n):
        parts.append(machine(f"Task{i}", f"run{i}", f"done{i}"))
        has, waits = ("*!has", "waits") if i == 0 else ("has", "*!waits")
        turn = {
            has: [f"on request to run{i} goto waits"],
            waits: [f"on request to run{(i - 1) % n} goto has"],
        }
        parts.append(component(f"Turn{i}", [], [], turn))
    return robot(parts, [])


def cells(n: int, k: int) -> str:
    """n flexible manufacturing cells in a row (de Queiroz & Cury): machines, a robot, buffers."""
    parts: list[str] = []
    rules: list[str] = []
    for i in range(n):
        machines = {"ConvA": "feedA inA", "ConvB": "feedB inB", "Mill": "mill milled"}
        machines |= {"Lathe": "turn turned", "Asm": "asm made"}
        for name, events in machines.items():
            parts.append(machine(f"{name}{i}", *(f"{event}{i}" for event in events.split())))
        tasks = {"ra": "rawA gotA", "rb": "rawB gotB", "ta": "toA putA", "tb": "toB putB"}
        pairs = {state: events.split() for state, events in tasks.items()}
        idle = [f"on request to {one}{i} goto {state}" for state, (one, _) in pairs.items()]
        busy = {s: [f"on response from {end}{i} goto idle"] for s, (_, end) in pairs.items()}
        commands, told = ([f"{pair[n]}{i}" for pair in pairs.values()] for n in (0, 1))
        parts.append(component(f"Robot{i}", commands, told, {"*!idle": idle, **busy}))
        buffers = [
            ("B1_", "inA", "ConvA{}.busy", "rawA"), ("B2_", "inB", "ConvB{}.busy", "rawB"),
            ("B3_", "gotA", "Robot{}.ra", "mill"), ("B4_", "gotB", "Robot{}.rb", "turn"),
            ("B5_", "milled", "Mill{}.busy", "toA"), ("B6_", "turned", "Lathe{}.busy", "toB"),
            ("B7_", "putA", "Robot{}.ta", "asm"), ("B8_", "putB", "Robot{}.tb", "asm"),
        ]  # fmt: skip
        for name, put, where, taken in buffers:
            parts.append(buffer(f"{name}{i}", k, [(f"{put}{i}", where.format(i))], [f"{taken}{i}"]))
            rules.append(f"{taken}{i} needs {name}{i}.level > 0")
        if i:
            filled = [(f"made{i - 1}", f"Asm{i - 1}.busy")]
            parts.append(buffer(f"Link{i}", k, filled, [f"feedA{i}"]))
            rules.append(f"feedA{i} needs Link{i}.level > 0")
    return robot(parts, rules)


def jacks(n: int, k: int) -> str:
    """A platform on n jacks: neighbours differ by two steps at most; a cracked one may slip."""
    parts, rules = [], []
    for i in range(n):
        states = {
            "*!s": [
                f"on request to up{i} do h := h + 1",
                f"on request to down{i} do h := h - 1",
                f"on response from slip{i} if h > 0 and loose do h := h - 1, loose := false",
            ]
        }
        variables = [f"h: integer(0..{k}) = 0", "loose: boolean = false"]
        commands, told = [f"up{i}", f"down{i}"], [f"slip{i}", f"crack{i}"]
        always = [f"on response from crack{i} do loose := true"]
        parts.append(component(f"Jack{i}", commands, told, states, variables, always))
        if i:
            rules.append(f"always Jack{i - 1}.h - Jack{i}.h <= 2")
            rules.append(f"always Jack{i}.h - Jack{i - 1}.h <= 2")
    return robot(parts, rules)


def hot(n: int, k: int) -> str:
    """n stations; one that runs may become hot by itself, and never more than k may be hot."""
    messages = "".join(
        f'incoming message {name} with identifier: "/{name}{{index}}", type: none\n'
        for name in ("run", "stop", "cool")
    )
    return f"""robot R {{
        component S[0..{n - 1}] {{
            {messages}
            outgoing message heat with identifier: "/heat{{index}}", type: none
            behaviour {{
                initial marked state off {{ on request to run goto going }}
                marked state going {{
                    on response from heat goto hot
                    on request to stop goto off
                }}
                state hot {{ on request to cool goto off }}
            }}
        }}
        requirement always count(s.hot for s in S) <= {k}
    }}
    """


def fork_timers(n: int) -> str:
    """Dining philosophers that stop eating after a time at the latest."""
    parts, rules = [], []
    for i in range(n):
        states = {
            "*!thinks": [f"on response from hungry{i} goto hungry"],
            "hungry": [f"on request to left{i} goto has_left"],
            "has_left": [f"on request to right{i} goto has_both"],
            "has_both": [f"on request to eat{i} goto eats"],
            "eats": [f"on response from full{i} goto thinks", "after 5 s goto thinks"],
        }
        commands, told = [f"left{i}", f"right{i}", f"eat{i}"], [f"full{i}", f"hungry{i}"]
        parts.append(component(f"Phil{i}", commands, told, states))
        own, other = f"Phil{i}", f"Phil{(i + 1) % n}"
        rules.append(
            f"never ({own}.has_both or {own}.eats)"
            f" and ({other}.has_left or {other}.has_both or {other}.eats)"
        )
    return robot(parts, rules)


def locks(n: int) -> str:
    """A staircase of n water locks: culverts level the chambers, ships move by themselves."""
    parts, rules = [], []
    for g in range(n + 1):
        gate = {
            "*!closed": [f"on request to open{g} goto opening"],
            "opening": [f"on response from opened{g} goto open"],
            "open": [f"on request to shut{g} goto shutting"],
            "shutting": [f"on response from closed{g} goto closed"],
        }
        told = [f"opened{g}", f"closed{g}"]
        parts.append(component(f"Gate{g}", [f"open{g}", f"shut{g}"], told, gate))
        culvert = {
            "*!dry": [f"on request to drain{g} goto flows"],
            "flows": [f"on request to stop{g} goto dry"],
        }
        parts.append(component(f"Culvert{g}", [f"drain{g}", f"stop{g}"], [], culvert))
    for c in range(n):
        parts += [_water(c), _chamber(c, n)]
        d = c + 1
        rules += [
            f"never !Gate{c}.closed and !Gate{d}.closed",
            f"never Culvert{c}.flows and Culvert{d}.flows",
            f"never Culvert{c}.flows and !Gate{d}.closed",
            f"never Culvert{d}.flows and !Gate{c}.closed",
            f"open{c} needs Water{c}.low",
            f"open{d} needs Water{c}.high",
            f"always Gate{c}.closed or Water{c}.low",
            f"always Gate{d}.closed or Water{c}.high",
        ]
    return robot(parts, rules)


def _water(c: int) -> str:
    rises = f"on response from rises{c} if Culvert{c + 1}.flows goto"
    sinks = f"on response from sinks{c} if Culvert{c}.flows goto"
    states = {
        "*!low": [f"{rises} mid"],
        "mid": [f"{rises} high", f"{sinks} low"],
        "!high": [f"{sinks} mid"],
    }
    return component(f"Water{c}", [], [f"sinks{c}", f"rises{c}"], states)


def _chamber(c: int, n: int) -> str:
    entry = f"pass{c}" if c else "arrives"
    before = f" and Chamber{c - 1}.ship" if c else ""
    behind = f" and Chamber{c + 1}.free" if c + 1 < n else ""
    states = {
        "*!free": [f"on response from {entry} if Gate{c}.open{before} goto ship"],
        "ship": [f"on response from pass{c + 1} if Gate{c + 1}.open{behind} goto free"],
    }
    return component(f"Chamber{c}", [], [*(["arrives"] if c == 0 else []), f"pass{c + 1}"], states)


# --- parts of models -----------------------------------------------------------------------------


def machine(name: str, start: str, *ends: str) -> str:
    """A machine that is started, and ends by itself."""
    states = {
        "*!idle": [f"on request to {start} goto busy"],
        "busy": [f"on response from {end} goto idle" for end in ends],
    }
    return component(name, [start], ends, states)


def buffer(name: str, most: int, filled: Sequence[tuple[str, str]], emptied: Sequence[str]) -> str:
    """A buffer; ``filled`` are events with the states in which they fill it."""
    steps = [f"on response from {e} if {where} do level := level + 1" for e, where in filled]
    steps += [f"on request to {event} do level := level - 1" for event in emptied]
    return component(name, [], [], {"*!s": steps}, [f"level: integer(0..{most}) = 0"])


def component(
    name: str,
    commands: Sequence[str],
    told: Sequence[str],
    states: Mapping[str, Sequence[str]],
    variables: Sequence[str] = (),
    always: Sequence[str] = (),
) -> str:
    """A component; ``*`` before a state means initial, ``!`` marked."""
    lines = [f"component {name} {{"]
    lines += [f"incoming message {message} with type: none" for message in commands]
    lines += [f"outgoing message {message} with type: none" for message in told]
    lines += ["behaviour {", *(f"variable {variable}" for variable in variables), *always]
    for state, steps in states.items():
        kind = ("initial " if "*" in state else "") + ("marked " if "!" in state else "")
        lines += [f"{kind}state {state.strip('*!')} {{", *steps, "}"]
    return "\n".join([*lines, "}", "}"])


def robot(parts: Sequence[str], rules: Sequence[str]) -> str:
    lines = ["robot R {", *parts, *(f"requirement {rule}" for rule in rules), "}"]
    return "\n".join(lines) + "\n"
