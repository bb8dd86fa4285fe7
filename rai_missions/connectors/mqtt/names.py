# SPDX-License-Identifier: Apache-2.0
"""Which names MQTT takes for a topic or a service."""

from __future__ import annotations

import unicodedata

from rai_missions.connectors.connector import TypeKind
from rai_missions.errors import ConnectorError
from rai_missions.redaction import cut_repr

__all__ = ("REQUEST", "check_name", "why_no_name")

REQUEST = "/request"
"""Ends the topic on which a service is asked."""
LONGEST = 65_535 - len(REQUEST)
"""Bytes of a name, MQTT 5, 1.5.4."""
WILDCARDS = "+#"


def why_no_name(name: str, kind: TypeKind) -> str:
    """Why MQTT takes no such name, in a sentence; empty if it does."""
    shown = cut_repr(name, 80)
    if kind == "action":
        return f"MQTT carries no actions, and so not {name}; compose it of services"
    if not name:
        return "a name of MQTT has at least one character"
    if any(each in name for each in WILDCARDS):
        return f"{shown} is no name in MQTT: '+' and '#' mean many topics; name each by itself"
    if strange := next((each for each in name if not _is_text(each)), ""):
        return f"{shown} is no name in MQTT: U+{ord(strange):04X} in it is no character of a text"
    if len(name.encode()) > LONGEST:
        return f"{shown} is no name in MQTT: it has more than {LONGEST} bytes"
    return ""


def _is_text(character: str) -> bool:
    """A broker may end the connection of one who sends control characters and the like, MQTT 5, 1.5.4."""
    code = ord(character)
    is_none = code & 0xFFFE == 0xFFFE or 0xFDD0 <= code <= 0xFDEF
    return not is_none and unicodedata.category(character) not in ("Cc", "Cs")


def check_name(name: str) -> None:
    """Raises `ConnectorError` where MQTT does not take the name of a topic or a service."""
    if why := why_no_name(name, "msg"):
        raise ConnectorError(why)
