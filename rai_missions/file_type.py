# SPDX-License-Identifier: Apache-2.0
"""What stands at a path: only of a regular file is anything read, since a pipe or a device may never end.

Rule: whoever opens a file that a person has named asks here first, and reports what it is instead.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

__all__ = ("irregular",)

SORTS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a named pipe (FIFO)"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def irregular(path: Path | str) -> str:
    """What there is instead of a regular file, links followed: a folder, a named pipe (FIFO), a socket or a device.

    Empty for a regular file, and where there is nothing or nobody can say. Nothing is opened, so nothing can block.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return ""
    return next((name for is_so, name in SORTS if is_so(mode)), "")
