# SPDX-License-Identifier: Apache-2.0
"""What is wrong with how a profile reaches its robot, found without reaching it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rai_missions.connectors.registry import check_connector, check_options, connector_offer
from rai_missions.errors import Fault, UsageError
from rai_missions.mission.mission import Mission
from rai_missions.profile.endpoints import lacking, misnamed
from rai_missions.profile.message_fields import unknown_fields
from rai_missions.profile.profile import Robot
from rai_missions.worlds.world import check_local

__all__ = ("connector_faults", "field_faults", "middleware_faults")


def connector_faults(robot: Robot) -> Iterator[Fault]:
    """A kind of connector, a simulated world, an option of one, or a name there, that there is not."""
    connector = robot.connector
    kind, options = str(connector["kind"]), {word: each for word, each in connector.items() if word != "kind"}
    try:
        offer = check_connector(kind)
    except UsageError as error:
        yield Fault("/connector/kind", str(error))
        return
    try:
        if offer is not None:
            check_options(offer, options)
            yield from _name_faults(robot, offer.load())
        elif kind == "local":
            check_local(options)
    except UsageError as error:
        yield Fault("/connector", str(error))


def middleware_faults(mission: Mission, robot: Robot) -> tuple[Fault, ...]:
    """What the robot's middleware on this machine has no place for: names, types of messages, and fields of these.

    Args:
        mission: What is to run.
        robot: On which robot; what is inside this process has no middleware.

    Raises:
        UsageError: The package of its connector does not load.
    """
    offer = connector_offer(str(robot.connector["kind"]))
    package: Any = offer.load() if offer is not None else None
    if found := _name_faults(robot, package):
        return found
    if not hasattr(package, "why_absent"):
        return ()
    return (*lacking(mission, robot, package.why_absent), *_field_faults(mission, robot, package))


def field_faults(mission: Mission | None, robot: Robot) -> tuple[Fault, ...]:
    """The types that no machine has, and the fields that types lack; those absent here are left to the robot's machine.

    Args:
        mission: What is to run; without one everything that the profile names is looked at.
        robot: On which robot; none are found while its connector has faults of its own.
    """
    try:
        offer = check_connector(str(robot.connector["kind"]))
        package: Any = offer.load() if offer is not None else None
    except UsageError:
        return ()
    why_no_type = getattr(package, "why_no_type", None)
    unknown = lacking(mission, robot, why_no_type) if why_no_type is not None else ()
    return (*unknown, *_field_faults(mission, robot, package))


def _field_faults(mission: Mission | None, robot: Robot, package: Any) -> tuple[Fault, ...]:
    fields_of = getattr(package, "fields_of", None)
    return unknown_fields(mission, robot, fields_of) if fields_of is not None else ()


def _name_faults(robot: Robot, package: Any) -> tuple[Fault, ...]:
    """The names that a middleware has no place for; none where its package names no rule for them."""
    why_no_name = getattr(package, "why_no_name", None)
    return misnamed(robot, why_no_name) if why_no_name is not None else ()
