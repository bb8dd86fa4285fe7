# SPDX-License-Identifier: Apache-2.0
"""The text that states how a message's bytes are read: its .msg file, followed by those of all that it is made of.

Source: the MCAP specification's registry, "ros2msg": definitions are separated by a line of 80 `=`, and each after the
first begins with `MSG: package/Type`.
"""

from __future__ import annotations

import importlib.util
import os
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from rai_missions.errors import ConnectorError

__all__ = ("definition_of",)

PLAIN = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)) | {
    "bool",
    "byte",
    "char",
    "float32",
    "float64",
    "string",
    "wstring",
}
SEPARATOR = f"\n{'=' * 80}\nMSG: "


@cache
def definition_of(type_name: str) -> str:
    """The definition of a message type, `geometry_msgs/msg/PoseStamped`, with all that it depends on.

    Raises:
        ConnectorError: Its package was installed without its .msg files.
    """
    package, _, name = _parts(type_name)
    texts: dict[str, str] = {}
    wanted = [(package, name)]
    while wanted:
        package, name = wanted.pop(0)
        if f"{package}/{name}" not in texts:
            texts[f"{package}/{name}"] = text = _text(package, name)
            wanted += _used(text, package)
    (_, first), *others = texts.items()
    return "".join([first, *(f"{SEPARATOR}{name}\n{text}" for name, text in others)])


def _parts(type_name: str) -> tuple[str, str, str]:
    package, _, rest = type_name.partition("/")
    middle, _, name = rest.rpartition("/")
    return package, middle, name


def _used(text: str, package: str) -> Iterator[tuple[str, str]]:
    """The types of a definition's fields that are messages."""
    for line in text.splitlines():
        kind = re.split(r"[\s\[<]", line.partition("#")[0].strip())[0]
        if kind and kind not in PLAIN:
            own, _, name = _parts(kind)
            yield (own, name) if name else (package, kind)


def _text(package: str, name: str) -> str:
    for prefix in _prefixes(package):
        path = prefix / "share" / package / "msg" / f"{name}.msg"
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise ConnectorError(f"the definition of {package}/msg/{name} is not on this machine: no share/{package}/msg")


def _prefixes(package: str) -> Iterator[Path]:
    """Where packages of ROS are installed: a sourced ROS names the folder, wheels have it next to Python's own."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix)
    yield Path(sys.prefix)
    spec = importlib.util.find_spec(package)  # found, and not executed
    if spec is not None and spec.origin is not None:
        yield from Path(spec.origin).parents
