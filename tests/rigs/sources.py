# SPDX-License-Identifier: Apache-2.0
"""Sources as syntax trees, each parsed once a process.

Rule: who reads a tree does not change it. The tests that import this run in one worker (`tests/conftest.py`).
"""

from __future__ import annotations

import ast
from functools import cache

__all__ = ("nodes", "parsed")


@cache
def parsed(text: str) -> ast.Module:
    """The tree of a module's text."""
    return ast.parse(text)


@cache
def nodes(tree: ast.AST) -> tuple[ast.AST, ...]:
    """The tree and all that is in it, as `ast.walk` finds them."""
    return tuple(ast.walk(tree))
