# SPDX-License-Identifier: Apache-2.0
"""How pictures are rendered on this machine.

Rule: MuJoCo reads the choice when it is imported, so a world makes it before that.
"""

from __future__ import annotations

import os
import sys

__all__ = ("choose_renderer",)


def choose_renderer() -> None:
    """Without a display, render through EGL, unless `MUJOCO_GL` reports otherwise."""
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
