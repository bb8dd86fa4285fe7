# SPDX-License-Identifier: Apache-2.0
"""What the words of a model mean: the texts below its fields, read from its source."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from typing import Any

__all__ = ("attribute_docs", "explained")

Docs = Mapping[str, str]


def explained(doc: str, function: Any, meanings: Mapping[str, str]) -> str:
    """A docstring with the arguments of a function, each with its meaning and its default.

    Args:
        doc: Has no arguments yet.
        function: Whose arguments are explained.
        meanings: Argument → what it means, with its unit.
    """
    lines = []
    for name, parameter in inspect.signature(function).parameters.items():
        if name in meanings:
            default = parameter.default
            shown = "" if default in (parameter.empty, None, (), {}, "") else f" Default: {default!r}."
            lines.append(f"    {name}: " + meanings[name].replace("\n", "\n        ") + shown)
    return "\n".join([inspect.cleandoc(doc), "", "Args:", *lines]) if lines else inspect.cleandoc(doc)


def attribute_docs(kind: type[Any]) -> dict[str, str]:
    """Attribute → the text below its annotation, those of the classes it derives from included.

    A class whose source is not available, and a class inside a function, has none.
    """
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        found.update(_in_module(each.__module__).get(each.__qualname__, {}) if _annotates(each) else {})
    return found


def _annotates(kind: type[Any]) -> bool:
    """Whether a class itself is annotated; from Python 3.14 on by a function, unless its module postpones that."""
    return "__annotations__" in vars(kind) or getattr(kind, "__annotate__", None) is not None


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
