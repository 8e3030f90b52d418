"""Random behaviour of components, as model text."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

from random_expressions import RandomCommunication, RandomComponent, RandomExpressions, Scope


@dataclass(frozen=True)
class Place:
    """Where a transition stands: a state, or none for the automaton level.

    ``targets`` collects where the transitions of the state lead. Those of the automaton level do
    not count, since a state may hide them.
    """

    state: str | None = None
    targets: set[str] = field(default_factory=set)


class RandomBehaviours(RandomExpressions):
    """Draws the states and transitions of components."""

    stays = False

    # --- behaviour ---------------------------------------------------------------------------

    def component_text(self, component: RandomComponent) -> str:
        lines = [self.communication_text(c) for c in component.communications]
        if component.states:
            lines.append(self.behaviour_text(component))
        if self.chance(10):
            lines.reverse()
        return f"component {component.name} {{\n" + "".join(map(indented, lines)) + "}"

    def communication_text(self, communication: RandomCommunication) -> str:
        name, kind = communication.name, communication.kind
        identifier = f'identifier: "/{name}", ' if self.chance(30) else ""
        if kind in ("incoming", "outgoing"):
            type_ = communication.request if kind == "incoming" else communication.response
            links = " links link" if type_.kind == "object" else ""
            return f"{kind} message {name} with {identifier}type: {type_.text}{links}"
        text = f"{kind} {name} with {identifier}request: {communication.request.text}"
        text += f", response: {communication.response.text}"
        if kind.endswith("action"):
            text += f", feedback: {communication.feedback.text}"
        return text + " links link"

    def behaviour_text(self, component: RandomComponent) -> str:
        edges: dict[str, set[str]] = {state: set() for state in component.states}
        bodies = {
            state: self.state_transitions(component, Place(state, edges[state])) for state in edges
        }
        general = self.automaton_transitions(component)
        self.answer(component, [*bodies.values(), general])
        component.marked = _enough_marked(self.rng, component.states, edges)
        lines = []
        for variable in component.variables:
            initial = f" = {variable.initial}" if variable.initial is not None else ""
            stays = self.stays and variable.type.values and self.chance(60)
            word = "persistent variable" if stays else "variable"
            lines.append(f"{word} {variable.name}: {variable.type.text}{initial}")
        for state, body in bodies.items():
            words = ["initial"] if state == component.states[0] else []
            words += ["marked"] if state in component.marked else []
            head = " ".join([*words, "state", state])
            lines.append(f"{head} {{\n" + "".join(map(indented, body)) + "}")
        position = self.number(0, len(lines)) if self.chance(30) else len(lines)
        lines[position:position] = general
        return "behaviour {\n" + "".join(map(indented, lines)) + "}"

    def answer(self, component: RandomComponent, bodies: list[list[str]]) -> None:
        """Let the component answer the goals of its own actions, somewhere at least."""
        for communication in component.communications:
            answers = [f"on {e} {d} {communication.name}" for e in ("response", "error")
                       for d in ("from", "to")]  # fmt: skip
            texts = (text for body in bodies for text in body)
            if communication.kind == "outgoing action" and not any(
                answer in text for text in texts for answer in answers
            ):
                bodies[0].append(f"on response to {communication.name}")

    def state_transitions(self, component: RandomComponent, place: Place) -> list[str]:
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
        self,
        component: RandomComponent,
        communication: RandomCommunication,
        event: str,
        place: Place,
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

    def automaton_transitions(self, component: RandomComponent) -> list[str]:
        body = []
        for communication, event, own in self.events(component):
            if self.chance(10 if own else 4):
                body += self.reactions(component, communication, event, Place())
        if self.chance(5):
            body.append(self.tau(component, Place()))
        return body

    def events(self, component: RandomComponent) -> list[tuple[RandomCommunication, str, bool]]:
        return [
            (communication, event, owner is component)
            for owner in self.components
            for communication in owner.communications
            for event in communication.events
        ]

    def reactions(
        self,
        component: RandomComponent,
        communication: RandomCommunication,
        event: str,
        place: Place,
    ) -> list[str]:
        """The transitions of one state for one event: one, or several whose guards exclude."""
        scope = Scope(component.name, communication.value(event))
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

    def effects(self, component: RandomComponent, scope: Scope, place: Place) -> str:
        text = ""
        assigned = []
        for variable in component.variables:
            if self.chance(45):
                assigned.append(f"{variable.name} := {self.assigned(variable, scope)}")
        if assigned:
            text += " do " + ", ".join(assigned)
        return text + self.goto(component, place, 70)

    def goto(self, component: RandomComponent, place: Place, percent: int) -> str:
        if not self.chance(percent):
            return ""
        states = component.states
        target = self.pick(states)
        if place.state is not None and self.chance(50):
            target = states[(states.index(place.state) + 1) % len(states)]
        place.targets.add(target)
        return f" goto {target}"

    def tau(self, component: RandomComponent, place: Place) -> str:
        guard = f" if {self.boolean(Scope(component.name))}" if self.chance(60) else ""
        goto = self.goto(component, place, 90)
        # By a generator of their own: the rest of the model does not depend on them.
        drawn, self.rng = self.rng, random.Random(f"{component.name} {place.state} {guard}{goto}")
        scope = Scope(component.name)
        finite = [v for v in component.variables if v.type.values and self.chance(30)]
        assigned = [f"{v.name} := {self.assigned(v, scope)}" for v in finite]
        self.rng = drawn
        return f"transition{guard}{' do ' + ', '.join(assigned) if assigned else ''}{goto}"

    # --- requirements and data ---------------------------------------------------------------

    def requestable(self) -> list[RandomCommunication]:
        return [
            communication
            for component in self.components
            for communication in component.communications
            if communication.kind != "outgoing"
        ]


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


def indented(text: str) -> str:
    return "".join(f"    {line}\n" for line in text.rstrip("\n").split("\n"))
