# SPDX-License-Identifier: Apache-2.0
"""`rai-missions new`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("new",)


@command()
def new(
    directory: Annotated[Path | None, Argument("DIRECTORY", files=("*/",))] = None,
    *,
    template: Annotated[str, Argument("NAME")] = "delivery",
    list: bool = False,  # noqa: A002 - the word of the command line
) -> int:
    """Start a mission of your own from a template.

    It makes the mission, a robot simulated in Python, a profile for ROS, the schemas, a README and a test. The mission
    has the name of the folder.

    Args:
        directory: The folder to make. It must not exist yet, or be empty.
        template: delivery, patrol, pick_and_place, python (the mission in Python), or a shipped example: desk,
            rosbot, tractor.
        list: Print what there is to begin from.

    Exit status:
        0 the files were made, 2 the input is at fault

    Example:
        rai-missions new my_mission --template patrol
    """
    from rai_missions.cli.templates import copy_template, templates
    from rai_missions.errors import UsageError

    if list:
        width = max(map(len, templates()))
        for each in templates().values():
            print(f"{each.name:{width}}  {'example: ' if each.is_example else ''}{each.about}")
        return 0
    if directory is None:
        raise UsageError("name the folder to make: rai-missions new my_mission")
    print(*copy_template(template, directory), sep="\n")
    chosen = templates()[template]
    print(f"\nnext:\n  cd {shlex.quote(str(directory))}\n  rai-missions run {chosen.mission} --robot {chosen.robot}")
    return 0
