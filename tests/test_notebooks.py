# SPDX-License-Identifier: Apache-2.0
"""The notebooks of the documents are executed, cell by cell, in the IPython that a notebook's kernel is made of."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[1] / "docs"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def code(path: Path) -> list[str]:
    """The code cells of a notebook."""
    cells: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_s_cells_run_in_their_order(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from IPython.core.interactiveshell import InteractiveShell

    if "pandas" in path.read_text(encoding="utf-8"):
        pytest.importorskip("pandas")
    shutil.copytree(DOCS / "tutorial", tmp_path / "tutorial")
    (tmp_path / "notebooks").mkdir()
    monkeypatch.chdir(tmp_path / "notebooks")
    shell = InteractiveShell()
    for cell in code(path):
        ran = shell.run_cell(cell)
        ran.raise_error()
    assert len(code(path)) > 2 and all(map(str.strip, code(path)))


def test_there_is_a_notebook_for_each_of_the_four() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["journal", "mission", "play", "proof"]
