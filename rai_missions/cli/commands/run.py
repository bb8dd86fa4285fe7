# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run`."""

from __future__ import annotations

from rai_missions.cli.command import command
from rai_missions.cli.run.options import RunOptions

__all__ = ("run",)


@command(draws=True)
def run(options: RunOptions) -> int:
    """Run a mission on a robot, simulated or real.

    Ctrl-C cancels the mission; a second Ctrl-C is an e-stop.

    Exit status:
        0 the mission succeeded, 1 it ended otherwise, 2 the input is at fault

    Example:
        rai-missions run mission.json --robot robot.json --set alleys=3
        rai-missions run --resume journals/tractor-20260101-090000-4711.journal
    """
    from rai_missions.cli.output import nonblocking_output
    from rai_missions.mission.garbage import few_collections

    with few_collections():
        from rai_missions.cli.run.mission_run import run_mission

    with nonblocking_output():
        return run_mission(options)
