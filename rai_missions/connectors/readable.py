# SPDX-License-Identifier: Apache-2.0
"""Which files can be read now.

Rule: `select.select` fails for the 1,025th file a process has open; a program that hosts a mission may have as many.
"""

from __future__ import annotations

import math
import select

__all__ = ("readable",)


def readable(*files: int, within_s: float = math.inf) -> frozenset[int]:
    """Wait until one of `files` can be read or is at its end; those that are. None within `within_s` seconds."""
    poll = select.poll()
    for file in files:
        poll.register(file, select.POLLIN)
    return frozenset(file for file, _ in poll.poll(None if math.isinf(within_s) else 1000.0 * within_s))
