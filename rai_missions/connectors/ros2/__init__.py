# SPDX-License-Identifier: Apache-2.0
"""The connector to ROS 2, over the real rclpy; importing this room loads nothing of ROS.

Rule: rclpy is known in this room only, and comes in when a connector is opened.

Imports the modules of the root only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal

from rai_missions.connectors.connector import Connector, TypeKind
from rai_missions.errors import ConnectorError, UsageError, install_command

__all__ = (
    "check_options",
    "fields_of",
    "how_to_install",
    "installation",
    "open_connector",
    "why_absent",
    "why_no_name",
    "why_no_type",
)

REPLIES = {"srv": "response"}


def open_connector(options: Mapping[str, Any], *, now: Callable[[], float] | None = None) -> Connector:
    """A connector to the ROS 2 graph, not started.

    Args:
        options: What a profile's `connector` states besides its `kind`; see `config.Options`.
        now: Seconds on the run's clock; stamps what is received. Left out, ROS time.

    Raises:
        UsageError: rclpy is not here, or an option is not understood.
    """
    try:
        import rclpy  # noqa: F401 - only whether it loads
    except (ImportError, OSError) as fault:
        raise UsageError(
            f"a connector of kind 'ros2' needs rclpy, which does not load ({fault}): {how_to_install()}"
        ) from fault
    from rai_missions.connectors.ros2.connector import Ros2Connector

    return Ros2Connector(options, now=now)


def how_to_install() -> str:
    """How rclpy comes to a machine that lacks it."""
    wheels = install_command("ros")
    return f"source a robot's own ROS 2 (source /opt/ros/jazzy/setup.bash), or, without one, {wheels}; never both"


def check_options(options: Mapping[str, Any]) -> None:
    """Whether a profile's words are understood, without ROS.

    Raises:
        UsageError: One is not.
    """
    from rai_missions.connectors.ros2.config import read_options

    read_options(options)


def installation() -> dict[str, str]:
    """The `file` that rclpy was loaded from, and the middleware (`rmw`) that it uses.

    Raises:
        ImportError: rclpy is not here.
        OSError: One of its libraries is not.
    """
    import rclpy
    from rclpy.utilities import get_rmw_implementation_identifier

    return {"file": str(rclpy.__file__), "rmw": str(get_rmw_implementation_identifier())}


def fields_of(type_name: str, part: Literal["msg", "srv", "request", "goal", "result"]) -> Mapping[str, Any] | None:
    """The fields of a message, of a service's reply (`srv`) or request, or of an action's goal or result.

    Returns:
        As `types.describe_type` reports them; None if it cannot, as without rclpy, or the type has no such part.
    """
    try:
        from rai_missions.connectors.ros2.types import describe_type

        description = describe_type(type_name)
    except (ConnectorError, ImportError, OSError):
        return None
    fields: Mapping[str, Any] | None = description if part == "msg" else description.get(REPLIES.get(part, part))
    return fields


def why_absent(type_name: str, kind: TypeKind) -> str:
    """Why a type of messages is not to be had on this machine, in a sentence; empty if it is."""
    from rai_missions.connectors.ros2 import names

    return names.why_absent(type_name, kind)


def why_no_type(type_name: str, kind: TypeKind) -> str:
    """Why no machine has a type of messages, in a sentence; empty if one may have it."""
    from rai_missions.connectors.ros2 import names

    return names.why_no_type(type_name, kind)


def why_no_name(name: str, kind: TypeKind) -> str:
    """Why ROS takes no such name, in a sentence; empty if it does, and on a machine without rclpy."""
    from rai_missions.connectors.ros2 import names

    try:
        names.check_name(name, kind)
    except (ImportError, OSError):
        return ""
    except ConnectorError as fault:
        return str(fault)
    return ""
