# SPDX-License-Identifier: Apache-2.0
"""What `rai-missions gate` takes: its options, with their help."""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from rai_missions.cli.command import Argument

__all__ = ("GateOptions",)


class GateOptions(NamedTuple):
    """What a gate takes.

    Args:
        ros: On the ROS 2 graph, which is the default.
        file: All of these options in a file, and what stops each topic.
        command: A command topic of the actuators; may be repeated. Without it: /cmd_vel=geometry_msgs/msg/Twist.
        lease: A holder that sends nothing for so many seconds loses control; 0 is never; may be repeated. Without it:
            agent=0.5.
        safe: Who has control then, and at first. Without it: autonomy.
        memory: The file that keeps who holds control, for a gate that is started again. Without it: a file for each
            name and ROS domain below ~/.local/state/rai_missions.
        name: The first part of the names of the gate's topics and services. Without it: /gate.
        domain: The ROS domain, instead of ROS_DOMAIN_ID.
        sim_time: The stamps of commands are simulated time, as on /clock.
        log: Write every command and handover to this file, a JSON object a line.
        quiet: Print nothing.
    """

    ros: bool = False
    file: Annotated[str | None, Argument("FILE.json", files=("*.json",))] = None
    command: tuple[Annotated[str, Argument("TOPIC=TYPE")], ...] = ()
    lease: tuple[Annotated[str, Argument("HOLDER=SECONDS")], ...] = ()
    safe: Literal["autonomy", "nobody"] | None = None
    memory: Annotated[str | None, Argument("FILE", files=("*",))] = None
    name: Annotated[str | None, Argument("NAME")] = None
    domain: Annotated[int | None, Argument("N")] = None
    sim_time: bool = False
    log: Annotated[str | None, Argument("FILE", files=("*",))] = None
    quiet: bool = False
