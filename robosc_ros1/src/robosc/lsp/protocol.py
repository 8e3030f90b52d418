"""Values of this package as the protocol's types."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from urllib.parse import unquote, urlsplit

from lsprotocol import types

from robosc import errors
from robosc.lsp import actions, outline
from robosc.lsp.completion.candidates import Candidate
from robosc.lsp.hover import Signature
from robosc.lsp.positions import Encoding, range_of
from robosc.source import Source, Span

_SEVERITY = {
    errors.Severity.ERROR: types.DiagnosticSeverity.Error,
    errors.Severity.WARNING: types.DiagnosticSeverity.Warning,
}


def path_of(uri: str) -> str:
    """The file of a URI; what is no file keeps its URI as its name."""
    parts = urlsplit(uri)
    return unquote(parts.path) if parts.scheme == "file" else uri


def uri_of(path: str) -> str:
    return Path(path).as_uri() if path.startswith("/") else path


def range_(span: Span, encoding: Encoding) -> types.Range:
    (line, column), (end_line, end_column) = range_of(span, encoding)
    return types.Range(types.Position(line, column), types.Position(end_line, end_column))


def location(span: Span, encoding: Encoding) -> types.Location:
    return types.Location(uri_of(span.source.path), range_(span, encoding))


def text_edit(edit: actions.Edit, encoding: Encoding) -> types.TextEdit:
    return types.TextEdit(range_(edit.span, encoding), edit.text)


# --- diagnostics ---------------------------------------------------------------------------------


def diagnostics_for(
    source: Source, diagnostics: Iterable[errors.Diagnostic], encoding: Encoding, page: str | None
) -> list[types.Diagnostic]:
    """Those that concern a text; a library's stand where it is imported.

    ``page`` is the address of the page that explains their codes.
    """
    return [_diagnostic(source, diagnostic, encoding, page) for diagnostic in diagnostics]


def _diagnostic(
    source: Source, diagnostic: errors.Diagnostic, encoding: Encoding, page: str | None
) -> types.Diagnostic:
    message, span, notes = diagnostic.message, diagnostic.span, diagnostic.notes
    if diagnostic.hint is not None:
        message += f"\n{diagnostic.hint}"
    if span.source is not source:
        here = [n.span for n in notes if n.span is not None and n.span.source is source]
        notes = (errors.Note("the fault is here", span), *notes)
        message = f"{span.place}: {message}"
        span = here[0] if here else Span(source, 0, 0)
    related = [
        types.DiagnosticRelatedInformation(location(n.span, encoding), n.message)
        for n in notes
        if n.span is not None
    ]
    words = [message, *(n.message for n in notes if n.span is None)]
    faded = diagnostic.code.startswith("unused") or diagnostic.code == "unreachable-state"
    return types.Diagnostic(
        range=range_(span, encoding),
        message="\n".join(words),
        severity=_SEVERITY[diagnostic.severity],
        code=diagnostic.code,
        code_description=types.CodeDescription(f"{page}#{diagnostic.code}") if page else None,
        source="robosc",
        tags=[types.DiagnosticTag.Unnecessary] if faded else None,
        related_information=related or None,
    )


# --- outline, folding, completion ----------------------------------------------------------------


def document_symbol(entry: outline.OutlineItem, encoding: Encoding) -> types.DocumentSymbol:
    return types.DocumentSymbol(
        name=entry.label,
        detail=entry.detail,
        kind=types.SymbolKind[outline.KINDS[entry.kind].symbol],
        range=range_(entry.whole, encoding),
        selection_range=range_(entry.name, encoding),
        children=[document_symbol(child, encoding) for child in entry.children],
    )


def workspace_symbol(symbol: outline.Found, encoding: Encoding) -> types.WorkspaceSymbol:
    return types.WorkspaceSymbol(
        location=location(symbol.item.name, encoding),
        name=symbol.item.label,
        kind=types.SymbolKind[outline.KINDS[symbol.item.kind].symbol],
        container_name=symbol.inside or None,
    )


def hover(text: str, span: Span, encoding: Encoding) -> types.Hover:
    content = types.MarkupContent(types.MarkupKind.Markdown, text)
    return types.Hover(content, range_(span, encoding))


def folding_range(fold: outline.Fold) -> types.FoldingRange:
    kind = types.FoldingRangeKind.Comment if fold.comment else types.FoldingRangeKind.Region
    return types.FoldingRange(fold.first - 1, fold.last - 1, kind=kind)


def completion_item(
    candidate: Candidate, place: types.Range, snippets: bool
) -> types.CompletionItem:
    text = candidate.text if candidate.text is not None else candidate.label
    is_snippet = "$" in text and snippets
    return types.CompletionItem(
        label=candidate.label,
        kind=types.CompletionItemKind[outline.KINDS[candidate.kind].item],
        detail=candidate.detail or None,
        sort_text=f"{candidate.rank}{candidate.order:05}{candidate.label.casefold()}",
        text_edit=types.TextEdit(place, text if is_snippet else text.replace("$0", "")),
        insert_text_format=(
            types.InsertTextFormat.Snippet if is_snippet else types.InsertTextFormat.PlainText
        ),
    )


def signature_help(signature: Signature) -> types.SignatureHelp:
    parameters = [types.ParameterInformation(label=place) for place in signature.places]
    information = types.SignatureInformation(signature.label, parameters=parameters)
    return types.SignatureHelp([information], 0, signature.active)


def inlay_hint(span: Span, text: str, encoding: Encoding) -> types.InlayHint:
    end = range_(span, encoding).end
    return types.InlayHint(end, text, types.InlayHintKind.Type, padding_left=True)


def legend(token_types: Sequence[str], modifiers: Sequence[str]) -> types.SemanticTokensLegend:
    return types.SemanticTokensLegend(list(token_types), list(modifiers))
