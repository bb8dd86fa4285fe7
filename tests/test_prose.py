# SPDX-License-Identifier: Apache-2.0
"""Text for people is read by people: no module looks into a note, a reason or a line of a log."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.rigs.sources import parsed

ROOT = Path(__file__).parents[1]
PACKAGES = ("rai_missions", "visualize", "missions")
PROSE = frozenset({"notes", "note", "why", "remark", "remarks"})
"""Names of what is written for people, as variables and as fields."""
SENTENCES = frozenset({"sentence", "sentences"})
"""These may be equal to each other: what is shown already is not shown twice."""
HOLDERS = frozenset({"note", "row", "record", "entry", "fault", "finding"})
"""Whose `text`, `message` and `sentence` are the same."""
ERRORS = frozenset({"error", "exc", "exception", "cause", "reason", "failure"})
"""What is raised; its text is for people too."""
PARSERS = frozenset({
    "startswith", "endswith", "split", "rsplit", "partition", "rpartition", "find", "rfind", "index", "rindex", "count",
    "removeprefix", "removesuffix", "splitlines",
})  # fmt: skip
PATTERNS = frozenset({"match", "search", "fullmatch", "findall", "finditer"})
ELSEWHERE = {
    "rai_missions/redaction.py": "what is hidden may be in any text: it is searched for in each",
    "rai_missions/connectors/ros2/services.py": "a ROS reply has a message, and no field for the reason of a failure",
    "rai_missions/connectors/ros2/names.py": "rclpy reports where a name is invalid in its exception alone",
    "rai_missions/connectors/contract.py": "the contract that a reply quotes what a service raised",
}
"""Where it is another program's text, and why there is no field."""


class Reader(ast.NodeVisitor):
    """Finds where a module looks into prose."""

    def __init__(self) -> None:
        self.found: list[int] = []
        self.names: set[str] = set()
        """Variables that are an item of the notes."""

    def is_prose(self, node: ast.AST) -> bool:
        if isinstance(node, ast.Name):
            return node.id in PROSE or node.id in self.names
        if isinstance(node, ast.Attribute):
            held = isinstance(node.value, ast.Name) and (node.value.id in HOLDERS or node.value.id in self.names)
            return node.attr in PROSE or (node.attr in ("text", "message", "sentence") and held)
        if isinstance(node, ast.Subscript):
            return self.is_prose(node.value)
        if isinstance(node, ast.Call):
            inner = node.func.value if isinstance(node.func, ast.Attribute) else None
            named = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
            worded = named in ("str", "repr", "in_words") and any(
                getattr(each, "id", "") in ERRORS for each in node.args
            )
            shown = worded or (named in ("str", "tuple", "list", "sorted") and any(map(self.is_prose, node.args)))
            return (
                shown
                or named == "getMessage"
                or (inner is not None and named in ("lower", "strip", "casefold") and self.is_prose(inner))
            )
        return False

    def _loop(self, target: ast.expr, over: ast.expr) -> None:
        if self.is_prose(over) and isinstance(target, ast.Name):
            self.names.add(target.id)

    def visit_For(self, node: ast.For) -> None:
        self._loop(node.target, node.iter)
        self.generic_visit(node)

    def visit(self, node: ast.AST) -> None:
        for each in getattr(node, "generators", ()):
            self._loop(each.target, each.iter)
        super().visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        if self.is_prose(node.value):
            self.names.update(each.id for each in node.targets if isinstance(each, ast.Name))
        taken = node.value.args[0] if isinstance(node.value, ast.Call) and node.value.args else node.value
        if isinstance(taken, ast.GeneratorExp):
            self.visit(taken)
            if isinstance(taken.elt, ast.Name) and taken.elt.id in self.names:
                self.names.update(each.id for each in node.targets if isinstance(each, ast.Name))
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        sides = [node.left, *node.comparators]
        compared = any(isinstance(each, ast.In | ast.NotIn | ast.Eq | ast.NotEq) for each in node.ops)
        is_empty = any(isinstance(each, ast.Constant) and each.value in ("", None) for each in sides)
        if compared and not is_empty and any(map(self.is_prose, sides)):
            self.found.append(node.lineno)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        called = node.func
        if isinstance(called, ast.Attribute):
            on = called.value
            named = isinstance(on, ast.Name | ast.Attribute) and getattr(on, "id", getattr(on, "attr", "")) in SENTENCES
            parsed = called.attr in PARSERS and (named or self.is_prose(on))
            matched = called.attr in PATTERNS and any(map(self.is_prose, node.args))
            if parsed or matched:
                self.found.append(node.lineno)
        self.generic_visit(node)


def looks(source: str) -> list[int]:
    """The lines in which a module looks into prose."""
    reader = Reader()
    reader.visit(parsed(source))
    return reader.found


def modules() -> Iterator[Path]:
    for package in PACKAGES:
        yield from sorted((ROOT / package).rglob("*.py"))


@pytest.mark.parametrize(
    "line",
    [
        'kept = [note for note in step.notes if not note.startswith(("question ", "fallback "))]',
        'for note in step.notes:\n    if note.endswith(": accepted"):\n        pass',
        'note = next((each for each in step.notes if each.startswith("question 1:")), "")\nnote.endswith("x")',
        'if "paused" in step.notes:\n    pass',
        'step.outcome == "aborted" and step.why.startswith("e-stop by ")',
        'if step.why == NOT_STARTED:\n    pass',
        'if row.text.startswith("the run breaks off"):\n    pass',
        'went = [note.data for note in before.notes() if note.text == MIGRATED]',
        're.match("question", why)',
        '"refused" in record.getMessage()',
        'step.why.partition(":")',
        '"x" in str(step.why)',
        'step.notes[0].lower().startswith("x")',
        'sentence.startswith("x")',
        'lines = step.notes\n"paused" in lines',
        '"refused" in str(error)',
        'text = str(error)\ntext.startswith("no server")',
        '"no state" in fault.sentence',
    ],
)  # fmt: skip
def test_a_look_into_prose_is_found(line: str) -> None:
    assert looks(line)


@pytest.mark.parametrize("line", ["if step.why:\n    pass", 'why == ""', "notes + step.notes", "verdict.note is None"])
def test_prose_that_is_shown_or_absent_is_no_look_into_it(line: str) -> None:
    assert not looks(line)


def test_no_module_looks_into_a_note_a_reason_or_a_log_line() -> None:
    found = {
        f"{path.relative_to(ROOT)}:{line}"
        for path in modules()
        if str(path.relative_to(ROOT)) not in ELSEWHERE
        for line in looks(path.read_text())
    }
    assert found == set()


def test_no_script_of_a_page_looks_into_a_note() -> None:
    for path in sorted((ROOT / "visualize").rglob("*.js")):
        assert "note.startsWith" not in path.read_text(), path
        assert ".why.startsWith" not in path.read_text(), path
