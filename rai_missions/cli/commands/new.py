# SPDX-License-Identifier: Apache-2.0
"""`rai-missions new`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("new",)


@command()
def new(
    directory: Annotated[Path, Argument("DIRECTORY", files=("*/",))],
    *,
    template: Annotated[str, Argument("NAME")] = "minimal",
) -> int:
    """Start a mission of your own from a template.

    Args:
        directory: The folder to make. It must not exist yet, or be empty.
        template: minimal, or a mission that is shipped: rosbot, tractor.

    Exit status:
        0 the files were made, 2 the input is at fault

    Example:
        rai-missions new my_mission --template tractor
    """
    from rai_missions.cli.templates import copy_template

    for path in copy_template(template, directory):
        print(path)
    print(f"next: rai-missions check {directory}/mission.json")
    return 0
