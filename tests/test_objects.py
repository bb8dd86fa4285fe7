# SPDX-License-Identifier: Apache-2.0
"""What belongs to an object is changed by that object: no function changes a module's, nor another object's."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
OURS = ("rai_missions", "visualize")
CHANGES = frozenset(
    (
        "add", "append", "appendleft", "clear", "discard", "extend", "insert", "pop", "popitem", "popleft", "remove",
        "reverse", "setdefault", "sort", "update",
    )
)  # fmt: skip
"""Methods that change a list, a set, a dict or a deque."""

PROCESS = "the process is this program's own: it was started for this alone"
GLOBALS: dict[tuple[str, str], str] = {}
"""A module, and an object of the module or of the interpreter that its functions change → why."""

SHARED: dict[tuple[str, str], str] = {}
"""A module, and what it assigns attributes of → why."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


def modules() -> Iterator[tuple[str, ast.Module]]:
    for folder in OURS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            yield str(path.relative_to(ROOT)), ast.parse(path.read_text(encoding="utf-8"))


def functions(tree: ast.AST) -> Iterator[Function]:
    return (node for node in ast.walk(tree) if isinstance(node, Function))


def first_name(node: ast.expr) -> str:
    """`a` of `a.b[c].d`; empty where it does not begin with a name."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


def module_names(tree: ast.Module) -> set[str]:
    """The names that a module binds: by assignment, by `class`, and by `import`."""
    names = {alias.asname or alias.name for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)
             for alias in node.names}  # fmt: skip
    names |= {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", ast.Tuple())]
        names |= {each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)}
    return names


def local_names(function: Function) -> set[str]:
    arguments = {node.arg for node in ast.walk(function) if isinstance(node, ast.arg)}
    return arguments | {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def changed(function: Function) -> Iterator[tuple[str, str]]:
    """What a function changes in place: the name with which the expression begins, and the expression."""
    for node in ast.walk(function):
        if isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
            yield first_name(node), ast.unparse(node.value)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in CHANGES:
            yield first_name(node.func), ast.unparse(node.func.value)
        elif isinstance(node, ast.Global):
            yield from ((name, name) for name in node.names)


def changed_globals(tree: ast.Module) -> set[str]:
    known = module_names(tree)
    found: set[str] = set()
    for function in functions(tree):
        outer = known - local_names(function)
        found |= {what for name, what in changed(function) if name in outer}
    return found


def made(function: Function) -> set[str]:
    """The names that a function binds to an object that it has just made: by calling a class."""
    names: set[str] = set()
    for node in ast.walk(function):
        values = node.value.elts if isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple) else (
            [node.value] if isinstance(node, ast.Assign) else []
        )  # fmt: skip
        if any(isinstance(each, ast.Call) and makes(each.func) for each in values):
            names |= {n.id for target in node.targets for n in ast.walk(target) if isinstance(n, ast.Name)}
    return names


def makes(what: ast.expr) -> bool:
    """It is a class by its name, or makes a copy."""
    name = ast.unparse(what).rpartition(".")[2].lstrip("_")
    return name[:1].isupper() or name in ("cls", "copy", "type(self)", "__new__", "finalize")


def assigned(tree: ast.Module) -> set[str]:
    """The expressions, but for `self`, of whose value a function assigns an attribute."""
    found: set[str] = set()
    for function in functions(tree):
        own = made(function) | {"self", "cls"}
        found |= {
            ast.unparse(node.value)
            for node in ast.walk(function)
            if isinstance(node, ast.Attribute) and not isinstance(node.ctx, ast.Load)
            and ast.unparse(node.value) not in own
        }  # fmt: skip
    return found


def test_no_function_changes_what_belongs_to_a_module() -> None:
    found = {(path, what) for path, tree in modules() for what in changed_globals(tree)}
    assert found - GLOBALS.keys() == set()


def test_no_function_assigns_the_attributes_of_another_object() -> None:
    found = {(path, what) for path, tree in modules() for what in assigned(tree)}
    assert {each for each in found if each not in SHARED} == set()


def test_no_reason_is_left_over() -> None:
    trees = dict(modules())
    assert [key for key in GLOBALS if key[0] in trees and key[1] not in changed_globals(trees[key[0]])] == []
    assert [key for key in SHARED if key[0] in trees and key[1] not in assigned(trees[key[0]])] == []


def test_what_changes_a_module_or_another_object_is_found() -> None:
    tree = ast.parse(
        "import os\nKNOWN = {}\n"
        "def learn(name): KNOWN[name] = 1\n"
        "def forget(): KNOWN.clear()\n"
        "def keep(KNOWN): KNOWN.clear()\n"
        "def show(): os.environ['A'] = '1'\n"
        "def close(other): other.is_open = False\n"
        "def make():\n    other = Thing()\n    other.is_open = False\n"
        "class Thing:\n    def end(self): self.is_open = self.inner.is_open = False\n"
    )
    assert changed_globals(tree) == {"KNOWN", "os.environ"} and assigned(tree) == {"other", "self.inner"}
