# SPDX-License-Identifier: Apache-2.0
"""`rai-missions doctor`."""

from __future__ import annotations

from rai_missions.cli.command import ProfileFile, command

__all__ = ("doctor",)


@command()
def doctor(*, robot: ProfileFile | None = None) -> int:
    """Check what this machine has, what it lacks and how to get it.

    Args:
        robot: Check also whether the profile's message types are installed, and whether its topics, services and
            actions are there.

    Exit status:
        0 nothing that is needed is missing, 1 something is, 2 the input is at fault

    Example:
        rai-missions doctor --robot robot.json
    """
    from rai_missions.cli.doctor import examine
    from rai_missions.profile import load_profile

    is_missing = False
    for finding in examine(load_profile(robot) if robot else None):
        print(finding, flush=True)
        is_missing |= finding.status == "missing"
    return int(is_missing)
