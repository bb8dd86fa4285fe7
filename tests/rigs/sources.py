# SPDX-License-Identifier: Apache-2.0
"""Sources as syntax trees, each parsed once a process.

Rule: who reads a tree does not change it. The tests that import this run in one worker (`tests/conftest.py`).
"""

from __future__ import annotations

import ast
import gc
from functools import cache

__all__ = ("nodes", "parsed")


@cache
def parsed(text: str) -> ast.Module:
    """The tree of a module's text. All of it stays: to search it for garbage takes longer than to parse it."""
    gc.disable()
    try:
        return ast.parse(text)
    finally:
        gc.enable()


@cache
def nodes(tree: ast.AST) -> tuple[ast.AST, ...]:
    """The tree and all that is in it, as `ast.walk` finds them."""
    return tuple(ast.walk(tree))
