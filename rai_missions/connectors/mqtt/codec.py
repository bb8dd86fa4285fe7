# SPDX-License-Identifier: Apache-2.0
"""Messages as JSON and back; bytes and pictures in base64."""

from __future__ import annotations

import base64
import json
from array import array
from collections.abc import Mapping
from typing import Any

from rai_missions.connectors.connector import Data
from rai_missions.errors import ConnectorError
from rai_missions.image import Image
from rai_missions.redaction import cut, cut_repr

__all__ = ("decode", "encode")

BYTES, IMAGE = "$bytes", "$image"


def encode(message: Data) -> bytes:
    """Plain data as JSON; bytes and pictures in base64.

    Raises:
        ConnectorError: It is no plain data.
    """
    try:
        return json.dumps(message, default=_jsonable).encode()
    except (TypeError, ValueError, RecursionError) as fault:
        raise ConnectorError(f"a message is no plain data: {fault}") from None


def decode(payload: bytes) -> dict[str, Any]:
    """What `encode` was given.

    Raises:
        ConnectorError: It is no JSON object.
    """
    try:
        content = json.loads(payload, object_hook=_from_json)
    except (ValueError, TypeError, RecursionError) as fault:
        raise ConnectorError(f"a message is no JSON: {cut(fault, 120)}") from None
    if not isinstance(content, dict):
        raise ConnectorError(f"{cut_repr(payload, 40)} is given where a JSON object belongs")
    return content


def _jsonable(value: Any) -> Any:
    if isinstance(value, bytes | bytearray | memoryview):
        return {BYTES: base64.b64encode(bytes(value)).decode()}
    if isinstance(value, Image):
        return {IMAGE: [value.ref, value.width, value.height, value.encoding, base64.b64encode(value.data).decode()]}
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, array):
        return value.tolist()
    raise TypeError(f"{cut_repr(value, 60)} is a {type(value).__name__}")


def _from_json(content: dict[str, Any]) -> Any:
    if content.keys() == {BYTES}:
        return base64.b64decode(content[BYTES], validate=True)
    if content.keys() == {IMAGE}:
        ref, width, height, encoding, data = content[IMAGE]
        if not (isinstance(ref, str) and isinstance(encoding, str) and type(width) is type(height) is int):
            raise ValueError("a picture whose size or name is none")
        return Image(ref, width, height, encoding, base64.b64decode(data, validate=True))
    return content
