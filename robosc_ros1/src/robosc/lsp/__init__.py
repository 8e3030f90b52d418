"""The language server: what ``check`` knows, in the editor, while one types.

:mod:`robosc.lsp.server` speaks the protocol and is the only module that knows of pygls; the others
work on texts and offsets. :mod:`robosc.lsp.analysis` is what is known of one state of a document,
:mod:`robosc.model.names.occurrences` what each name in it means.
"""
