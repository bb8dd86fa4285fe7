# SPDX-License-Identifier: Apache-2.0
"""Where a run is: its world, how the robot is reached, and whose time counts.

Rule: what is opened enters the stack of the run at once, which closes it whatever happens in between.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.agents.run_plan import CleanupStack, RunPlan
from rai_missions.connectors.connector import Connector
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.python_robot import PythonRobot, PythonRobotConnector, RobotTime
from rai_missions.connectors.registry import check_connector, open_offered
from rai_missions.errors import UsageError
from rai_missions.keys import Key
from rai_missions.kinds import PackageOffer
from rai_missions.profile import Robot, middleware_faults
from rai_missions.profile.python_robot import KIND
from rai_missions.redaction import logger
from rai_missions.runtime.clock import Clock, PublishedClock, SimulatedClock, WallClock
from rai_missions.runtime.robot_clock import RobotClock
from rai_missions.worlds.world import World, check_local, continued_options, open_world, put_on, world_offer

__all__ = ("RunEnvironment", "open_environment")

log = logger(__name__)
SLOW = "fact '%s' is read every %g s, and is stale after %g s: in between it is unknown; read it more often (every_s)"


class RunEnvironment(NamedTuple):
    """The world, how it is reached, and whose time counts."""

    world: World | None
    connector: Connector | None
    clock: Clock
    packages: Mapping[str, str] = {}
    """Other packages that they and the answerers come from, and their versions."""


def open_environment(plan: RunPlan, closing: CleanupStack) -> RunEnvironment:
    """Open what a run is made in: a world, a robot in this process, or a middleware.

    Raises:
        DefinitionError: The robot lacks what the mission uses.
        UsageError: Something named is not there.
    """
    config = plan.config
    if plan.python is not None and config.connector is None:
        return _open_python(plan, plan.python)
    if config.opened is not None and plan.robot is not None:
        plan.refuse(middleware_faults(plan.mission, plan.robot), config.robot)
    if (connector := config.connector or config.opened) is not None or plan.robot is None:
        return RunEnvironment(None, connector, plan.continued(config.clock or WallClock()))
    options = dict(plan.robot.connector)
    kind, world = str(options.pop("kind")), options.pop("world", None)
    if (offer := check_connector(kind)) is not None:
        return _open_connector(plan, plan.robot, offer, options, closing)
    if kind == KIND:
        raise UsageError("a profile cannot name a robot in Python; a person does: --robot FILE.py")
    if world is None:
        check_local(options)
        clock = plan.continued(config.clock or WallClock())
        return RunEnvironment(None, LocalConnector(now=clock.now), clock)
    return _open_world(plan, str(world), options, closing)


def _open_python(plan: RunPlan, robot: PythonRobot) -> RunEnvironment:
    """A robot whose functions execute in this process: by the wall, or as fast as they wait."""
    given, speed = plan.config.clock, plan.config.speed
    robot_time = RobotTime(steered=given is None and speed not in (None, 1.0))
    steered = RobotClock(robot_time, speed or math.inf) if robot_time.is_steered else WallClock()
    clock = plan.continued(given or steered)
    keys = plan.mission.keys_of("robot")
    _name_slow_facts(robot, keys)
    connector = PythonRobotConnector(robot, now=clock.now, robot_time=robot_time, events=plan.mission.events, keys=keys)
    return RunEnvironment(None, connector, clock)


def _name_slow_facts(robot: PythonRobot, keys: Mapping[str, Key]) -> None:
    for name, key in keys.items():
        fact = robot.fact_functions.get(name)
        if fact is not None and fact.read is not None and key.max_age_s is not None and fact.every_s >= key.max_age_s:
            log.warning(SLOW, name, fact.every_s, key.max_age_s)


def _open_connector(
    plan: RunPlan, robot: Robot, offer: PackageOffer, options: Mapping[str, Any], closing: CleanupStack
) -> RunEnvironment:
    """A robot that is reached by a middleware."""
    given = plan.config.clock
    published = PublishedClock() if given is None and options.get("sim_time") is True else None
    clock = plan.continued(published or given or WallClock())
    connector = open_offered(offer, options, now=clock.now)
    plan.refuse(middleware_faults(plan.mission, robot), plan.config.robot)
    if published is not None:
        connector.start()
        closing.closes(connector.stop)
        published.follow(connector)
    return RunEnvironment(None, connector, clock, _packages(offer))


def _open_world(plan: RunPlan, name: str, options: dict[str, Any], closing: CleanupStack) -> RunEnvironment:
    """A simulated world."""
    config = plan.config
    if plan.resumed is not None:  # its clock continues, and all else in it begins again
        options = continued_options(name, options, plan.resumed.resumption.at)
    world = open_world(name, **options)
    closing.closes(world.close)
    connector = LocalConnector(now=lambda: world.at)
    put_on(connector, name, world)
    return RunEnvironment(
        world,
        connector,
        config.clock or SimulatedClock(world, math.inf if config.speed is None else config.speed),
        _packages(world_offer(name)),
    )


def _packages(offer: PackageOffer | None) -> Mapping[str, str]:
    return {offer.package: offer.version} if offer is not None and offer.version else {}
