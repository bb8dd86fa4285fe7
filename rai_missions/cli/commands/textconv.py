# SPDX-License-Identifier: Apache-2.0
"""`rai-missions textconv`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("textconv",)


@command(draws=True, only_reads=True)
def textconv(file: Annotated[Path, Argument("FILE", files=("*.json",))]) -> int:
    """Print a mission as text, one thing a line, for git diff.

    Git uses it after: git config diff.mission.textconv 'rai-missions textconv'.

    Args:
        file: A .json mission. Any other file is printed as it is.

    Exit status:
        0 it was printed, 2 the input is at fault

    Example:
        rai-missions textconv mission.json
    """
    import sys

    from rai_missions.errors import MissionError, irregular
    from rai_missions.mission.include import read_mission
    from visualize.outline import outline

    try:
        text = outline(read_mission(file))
    except MissionError:
        if irregular(file) or not file.exists():
            raise
        text = file.read_text(encoding="utf-8", errors="replace")
    sys.stdout.write(text)
    return 0
