"""Random robots, as model text: small, valid, and of everything that has a meaning in synthesis.

:func:`random_model` builds one from a ``random.Random``; :func:`models` is the same as a hypothesis
strategy, whose random source shrinks. ``size`` from 1 bounds the product of all state variables.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

from hypothesis import strategies as st

__all__ = ["models", "random_model"]

BUDGETS = {1: 150, 2: 800, 3: 3000, 4: 12000}
COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")


def models(
    size: st.SearchStrategy[int] | None = None,
) -> st.SearchStrategy[str]:
    """Model texts; hypothesis shrinks them through the choices that made them."""
    sizes = size if size is not None else st.integers(1, 3)
    return st.builds(random_model, st.randoms(use_true_random=False), sizes)


def random_model(rng: random.Random, size: int = 2) -> str:
    """The text of a robot that ``check`` accepts without errors."""
    return _Builder(rng, BUDGETS[size]).build()


@dataclass(frozen=True)
class _Type:
    """``values`` of a finite type as they are written in expressions; None for all others."""

    text: str
    kind: str
    values: tuple[str, ...] | None = None
    properties: tuple[tuple[str, _Type], ...] = ()

    @property
    def size(self) -> int:
        return len(self.values) if self.values else 1


NONE = _Type("none", "none")
BOOLEAN = _Type("boolean", "boolean", ("false", "true"))
DOUBLE = _Type("double", "double")
INTEGER = _Type("integer", "integer")
STRING = _Type("string", "string")


def _range(low: int, high: int) -> _Type:
    return _Type(f"integer({low}..{high})", "integer", tuple(str(i) for i in range(low, high + 1)))


@dataclass
class _Variable:
    component: str
    name: str
    type: _Type
    initial: str | None
    silent: bool  # never read where synthesis would see it

    def reference(self, component: str | None, rng: random.Random) -> str:
        if self.component == component and rng.random() < 0.8:
            return self.name
        return f"{self.component}.{self.name}"


@dataclass
class _Communication:
    name: str
    kind: str
    request: _Type = NONE
    response: _Type = NONE
    feedback: _Type = NONE

    @property
    def events(self) -> list[str]:
        return {
            "incoming": ["request"],
            "outgoing": ["response"],
            "service": ["request", "response", "error"],
            "action": ["request", "response", "feedback", "error", "cancel"],
        }[self.kind]

    def value(self, event: str) -> _Type:
        return {"response": self.response, "feedback": self.feedback}.get(event, NONE)


@dataclass
class _Component:
    name: str
    states: list[str] = field(default_factory=list)
    marked: set[str] = field(default_factory=set)
    variables: list[_Variable] = field(default_factory=list)
    communications: list[_Communication] = field(default_factory=list)
    machine: bool = False  # works through its own communications in a cycle, and counts


@dataclass(frozen=True)
class _Place:
    """Where a transition stands: a state, or none for the automaton level.

    ``targets`` collects where the transitions of the state lead. Those of the automaton level do
    not count, since a state may hide them.
    """

    state: str | None = None
    targets: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class _Scope:
    """Where an expression stands: in which behaviour, and what ``value`` is there."""

    component: str | None = None
    value: _Type = NONE
    # Expressions over data-only variables are allowed where nothing of synthesis reads the result.
    data: bool = False


class _Builder:
    def __init__(self, rng: random.Random, budget: int) -> None:
        self.rng = rng
        self.budget = budget
        self.enums: list[_Type] = []
        self.objects: list[_Type] = []
        self.declarations: list[str] = []
        self.components: list[_Component] = []

    # --- chance ------------------------------------------------------------------------------

    def chance(self, percent: int) -> bool:
        return self.rng.randrange(100) < percent

    def pick(self, options: list[str] | tuple[str, ...]) -> str:
        return options[self.rng.randrange(len(options))]

    def number(self, low: int, high: int) -> int:
        return self.rng.randint(low, high)

    def spend(self, factor: int) -> bool:
        if factor > self.budget:
            return False
        self.budget //= factor
        return True

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
        declarations = ["interface link use Thing from random_robot_msgs", *self.declarations]
        parts = declarations + bodies + rest
        return "robot Random {\n" + "".join(_indented(part) for part in parts) + "}\n"

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
        self.enums.append(_Type(name, "enum", tuple(values)))

    def object(self, index: int) -> None:
        name = f"Object{index}"
        properties = []
        for position in range(self.number(1, 3)):
            options = [BOOLEAN, _range(0, 2), _range(-1, 1), DOUBLE, STRING]
            options += self.enums + self.objects
            type_ = options[self.rng.randrange(len(options))]
            if self.chance(15):
                type_ = _Type(f"array({type_.text})", "array", None, (("", type_),))
            properties.append((f"p{position}", type_))
        body = "\n".join(f"    {n}: {t.text}" for n, t in properties)
        self.declarations.append(f"datatype object {name} {{\n{body}\n}}")
        self.objects.append(_Type(name, "object", None, tuple(properties)))

    def paths(self, type_: _Type, path: str = "value") -> list[tuple[str, _Type]]:
        """Finite parts of an incoming value."""
        if type_.values is not None:
            return [(path, type_)]
        if type_.kind == "array":
            element = type_.properties[0][1]
            return [p for i in (0, 1) for p in self.paths(element, f"{path}[{i}]")]
        return [p for name, t in type_.properties for p in self.paths(t, f"{path}.{name}")]

    # --- components --------------------------------------------------------------------------

    def component(self, index: int) -> None:
        component = _Component(f"Comp{index}")
        self.components.append(component)
        for position in range(self.number(0, 3)):
            self.communication(component, f"c{index}_{position}")
        if self.chance(6):
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
        load = _Variable("Depot", "load", _range(0, self.number(1, 3)), None, False)
        if not self.spend(2 * 2 * load.type.size):
            return
        fetch = _Communication("fetch", "service")
        if self.chance(50):
            fetch.response = _range(0, self.number(1, 2))
        drop = _Communication("drop", "incoming")
        self.components.append(
            _Component("Depot", ["home", "away"], {"home"}, [load], [fetch, drop])
        )

    def depot_text(self, depot: _Component) -> str:
        fetch, drop = depot.communications
        brought = "1" if fetch.response is NONE else "value"
        guard = f" if {self.boolean(_Scope('Depot'), 1)}" if self.chance(30) else ""
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
        return "component Depot {\n" + "".join(map(_indented, lines)) + "}"

    def communication(self, component: _Component, name: str) -> None:
        kind = self.pick(("incoming", "outgoing", "outgoing", "service", "action"))
        if kind in ("service", "action") and not self.spend(2):
            kind = "outgoing"
        incoming = [NONE, NONE, BOOLEAN, _range(0, 2), _range(-1, 2), INTEGER, DOUBLE]
        incoming += self.enums + self.objects
        outgoing = [NONE, NONE, BOOLEAN, _range(1, 3), DOUBLE, *self.plain_objects()]

        def one(options: list[_Type]) -> _Type:
            return options[self.rng.randrange(len(options))]

        communication = _Communication(name, kind)
        if kind != "outgoing":
            communication.request = one(outgoing)
        if kind != "incoming":
            communication.response = one(incoming)
        if kind == "action":
            communication.feedback = one(incoming)
        component.communications.append(communication)

    def plain_objects(self) -> list[_Type]:
        """Objects that can be sent: without enums, which only convert what comes in."""

        def plain(type_: _Type) -> bool:
            return type_.kind != "enum" and all(plain(t) for _, t in type_.properties)

        return [o for o in self.objects if plain(o)]

    def variable(self, component: _Component, index: int) -> None:
        low = self.number(-2, 1)
        options = [BOOLEAN, _range(low, low + self.number(0, 3)), *self.enums]
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
        component.variables.append(_Variable(component.name, name, type_, initial, silent))

    # --- expressions -------------------------------------------------------------------------

    def readable(self, kind: str, scope: _Scope, type_: _Type | None = None) -> list[str]:
        """References of a kind that may stand in the scope; ``type_`` tells enums apart."""

        def fits(candidate: _Type) -> bool:
            if candidate.values is None and not scope.data:
                return False
            return candidate.kind == kind and (type_ is None or candidate.text == type_.text)

        found = [
            variable.reference(scope.component, self.rng)
            for component in self.components
            for variable in component.variables
            if fits(variable.type) and (scope.data or not variable.silent)
        ]
        found += [path for path, t in self.paths(scope.value) if fits(t)]
        return found

    def boolean(self, scope: _Scope, depth: int = 2) -> str:
        if depth > 0 and self.chance(55):
            shape = self.number(0, 4)
            if shape == 0:
                return f"!({self.boolean(scope, depth - 1)})"
            operator = self.pick(("and", "or", "and", "or", "=>", "=", "!="))
            left, right = self.boolean(scope, depth - 1), self.boolean(scope, depth - 1)
            if operator in ("=", "!="):
                left, right = f"({left})", f"({right})"
            return f"({left} {operator} {right})"
        atoms: list[Callable[[_Scope], str | None]] = [
            self.flag, self.place, self.comparison, self.enum_test, self.comparison,
        ]  # fmt: skip
        order = list(range(len(atoms)))
        self.rng.shuffle(order)
        for index in order:
            atom = atoms[index](scope)
            if atom is not None:
                return atom
        return self.pick(("true", "true", "false"))

    def flag(self, scope: _Scope) -> str | None:
        found = self.readable("boolean", scope)
        return self.pick(found) if found else None

    def place(self, scope: _Scope) -> str | None:
        places = []
        for component in self.components:
            for state in component.states:
                own = component.name == scope.component and self.chance(70)
                places.append(state if own else f"{component.name}.{state}")
        return self.pick(places) if places else None

    def comparison(self, scope: _Scope) -> str | None:
        if not self.readable("integer", scope):
            return None
        left = self.integer(scope)
        if self.chance(10):
            return f"{left} / 2 {self.pick(('<', '>', '='))} {self.pick(('0.5', '1.0', '-1'))}"
        return f"{left} {self.pick(COMPARISONS)} {self.integer(scope)}"

    def enum_test(self, scope: _Scope) -> str | None:
        if not self.enums:
            return None
        type_ = self.enums[self.rng.randrange(len(self.enums))]
        found = self.readable("enum", scope, type_)
        if not found:
            return None
        assert type_.values is not None
        operator = self.pick(("=", "=", "!="))
        other = self.pick(found) if self.chance(25) else self.pick(type_.values)
        return f"{self.pick(found)} {operator} {other}"

    def integer(self, scope: _Scope, depth: int = 1) -> str:
        found = self.readable("integer", scope)
        if depth > 0 and self.chance(40):
            left, right = self.integer(scope, depth - 1), self.integer(scope, depth - 1)
            return f"({left} {self.pick(('+', '-', '+', '-', '*'))} {right})"
        if found and self.chance(70):
            reference = self.pick(found)
            return f"-{reference}" if self.chance(10) else reference
        return str(self.number(-1, 3))

    def assigned(self, variable: _Variable, scope: _Scope) -> str:
        """A right-hand side for a variable."""
        type_ = variable.type
        if type_.values is None:
            return self.data_only(variable, scope)
        if type_.kind == "boolean":
            return self.boolean(scope, 1)
        found = self.readable(type_.kind, scope, type_ if type_.kind == "enum" else None)
        if type_.kind == "integer":
            if self.chance(40):
                reference = variable.reference(scope.component, self.rng)
                return f"{reference} + {self.pick(('1', '-1', '2'))}"
            if found and self.chance(40):
                return f"{self.pick(found)} {self.pick('+-*%')} {self.integer(scope)}"
        return self.pick(found) if found and self.chance(65) else self.pick(type_.values)

    def data_only(self, variable: _Variable, scope: _Scope) -> str:
        kind = variable.type.kind
        if kind == "string":
            return self.pick(('"here"', "'there'"))
        if scope.value in (INTEGER, DOUBLE) and (kind == "double" or scope.value == INTEGER):
            return "value"
        if kind == "double" and self.chance(50):
            return f"{variable.name} * 0.5 + {self.integer(scope)}"
        return f"{variable.name} + {self.integer(scope)}"

    # --- behaviour ---------------------------------------------------------------------------

    def component_text(self, component: _Component) -> str:
        lines = [self.communication_text(c) for c in component.communications]
        if component.states:
            lines.append(self.behaviour_text(component))
        if self.chance(10):
            lines.reverse()
        return f"component {component.name} {{\n" + "".join(map(_indented, lines)) + "}"

    def communication_text(self, communication: _Communication) -> str:
        name, kind = communication.name, communication.kind
        identifier = f'identifier: "/{name}", ' if self.chance(30) else ""
        if kind in ("incoming", "outgoing"):
            type_ = communication.request if kind == "incoming" else communication.response
            links = " links link" if type_.kind == "object" else ""
            return f"{kind} message {name} with {identifier}type: {type_.text}{links}"
        text = f"{kind} {name} with {identifier}request: {communication.request.text}"
        text += f", response: {communication.response.text}"
        if kind == "action":
            text += f", feedback: {communication.feedback.text}"
        return text + " links link"

    def behaviour_text(self, component: _Component) -> str:
        edges: dict[str, set[str]] = {state: set() for state in component.states}
        bodies = {
            state: self.state_transitions(component, _Place(state, edges[state])) for state in edges
        }
        general = self.automaton_transitions(component)
        component.marked = _enough_marked(self.rng, component.states, edges)
        lines = []
        for variable in component.variables:
            initial = f" = {variable.initial}" if variable.initial is not None else ""
            lines.append(f"variable {variable.name}: {variable.type.text}{initial}")
        for state, body in bodies.items():
            words = ["initial"] if state == component.states[0] else []
            words += ["marked"] if state in component.marked else []
            head = " ".join([*words, "state", state])
            lines.append(f"{head} {{\n" + "".join(map(_indented, body)) + "}")
        position = self.number(0, len(lines)) if self.chance(30) else len(lines)
        lines[position:position] = general
        return "behaviour {\n" + "".join(map(_indented, lines)) + "}"

    def state_transitions(self, component: _Component, place: _Place) -> list[str]:
        body = []
        for communication, event, own in self.events(component):
            if own and component.machine:
                body += self.work(component, communication, event, place)
            elif self.chance(45 if own else (4 if event == "request" else 10)):
                body += self.reactions(component, communication, event, place)
        if self.chance(20):
            body.append(self.tau(component, place))
            if self.chance(20):
                body.append(self.tau(component, place))
        return body

    def work(
        self, component: _Component, communication: _Communication, event: str, place: _Place
    ) -> list[str]:
        """A machine: a request starts it and uses up, what comes back ends it and adds."""
        first, second = component.states[:2]
        counters = [v for v in component.variables if v.type.kind == "integer" and v.type.values]
        step = {"request": "-1", "response": "1"}.get(event)
        if communication.kind == "incoming" and self.chance(70):
            goto = ""  # makes room in any state
        elif (event == "request") != (place.state == first) or not self.chance(85):
            return []
        else:
            target = second if place.state == first else first
            place.targets.add(target)
            goto = f" goto {target}"
        text = f"on {event} to {communication.name}"
        if counters and step is not None and self.chance(75):
            text += f" do {counters[0].name} := {counters[0].name} + {step}"
        return [text + goto]

    def automaton_transitions(self, component: _Component) -> list[str]:
        body = []
        for communication, event, own in self.events(component):
            if self.chance(10 if own else 4):
                body += self.reactions(component, communication, event, _Place())
        if self.chance(5):
            body.append(self.tau(component, _Place()))
        return body

    def events(self, component: _Component) -> list[tuple[_Communication, str, bool]]:
        return [
            (communication, event, owner is component)
            for owner in self.components
            for communication in owner.communications
            for event in communication.events
        ]

    def reactions(
        self,
        component: _Component,
        communication: _Communication,
        event: str,
        place: _Place,
    ) -> list[str]:
        """The transitions of one state for one event: one, or several whose guards exclude."""
        scope = _Scope(component.name, communication.value(event))
        guards: list[str | None] = [None]
        if self.chance(30):
            guard = self.boolean(scope, 1)
            guards = [guard]
            if self.chance(50):
                guards = [guard, f"!({guard})"]
        texts = []
        for guard in guards:
            text = f"on {event} {self.pick(('from', 'to'))} {communication.name}"
            if guard is not None:
                text += f" if {guard}"
            texts.append(text + self.effects(component, scope, place))
        return texts

    def effects(self, component: _Component, scope: _Scope, place: _Place) -> str:
        text = ""
        assigned = []
        for variable in component.variables:
            if self.chance(45):
                assigned.append(f"{variable.name} := {self.assigned(variable, scope)}")
        if assigned:
            text += " do " + ", ".join(assigned)
        return text + self.goto(component, place, 70)

    def goto(self, component: _Component, place: _Place, percent: int) -> str:
        if not self.chance(percent):
            return ""
        states = component.states
        target = self.pick(states)
        if place.state is not None and self.chance(50):
            target = states[(states.index(place.state) + 1) % len(states)]
        place.targets.add(target)
        return f" goto {target}"

    def tau(self, component: _Component, place: _Place) -> str:
        guard = f" if {self.boolean(_Scope(component.name))}" if self.chance(60) else ""
        return f"transition{guard}{self.goto(component, place, 90)}"

    # --- requirements and data ---------------------------------------------------------------

    def requestable(self) -> list[_Communication]:
        return [
            communication
            for component in self.components
            for communication in component.communications
            if communication.kind != "outgoing"
        ]

    def requirements(self) -> list[str]:
        names = [communication.name for communication in self.requestable()]
        texts = self.work_requirements()
        for _ in range(self.number(0, 3)):
            condition = self.boolean(_Scope())
            if not names or self.chance(20):
                kind = self.pick(("never", "always"))
                texts.append(f"requirement {kind} {self.rarely(kind)}")
                continue
            chosen = self.rng.sample(names, min(len(names), 2 if self.chance(25) else 1))
            some = chosen[0] if len(chosen) == 1 else "{" + ", ".join(chosen) + "}"
            if self.chance(50):
                texts.append(f"requirement {some} needs {condition}")
            else:
                texts.append(f"requirement {condition} disables {some}")
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

    def rarely(self, kind: str) -> str:
        """A state requirement that leaves something: about a combination, not one condition."""
        parts = [self.boolean(_Scope(), 1) for _ in range(2)]
        if self.chance(60):
            parts = [self.place(_Scope()) or part for part in parts]
        if kind == "never":
            return f"({parts[0]} and {parts[1]})"
        return f"!({parts[0]} and {parts[1]})"

    def provides(self) -> list[str]:
        texts = []
        for communication in self.requestable():
            type_ = communication.request
            if type_.kind == "none" or not self.chance(60):
                continue
            for _ in range(self.number(1, 2)):
                condition = f" if {self.boolean(_Scope(), 1)}" if self.chance(40) else ""
                texts.append(f"provide {communication.name} with {self.data(type_)}{condition}")
        return texts

    def data(self, type_: _Type) -> str:
        if type_.kind == "object":
            fields = [
                f"{name}: {self.data(t)}"
                for name, t in type_.properties
                if t.kind != "array" and self.chance(70)
            ]
            return "{ " + ", ".join(fields) + " }" if fields else "{}"
        if type_.kind == "string":
            return '"text"'
        if type_.kind == "double":
            return f"{self.integer(_Scope(data=True))} / 2"
        if type_.values is None:
            return self.integer(_Scope(data=True))
        return self.pick(type_.values)


def _enough_marked(rng: random.Random, states: list[str], edges: dict[str, set[str]]) -> set[str]:
    """Some states, such that each state reaches one of them in its own automaton."""
    marked = {state for state in states[1:] if rng.randrange(100) < 35}
    if rng.randrange(100) < 75:
        marked.add(states[0])
    for state in states:
        reached, todo = {state}, [state]
        while todo:
            for target in edges[todo.pop()] - reached:
                reached.add(target)
                todo.append(target)
        if not reached & marked:
            marked.add(state)
    return marked


def _indented(text: str) -> str:
    return "".join(f"    {line}\n" for line in text.rstrip("\n").split("\n"))
