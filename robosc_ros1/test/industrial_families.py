"""Families of models of industrial plants, as model text: each grows with its numbers."""

from __future__ import annotations

from itertools import pairwise, product

from families import robot_text

__all__ = ["cluster_tool", "conveyor", "corridor_mesh", "elevator", "road"]


def cluster_tool(chambers: int) -> str:
    """An arm that carries two kinds of wafers through the chambers in opposite orders.

    Each chamber and the arm hold one wafer: synthesis has to keep room for them to pass.
    """
    arm = ["      initial marked state empty {\n"]
    holding: list[str] = []
    parts = []
    for kind, route in (("A", range(chambers)), ("B", range(chambers - 1, -1, -1))):
        stops = ["In", *(str(chamber) for chamber in route), "Out"]
        for start, target in pairwise(stops):
            arm.append(f"        on request to take{kind}{start} goto {kind}{target}\n")
            holding.append(
                f"      state {kind}{target} {{ on request to put{kind}{target} goto empty }}\n"
            )
    for chamber in range(chambers):
        commands, states, first = "", "", ""
        for kind in "AB":
            name = f"{kind}{chamber}"
            commands += (
                f"    incoming message put{name} with type: none\n"
                f"    incoming message take{name} with type: none\n"
                f"    outgoing message done{name} with type: none\n"
            )
            first += f" on request to put{name} goto busy{kind}"
            states += (
                f"      state busy{kind} {{ on response from done{name} goto full{kind} }}\n"
                f"      state full{kind} {{ on request to take{name} goto empty }}\n"
            )
        parts.append(
            f"  component Chamber{chamber} {{\n{commands}    behaviour {{\n"
            f"      initial marked state empty {{{first} }}\n{states}    }}\n  }}\n"
        )
    own = "".join(
        f"    incoming message take{kind}In with type: none\n"
        f"    incoming message put{kind}Out with type: none\n"
        for kind in "AB"
    )
    behaviour = "".join([*arm, "      }\n", *holding])
    return robot_text(
        "ClusterTool",
        [*parts, f"  component Arm {{\n{own}    behaviour {{\n{behaviour}    }}\n  }}\n"],
    )


def corridor_mesh(rows: int, columns: int) -> str:
    """Corridors in a mesh that vehicles cross to the right and downwards, one in each at a time.

    They enter at the left and leave at the last one; no square of four corridors may be full.
    """
    parts = []
    for row, column in product(range(rows), range(columns)):
        here = f"{row}_{column}"
        enters = [f"right{row}_{column - 1}"] if column else [f"enter{row}"]
        enters += [f"down{row - 1}_{column}"] if row else []
        leaves = [f"right{here}"] * (column < columns - 1) + [f"down{here}"] * (row < rows - 1)
        commands = [*leaves, *([f"enter{row}"] if not column else [])]
        last = not leaves
        parts.append(
            f"  component Corridor{here} {{\n"
            + "".join(f"    incoming message {name} with type: none\n" for name in commands)
            + ("    outgoing message left with type: none\n" if last else "")
            + "    behaviour {\n      initial marked state free {"
            + "".join(f" on request to {name} goto taken" for name in enters)
            + " }\n      state taken {"
            + "".join(f" on request to {name} goto free" for name in leaves)
            + (" on response from left goto free" if last else "")
            + " }\n    }\n  }\n"
        )
    for row, column in product(range(rows - 1), range(columns - 1)):
        square = product((row, row + 1), (column, column + 1))
        full = " and ".join(f"Corridor{r}_{c}.taken" for r, c in square)
        parts.append(f"  requirement never {full}\n")
    return robot_text("CorridorMesh", parts)


def conveyor(places: int) -> str:
    """Three boxes on a conveyor of so many places, which keep their order and a distance of two."""
    parts = [
        f"  component Box{i} {{\n"
        f"    incoming message push{i} with type: none\n"
        f"    outgoing message moved{i} with type: none\n"
        f"    outgoing message stuck{i} with type: none\n"
        "    behaviour {\n"
        f"      variable place: integer(0..{places - 1}) = {4 - 2 * i}\n"
        f"      initial marked state rests {{ on request to push{i} goto moves }}\n"
        "      state moves {\n"
        f"        on response from moved{i} do place := place + 1 goto rests\n"
        f"        on response from stuck{i} goto rests\n"
        "      }\n"
        "    }\n"
        "  }\n"
        for i in range(3)
    ]
    parts += [f"  requirement always Box{i}.place - Box{i + 1}.place >= 2\n" for i in range(2)]
    return robot_text("Conveyor", parts)


def road(segments: int, most: int) -> str:
    """A ring road of segments for up to ``most`` cars; a light before each lets one car pass.

    A car that was let on arrives later or stays, so its place has to be kept on both sides.
    """
    parts = ["  interface light use Empty from std_srvs\n"]
    lights = [*(f"go{i}" for i in range(segments)), "enter"]
    parts += [
        f"  component Light_{name} {{\n"
        f"    service {name} with request: none, response: none links light\n"
        "  }\n"
        for name in lights
    ]
    for i in range(segments):
        entrances = [f"go{(i - 1) % segments}", *(["enter"] if i == 0 else [])]
        exits = i == segments // 2
        parts.append(
            f"  component Segment{i} {{\n"
            + ("    incoming message leave with type: none\n" if exits else "")
            + "    behaviour {\n"
            f"      variable cars: integer(0..{most}) = 0\n"
            "      initial marked state s {\n"
            + "".join(f"        on response from {e} do cars := cars + 1\n" for e in entrances)
            + f"        on request to go{i} if cars > 0 do cars := cars - 1\n"
            f"        on error from go{i} do cars := cars + 1\n"
            + ("        on request to leave if cars > 0 do cars := cars - 1\n" if exits else "")
            + "      }\n    }\n  }\n"
        )
    return robot_text("Road", parts)


def elevator(floors: int) -> str:
    """A cab between so many floors, each of which may call it; calls are served one by one."""
    cab = "".join(f"        on request to serve{i} if floor = {i}\n" for i in range(floors))
    parts = [
        "  component Cab {\n"
        "    incoming message up with type: none\n"
        "    incoming message down with type: none\n"
        "    outgoing message arrived with type: none\n"
        "    behaviour {\n"
        f"      variable floor: integer(0..{floors - 1}) = 0\n"
        "      initial marked state stands {\n"
        "        on request to up goto rises\n"
        f"        on request to down goto sinks\n{cab}"
        "      }\n"
        "      state rises { on response from arrived do floor := floor + 1 goto stands }\n"
        "      state sinks { on response from arrived do floor := floor - 1 goto stands }\n"
        "    }\n"
        "  }\n"
        "  component Door {\n"
        "    incoming message open with type: none\n"
        "    incoming message close with type: none\n"
        "    behaviour {\n"
        "      initial marked state closed { on request to open goto opened }\n"
        "      state opened { on request to close goto closed }\n"
        "    }\n"
        "  }\n"
        "  requirement { up, down } needs Door.closed\n"
        "  requirement open needs Cab.stands\n"
    ]
    parts += [
        f"  component Floor{i} {{\n"
        f"    outgoing message call{i} with type: none\n"
        f"    incoming message serve{i} with type: none\n"
        "    behaviour {\n"
        f"      initial marked state quiet {{ on response from call{i} goto calls }}\n"
        f"      state calls {{ on request to serve{i} goto quiet }}\n"
        "    }\n"
        "  }\n"
        f"  requirement serve{i} needs Door.opened\n"
        for i in range(floors)
    ]
    return robot_text("Elevator", parts)
