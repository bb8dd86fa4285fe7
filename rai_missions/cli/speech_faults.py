# SPDX-License-Identifier: Apache-2.0
"""What fails of that which listens and speaks, for the terminal."""

from __future__ import annotations

import sys

__all__ = ("SpeechFaults",)


class SpeechFaults:
    """Faults of what listens and speaks, each printed once; one that keeps it from its begin is raised instead.

    Args:
        command: Whose line on stderr it is.
    """

    def __init__(self, command: str) -> None:
        self._command = command
        self._printed, self._begun = set[str](), False

    def begin(self) -> None:
        """All that listens is ready."""
        self._begun = True

    def take(self, fault: str) -> None:
        """Print a fault, unless it is empty or was printed."""
        if self._begun and fault and fault not in self._printed:
            self._printed.add(fault)
            print(f"rai-missions {self._command}: {fault}", file=sys.stderr, flush=True)
