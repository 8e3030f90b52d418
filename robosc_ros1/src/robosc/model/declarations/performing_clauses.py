"""Resolution of what states perform: the command, what follows, and what happens after errors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from robosc.errors import Note
from robosc.expr import quantified, tree
from robosc.language.events import EventKind
from robosc.model.automata import Transition
from robosc.model.checks.behaviour_rules import NamedTransition
from robosc.model.declarations.performing import Performing, Retries, count_of
from robosc.model.declarations.statements import StatementResolver
from robosc.model.declarations.transitions import TransitionResolver
from robosc.model.diagnostics import Report
from robosc.model.entities import Provide
from robosc.model.names.groups import GroupResolver
from robosc.model.names.tables import PERFORMING, CommunicationInfo, Instance, SymbolTable
from robosc.runtime.core.places import DUE
from robosc.syntax import nodes


def find_performed(instance: Instance, symbols: SymbolTable, report: Report) -> None:
    """Resolve the commands that the states of a component perform."""
    groups = GroupResolver(symbols, instance.types.scope, report)
    for path, state in instance.states.items():
        if state.performs is None:
            continue
        access = state.performs.communication
        command = groups.command(access, "performs-outgoing", "no state can perform it", given=True)
        if command is not None:
            instance.performed[path] = command
        for inner in state.states[:1]:
            report.add(
                "states-in-performing",
                inner.name.span,
                f"state '{path}' performs '{access.span.text}', so that no states stand in it",
                "let a state in another one perform it: put this state, and what it performs, into"
                " a state around both",
            )


def performed_data(instance: Instance, resolver: StatementResolver) -> Iterator[Provide]:
    """The data behind ``performs``: those of the command where the state may send it."""
    for path, command in instance.performed.items():
        node = instance.states[path].performs
        assert node is not None
        if node.data is None:
            continue
        statement = nodes.ProvideNode(node.communication, node.data, None, span=node.data.span)
        for provide in resolver.provides(statement):
            stages = (DUE, PERFORMING) if command.replaces else (DUE,)
            sends = [tree.StateRef(instance.name, f"{path} {stage}", node.span) for stage in stages]
            condition = quantified.chain("or", sends, node.span)
            yield replace(provide, communication=command.key, condition=condition)


class PerformingResolver:
    """Resolves the clauses of states that perform, of one component."""

    def __init__(self, instance: Instance, transitions: TransitionResolver, report: Report) -> None:
        self._instance = instance
        self._transitions = transitions
        self._report = report
        self.counts: list[Retries] = []

    def resolve(
        self,
        state: nodes.StateNode,
        path: str,
        own: Sequence[Transition],
        retries: Sequence[nodes.RetryNode],
    ) -> Performing | None:
        """What a state performs; None after an error in its command.

        ``own`` are the transitions in its braces for events of the command.
        """
        node, command = state.performs, self._instance.performed.get(path)
        if node is None or command is None:
            return None
        ends = EventKind.RESPONSE if command.is_awaited else command.command
        done = self._outcome(ends, command, path, node)
        performing = Performing(path, node, command, done, own=list(own))
        spans = self._transitions.event_spans
        for kind in command.events:
            spans.setdefault((node.span.start, kind), node.communication.span)
        for other in retries[1:]:
            note = Note("the first one is here", retries[0].span)
            self._misplaced(other, f"state '{path}' has a 'retry' already", "join them", [note])
        if retries:
            self._retry(performing, retries[0])
        return performing

    def check_retries(self, retries: Iterable[nodes.RetryNode]) -> None:
        """Report each ``retry`` in a state that performs nothing."""
        for node in retries:
            self._misplaced(
                node,
                "'retry' stands in a state that performs a service or an action",
                "write 'performs' and the name of the command behind the name of the state",
            )

    def check_requests(self, named: Iterable[NamedTransition], path: str) -> None:
        """Report what is said about a request, outside of the states that perform it."""
        for new in named:
            transition = new.transition
            if transition.event is not EventKind.REQUEST:
                continue
            key = transition.communication
            places = [p for p, command in self._instance.performed.items() if command.key == key]
            if not places or (path in places and transition.goto is None):
                continue
            name = new.communication.span.text
            if path in places:
                message = f"'goto' stands behind 'then': the state is left when {name} is done"
                hint = "leave out 'goto' here: the state is the same while its command is under way"
            else:
                message = f"{name} is performed in state '{places[0]}': only that state requests it"
                hint = f"let this state perform it: performs {name} then …"
            self._report.add("performed-elsewhere", new.event.span, message, hint)

    def _outcome(
        self,
        event: EventKind,
        command: CommunicationInfo,
        path: str,
        node: nodes.PerformsNode | nodes.RetryNode,
    ) -> Transition:
        """What ``then`` or ``else`` of a node says; without ``goto`` the state begins anew."""
        clauses = node.finally_ if isinstance(node, nodes.RetryNode) else node
        assert clauses is not None
        effect = self._transitions.effect(event, command, clauses)
        transition = replace(effect, span=node.span)
        if transition.goto:
            return transition
        return replace(transition, goto=f"{path} {DUE}", named=path)

    def _retry(self, performing: Performing, node: nodes.RetryNode) -> None:
        command = performing.command
        if not command.is_awaited:
            what = "an answer" if command.sort.served else "a message"
            self._misplaced(
                node,
                f"{command.name} is {what}, which is done when it is sent: it has no errors",
                "leave out 'retry'",
            )
            return
        if (node.times is None) != (node.finally_ is None):
            missing = "'else', and what follows then" if node.finally_ is None else "'times'"
            text = f"'{'times' if node.times else 'else'}' of 'retry' needs {missing}"
            self._misplaced(node, text, "write: retry 2 times else goto failed")
            return
        self._transitions.event_spans[node.span.start, EventKind.ERROR] = node.span
        again = self._transitions.goes(EventKind.ERROR, command.key, node)
        via = again.named or again.goto
        if again.goto is None:
            again = replace(again, goto=f"{performing.path} {DUE}")
        performing.retries = count_of(performing.path, node, self._instance, via)
        if performing.retries is not None:
            self.counts.append(performing.retries)
        performing.again = again
        if node.every is not None:
            performing.wait = self._wait(node, again)
        if node.finally_ is not None:
            performing.given_up = self._outcome(EventKind.ERROR, command, performing.path, node)

    def _wait(self, node: nodes.RetryNode, again: Transition) -> Transition | None:
        assert node.every is not None
        taken = replace(again, event=EventKind.AFTER, communication=self._instance.name)
        return self._transitions.waits(node.every, "'every'", taken)

    def _misplaced(
        self, node: nodes.RetryNode, message: str, hint: str, notes: Sequence[Note] = ()
    ) -> None:
        self._report.add("misplaced-retry", node.span, message, hint, notes)


def own_transitions(
    named: Iterable[Transition], command: CommunicationInfo
) -> tuple[list[Transition], tuple[Transition, ...]]:
    """The transitions of a place for events of a command, and the others.

    Of an answer, only its being sent is one: the robot may cancel its call meanwhile.
    """
    own: list[Transition] = []
    others: list[Transition] = []
    for transition in named:
        is_own = transition.communication == command.whole_key and (
            not command.sort.served or transition.event is command.command
        )
        (own if is_own else others).append(transition)
    return own, tuple(others)
