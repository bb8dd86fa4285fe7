# SPDX-License-Identifier: Apache-2.0
"""Missions to begin from: a minimal one, and the shipped ones copied out.

Rule: nothing that is there is written over.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rai_missions.errors import UsageError, suggestion
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile

__all__ = ("copy_template", "templates")

MINIMAL = "minimal"
MISSION: dict[str, Any] = {
    "version": "0.1.0",
    "about": "Drive to a place; when something is in the way, ask what to do.",
    "blackboard": {
        "arrived": {"type": "boolean", "source": "robot", "max_age_s": 5, "about": "the robot is at the place"},
        "blocked": {"type": "boolean", "source": "robot", "max_age_s": 2, "about": "something is in the way"},
    },
    "initial": "driving",
    "states": {
        "driving": {
            "action": "drive",
            "timeout_s": 120,
            "achieved": {"key": "arrived", "==": True},
            "settle_s": 1,
            "transitions": [
                {"when": {"possible": {"key": "blocked", "==": True}}, "to": "assessing"},
                {"on": "succeeded", "to": "done"},
            ],
        },
        "assessing": {
            "decision": {
                "question": "Something is in the way. What should the robot do?",
                "evidence": ["blocked"],
                "options": {
                    "go_on": {"about": "drive on: the way is free again", "when": {"key": "blocked", "==": False}},
                    "give_up": {"about": "stay here and call a person"},
                },
                "deadline_s": 20,
                "fallback": "give_up",
            },
            "transitions": [{"on": "go_on", "to": "driving"}, {"on": "give_up", "to": "given_up"}],
        },
        "done": {"final": "succeeded", "requires": {"key": "arrived", "==": True}},
        "given_up": {"final": "aborted"},
    },
}
PROFILE: dict[str, Any] = {
    "name": "my robot",
    "connector": {"kind": "local"},
    "blackboard": {
        "arrived": {"topic": "/arrived", "type": "std_msgs/msg/Bool"},
        "blocked": {"topic": "/blocked", "type": "std_msgs/msg/Bool"},
    },
    "actions": {
        "drive": {"action": "/navigate_to_pose", "type": "nav2_msgs/action/NavigateToPose", "uses": ["base"]},
    },
}


def shipped() -> Path | None:
    """Where the shipped missions are: next to the package in a checkout, inside it when installed."""
    here = Path(__file__).resolve().parents[1]
    return next((path for path in (here / "missions", here.parent / "missions") if (path / "tractor").is_dir()), None)


def templates() -> tuple[str, ...]:
    """The names that `copy_template` takes."""
    folder = shipped()
    found = sorted(path.parent.name for path in folder.glob("*/mission.json")) if folder is not None else []
    return (MINIMAL, *found)


def copy_template(template: str, directory: Path) -> Iterator[Path]:
    """Make a folder with a mission of one's own; the files made, in order.

    Raises:
        UsageError: No such template, or the folder holds something already or cannot be made.
    """
    if template not in templates():
        raise UsageError(f"there is no template '{template}'{suggestion(template, templates())}")
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        raise UsageError(f"'{directory}' is there and not empty; name a folder that is new")
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"'{directory}' cannot be made: {error.strerror}") from error
    folder = shipped()
    if template == MINIMAL or folder is None:
        yield from _minimal(directory)
        return
    for source in sorted((folder / template).rglob("*")):
        if source.is_file() and "__pycache__" not in source.parts:
            target = directory / source.relative_to(folder / template)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
            yield target


def _minimal(directory: Path) -> Iterator[Path]:
    name = re.sub(r"[^a-z0-9_]+", "_", directory.resolve().name.lower()).strip("_") or "mission"
    mission = Mission.model_validate({"name": name if name[0].isalpha() else f"mission_{name}", **MISSION})
    dump(mission, directory / "mission.json")
    yield directory / "mission.json"
    profile = json.loads(dump_profile(Robot.model_validate(PROFILE)))
    (directory / "robot.json").write_text(json.dumps(profile, indent=2) + "\n", encoding="utf-8")
    yield directory / "robot.json"
