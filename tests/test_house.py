# SPDX-License-Identifier: Apache-2.0
"""The habits of the house that no linter knows: what stands at the top of every file."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = sorted(
    path
    for folder in ("rai_missions", "visualize", "missions", "benchmarks", "tests")
    for path in (ROOT / folder).rglob("*.py")
    if path.read_text(encoding="utf-8").strip()
)
OURS = [path for path in FILES if path.relative_to(ROOT).parts[0] in ("rai_missions", "visualize")]
LICENCE = "# SPDX-License-Identifier: Apache-2.0"


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", FILES, ids=name)
def test_a_file_begins_with_its_licence_and_its_role(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert LICENCE in text.splitlines()[:2], f"{name(path)}:1: begin with {LICENCE!r}"
    assert ast.get_docstring(ast.parse(text)), f"{name(path)}:2: say the room's role in a docstring"


@pytest.mark.parametrize("path", OURS, ids=name)
def test_a_files_public_names_are_a_tuple_of_what_it_has(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    offered = [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        and any(isinstance(t, ast.Name) and t.id == "__all__" for t in getattr(node, "targets", [node]))
    ]
    assert len(offered) == 1, f"{name(path)}: name what is public in `__all__`"
    assert isinstance(offered[0], ast.Tuple), f"{name(path)}: `__all__` is a tuple"


@pytest.mark.parametrize("path", FILES, ids=name)
def test_nothing_is_left_to_do(path: Path) -> None:
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        comment = line.partition("#")[2].strip()
        assert not comment.startswith(("TODO", "FIXME", "XXX", "HACK")), f"{name(path)}:{number}: {comment}"
