# SPDX-License-Identifier: Apache-2.0
"""What each command of the command line does, one room a family; a room is loaded when its command runs.

Imports `agents`, `answerers`, `check`, `connectors`, `engine`, `gate`, `journal`, `mission`, `node`, `profile`,
`prove`, `recording`, `replay`, `runtime`, `visualize` and `worlds`, and the modules of the root.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable, Mapping
from typing import cast

__all__ = ("COMMANDS", "command")

COMMANDS: Mapping[str, str] = {
    "run": "run.run", "check": "check_draw.check_mission", "draw": "check_draw.draw", "diff": "diff.diff",
    "textconv": "diff.textconv",
    "replay": "replay.replay", "schema": "schema_new_doctor.schema", "new": "schema_new_doctor.new",
    "doctor": "schema_new_doctor.doctor",
    "prove": "prove.prove",
    "world": "world.world", "gate": "gate.gate", "watch": "watch.watch",
}  # fmt: skip
"""Command → its room and function."""


def command(name: str) -> Callable[[argparse.Namespace], int]:
    """What a command does, given its words; returns the exit status."""
    room, function = COMMANDS[name].split(".")
    module = importlib.import_module(f"rai_missions.cli.commands.{room}")
    return cast(Callable[[argparse.Namespace], int], getattr(module, function))
