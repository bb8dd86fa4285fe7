# SPDX-License-Identifier: Apache-2.0
"""No module is imported by a string, which the import contracts of `pyproject.toml` could not see."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

from tests.rigs.sources import parsed

ROOT = Path(__file__).parents[1]
IMPORTERS = frozenset({
    "__import__", "exec_module", "import_module", "load_module", "resolve_name", "run_module", "run_path",
    "spec_from_file_location",
})  # fmt: skip
"""Functions that import what a string names."""
LISTED = {
    "rai_missions/answerers/model/providers.py:package_of": "the package of a provider that the user names",
    "rai_missions/cli/inputs.py:load_guards": "a file of the user's",
    "rai_missions/connectors/process/guard.py:_become_worker": "a module of ours, by our own command",
    "rai_missions/connectors/ros2/names.py:find_type": "the package of a message type",
    "rai_missions/kinds.py:load_kinds": "the modules of a folder of ours, each a kind",
    "rai_missions/errors.py:lazy_names": "a module of ours, by the table of its package",
    "rai_missions/worlds/world.py:_ours": "one of our own worlds, by the table of their names",
}
"""A function that may import what a string names → what that is."""


def is_ours(node: ast.expr) -> bool:
    """Whether a text names a module of ours: `"rai_missions.x"`, `f"rai_missions.{x}"`, `f"{__name__}.{x}"`."""
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    first = parts[0]
    if isinstance(first, ast.FormattedValue):
        return isinstance(first.value, ast.Name) and first.value.id == "__name__"
    return isinstance(first, ast.Constant) and str(first.value).startswith(("rai_missions.", "visualize."))


def opened_by_string(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Where a module is imported by a string: the function at the top of the file, and the line."""
    for outer in tree.body:
        for node in ast.walk(outer):
            if not isinstance(node, ast.Call):
                continue
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in IMPORTERS and not (node.args and is_ours(node.args[0])):
                yield getattr(outer, "name", ""), node.lineno


@cache
def all_opened() -> Mapping[str, int]:
    """The same for all of the code: each file and function, with the line."""
    return {
        f"{path.relative_to(ROOT)}:{name}": line
        for folder in ("rai_missions", "visualize", "missions")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if any(each in (text := path.read_text(encoding="utf-8")) for each in IMPORTERS)
        for name, line in opened_by_string(parsed(text))
    }


def test_no_door_is_opened_by_a_string() -> None:
    assert {place: line for place, line in all_opened().items() if place not in LISTED} == {}


def test_no_reason_is_left_over() -> None:
    assert LISTED.keys() - all_opened().keys() == set()


@pytest.mark.parametrize(
    ("code", "count"),
    [
        ('importlib.import_module("rclpy")', 1),
        ('import_module("rclpy.node")', 1),
        ('__import__("rclpy")', 1),
        ("importlib.import_module(name)", 1),
        ('importlib.import_module(f"{package}.msg")', 1),
        ('runpy.run_path("x.py")', 1),
        ('importlib.import_module("rai_missions.engine")', 0),
        ('import_module(f"{__name__}.{name}")', 0),
        ("import rclpy", 0),
    ],
)
def test_what_names_a_module_by_a_string_is_found(code: str, count: int) -> None:
    assert len(list(opened_by_string(ast.parse(f"def opened():\n    {code}\n")))) == count
