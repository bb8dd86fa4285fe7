# SPDX-License-Identifier: Apache-2.0
"""`rai-missions world`."""

from __future__ import annotations

from typing import Annotated

from rai_missions.cli.command import Argument, command, read_speed

__all__ = ("world",)


@command()
def world(
    world: Annotated[str, Argument("WORLD")],
    *,
    ros: bool = False,
    domain: Annotated[int | None, Argument("N")] = None,
    seed: Annotated[int | None, Argument("N")] = None,
    speed: Annotated[float, Argument("1|N|max", parse=read_speed)] = 1.0,
    option: tuple[Annotated[str, Argument("KEY=VALUE")], ...] = (),
    no_camera: bool = False,
) -> int:
    """Put a simulated robot on ROS, in a process of its own.

    Args:
        world: desk, house or orchard, or a world of another package.
        ros: On the ROS 2 graph.
        domain: The ROS domain, instead of ROS_DOMAIN_ID.
        seed: Decides what no option sets. Without it: the world's own seed.
        speed: Simulated seconds for each second of wall time; missions follow /clock.
        option: An option of the world, as JSON: alleys=2, obstacles='["branch", "none"]'; may be repeated.
        no_camera: No pictures and no detected obstacles; needs no OpenGL.

    Exit status:
        0 it was ended (Ctrl-C, SIGTERM), 2 the input is at fault

    Example:
        rai-missions world orchard --ros --option alleys=2
    """
    from rai_missions.cli.inputs import read_pairs
    from rai_missions.cli.world_server import serve_world
    from rai_missions.errors import UsageError
    from rai_missions.worlds.world import check_world

    check_world(world)
    if not ros:
        raise UsageError(
            f"name where the world is to run: 'rai-missions world {world} --ros' puts it on the ROS graph; "
            "in one process with its mission a profile opens it: "
            "rai-missions run missions/tractor/mission.json --robot missions/tractor/robot.sim.json"
        )
    options = read_pairs("--option", option)
    if seed is not None:
        options["seed"] = seed
    if no_camera:
        options["camera"] = False
    return serve_world(world, options, domain=domain, speed=speed)
