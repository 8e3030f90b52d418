"""Random models as text: every construct, odd blanks, comments anywhere.

The models are well formed; that their names mean something is not attempted.
"""

from __future__ import annotations

from hypothesis import strategies as st

__all__ = ["comments", "model_text", "tokens"]

_WORDS = """
    a b1 LineDetector current_correction a_rather_long_name_that_fills_the_line ^value ^and ^x
    state type from never needs on if goto message
"""
_NAMES = st.sampled_from(_WORDS.split())
_COMMENT_TEXTS = st.text("abc é{}()\"'/*;:=-", max_size=20)
_LEVELS = [
    ["=>"],
    ["or"],
    ["and"],
    ["=", "!="],
    ["<", "<=", ">", ">="],
    ["+", "-"],
    ["*", "/", "%"],
]


def _flat(parts: list[list[str]]) -> list[str]:
    return [token for part in parts for token in part]


def _listed(part: st.SearchStrategy[list[str]], most: int = 4) -> st.SearchStrategy[list[str]]:
    """One or more parts with commas between them."""
    return st.lists(part, min_size=1, max_size=most).map(
        lambda parts: _flat([[",", *part] for part in parts])[1:]
    )


def _maybe(part: st.SearchStrategy[list[str]]) -> st.SearchStrategy[list[str]]:
    return st.one_of(st.just([]), part)


def _seq(*parts: str | st.SearchStrategy[list[str]]) -> st.SearchStrategy[list[str]]:
    return st.tuples(*(st.just(p.split(" ")) if isinstance(p, str) else p for p in parts)).map(
        lambda drawn: _flat(list(drawn))
    )


def _block(
    head: st.SearchStrategy[list[str]], item: st.SearchStrategy[list[str]], most: int = 4
) -> st.SearchStrategy[list[str]]:
    return _seq(head, "{", st.lists(item, max_size=most).map(_flat), "}")


name = _NAMES.map(lambda n: [n])
qualified = st.one_of(name, _seq(name, ".", name))
access = st.one_of(
    name,
    st.just(["value"]),
    _seq(name, ".", name),
    _seq("value . x [ 0 ]"),
    _seq(name, "[ 12 ] .", name),
)
literal = st.sampled_from(
    ["0", "42", "4.25", "1e-3", "2.5E4", "true", "false", '"s"', "'a b'", '"\\n\\"\'"', "'// no'"]
).map(lambda text: [text])
string = st.sampled_from(['"/a/b"', "'/vel'", '"\\t"']).map(lambda text: [text])


@st.composite
def _operation(draw: st.DrawFn, inner: st.SearchStrategy[list[str]]) -> list[str]:
    """Operators of one level between operands, some of them in parentheses."""
    operators = draw(st.sampled_from(_LEVELS))
    parts = draw(st.lists(inner, min_size=2, max_size=5))
    found = list(parts[0])
    for part in parts[1:]:
        found += [draw(st.sampled_from(operators)), *part]
    return found


expression = st.recursive(
    st.one_of(access, literal),
    lambda inner: st.one_of(
        _operation(inner), _seq("(", inner, ")"), _seq("!", inner), _seq("- (", inner, ")")
    ),
    max_leaves=12,
)
type_ = st.recursive(
    st.one_of(
        st.sampled_from([["string"], ["boolean"], ["double"], ["none"], ["integer"]]),
        _seq("integer ( - 3 .. 4 )"),
        name,
    ),
    lambda inner: _seq("array (", inner, ")"),
    max_leaves=3,
)
data = st.recursive(
    expression,
    lambda inner: _seq("{", _maybe(_listed(_seq(name, ":", inner))), "}"),
    max_leaves=8,
)
condition = _maybe(_seq("if", expression))
goto = _maybe(_seq("goto", name))
assignments = _maybe(_seq("do", _listed(_seq(access, ":=", expression), 3)))
transition = st.one_of(
    _seq(
        "on",
        st.sampled_from([[k] for k in ("request", "response", "feedback", "error", "cancel")]),
        st.sampled_from([["from"], ["to"]]),
        qualified,
        condition,
        assignments,
        goto,
    ),
    _seq("transition", condition, goto),
)
state = _block(
    _seq(st.sampled_from([[], ["initial"], ["marked"], ["initial", "marked"]]), "state", name),
    transition,
)
variable = _seq("variable", name, ":", type_, _maybe(_seq("=", expression)))
behaviour = _block(st.just(["behaviour"]), st.one_of(variable, state, transition))
identifier = _maybe(_seq("identifier :", string, ","))
links = _maybe(_seq("links", name))
communication = st.one_of(
    _seq(
        st.sampled_from([["incoming"], ["outgoing"]]),
        "message",
        name,
        "with",
        identifier,
        "type :",
        type_,
        links,
    ),
    _seq("service", name, "with", identifier, "request :", type_, ", response :", type_, links),
    _seq(
        "action", name, "with", identifier, "request :", type_, ", response :", type_,
        ", feedback :", type_, links,
    ),
)  # fmt: skip
component = st.one_of(
    _block(_seq("component", name), st.one_of(communication, behaviour)),
    _seq("component", name, "from", name, "import", name, _maybe(_seq("with prefix :", string))),
)
communications = st.one_of(qualified, _seq("{", _listed(qualified, 6), "}"))
requirement = st.one_of(
    _seq("requirement", communications, "needs", expression, _maybe(_seq("to start"))),
    _seq("requirement (", expression, ") disables", communications, _maybe(_seq("to start"))),
    _seq("requirement ( a ) needs b"),
    _seq("requirement", st.sampled_from([["never"], ["always"]]), "(", expression, ")"),
)
provide = _seq("provide", qualified, "with", data, condition)
datatype = st.one_of(
    _block(_seq("datatype object", name), _seq(name, ":", type_)),
    _block(
        _seq("datatype enum", name, "from", type_, "to"),
        st.one_of(_seq(expression, "->", name), _seq("default ->", name)),
    ),
)
interface = _seq("interface", name, "use", name, "from", name)
declaration = st.one_of(component, requirement, provide, datatype, interface)


@st.composite
def tokens(draw: st.DrawFn) -> list[str]:
    """The words of a well-formed robot."""
    head = _seq("robot", name)
    return draw(_block(head, declaration, 5))


@st.composite
def comments(draw: st.DrawFn) -> str:
    """Blanks, line ends and comments that may stand between two words; never empty."""
    text = draw(_COMMENT_TEXTS)
    return draw(
        st.sampled_from(
            [
                f" // {text}\n",
                f"\n\t//{text}\n",
                f" /*{text.replace('*/', '')} */ ",
                f"\n    /*{text.replace('*/', '')}\n     * more\n  end */\n",
                f" /* {text.replace('*/', '')} */ // and\n",
                "\n\n\n  ",
                "\n",
                "\t ",
            ]
        )
    )


@st.composite
def model_text(draw: st.DrawFn) -> str:
    """A well-formed model, laid out at random."""
    words = draw(tokens())
    places = draw(st.dictionaries(st.integers(0, len(words)), comments(), max_size=8))
    parts: list[str] = []
    for index, word in enumerate(words):
        parts += [places.get(index, " "), word]
    return "".join([*parts, places.get(len(words), "")])
