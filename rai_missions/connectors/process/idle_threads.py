# SPDX-License-Identifier: Apache-2.0
"""What the threads of numpy do in this process while there is nothing to multiply."""

from __future__ import annotations

import os

__all__ = ("let_idle_threads_sleep",)


def let_idle_threads_sleep() -> None:
    """Let idle threads of OpenBLAS sleep, unless the environment has it otherwise; before numpy is imported.

    OpenBLAS, with which numpy multiplies, has a thread for each core. Each of them spins for 2^26 cycles before it
    sleeps: when numpy is imported, and after each product that it took part in. 2^4 is the least that it accepts.
    """
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")
