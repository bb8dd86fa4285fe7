# SPDX-License-Identifier: Apache-2.0
"""How the libraries of a simulated world behave in this process.

Rule: they read it from the environment when they are imported, so a world decides it before that.
"""

from __future__ import annotations

import os
import sys

__all__ = ("configure_libraries",)


def configure_libraries() -> None:
    """Render without a display, and let idle threads sleep, unless the environment has it otherwise.

    OpenBLAS, with which numpy multiplies, has a thread for each core. Each of them spins for 2^26 cycles before it
    sleeps: when numpy is imported, and after each product that it took part in. 2^4 is the least that it accepts.
    """
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
