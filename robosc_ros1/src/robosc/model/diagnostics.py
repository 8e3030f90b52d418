"""The diagnostics of a file, and suggestions for names that do not exist."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import get_close_matches

from robosc import codes, errors, limits, source
from robosc.remedies import Hint, meant


class Report:
    """The diagnostics of one file, each once, in the order in which they were found.

    ``strict`` turns the warnings that are marked ``strict`` in :data:`robosc.codes.CODES` into
    errors.
    """

    def __init__(self, strict: bool = False) -> None:
        self._strict = strict
        self._items: dict[errors.Diagnostic, None] = {}
        self._searches = 0

    def add(
        self,
        code: str,
        span: source.Span,
        message: str,
        hint: Hint | None = None,
        notes: Sequence[errors.Note] = (),
    ) -> errors.Diagnostic:
        """Add and return a diagnostic with the severity that its code has in ``CODES``."""
        entry = codes.CODES[code]
        severity = errors.Severity.ERROR if self._strict and entry.strict else entry.severity
        diagnostic = errors.Diagnostic(severity, code, message, span, hint, tuple(notes))
        self._keep(diagnostic)
        return diagnostic

    def _keep(self, diagnostic: errors.Diagnostic) -> None:
        self._items[diagnostic] = None

    def withdraw(self, found: Iterable[errors.Diagnostic]) -> bool:
        """Remove diagnostics that only follow from another fault; whether there were any."""
        reported = [diagnostic for diagnostic in found if diagnostic in self._items]
        for diagnostic in reported:
            del self._items[diagnostic]
        return bool(reported)

    def extend(self, diagnostics: Iterable[errors.Diagnostic]) -> None:
        self._items.update(dict.fromkeys(diagnostics))

    @property
    def diagnostics(self) -> tuple[errors.Diagnostic, ...]:
        return tuple(self._items)

    @property
    def has_errors(self) -> bool:
        return any(d.severity is errors.Severity.ERROR for d in self._items)

    def suggest(self, name: str, candidates: Iterable[str], what: str = "there are") -> Hint | None:
        """``did you mean 'x'?`` for the nearest candidate, else a list of up to eight, or None."""
        names = list(dict.fromkeys(candidates))
        nearest = self.nearest(name, names)
        if nearest is not None:
            return meant(nearest)
        if names and len(names) <= 8:
            return f"{what}: {first_of(names)}"
        return None

    def nearest(self, name: str, candidates: Sequence[str]) -> str | None:
        """The candidate that a name was probably meant to be; None if there is none."""
        near = _same_but_for_case(name, candidates)
        if near is None and self._searches < limits.SUGGESTIONS:
            self._searches += 1
            near = next(iter(get_close_matches(name, candidates, 1, 0.6)), None)
            near = near or _extension(name, candidates)
        return near


class Muted(Report):
    """A report that drops all diagnostics, for nodes whose faults were reported already."""

    def _keep(self, diagnostic: errors.Diagnostic) -> None:
        return None

    def suggest(self, name: str, candidates: Iterable[str], what: str = "") -> Hint | None:
        return None


class OfImport(Report):
    """The report of a component that is resolved again where it is imported.

    A library with errors is not imported. So those that remain come from the constants that the
    import sets, unless another component of the library is missing. ``place`` is the name of the
    component in the import.
    """

    def __init__(self, report: Report, place: source.Span) -> None:
        super().__init__()
        self._report = report
        self._place = place

    def _keep(self, diagnostic: errors.Diagnostic) -> None:
        told = [(d.code, d.span) for d in self._report.diagnostics]
        is_error = diagnostic.severity is errors.Severity.ERROR
        if is_error and ("import-incomplete", self._place) not in told:
            note = errors.Note("the component is imported here", self._place)
            self._report.extend([replace(diagnostic, notes=(*diagnostic.notes, note))])


def first_of(names: Iterable[str]) -> str:
    """The first 12 names separated by commas, and how many there are if that is not all."""
    all_names = list(names)
    shown = ", ".join(all_names[:12])
    return shown if len(all_names) <= 12 else f"{shown}, … ({len(all_names)} in all)"


def _same_but_for_case(name: str, names: Sequence[str]) -> str | None:
    folded = name.casefold()
    return next((n for n in names if n.casefold() == folded), None)


def _extension(name: str, names: Sequence[str]) -> str | None:
    """The only candidate that continues the name, or that the name continues."""
    if len(name) < 3:
        return None
    extended = [n for n in names if n.startswith(name) or (len(n) > 2 and name.startswith(n))]
    return extended[0] if len(extended) == 1 else None
