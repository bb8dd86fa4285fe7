# SPDX-License-Identifier: Apache-2.0
"""What each command of the command line does, one room a family; a room is loaded when its command runs."""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable, Mapping
from typing import cast

__all__ = ("COMMANDS", "command")

COMMANDS: Mapping[str, str] = {
    "run": "run.run", "check": "review.check_mission", "draw": "review.draw", "diff": "difference.diff",
    "textconv": "difference.textconv",
    "replay": "replay.replay", "schema": "workbench.schema", "new": "workbench.new", "doctor": "workbench.doctor",
    "prove": "prove.prove",
    "world": "world.world", "gate": "gate.gate", "watch": "watch.watch",
}  # fmt: skip
"""Command → its room and function."""


def command(name: str) -> Callable[[argparse.Namespace], int]:
    """What a command does, given its words; returns the exit status."""
    room, function = COMMANDS[name].split(".")
    module = importlib.import_module(f"rai_missions.commands.{room}")
    return cast(Callable[[argparse.Namespace], int], getattr(module, function))
