# SPDX-License-Identifier: Apache-2.0
"""The commands: each is a file with a function of its name, whose signature and docstring are its parser.

Rule: a file here is a command, and a command is a file here; a word of Python ends in `_` there, as in `try_`.

Imports `agents`, `campaign`, `check`, `connectors`, `conversation`, `embodiment`, `engine`, `journal`, `mission`,
`profile`, `prove`, `recording`, `replay`, `runtime`, `visualize`, `voice` and `worlds`, and the modules of the root.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from functools import partial
from keyword import iskeyword
from typing import cast

from rai_missions.cli.command import Command, Parser

__all__ = ("load_command", "names", "root_parser", "whole_parser")

ABOUT = "Missions for robots: rules own the state, models only answer questions."
AFTER = (
    "'rai-missions COMMAND --help' explains a command.\n\n"
    "exit status: 0 it succeeded or holds, 1 it ended otherwise or does not hold, 2 the input is at fault, "
    "130 it was cut short by Ctrl-C"
)


def names() -> tuple[str, ...]:
    """All commands."""
    files = (file for folder in __path__ for file in os.listdir(folder))
    return tuple(
        sorted(file.removesuffix(".py").rstrip("_") for file in files if file.endswith(".py") and file != "__init__.py")
    )


def load_command(name: str) -> Command:
    """Import a command; the module of one that is a word of Python, such as `try`, ends with `_`."""
    own = f"{name}_" if iskeyword(name) else name
    return cast(Command, getattr(importlib.import_module(f"{__name__}.{own}"), own))


def root_parser() -> Parser:
    """What reads a command line up to its command."""
    return _parser(lambda command, add: add())


def whole_parser(complete: Callable[..., object]) -> Parser:
    """What reads the whole command line, for a shell to complete.

    Args:
        complete: What a shell completes, given patterns of files.
    """
    return _parser(lambda command, add: command.configure(add(**command.texts()), complete))


def _parser(configure: Callable[[Command, Callable[..., Parser]], object]) -> Parser:
    parser = Parser(prog="rai-missions", description=ABOUT, epilog=AFTER)
    parser.add_argument("--version", action="store_true", help="print the version")
    commands = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND")
    for name in names():
        command = load_command(name)
        summary = command.summary[0].lower() + command.summary[1:].rstrip(".")
        configure(command, partial(commands.add_parser, name, help=summary))
    return parser
