# SPDX-License-Identifier: Apache-2.0
"""Hostile input made by hand, for the targets of the fuzzing: `made(target)` gives each under its name."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tests.fuzz.seeds import seeds

__all__ = ("made",)

DEEP = 100_000
BOMB = b"\x28\xb5\x2f\xfd\xe0" + (3 << 30).to_bytes(8, "little") + b"\x03\x00\x08" * 2
"""How a Zstandard frame of 3 GiB begins (RFC 8878, section 3.1.1)."""


def _missions() -> dict[str, bytes]:
    good = next(seeds("mission"))
    lamp: dict[str, Any] = json.loads(list(seeds("mission"))[-1])
    states = {f"s{number}": {"transitions": [{"to": f"s{(number + 1) % 20_000}"}]} for number in range(20_000)}
    return {
        "nothing": b"",
        "zeros": bytes(100_000),
        "no text": b"\xff\xfe\xfa",
        "deep lists": b"[" * DEEP,
        "deep objects": b'{"states":' * DEEP,
        "deep guards": json.dumps({**lamp, "invariants": {"deep": _nested(90)}}).encode(),
        "cut short": good[: len(good) // 2],
        "many anchors": b"a: &a [x]\nb: &b [*a,*a]\nc: [*b,*b]\n",
        "an endless number": b'{"format": ' + b"1" * 1_000_000 + b"}",
        "an endless name": json.dumps({**lamp, "name": "n" * 1_000_000}).encode(),
        "half a surrogate": b'{"name": "\\ud800"}',
        "twenty thousand states": json.dumps({**lamp, "initial": "s0", "states": states}).encode(),
        "an inclusion elsewhere": _including(lamp, "../../../../etc/passwd"),
        "an inclusion by its root": _including(lamp, "/etc/passwd.json"),
        "an inclusion of itself": _including(lamp, "mission.json"),
        "an inclusion with a zero": _including(lamp, "a\0.json"),
        "larger than may be": b" " * (16 * 2**20 + 1),
    }


def _nested(levels: int) -> Any:
    guard: Any = {"in": "on"}
    for _ in range(levels // 2):
        guard = {"not": {"not": {"any": [guard, {"in": "off"}]}}}
    return guard


def _including(lamp: dict[str, Any], file: str) -> bytes:
    return json.dumps({**lamp, "initial": "inner", "states": {"inner": {"mission": file}}}).encode()


def _profiles() -> dict[str, bytes]:
    good = json.loads(next(seeds("profile")))
    changes: dict[str, dict[str, Any]] = {
        "an identity elsewhere": {"identity": "../.."},
        "an identity by its root": {"identity": "/etc"},
        "an identity with a zero": {"identity": "a\0b"},
        "an identity without end": {"identity": "a/" * 50_000},
        "a connector without kind": {"connector": {}},
        "a connector of lists": {"connector": {"kind": ["ros2"]}},
        "a field without end": {"blackboard": {"battery": {"topic": "/a", "type": "x", "field": "a." * 100_000}}},
    }
    return {name: json.dumps({**good, **change}).encode() for name, change in changes.items()}


def _journals() -> dict[str, bytes]:
    good = next(seeds("journal"))
    return {
        "nothing": b"",
        "cut short": good[:5_000],
        "a head alone": good[:100],
        "other bytes in the middle": good[:9_000] + bytes(range(256)) * 4 + good[10_024:],
        "a zip": b"PK\x03\x04" + bytes(1_000),
    }


def _rows() -> dict[str, bytes]:
    listed: list[Any] = json.loads(next(seeds("rows")))
    header, *steps = listed
    strange = {**steps[0][1]["step"]}
    strange["event"] = {"name": "battery", "at": 1.0, "kind": "write", "data": {"stamp": "now"}}
    return {
        "no row": b"[]",
        "two headers": json.dumps([header, header, *steps]).encode(),
        "no header": json.dumps(steps).encode(),
        "a mission that is none": json.dumps([["header", {**header[1], "mission": "[" * DEEP}]]).encode(),
        "a profile that is none": json.dumps([["header", {**header[1], "profile": "{"}], *steps]).encode(),
        "an event that none brings": json.dumps([header, ["step", {"since": 0, "step": strange}]]).encode(),
        "deep values": json.dumps([header, ["note", '{"text": "x", "data": ' + "[" * DEEP]]).encode(),
        "time without end": json.dumps([header, ["step", '{"since": 1e999, "step": {}}']]).encode(),
    }  # fmt: skip


def _recordings() -> dict[str, bytes]:
    good = next(seeds("recording"))
    return {
        "a head alone": good[:8],
        "cut short": good[: len(good) // 2],
        "a record without end": good[:8] + b"\x06" + b"\xff" * 8,
        "a bomb": good[:8] + _chunk("zstd", 2**62, b"\x28\xb5\x2f\xfd\xe4" + b"\xff" * 40),
        "a bomb that claims to be small": good[:8] + _chunk("zstd", 100, BOMB),
        "another packing": good[:8] + _chunk("lz4", 100, bytes(100)),
        "an enormous chunk": good[:8] + _chunk("", 2**40, bytes(100)),
        "an unknown packing": good[:8] + _chunk("rar", 100, zlib.compress(bytes(100))),
    }


def _chunk(packing: str, size: int, data: bytes) -> bytes:
    """An MCAP chunk (MCAP specification, section Chunk)."""
    name = packing.encode()
    body = bytes(16) + size.to_bytes(8, "little") + bytes(4) + len(name).to_bytes(4, "little") + name
    body += len(data).to_bytes(8, "little") + data
    return b"\x06" + len(body).to_bytes(8, "little") + body


def _identities() -> dict[str, bytes]:
    laughs = b'<!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><robot name="&b;"/>'
    return {
        "a billion laughs": laughs,
        "a file by XML": b'<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot name="&a;"/>',
        "deep elements": b"<robot>" + b"<a>" * DEEP,
        "an enormous picture": b"\x89PNG\r\n\x1a\n" + bytes(4) + b"IHDR" + b"\xff" * 8,
        "a picture cut short": b"\xff\xd8\xff\xc0",
    }


MAKERS: Mapping[str, Callable[[], dict[str, bytes]]] = {
    "mission": _missions, "profile": _profiles, "journal": _journals, "rows": _rows, "recording": _recordings,
    "identity": _identities,
}  # fmt: skip
FOUND = Path(__file__).parent / "corpus"
"""What the fuzzing found, each by the error that it raised then."""


def made(target: str) -> dict[str, bytes]:
    """Hostile input of a target: by hand, and what was found."""
    found = {path.name: path.read_bytes() for path in sorted((FOUND / target).glob("*"))}
    return {**MAKERS[target](), **found}
