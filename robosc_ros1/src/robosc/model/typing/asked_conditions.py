"""Typing of conditions that a person or a script asks of a resolved robot.

They are read as the model's own requirements are, with the same names:
``blocked and Sensor.way = Lib.Way.free``.
"""

from __future__ import annotations

from robosc.expr import tree, undefined_data
from robosc.model import diagnostics, entities
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.names import copies, tables
from robosc.model.typing.expected import BOOLEAN
from robosc.model.typing.expressions import Typer
from robosc.model.typing.value_word import no_value
from robosc.syntax.nodes import ExprNode


def conditions_over(types: TypeTable, table: tables.ComponentTable) -> entities.ConditionReader:
    """A reader with the names of a file in which everything is declared."""

    def read(node: ExprNode, report: diagnostics.Report) -> tree.Expr | None:
        expanded = copies.over_copies(node, table.copies, report)
        if report.has_errors:
            return None
        incoming = no_value("a condition on states has no received value")
        typer = Typer(report, types.reporting_to(report), tables.SymbolTable(table), incoming)
        found = typer.check(expanded, BOOLEAN, "a condition")
        return None if found is None else undefined_data.condition_on_data(found)

    return read
