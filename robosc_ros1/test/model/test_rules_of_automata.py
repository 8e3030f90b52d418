"""Rules about one automaton: states, taus, transitions for one event."""

from __future__ import annotations

from model_text import behaviour_of, faults, resolve


def component(behaviour: str) -> str:
    return f"""
    component P {{
        incoming message go with type: none
        outgoing message seen with type: none
        outgoing message level with type: boolean
        behaviour {{ {behaviour} }}
    }}
    """


def test_taus_are_counted_in_source_order_over_states_and_automaton() -> None:
    robot = resolve(
        component(
            """
            transition if b
            initial marked state a { transition goto b on request to go transition goto a }
            transition if a
            marked state b { transition goto a }
            """
        )
    )
    behaviour = behaviour_of(robot, "P")
    assert [t.index for t in behaviour.taus] == [1, 4]
    assert [[t.index for t in s.taus] for s in behaviour.states] == [[2, 3], [5]]


def test_a_state_is_cut_off_if_the_way_back_is_hidden() -> None:
    text = component(
        """
        on response from seen goto a
        initial marked state a { on request to go goto b }
        state b { on response from seen goto c }
        state c { on response from seen }
        """
    )
    found = faults(text)
    assert [f for f in found if f[0] == "no-marked-reachable"] == [("no-marked-reachable", "b")]
    assert ("hidden-transition", "response") in found


def test_an_unreachable_state_need_not_reach_a_marked_one() -> None:
    text = component("initial marked state a {} state b {}")
    assert faults(text) == [("unreachable-state", "b")]


def test_reachability_is_not_judged_where_a_goto_is_wrong() -> None:
    text = component("initial state a { transition goto bb } marked state b {}")
    assert faults(text) == [("unknown-state", "bb")]


def test_two_guarded_transitions_for_one_event_are_left_to_the_plant() -> None:
    events = "on response from level if value on response from level if !value"
    resolve(component(f"initial marked state a {{ {events} }}"))


def test_guarded_requests_and_errors_are_allowed() -> None:
    resolve(component("initial marked state a { on request to go if a }"))


def test_one_unguarded_among_several_is_an_error() -> None:
    text = component("initial marked state a { on response from seen if a on response from seen }")
    assert faults(text) == [("duplicate-transition", "response")]


def test_two_kinds_of_event_of_one_communication_are_two_events() -> None:
    resolve(
        """
        component P {
            service s with request: none, response: none links l
            behaviour {
                initial marked state a { on request to s on response from s on error from s }
            }
        }
        interface l use L from p
        """
    )


def test_requirement_text_is_one_line_without_comments() -> None:
    robot = resolve(
        component("initial marked state a {}")
        + """
        requirement go   // not too
            needs /* very */ P.a
        """
    )
    assert robot.requirements[0].text == "requirement go needs P.a"


def test_errors_are_not_repeated_by_their_consequences() -> None:
    text = """
    component P {
        outgoing message m with type: Missing
        incoming message n with type: Missing
        behaviour {
            variable v: Missing = first
            initial marked state a { on response from m if value.x do v := value }
        }
    }
    requirement n needs P.v = second and P.v > 3
    provide n with { x: 3 }
    """
    assert faults(text) == [("unknown-type", "Missing")] * 3


def test_names_in_a_declaration_that_does_not_parse_are_not_unknown() -> None:
    text = """
    component P { outgoing message seen with type }
    component Q { behaviour { initial marked state a { on response from seen if P.on goto b } } }
    """
    assert [code for code, _ in faults(text)] == ["syntax", "unknown-state"]
