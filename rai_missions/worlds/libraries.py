# SPDX-License-Identifier: Apache-2.0
"""How the libraries of a simulated world behave in this process.

Rule: they read it from the environment when they are imported, so a world decides it before that.
"""

from __future__ import annotations

import os
import sys

from rai_missions.connectors.process.idle_threads import let_idle_threads_sleep

__all__ = ("configure_libraries",)


def configure_libraries() -> None:
    """Render without a display, and let idle threads sleep, unless the environment has it otherwise."""
    let_idle_threads_sleep()
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
