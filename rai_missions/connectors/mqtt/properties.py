# SPDX-License-Identifier: Apache-2.0
"""What accompanies a request and its reply, as properties of MQTT 5."""

from __future__ import annotations

import math
import time
from typing import Any

__all__ = ("key_of", "late_s", "reply_properties", "reply_topic", "request_properties")

EXPIRES_AT = "expires_at"
"""The user property of a request that states until when its reply is awaited, in seconds since 1970."""
LONGEST_EXPIRY_S = 0xFFFF_FFFF
"""MQTT 5, 3.3.2.3.3: a number of four bytes."""


def request_properties(key: bytes, replies_to: str, timeout_s: float | None) -> Any:
    """The properties of a request; after the timeout no one awaits its reply.

    The broker drops it then, in whole seconds: a device may come back much later. One that hung with its connection
    open has it already, and looks at the time of day.
    """
    expiry: dict[str, Any] = {}
    if timeout_s is not None:
        expiry["MessageExpiryInterval"] = math.ceil(min(max(timeout_s, 1), LONGEST_EXPIRY_S))
        expiry["UserProperty"] = (EXPIRES_AT, f"{time.time() + timeout_s:.3f}")
    return _properties(CorrelationData=key, ResponseTopic=replies_to, **expiry)


def reply_properties(request: Any) -> Any:
    """The properties of the reply to a request."""
    return _properties(CorrelationData=key_of(request))


def reply_topic(request: Any) -> str:
    """Where a request's sender awaits the reply; empty if it does not."""
    return getattr(request.properties, "ResponseTopic", "")


def key_of(message: Any) -> bytes:
    """What a request and its reply have in common; empty if the message brings none."""
    return getattr(message.properties, "CorrelationData", b"")


def late_s(request: Any) -> float:
    """For how many seconds no one has awaited the reply to a request, by the time of day; negative before."""
    words = dict(getattr(request.properties, "UserProperty", ()))
    try:
        return time.time() - float(words.get(EXPIRES_AT, "inf"))
    except ValueError:
        return -math.inf


def _properties(**words: Any) -> Any:
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.properties import Properties

    made = Properties(PacketTypes.PUBLISH)
    for word, value in words.items():
        setattr(made, word, value)
    return made
