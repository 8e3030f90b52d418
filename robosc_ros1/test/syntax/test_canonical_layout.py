"""``format`` gives every model one layout and changes nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from large_model import large_model
from random_text import model_text
from syntax_support import parsed

from robosc.errors import ModelError
from robosc.language.tokens import tokenize
from robosc.source import Source
from robosc.syntax.formatting.format import WIDTH, format_text

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*/*.rscd"))


def formatted(text: str) -> str:
    return format_text(Source("model.rscd", text))


def written_comments(text: str) -> list[list[str]]:
    """All comments in order, line by line, without the blanks around them."""
    found = tokenize(Source("model.rscd", text)).comments
    return [[line.strip() for line in comment.text.split("\n")] for comment in found]


def check(text: str) -> None:
    once = formatted(text)
    assert parsed(once) == parsed(text)
    assert written_comments(once) == written_comments(text)
    assert formatted(once) == once
    assert once.endswith("}\n") or written_comments(text)
    assert "\n\n\n" not in "\n".join(line.strip() for line in once.split("\n"))
    assert "\t" not in once or any("\t" in c.text for c in tokenize(Source("m", text)).comments)


def test_states_that_perform() -> None:
    text = """robot R {
    component A {
        behaviour {
            initial state a performs b meanwhile then goto c
            state c performs a_rather_long_name with { x: a_long_name, y: 1.0 }
                then do one_more := value goto another_state {
                retry 2 times every 5 s else do one_more := false goto a
            }
        }
    }
}
"""
    assert formatted(text) == text
    assert formatted(" ".join(text.split())) == text


@pytest.mark.slow
@settings(max_examples=90)
@given(model_text())
def test_random_models_keep_their_meaning_and_comments(text: str) -> None:
    check(text)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_keep_their_meaning_and_comments(path: Path) -> None:
    check(path.read_text())


@pytest.mark.slow
def test_every_comment_position_is_kept() -> None:
    words = parsed_words(UGLY)
    for index in range(len(words) + 1):
        kinds = ("/* c */", "// c\n", "\n// c\n", "\n/* a\n  b */\n")
        for comment in kinds[index % 2 :: 2]:
            check(" ".join([*words[:index], comment, *words[index:]]))


def parsed_words(text: str) -> list[str]:
    return list(tokenize(Source("model.rscd", text)).texts())


UGLY = """\
robot  R {
 component A { } component B { incoming message m with identifier : "/m" , type : T links l
 behaviour { variable v : integer ( 0 .. 3 ) = 1 initial state s {
   on response from n if ( a = 1 or b ) and c do v := value , w := - 2 goto t transition goto s }
   } }
 datatype enum E from double to { value . x [ 0 ] >= 3 -> big default -> small }
 datatype object O { x : array ( double ) }
 provide m with { x : { y : 1 , z : ! a } } if b
 requirement { m , n } needs d
 requirement  d   disables { m } to
  start requirement n needs d to /* only */ start
 component C from L import D with prefix : "/c"
 interface i use T from p }
"""

UGLY_SECOND_EDITION = """\
robot  R {
 constant  a:array ( double )=[ 1.0 ,b ] parameter p:duration = 2  min
 condition c=any ( s . on for  s  in S [ 1 .. 3 ] if s.x  in {a ,b} )
 component S [ 1 .. 6 ] { outgoing message m with identifier : "/m" , timeout : 0.5 s , type : p / T
 action n with type : p / action / T
 behaviour { initial state s { after 2 s if Way ( value . x )=b do y := f ( ) goto t
   on timeout from m } } }
 component L [ 1..2 ] from W import V with prefix : "/l" , radius : 0.2
 for i  in 1 .. 6 { requirement S [ i - 1 ] . go needs a [ f ( i ,j ) ] . b
   prefer { x , S[i].y } over z  requirement all   except {S [i],x }except  S[1] needs q }
 provide m with { x : [ { y : 1 s } , min ( a ,b ) ] , z : [ ] } }
"""


def test_layout_of_the_second_edition() -> None:
    check(UGLY_SECOND_EDITION)
    assert (
        formatted(UGLY_SECOND_EDITION)
        == """\
robot R {
    constant a: array(double) = [1.0, b]
    parameter p: duration = 2 min
    condition c = any(s.on for s in S[1..3] if s.x in {a, b})
    component S[1..6] {
        outgoing message m with identifier: "/m", timeout: 0.5 s, type: p/T
        action n with type: p/action/T
        behaviour {
            initial state s {
                after 2 s if Way(value.x) = b do y := f() goto t
                on timeout from m
            }
        }
    }
    component L[1..2] from W import V with prefix: "/l", radius: 0.2
    for i in 1..6 {
        requirement S[i-1].go needs a[f(i, j)].b
        prefer { x, S[i].y } over z
        requirement all except { S[i], x } except S[1] needs q
    }
    provide m with { x: [{ y: 1 s }, min(a, b)], z: [] }
}
"""
    )


def test_layout_of_every_construct() -> None:
    assert (
        formatted(UGLY)
        == """\
robot R {
    component A {}
    component B {
        incoming message m with identifier: "/m", type: T links l
        behaviour {
            variable v: integer(0..3) = 1
            initial state s {
                on response from n if (a = 1 or b) and c do v := value, w := -2 goto t
                transition goto s
            }
        }
    }
    datatype enum E from double to {
        value.x[0] >= 3 -> big
        default -> small
    }
    datatype object O {
        x: array(double)
    }
    provide m with { x: { y: 1, z: !a } } if b
    requirement { m, n } needs d
    requirement d disables { m } to start
    requirement n needs d to /* only */ start
    component C from L import D with prefix: "/c"
    interface i use T from p
}
"""
    )


def test_long_lines_are_broken_where_they_bind_least() -> None:
    text = """robot R {
    component A {
        action a_rather_long_name with identifier: "/a/rather/long/name", request: OneObject, response: AnotherObject, feedback: none links some_interface
        behaviour { state s {
            on response from a_rather_long_name if first_condition and second_condition or third do first := value.one, second := value.two goto elsewhere
        } }
    }
    requirement stop needs DistanceSensor.current = obstructed or ObstacleGrabber.grabbing and LineDetector.no_line
    requirement DistanceSensor.current = obstructed and ObstacleGrabber.grabbing => LineDetector.no_line disables { go, stop }
    requirement never (DistanceSensor.current = obstructed or DistanceSensor.current = touching) and Motor.running
    provide move with { linear: { x: 0.4, y: 0.0, z: 0.0 }, angular: { z: LineDetector.current_correction / 100 } } if LineDetector.line_found
    provide halt with one_value + another_value * a_third_value if DistanceSensor.current = obstructed or LineDetector.no_line
}
"""
    assert (
        formatted(text)
        == """\
robot R {
    component A {
        action a_rather_long_name with identifier: "/a/rather/long/name",
            request: OneObject,
            response: AnotherObject,
            feedback: none links some_interface
        behaviour {
            state s {
                on response from a_rather_long_name
                    if first_condition and second_condition or third
                    do first := value.one, second := value.two
                    goto elsewhere
            }
        }
    }
    requirement stop
        needs DistanceSensor.current = obstructed
            or ObstacleGrabber.grabbing and LineDetector.no_line
    requirement DistanceSensor.current = obstructed and ObstacleGrabber.grabbing
        => LineDetector.no_line
        disables { go, stop }
    requirement never (DistanceSensor.current = obstructed or DistanceSensor.current = touching)
        and Motor.running
    provide move with {
        linear: { x: 0.4, y: 0.0, z: 0.0 },
        angular: { z: LineDetector.current_correction / 100 }
    } if LineDetector.line_found
    provide halt with one_value + another_value * a_third_value
        if DistanceSensor.current = obstructed or LineDetector.no_line
}
"""
    )


def test_an_object_stays_open_where_it_was_opened() -> None:
    text = "robot R {\n    provide a with {\n        x: 1, y: { z: 2 }\n    }\n}\n"
    assert formatted(text) == (
        "robot R {\n    provide a with {\n        x: 1,\n        y: { z: 2 }\n    }\n}\n"
    )


def test_comments_keep_their_places() -> None:
    text = """// first


/* a licence
   of two lines */
robot R { // the robot


  // about A
  component A { } // A ends
  /* about B */ component B {
     // nothing yet
       }

  requirement a // why
     needs b /* inside */ or c
  requirement a
     // on its own
     needs b
  // last
} // tail
// end
"""
    assert (
        formatted(text)
        == """\
// first

/* a licence
   of two lines */
robot R { // the robot
    // about A
    component A {} // A ends
    /* about B */
    component B {
        // nothing yet
    }

    requirement a // why
        needs b /* inside */ or c
    requirement a
        // on its own
        needs b
    // last
} // tail
// end
"""
    )


def test_long_comments_move_with_their_first_line() -> None:
    text = "robot R {\n/* one\n   two\n */\ncomponent A { }\n        /* one\n        two */\n}"
    assert formatted(text) == (
        "robot R {\n    /* one\n       two\n     */\n"
        "    component A {}\n    /* one\n    two */\n}\n"
    )


def test_names_numbers_and_strings_stay_as_written() -> None:
    text = "robot R { provide ^a with { ^value: 007, x: 1.50E-03, s: 'a\\'b', t: \"\\t\" } }"
    for word in ("^a", "^value", "007", "1.50E-03", "'a\\'b'", '"\\t"'):
        assert word in formatted(text)


def test_windows_line_ends_and_marks_go() -> None:
    assert formatted("\ufeffrobot R {\r\n}\r\n") == "robot R {}\n"


def test_large_models_are_formatted() -> None:
    check(large_model(40))


def test_lines_are_short_where_words_are() -> None:
    chain = " or ".join(f"Component{i}.variable = value_{i}" for i in range(300))
    text = f"robot R {{ requirement a needs {chain} requirement {{ {chain_of_names()} }} needs b }}"
    once = formatted(text)
    assert max(map(len, once.split("\n"))) <= WIDTH
    check(text)


def chain_of_names() -> str:
    return ", ".join(f"communication_{i}" for i in range(50))


def test_deep_expressions_are_formatted() -> None:
    deep = "(" * 150 + "a" + " + b)" * 150
    check(f"robot R {{ requirement a needs {deep} > {'!' * 58}c }}")


def test_a_faulty_model_is_not_touched() -> None:
    with pytest.raises(ModelError) as caught:
        formatted("robot R { requirement }")
    assert [d.code for d in caught.value.diagnostics] == ["syntax"]


def test_functions_are_laid_out_like_constants() -> None:
    text = "robot R { function f ( a:double,b : array( double ) ):double=min(a , 2)*b [ 0 ] }"
    line = "    function f(a: double, b: array(double)): double = min(a, 2) * b[0]"
    assert formatted(text) == f"robot R {{\n{line}\n}}\n"
    check(text)


def test_an_object_that_a_function_returns_is_laid_out_like_that_of_a_constant() -> None:
    body = "{\n        x: a,\n        y: { z: 2 }\n    }\n}\n"
    for head in ("function f(a: double): Pose = ", "constant c: Pose = "):
        text = f"robot R {{\n    {head}{body}"
        assert formatted(text) == text
