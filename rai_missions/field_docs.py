# SPDX-License-Identifier: Apache-2.0
"""What stands below each attribute of a class in its source: the format's words, explained.

Rule: sources are read when somebody wants the words; to load a mission nobody does.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from typing import Any

__all__ = ("attribute_docs",)

Docs = Mapping[str, str]


def attribute_docs(kind: type[Any]) -> dict[str, str]:
    """Attribute → the text below its annotation, those of the classes it derives from included.

    A class whose source is not to be had, and one inside a function, says nothing.
    """
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        found.update(_in_module(each.__module__).get(each.__qualname__, {}) if "__annotations__" in vars(each) else {})
    return found


@cache
def _in_module(name: str) -> Mapping[str, Docs]:
    """Class → attribute → text, of a whole module: to find one class in a source takes as long as to find all."""
    try:
        source = inspect.getsource(sys.modules[name])
    except (KeyError, OSError, TypeError):
        return {}
    return dict(_classes(ast.parse(source).body, ""))


def _classes(body: list[ast.stmt], outside: str) -> Iterator[tuple[str, Docs]]:
    for each in body:
        if isinstance(each, ast.ClassDef):
            yield outside + each.name, dict(_texts(each.body))
            yield from _classes(each.body, f"{outside}{each.name}.")


def _texts(body: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    for attribute, text in pairwise(body):
        if not (isinstance(attribute, ast.AnnAssign) and isinstance(attribute.target, ast.Name)):
            continue
        if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) and isinstance(text.value.value, str):
            yield attribute.target.id, inspect.cleandoc(text.value.value)
