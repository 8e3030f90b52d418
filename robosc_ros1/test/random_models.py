"""Random robots, as model text: small, valid, and of everything that has a meaning in synthesis.

:func:`random_model` builds one from a ``random.Random``; :func:`models` is the same as a hypothesis
strategy, whose random source shrinks. ``size`` from 1 bounds the product of all state variables.
"""

from __future__ import annotations

import random

from hypothesis import strategies as st
from random_behaviours import RandomBehaviours, indented
from random_expressions import (
    BOOLEAN,
    DOUBLE,
    INTEGER,
    NONE,
    STRING,
    RandomCommunication,
    RandomComponent,
    RandomType,
    RandomVariable,
    Scope,
    ranged,
)

__all__ = ["models", "random_model"]

BUDGETS = {1: 150, 2: 800, 3: 3000, 4: 12000}


def models(
    size: st.SearchStrategy[int] | None = None,
) -> st.SearchStrategy[str]:
    """Model texts; hypothesis shrinks them through the choices that made them."""
    sizes = size if size is not None else st.integers(1, 3)
    return st.builds(random_model, st.randoms(use_true_random=False), sizes)


def random_model(
    rng: random.Random,
    size: int = 2,
    *,
    served: bool = False,
    assumes: bool = False,
    stays: bool = False,
) -> str:
    """The text of a robot that ``check`` accepts without errors.

    ``served``: at least half of what would be services are calls of the robot. ``assumes``: there
    are assumptions. ``stays``: most finite variables are persistent.
    """
    builder = _Builder(rng, BUDGETS[size])
    builder.serves = served
    builder.assumes = assumes
    builder.stays = stays
    return builder.build()


class _Builder(RandomBehaviours):
    """Draws the declarations and requirements of a robot."""

    serves = False
    assumes = False

    # --- the whole ---------------------------------------------------------------------------

    def build(self) -> str:
        for index in range(self.number(0, 2)):
            self.enum(index)
        for index in range(self.number(0, 2)):
            self.object(index)
        if self.chance(60):
            self.depot()
        least, most = (1, 2) if self.components else (1 if self.chance(30) else 2, 4)
        for index in range(self.number(least, most)):
            self.component(index)
        bodies = [
            self.depot_text(c) if c.name == "Depot" else self.component_text(c)
            for c in self.components
        ]
        rest = self.requirements() + self.provides()
        rest += self.assumptions() if self.assumes else []
        declarations = ["interface link use Thing from random_robot_msgs", *self.declarations]
        parts = declarations + bodies + rest
        return "robot Random {\n" + "".join(indented(part) for part in parts) + "}\n"

    # --- datatypes ---------------------------------------------------------------------------

    def enum(self, index: int) -> None:
        count = self.number(2, 3)
        # The second enum may share value names with the first: the expected type tells them apart.
        prefix = "" if index == 0 or self.chance(30) else f"{'abc'[index]}_"
        values = [prefix + name for name in ("near", "far", "gone")[:count]]
        name = f"Enum{index}"
        rules = "\n".join(
            f"    value {self.pick(('>', '>=', '<', '='))} {self.number(-5, 5)} -> {value}"
            for value in values[1:]
        )
        source = self.pick(("double", "integer"))
        default = f"    default -> {values[0]}"
        body = f"{rules}\n{default}" if self.chance(50) else f"{default}\n{rules}"
        self.declarations.append(f"datatype enum {name} from {source} to {{\n{body}\n}}")
        self.enums.append(RandomType(name, "enum", tuple(values)))

    def object(self, index: int) -> None:
        name = f"Object{index}"
        properties = []
        for position in range(self.number(1, 3)):
            options = [BOOLEAN, ranged(0, 2), ranged(-1, 1), DOUBLE, STRING]
            options += self.enums + self.objects
            type_ = options[self.rng.randrange(len(options))]
            if self.chance(15):
                type_ = RandomType(f"array({type_.text})", "array", None, (("", type_),))
            properties.append((f"p{position}", type_))
        body = "\n".join(f"    {n}: {t.text}" for n, t in properties)
        self.declarations.append(f"datatype object {name} {{\n{body}\n}}")
        self.objects.append(RandomType(name, "object", None, tuple(properties)))

    # --- components --------------------------------------------------------------------------

    def component(self, index: int) -> None:
        component = RandomComponent(f"Comp{index}")
        self.components.append(component)
        for position in range(self.number(0, 3)):
            self.communication(component, f"c{index}_{position}")
        if self.chance(6) and not any(
            c.kind == "outgoing action" for c in component.communications
        ):
            return
        states = 1 if self.chance(12) else self.number(2, 4)
        while not self.spend(states):
            states -= 1
        # A state may be called like an enum value, or a keyword.
        names = ["idle", "busy", self.pick(("near", "stuck", "^state", "from")), "last"]
        component.states = names[:states]
        component.machine = states > 1 and self.chance(70)
        for position in range(self.number(0, 2)):
            self.variable(component, position)

    def depot(self) -> None:
        """A component that must not be sent out too often: what it brings may be too much."""
        load = RandomVariable("Depot", "load", ranged(0, self.number(1, 3)), None, False)
        if not self.spend(2 * 2 * load.type.size):
            return
        fetch = RandomCommunication("fetch", "service")
        if self.chance(50):
            fetch.response = ranged(0, self.number(1, 2))
        drop = RandomCommunication("drop", "incoming")
        self.components.append(
            RandomComponent("Depot", ["home", "away"], {"home"}, [load], [fetch, drop])
        )

    def depot_text(self, depot: RandomComponent) -> str:
        fetch, drop = depot.communications
        brought = "1" if fetch.response is NONE else "value"
        guard = f" if {self.boolean(Scope('Depot'), 1)}" if self.chance(30) else ""
        unload = "    on request to drop do load := load - 1"
        lines = [
            self.communication_text(fetch),
            self.communication_text(drop),
            "behaviour {",
            f"variable load: {depot.variables[0].type.text}",
            "initial marked state home {",
            "    on request to fetch goto away",
            unload,
            "}",
            "state away {",
            f"    on response from fetch{guard} do load := load + {brought} goto home",
            "    on error from fetch goto home",
            *([unload] if self.chance(50) else []),
            "}",
            "}",
        ]
        return "component Depot {\n" + "".join(map(indented, lines)) + "}"

    def communication(self, component: RandomComponent, name: str) -> None:
        kinds = ("incoming", "outgoing", "outgoing", "service", "action")
        kind = self.pick((*kinds, "service", "service") if self.serves else kinds)
        if kind in ("service", "action") and not self.spend(2):
            kind = "outgoing"
        incoming = [NONE, NONE, BOOLEAN, ranged(0, 2), ranged(-1, 2), INTEGER, DOUBLE]
        incoming += self.enums + self.objects
        outgoing = [NONE, NONE, BOOLEAN, ranged(1, 3), DOUBLE, *self.plain_objects()]

        def one(options: list[RandomType]) -> RandomType:
            return options[self.rng.randrange(len(options))]

        communication = RandomCommunication(name, kind)
        sent, received = one(outgoing), one(incoming)
        if self.serves and kind in ("service", "action") and self.chance(70):
            communication.kind = f"outgoing {kind}"
            sent, received = received, sent
        if kind != "outgoing":
            communication.request = sent
        if kind != "incoming":
            communication.response = received
        if kind == "action":
            communication.feedback = one(outgoing if communication.served else incoming)
        component.communications.append(communication)

    def plain_objects(self) -> list[RandomType]:
        """Objects that can be sent: without enums, which only convert what comes in."""

        def plain(type_: RandomType) -> bool:
            return type_.kind != "enum" and all(plain(t) for _, t in type_.properties)

        return [o for o in self.objects if plain(o)]

    def variable(self, component: RandomComponent, index: int) -> None:
        low = self.number(-2, 1)
        options = [BOOLEAN, ranged(low, low + self.number(0, 3)), *self.enums]
        type_ = options[self.rng.randrange(len(options))]
        silent = self.chance(15)
        if silent and self.chance(60):
            type_ = (DOUBLE, INTEGER, STRING)[self.number(0, 2)]
        elif not self.spend(type_.size):
            return
        initial: str | None = None
        if type_.values is not None and self.chance(70):
            initial = self.pick(type_.values)
        elif type_.values is None and self.chance(50):
            initial = {"double": "1.5", "integer": "7", "string": '"none"'}[type_.kind]
        name = ("x", "y")[index]
        component.variables.append(RandomVariable(component.name, name, type_, initial, silent))

    def requirements(self) -> list[str]:
        names = [communication.name for communication in self.requestable()]
        names += [f"{c.name}.feedback" for c in self.requestable() if c.kind == "outgoing action"]
        texts = self.work_requirements()
        for _ in range(self.number(0, 3)):
            condition = self.boolean(Scope())
            if not names or self.chance(20):
                kind = self.pick(("never", "always"))
                texts.append(f"requirement {kind} {self.rarely(kind)}")
                continue
            chosen = self.rng.sample(names, min(len(names), 2 if self.chance(25) else 1))
            some = chosen[0] if len(chosen) == 1 else "{" + ", ".join(chosen) + "}"
            # Actions alone are cancelled; of other commands it makes no difference.
            start = " to start" if self.chance(30) else ""
            if self.chance(50):
                texts.append(f"requirement {some} needs {condition}{start}")
            else:
                texts.append(f"requirement {condition} disables {some}{start}")
        while self.chance(25):
            parts = [f"requirement possible {self.boolean(Scope())}"]
            parts += [f"from {self.boolean(Scope())}"] if self.chance(60) else []
            parts += [f"while {self.boolean(Scope())}"] if self.chance(30) else []
            texts.append(" ".join(parts))
        return texts

    def assumptions(self) -> list[str]:
        heard = [
            c
            for component in self.components
            for c in component.communications
            if c.kind in ("outgoing", "service", "action")
        ]
        texts = []
        for _ in range(self.number(1, 3)):
            if heard and self.chance(50):
                one = heard[self.rng.randrange(len(heard))]
                condition = self.boolean(Scope(value=one.response))
                texts.append(f"assume {one.name} needs {condition}")
            else:
                kind = self.pick(("never", "always"))
                texts.append(f"assume {kind} {self.boolean(Scope())}")
        return texts

    def work_requirements(self) -> list[str]:
        """Machines that may not work together, and counters that are worth watching."""
        machines = [component for component in self.components if component.machine]
        texts = []
        if len(machines) > 1 and self.chance(50):
            both = " and ".join(f"{m.name}.{m.states[1]}" for m in machines[:2])
            texts.append(f"requirement never {both}")
        for machine in machines:
            for variable in machine.variables:
                if variable.type.kind == "integer" and variable.type.values and self.chance(60):
                    reference = f"{machine.name}.{variable.name}"
                    if not variable.silent:
                        texts.append(
                            f"requirement always {reference} <= {variable.type.values[-1]}"
                        )
        return texts

    def provides(self) -> list[str]:
        texts = []
        for communication in self.requestable():
            type_ = communication.sent
            if type_.kind == "none" or not self.chance(60):
                continue
            for _ in range(self.number(1, 2)):
                condition = f" if {self.boolean(Scope(), 1)}" if self.chance(40) else ""
                texts.append(f"provide {communication.name} with {self.data(type_)}{condition}")
        for communication in self.requestable():
            type_ = communication.feedback
            if communication.served and type_.kind != "none" and self.chance(60):
                condition = f" if {self.boolean(Scope(), 1)}" if self.chance(40) else ""
                name = f"{communication.name}.feedback"
                texts.append(f"provide {name} with {self.data(type_)}{condition}")
        return texts
