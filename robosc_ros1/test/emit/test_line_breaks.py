"""Long lines of generated Python: broken where formatters break them, the same program as before."""

from __future__ import annotations

import pytest

from robosc.emit.write.line_breaks import WIDTH, break_long_lines, unparenthesised

NAMES = [f"self.attribute_with_a_long_name_{number}" for number in range(4)]

BROKEN = [
    (
        f"        return {NAMES[0]} and ({NAMES[1]} or {NAMES[2]})",
        f"""\
        return (
            {NAMES[0]}
            and ({NAMES[1]} or {NAMES[2]})
        )""",
    ),
    (
        f"    if ({' or '.join(NAMES[:3])}):  # model.rscd:1",
        """\
    # model.rscd:1
    if (
        self.attribute_with_a_long_name_0
        or self.attribute_with_a_long_name_1
        or self.attribute_with_a_long_name_2
    ):""",
    ),
    (
        f'    self.robot = "right"  # state: {", ".join(["held_to_right"] * 7)}',
        f"""\
    # state: {", ".join(["held_to_right"] * 5)},
    #     held_to_right, held_to_right
    self.robot = "right\"""",
    ),
    (
        f"    # published by its neighbour as /{'a-long-name/' * 9}pose",
        f"""\
    # published by its neighbour as
    #     /{"a-long-name/" * 9}pose""",
    ),
    (
        f"    x = self.kept(lambda: {NAMES[0]} + {NAMES[1]}, {NAMES[2]}, -1)",
        f"""\
    x = self.kept(
        lambda: {NAMES[0]} + {NAMES[1]},
        {NAMES[2]},
        -1,
    )""",
    ),
    (
        f"""    return {{"a": {{"x": {NAMES[0]} * -1, "y": 2}}, "b": {NAMES[1]}, "c": [1, 2]}}""",
        f"""\
    return {{
        "a": {{"x": {NAMES[0]} * -1, "y": 2}},
        "b": {NAMES[1]},
        "c": [1, 2],
    }}""",
    ),
    (
        f"""    Command(reason="{"many words, " * 9}and a \\n"),""",
        f"""\
    Command(
        reason=(
            "{"many words, " * 7}"
            "{"many words, " * 2}and a \\n"
        )
    ),""",
    ),
    (
        f'    """{"A sentence of many words. " * 4}"""',
        f"""\
    \"""{"A sentence of many words. " * 3}A sentence
    of many words.\"""
""".rstrip(),
    ),
    (
        f"from {NAMES[0]}.{NAMES[1]}_controller import first, second  # noqa: E402",
        f"""\
from {NAMES[0]}.{NAMES[1]}_controller import (  # noqa: E402
    first,
    second,
)""",
    ),
    (
        f"""\
from {NAMES[0]}.{NAMES[1]}_controller_package import (  # noqa: E402
    first,
)""",
        f"""\
from {NAMES[0]}.{NAMES[1]}_controller_package import (  # noqa: E402
    first,
)""",
    ),
    (
        f"    x = first_of([f({NAMES[0]}) for i_, x_ in enumerate({NAMES[1]}) if x_ > {NAMES[2]}])",
        f"""\
    x = first_of(
        [
            f({NAMES[0]})
            for i_, x_ in enumerate({NAMES[1]})
            if x_ > {NAMES[2]}
        ]
    )""",
    ),
    (
        f"    x = where(spread(lambda i_, x_: x_ > {NAMES[0]}), enumerate({NAMES[1]}[i_ - 10_000]))",
        f"""\
    x = where(
        spread(lambda i_, x_: x_ > {NAMES[0]}),
        enumerate({NAMES[1]}[i_ - 10_000]),
    )""",
    ),
    (
        f"""    x = ["{"-".join(NAMES)}"]""",
        f"""\
    x = [
        "{"-".join(NAMES)}"
    ]""",
    ),
]


@pytest.mark.parametrize(("line", "expected"), BROKEN)
def test_where_a_line_is_broken(line: str, expected: str) -> None:
    assert break_long_lines(line) == expected


def test_what_a_text_over_several_lines_says_stays() -> None:
    source = f'x = """\n{"words " * 20}\n"""\n'
    assert break_long_lines(source) == source


def test_a_formatted_text_is_broken_between_its_words() -> None:
    words = " ".join(["requirement", "Station[i].load", "{{braces}}", "{"] * 4)
    line = f'    text=f"{words.replace("{", "{{")} (i = {{i - 1}})",'
    broken = break_long_lines(line)
    assert max(map(len, broken.splitlines())) <= WIDTH
    assert eval(f"dict({broken})", {"i": 3}) == eval(f"dict({line})", {"i": 3})


def test_a_tuple_keeps_its_brackets() -> None:
    assert unparenthesised("((a or b))") == "a or b"
    assert unparenthesised("(a) or (b)") == "(a) or (b)"
    assert unparenthesised("(a, b)") == "(a, b)"
