# SPDX-License-Identifier: Apache-2.0
"""The object finder as a process next to a robot on ROS 2: `python -m rai_missions.worlds.perception --config FILE`."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import threading
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import shown
from rai_missions.worlds.options import check_names
from rai_missions.worlds.perception.finder import FinderConfig, ObjectFinder
from rai_missions.worlds.perception.projection import Mount

__all__ = ("main", "read_config")


WORDS: Mapping[Any, str] = {str: "text", (int, float): "a number", Mapping: "an object"}
SORTS: Mapping[type, Any] = {str: str, float: (int, float), dict: Mapping, Mount: Mapping}
"""Type of a field → what JSON has for it."""


def read_config(path: str) -> FinderConfig:
    """The names on a robot, from a file with an object of `FinderConfig`'s fields.

    Raises:
        UsageError: It cannot be read, has a field that does not exist, or a value of another type.
    """
    try:
        given = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as fault:
        raise UsageError(f"{path} cannot be read: {fault.strerror}; name a file of JSON") from fault
    except ValueError as fault:
        raise UsageError(f"{path} is no JSON: {fault}") from fault
    known = [each.name for each in fields(FinderConfig)]
    if not isinstance(given, Mapping):
        raise UsageError(f"{path}: give an object with the fields {', '.join(known)}")
    check_names(path, given, known)
    plain = FinderConfig()
    for name, value in given.items():
        if not isinstance(value, sorts := SORTS[type(getattr(plain, name))]) or isinstance(value, bool):
            raise UsageError(f"{path}: {name} takes {WORDS[sorts]}, not {shown(value)}")
    mount = given.get("mount", {})
    try:
        return FinderConfig(**{**given, "mount": Mount(**mount)})
    except TypeError as fault:
        raise UsageError(f"{path}: mount takes {', '.join(Mount._fields)}, not {mount!r}") from fault


def main() -> int:
    """Run until a signal; the exit status."""
    reader = argparse.ArgumentParser(prog="python -m rai_missions.worlds.perception", description=__doc__)
    reader.add_argument("--config", metavar="FILE", help="the robot's names, as JSON; left out: those of the house")
    given = reader.parse_args()
    try:
        config = read_config(given.config) if given.config else FinderConfig()
        return _run(config)
    except (UsageError, ConnectorError) as fault:
        sys.stderr.write(f"error: {fault}\n")
        return 2


def _run(config: FinderConfig) -> int:
    from rai_missions.connectors.ros2 import open_connector  # heavy: rclpy

    connector: Any = open_connector({"node": "object_finder"})
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    connector.start()
    try:
        closes = ObjectFinder(config).open(connector)
        sys.stdout.write(f"ready: {config.look_for} starts it, {config.seen} has what it sees\n")
        sys.stdout.flush()
        ended.wait()
        for close in closes:
            close()
    finally:
        connector.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
