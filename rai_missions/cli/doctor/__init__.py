# SPDX-License-Identifier: Apache-2.0
"""What this machine has, what it lacks, and how to get it.

Rule: whatever may crash or hang is tried in a process of its own, within seconds.

Imports `agents`, `answerers`, `connectors`, `mission`, `profile`, `states`, `visualize`, `voice` and `worlds`, and the
modules of the root.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rai_missions.cli.doctor.finding import MachineFinding
from rai_missions.cli.doctor.machine import machine
from rai_missions.cli.doctor.mission import answerers
from rai_missions.cli.doctor.robot import loads, reach
from rai_missions.cli.doctor.ros import ros
from rai_missions.cli.doctor.speech import speech
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot

__all__ = ("MachineFinding", "examine")


def examine(robot: Robot | Path | None, *, mission: Mission | None, voice: bool) -> Iterator[MachineFinding]:
    """Look at everything that this project uses, and at a robot where one is given: its profile, or its Python file.

    Args:
        robot: Looked at as well.
        mission: Whose answerers of other packages are looked at as well.
        voice: So is what listens and speaks.
    """
    yield from machine()
    yield from ros()
    if voice:
        yield from speech()
    if mission is not None:
        yield from answerers(mission)
    if isinstance(robot, Path):
        yield loads(robot)
    elif robot is not None:
        yield from reach(robot)
