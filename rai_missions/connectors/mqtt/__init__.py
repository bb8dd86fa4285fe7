# SPDX-License-Identifier: Apache-2.0
"""The connector to an MQTT 5 broker; importing this room loads nothing of paho.

Imports the modules of the root only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Connector
from rai_missions.connectors.mqtt.connector import MqttConnector, read_options
from rai_missions.connectors.mqtt.names import why_no_name

__all__ = ("check_options", "open_connector", "why_no_name")


def open_connector(options: Mapping[str, Any], *, now: Callable[[], float] | None = None) -> Connector:
    """A connector to a broker, not started.

    Args:
        options: What a profile's `connector` has besides its `kind`: `host` (127.0.0.1), `port` (1883).
        now: Seconds on the run's clock; stamps what is received. Left out, the time of day.

    Raises:
        UsageError: An option is not known, or has a value that it cannot have.
    """
    return MqttConnector(options, now=now)


def check_options(options: Mapping[str, Any]) -> None:
    """Whether a profile's words are understood; raises as `open_connector` does."""
    read_options(options)
