# SPDX-License-Identifier: Apache-2.0
"""`rai-missions schema new doctor`: what an author needs beside a mission."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

__all__ = ("doctor", "new", "schema")


def schema(given: argparse.Namespace) -> int:
    """Print a JSON Schema."""
    if given.of == "robot":
        from rai_missions.profile.schema import robot_schema

        print(json.dumps(robot_schema(), indent=2, ensure_ascii=False))
        return 0
    if given.of == "map":
        from rai_missions.replay.migrate import map_schema

        print(json.dumps(map_schema(), indent=2, ensure_ascii=False))
        return 0
    from rai_missions.mission.schema import mission_schema

    print(json.dumps(mission_schema(), indent=2, ensure_ascii=False))
    return 0


def new(given: argparse.Namespace) -> int:
    """Start a mission from a template."""
    from rai_missions.cli.templates import start

    for path in start(given.template, Path(given.directory)):
        print(path)
    print(f"next: rai-missions check {given.directory}/mission.json")
    return 0


def doctor(given: argparse.Namespace) -> int:
    """Say what this machine has and lacks, and how much of a robot is there."""
    from rai_missions.cli.doctor import examine
    from rai_missions.profile import load_profile

    robot = load_profile(given.robot) if given.robot else None
    complaints = 0
    for item in examine(robot):
        print(item, flush=True)
        complaints += item.status == "missing"
    return 1 if complaints else 0
