"""Names of a workspace, wherever they are declared."""

from __future__ import annotations

from pathlib import Path

from lsp_support import open_text

from robosc.lsp.analysis import Workspace
from robosc.lsp.outline import symbols

ARM = """\
library Arms {
    component Arm {
        incoming message grip with type: none
        behaviour { initial marked state open {} }
    }
}
"""
ROBOT = """\
robot Keeper {
    component Gripper { incoming message halt with type: none }
    requirement halt needs true
}
"""


def test_symbols_of_open_documents_and_of_files(tmp_path: Path) -> None:
    (tmp_path / "arms.rscd").write_text(ARM)
    workspace = Workspace(folders=[str(tmp_path)])
    open_text(workspace, tmp_path / "keeper.rscd", ROBOT)

    def named(query: str) -> list[tuple[str, str]]:
        return sorted((f.item.label, f.inside) for f in symbols(workspace, query))

    assert named("grip") == [("Gripper", "Keeper"), ("grip", "Arm")]
    assert named("OP") == [("open", "Arm")]
    assert named("halt") == [("halt", "Gripper")]
    assert named("kpr") == [("Keeper", "")]
    assert named("(") == []


def test_symbols_without_an_open_document(tmp_path: Path) -> None:
    (tmp_path / "arms.rscd").write_text(ARM)
    found = symbols(Workspace(folders=[str(tmp_path)]), "arm")
    assert [f.item.label for f in found] == ["Arms", "Arm"]
    assert {f.item.name.source.path for f in found} == {str(tmp_path / "arms.rscd")}
