# SPDX-License-Identifier: Apache-2.0
"""`rai-missions gate`."""

from __future__ import annotations

from rai_missions.cli.command import command
from rai_missions.cli.gate_options import GateOptions

__all__ = ("gate",)


@command()
def gate(options: GateOptions) -> int:
    """Let only the holder of control command a robot's actuators.

    The gate receives the commands of autonomy, agent and operator, each on topics of its own (/gate/agent/cmd_vel →
    /cmd_vel), and passes on only those of the holder of control.

    Exit status:
        0 it was ended (Ctrl-C, SIGTERM), 1 another gate is there already, 2 the input is at fault

    Example:
        rai-missions gate --command /cmd_vel=geometry_msgs/msg/Twist --lease agent=0.5
    """
    from rai_missions.cli.gate_console import serve_gate

    return serve_gate(options)
