"""The formatter's entry points: a model in canonical layout.

The tree decides what stands on a line and where a line may be broken; the tokens themselves, and
the comments between them, are taken from the text one by one. So no token can get lost or change
places, and every name, number and string stays as it was written.
"""

from __future__ import annotations

from operator import eq

from robosc.errors import ModelError, has_errors
from robosc.language.tokens import tokenize
from robosc.source import Source
from robosc.syntax import nodes, parser
from robosc.syntax.formatting.formatter import WIDTH, Formatter
from robosc.syntax.formatting.pretty_printing import print_doc


def format_text(source: Source) -> str:
    """The model in canonical layout.

    Raises:
        ModelError: it has syntax errors.
    """
    tree, diagnostics = parser.parse(source)
    if tree is None or has_errors(diagnostics):
        raise ModelError(diagnostics)
    return format_tree(tree)


def format_tree(tree: nodes.FileNode) -> str:
    """The model in canonical layout, given its tree, which was parsed without errors."""
    tokens = tokenize(tree.span.source)
    formatted = Source(tokens.source.path, print_doc(Formatter(tokens).file(tree), WIDTH))
    if formatted.text == tokens.source.text:
        return formatted.text
    again = tokenize(formatted)
    # Equal tokens are the cheap check and almost always hold; equal trees are what must hold.
    same = again.kinds == tokens.kinds and all(map(eq, again.texts(), tokens.texts()))
    assert same or parser.parse(formatted)[0] == tree, "formatting has changed the model"
    return formatted.text
