# SPDX-License-Identifier: Apache-2.0
"""The commands: each is a file with a function of its name, whose signature and docstring are its parser.

Rule: a file here is a command, and a command is a file here.

Imports `check`, `journal`, `mission`, `profile`, `prove`, `recording`, `replay` and `visualize`, and the modules of
the root.
"""

from __future__ import annotations

import importlib
import os
from typing import cast

from rai_missions.cli.command import Command

__all__ = ("load_command", "names")


def names() -> tuple[str, ...]:
    """All commands."""
    files = (file for folder in __path__ for file in os.listdir(folder))
    return tuple(sorted(file.removesuffix(".py") for file in files if file.endswith(".py") and file != "__init__.py"))


def load_command(name: str) -> Command:
    """The command of that name."""
    return cast(Command, getattr(importlib.import_module(f"{__name__}.{name}"), name))
