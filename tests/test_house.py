# SPDX-License-Identifier: Apache-2.0
"""The habits of the house that no linter knows: what stands at the top of every file."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
OURS = ("rai_missions", "visualize")
FOLDERS = (*OURS, "missions", "benchmarks", "tests")
LICENCE = "# SPDX-License-Identifier: Apache-2.0"


def files(folder: str) -> Iterator[tuple[str, str]]:
    """The name and the text of each that has one."""
    for path in sorted((ROOT / folder).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if text.strip():
            yield str(path.relative_to(ROOT)), text


def offers(text: str) -> list[ast.expr | None]:
    """What is given to `__all__`, each time."""
    return [
        node.value
        for node in ast.parse(text).body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        and any(isinstance(t, ast.Name) and t.id == "__all__" for t in getattr(node, "targets", [node]))
    ]


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_file_begins_with_its_licence_and_its_role(folder: str) -> None:
    faults = list[str]()
    for name, text in files(folder):
        if LICENCE not in text.splitlines()[:2]:
            faults.append(f"{name}:1: begin with {LICENCE!r}")
        if not ast.get_docstring(ast.parse(text)):
            faults.append(f"{name}:2: say the room's role in a docstring")
    assert faults == []


@pytest.mark.parametrize("folder", OURS)
def test_every_files_public_names_are_a_tuple_of_what_it_has(folder: str) -> None:
    faults = list[str]()
    for name, text in files(folder):
        offered = offers(text)
        if len(offered) != 1:
            faults.append(f"{name}: name what is public in `__all__`")
        elif not isinstance(offered[0], ast.Tuple):
            faults.append(f"{name}: `__all__` is a tuple")
    assert faults == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_nothing_is_left_to_do(folder: str) -> None:
    assert [
        f"{name}:{number}: {comment}"
        for name, text in files(folder)
        for number, line in enumerate(text.splitlines(), start=1)
        if (comment := line.partition("#")[2].strip()).startswith(("TODO", "FIXME", "XXX", "HACK"))
    ] == []


def test_there_are_files_to_look_at() -> None:
    assert all(any(files(folder)) for folder in FOLDERS)
