"""Bounded response, confluence and nonblocking of the controller that runs a supervisor."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import pytest
import steep_families
from random_models import random_model
from synthesis.plants import plant_of, supervisor_of
from synthesis.subject import robot_of

from robosc import limits, pipeline
from robosc.errors import Diagnostic, StateSpaceError
from robosc.plant.build import lower
from robosc.supervisor import Supervisor
from robosc.synthesis import compiled_steps, compute, synthesize
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.run_to_completion import SymbolicController
from robosc.synthesis.bdd.search import SymbolicSystem
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine
from robosc.synthesis.controlled_system import Runs
from robosc.synthesis.explain import properties as explain_properties

CONTROL = ("livelock", "order-matters", "blocking-under-control")


def behaviour(states: str, other: str = "") -> str:
    return "component A { outgoing message m with type: none behaviour { " + states + " } }" + other


def properties(found: Supervisor) -> dict[str, bool]:
    return dict(found.properties)


def diagnostic(found: Supervisor) -> Diagnostic:
    (one,) = [d for d in found.diagnostics if d.code in CONTROL]
    return one


def test_without_own_steps_all_hold() -> None:
    found = supervisor_of(behaviour("initial marked state s { on response from m goto s }"))
    assert properties(found) == {
        "bounded response": True,
        "confluence": True,
        "nonblocking under control": True,
    }
    assert found.step_bound == 0


def test_bound_is_the_longest_settling() -> None:
    found = supervisor_of(
        behaviour(
            "initial marked state s { on response from m goto a }"
            " state a { transition goto b } state b { transition goto c }"
            " state c { transition goto s }"
        )
    )
    assert all(properties(found).values())
    assert found.step_bound == 3


def test_step_that_changes_nothing_is_none() -> None:
    """A transition for every state leads to one of them from that state itself, too."""
    found = supervisor_of(
        behaviour(
            "initial marked state s { on response from m goto a } state a { } transition goto s"
        )
    )
    assert all(properties(found).values())
    assert found.step_bound == 1


def test_steps_without_end() -> None:
    found = supervisor_of(
        behaviour(
            "initial marked state s { on response from m goto a }"
            " state a { transition goto b } marked state b { transition goto a }"
        )
    )
    assert properties(found)["bounded response"] is False
    assert found.step_bound is None
    assert diagnostic(found).message == (
        "the internal transitions never end: after m.response they repeat A: a->b, A: b->a"
    )


def test_guard_that_ends_the_round() -> None:
    found = supervisor_of(
        behaviour(
            "variable x: boolean initial marked state a { transition if x goto b"
            " on response from n do x := value }"
            " marked state b { transition if !x goto a on response from n do x := value }",
            " component B { outgoing message n with type: boolean }",
        )
    )
    assert all(properties(found).values())
    assert found.step_bound == 1


def test_order_matters() -> None:
    found = supervisor_of(
        behaviour(
            "initial marked state s { on response from m goto a }"
            " state a { transition goto left transition goto right }"
            " marked state left { on response from m goto s }"
            " marked state right { on response from m goto s }"
        )
    )
    assert properties(found)["confluence"] is False
    assert properties(found)["bounded response"] is True
    one = diagnostic(found)
    assert one.code == "order-matters"
    assert "after m.response, in A.left or in A.right" in one.message


def test_order_of_independent_steps_does_not_matter() -> None:
    found = supervisor_of(
        behaviour(
            "initial marked state s { on response from m goto a } state a { transition goto s }",
            " component B { behaviour { initial marked state s { on response from m goto a }"
            " state a { transition goto b } state b { transition goto s } } }",
        )
    )
    assert all(properties(found).values())
    assert found.step_bound == 3


def test_order_matters_only_where_the_controller_comes() -> None:
    """Both steps are possible in a state that eager settling never rests in nor passes."""
    found = supervisor_of(
        behaviour(
            "initial marked state s { transition goto rest on response from m goto fork }"
            " marked state rest {}"
            " state fork { transition goto rest transition goto s }"
        )
    )
    assert properties(found)["confluence"] is True


def forking(topic: str) -> str:
    """After m, completion would end here or there; n leads away, if it comes before."""
    return f"""
    component A {{
        outgoing message m with identifier: "/both", type: none
        outgoing message n with identifier: "{topic}", type: none
        behaviour {{
            initial marked state s {{ on response from m goto fork }}
            state fork {{
                transition goto one
                transition goto two
                on response from n goto s
            }}
            marked state one {{}}
            marked state two {{}}
        }}
    }}
    """


TOPICS = pytest.mark.parametrize(("topic", "holds"), [("/both", True), ("/other", False)])


@TOPICS
def test_all_communications_of_a_message_happen_before_the_controller_rests(
    topic: str, holds: bool
) -> None:
    assert properties(supervisor_of(forking(topic)))["confluence"] is holds


def test_a_trace_tells_all_communications_of_a_message() -> None:
    found = supervisor_of(
        """
        component A {
            outgoing message m with identifier: "/both", type: none
            outgoing message n with identifier: "/both", type: none
            behaviour {
                initial marked state s { on response from m goto near }
                state near { on response from n goto fork }
                state fork { transition goto one transition goto two }
                marked state one {}
                marked state two {}
            }
        }
        """
    )
    assert "after m.response, n.response, in A.one or in A.two" in diagnostic(found).message


def test_marked_state_that_is_only_passed() -> None:
    found = supervisor_of(
        behaviour(
            "initial marked state s { transition goto a } state a { on response from m goto s }"
        )
    )
    assert properties(found) == {
        "bounded response": True,
        "confluence": True,
        "nonblocking under control": False,
    }
    one = diagnostic(found)
    assert one.code == "blocking-under-control"
    assert one.message.startswith("after A: s->a the controller never again comes to rest")


def test_supervisor_ends_the_steps() -> None:
    """Of two internal transitions round, synthesis forbids one."""
    found = supervisor_of(
        behaviour(
            "initial marked state a { transition goto b } marked state b { transition goto c }"
            " marked state c { transition goto a }",
            " requirement never A.c",
        )
    )
    assert all(properties(found).values())
    assert found.step_bound == 1


def test_an_order_without_end_is_no_other_end() -> None:
    """From ``first`` and ``second`` settling ends in one state each, or goes round for ever."""
    found = supervisor_of(
        behaviour(
            "initial marked state s { on response from m goto first }"
            " state first { transition goto t transition goto round }"
            " marked state t { on response from m goto second }"
            " state second { transition goto u transition goto round }"
            " marked state u {}"
            " marked state round { transition goto about }"
            " state about { transition goto round }"
        )
    )
    assert properties(found)["confluence"]
    assert [d for d in found.diagnostics if d.code in CONTROL] == []


def going_round(commands: str) -> str:
    """After a command A goes round for ever."""
    return behaviour(
        "initial marked state a { on request to leave goto b on request to stay goto b }"
        " marked state b { transition goto c } state c { transition goto b }",
        "component B { incoming message leave with type: none"
        f" incoming message stay with type: none }} {commands} ",
    )


def test_trace_has_the_preferred_command() -> None:
    """Both commands lead to the same state, but only the preferred one is sent."""
    found = supervisor_of(going_round("prefer stay over leave"))
    assert diagnostic(found).message == (
        "the internal transitions never end: after stay.request they repeat A: b->c, A: c->b"
    )
    assert "after leave.request they" in diagnostic(supervisor_of(going_round(""))).message


def test_trace_through_one_of_very_many_values(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only one value leads on: it is not found by changing one part after the other."""
    monkeypatch.setattr(compiled_steps, "_MOST_KEPT", 10)
    found = supervisor_of(
        """
        datatype object Place { x: integer(0..9) y: integer(0..9) }
        component A {
            outgoing message at with type: Place links link
            behaviour {
                variable x: integer(0..9)
                variable y: integer(0..9)
                initial marked state a {
                    on response from at if value.x = 5 and value.y = 5
                        do x := value.x, y := value.y goto b
                }
                marked state b { transition goto c }
                state c { transition goto b }
            }
        }
        requirement never A.x = 7
        requirement never A.y = 7
        """
    )
    assert diagnostic(found).message == (
        "the internal transitions never end: after at.response(x: 5, y: 5) they repeat"
        " A: b->c, A: c->b"
    )


# --- systems with too many states to walk through

EACH_SENSOR = [
    f"component S{i} {{ outgoing message up{i} with type: none outgoing message down{i} with"
    f" type: none behaviour {{ initial marked state low {{ on response from up{i} goto high }}"
    f" marked state high {{ on response from down{i} goto low }} }} }} "
    for i in range(17)
]
SENSORS = "".join(EACH_SENSOR)

CIRCLE = (
    "component A { behaviour { initial marked state a { transition if S0.high goto b }"
    " marked state b { transition if S0.low goto a } } }"
)
"""Its internal transitions end, but only their guards tell so."""
GUARDED_CIRCLE = SENSORS + CIRCLE


@pytest.fixture
def symbolic() -> None:
    pytest.importorskip("oxidd")


@pytest.fixture
def in_one_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    """Robots of independent parts are solved as a whole."""
    monkeypatch.setattr(compute, "independent_parts", lambda plant, size: [plant])


@pytest.mark.usefixtures("in_one_piece")
def test_a_large_system_without_end_is_told() -> None:
    found = supervisor_of(steep_families.restless(18), "explicit")
    assert [d.code for d in found.diagnostics] == ["livelock", "properties-unchecked"]
    assert diagnostic(found).message.endswith(" Clock5: tock->tick, … (36 in all)")
    assert properties(found) == {"bounded response": False}
    assert found.step_bound is None


@pytest.mark.usefixtures("in_one_piece")
def test_a_large_system_whose_automata_end_by_themselves() -> None:
    states = "initial marked state a { transition goto b } state b { transition goto c }"
    states += " marked state c {}"
    found = supervisor_of(SENSORS + f"component A {{ behaviour {{ {states} }} }}", "explicit")
    assert properties(found) == {"bounded response": True}
    assert found.step_bound == 2
    assert "properties-unchecked" in {d.code for d in found.diagnostics}


@pytest.mark.usefixtures("in_one_piece", "symbolic")
class TestLargeSystemsSetBySet:
    def test_no_end(self) -> None:
        found = supervisor_of(steep_families.restless(40), "bdd")
        assert [d.code for d in found.diagnostics] == ["livelock"]
        assert properties(found) == {
            "bounded response": False,
            "confluence": True,
            "nonblocking under control": False,
        }
        assert found.step_bound is None

    def test_guards_end_it(self) -> None:
        found = supervisor_of(GUARDED_CIRCLE, "bdd")
        assert all(properties(found).values())
        assert found.step_bound == 1

    def test_an_end_that_depends_on_the_order(self) -> None:
        choice = "initial marked state a { on response from m goto b }"
        choice += " state b { transition goto a transition goto c } marked state c {}"
        found = supervisor_of(SENSORS + behaviour(choice), "bdd")
        assert not properties(found)["confluence"]
        assert diagnostic(found).message == (
            "where the internal transitions end depends on their order:"
            " after m.response, in A.a or in A.c; the controller takes them in source order"
        )

    def test_no_rest_in_a_marked_state(self) -> None:
        passing = "initial marked state a { on response from m goto b }"
        passing += " state b { transition goto c } state c { on request to go goto d }"
        passing += " marked state d { transition goto c }"
        go = "component B { incoming message go with type: none }"
        found = supervisor_of(SENSORS + behaviour(passing, go), "bdd")
        assert not properties(found)["nonblocking under control"]
        assert diagnostic(found).message == (
            "after m.response, A: b->c the controller never again comes to rest in a marked state,"
            " because it takes the internal transitions as soon as it can"
        )

    def test_only_in_source_order_it_ends(self) -> None:
        """In another order A goes round for ever."""
        first = behaviour(
            "initial marked state a { on response from m goto b }"
            " state b { transition goto a transition goto c } state c { transition goto b }"
        )
        found = supervisor_of(SENSORS + first, "bdd")
        assert properties(found)["bounded response"]
        assert found.step_bound is not None and found.step_bound >= 1

    @TOPICS
    def test_all_communications_of_a_message_are_one_input(self, topic: str, holds: bool) -> None:
        found = supervisor_of(SENSORS + forking(topic), "bdd")
        assert properties(found)["confluence"] is holds

    def test_preferred_commands_are_sent_first(self) -> None:
        """As long as ``stay`` is enabled, ``leave`` is not sent, and b is not marked."""
        text = behaviour(
            "initial marked state a { on response from m goto b }"
            " state b { on request to stay goto b on request to leave goto a }"
        )
        text += "component B { incoming message stay with type: none"
        text += " incoming message leave with type: none } prefer stay over leave "
        assert not properties(supervisor_of(SENSORS + text, "bdd"))["nonblocking under control"]


@pytest.mark.slow
@pytest.mark.usefixtures("symbolic")
def test_random_controllers_set_by_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same as state by state; of large systems the bound on steps may be larger."""
    plants = [lower(robot_of(random_model(random.Random(s), 1 + s % 3))) for s in range(25)]
    with monkeypatch.context() as stepping:
        stepping.setattr(SymbolicSystem, "runs", lambda self, exactly: None)
        stepwise = [synthesize(plant, "bdd") for plant in plants]
    few = [synthesize(plant, "bdd") for plant in plants]
    monkeypatch.setattr(explain_properties, "_FEW_STATES", 0)
    for number, (plant, expected, same) in enumerate(zip(plants, stepwise, few, strict=True)):
        assert replace(same, seconds=expected.seconds) == expected, number
        found = synthesize(plant, "bdd")
        assert found.properties == expected.properties, number
        codes = [[d.code for d in one.diagnostics] for one in (found, expected)]
        assert codes[0] == codes[1], number
        bounds = found.step_bound, expected.step_bound
        assert None in bounds or bounds[0] >= bounds[1], number  # type: ignore[operator]
        assert (bounds[0] is None) == (bounds[1] is None), number


@pytest.mark.slow
@pytest.mark.usefixtures("symbolic")
@pytest.mark.parametrize(
    "text",
    [steep_families.battery_swaps(1), steep_families.two_tools_each(3)],
    ids=["swaps", "tools"],
)
def test_fleets_set_by_set(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same as state by state."""
    plant = lower(robot_of(text))
    with monkeypatch.context() as stepping:
        stepping.setattr(SymbolicSystem, "runs", lambda self, exactly: None)
        expected = synthesize(plant, "bdd")
    assert replace(synthesize(plant, "bdd"), seconds=expected.seconds) == expected
    monkeypatch.setattr(explain_properties, "_FEW_STATES", 0)
    found = synthesize(plant, "bdd")
    assert found.properties == expected.properties
    assert found.diagnostics == expected.diagnostics


def _runs(text: str) -> Runs:
    return SymbolicController(SymbolicEngine(plant_of(text)).solve()).runs()


@pytest.mark.usefixtures("symbolic")
@pytest.mark.parametrize("family", ["battery_swaps", "two_tools_each"])
def test_fleets_take_as_many_rounds_as_one_robot(
    family: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where internal transitions of robots do not touch each other, other robots go on meanwhile;
    and what the controller comes to is not looked for where nothing fails."""
    rounds = 0

    def counted(self: SymbolicController, states: Bdd) -> Bdd:
        nonlocal rounds
        rounds += 1
        return leading(self, states)

    leading = SymbolicController._leading
    monkeypatch.setattr(SymbolicController, "_leading", counted)
    monkeypatch.delattr(SymbolicController, "_starts")
    needed = []
    for n in (3, 6):
        _runs(getattr(steep_families, family)(n))
        needed.append(rounds)
    assert needed[1] == 2 * needed[0]


YIELDING = """robot R {
  component A {
    outgoing message m with type: none
    incoming message away with type: none
    behaviour {
      initial marked state here { on response from m goto there }
      state there { on request to away goto here }
    }
  }
  component B {
    outgoing message m2 with type: none
    incoming message first with type: none
    behaviour {
      initial marked state p { on request to first goto q }
      marked state q { on response from m2 goto r }
      marked state r { transition goto p }
    }
  }
  prefer first over away
}
"""


@pytest.mark.usefixtures("symbolic")
def test_a_command_that_yields_is_sent_at_rest() -> None:
    """Nothing but it marks its component again, while another one has an internal transition."""
    assert _runs(YIELDING).stuck is None
    always = YIELDING.replace("on request to first goto q", "on request to first goto p")
    assert _runs(always).stuck is not None


@pytest.mark.usefixtures("in_one_piece")
def test_no_controller_without_a_bound_on_its_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compute, "usable", lambda: False)
    monkeypatch.setattr(limits, "SEARCHED_STATES", 200)
    model = tmp_path / "circle.rscd"
    few = "".join(EACH_SENSOR[:8])
    model.write_text(f"robot Circle {{ {few} {CIRCLE} }}", encoding="utf-8")
    with pytest.raises(StateSpaceError, match="whether internal transitions end"):
        pipeline.generate(model, output=pipeline.Output(folder=tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == ["circle.rscd"]
    (warning,) = [d for d in pipeline.check(model).diagnostics if d.code == "properties-unchecked"]
    assert "bounded response, confluence and nonblocking under control" in warning.message
