# SPDX-License-Identifier: Apache-2.0
"""Goal ids as ROS carries them: sixteen bytes, and the same text again on the other side where there is room."""

from __future__ import annotations

import string
import uuid

__all__ = ("to_bytes", "to_text")

HEX = frozenset("0123456789abcdef")
READABLE = frozenset(string.ascii_letters + string.digits + "-_./:")


def to_bytes(goal_id: str) -> bytes:
    """The id of a unique_identifier_msgs/UUID: 32 hex digits as they are, up to 15 letters padded, all else hashed."""
    if len(goal_id) == 32 and HEX.issuperset(goal_id):
        return bytes.fromhex(goal_id)
    if 0 < len(goal_id) < 16 and READABLE.issuperset(goal_id):
        return goal_id.encode().ljust(16, b"\0")
    return uuid.uuid5(uuid.NAMESPACE_URL, goal_id).bytes


def to_text(given: bytes) -> str:
    """The id that `to_bytes` was given, or 32 hex digits."""
    text = given.rstrip(b"\0").decode("latin-1")
    return text if 0 < len(text) < 16 and READABLE.issuperset(text) else given.hex()
