# SPDX-License-Identifier: Apache-2.0
"""A request typed at a desk: an arm does it; pictures of the desk before and after. It needs no key and no display.

`python scripts/desk.py [REQUEST] [--scene FILE] [--seed N] [--pictures FOLDER]`
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.engine.step import Step
from rai_missions.mission.json_reader import parse_json
from rai_missions.profile import Robot

ROOT = Path(__file__).resolve().parents[1] / "missions" / "desk"


STATES = {
    "looking_first": "the camera looks until it is sure of every thing",
    "moving": "the arm makes the first move of the plan",
    "looking": "the camera looks again",
    "putting_aside": "what is still held is set down where it is free",
    "done": "it is as wanted, by the camera",
}
"""States of the mission that are printed → in words."""


def arrange(request: str, scene: str | None, seed: int, pictures: Path) -> int:
    """Run one request to its end, and keep a picture of the desk before and after."""
    profile: dict[str, Any] = parse_json((ROOT / "robot.sim.json").read_bytes(), "robot.sim.json")
    profile["connector"] |= {"seed": seed, **({"scene": scene} if scene else {})}
    pictures.mkdir(parents=True, exist_ok=True)
    config = RunConfig(
        ROOT / "arrange.json",
        Robot.model_validate(profile),
        {"request": request},
        speed=None,
        journal=pictures / "desk.journal",
        on_step=_show,
    )
    print(f"request: {request}", flush=True)
    with prepare(config) as prepared:
        world: Any = prepared.world
        _picture(world, pictures / "before.png")
        result = prepared.runner.run()
        _picture(world, pictures / "after.png")
    print(f"{result.outcome}: {result.why}")
    print(f"pictures: {pictures / 'before.png'}, {pictures / 'after.png'}; journal: {pictures / 'desk.journal'}")
    return 0 if result.outcome == "succeeded" else 1


def _show(step: Step) -> None:
    """What a reader of the terminal wants to know of a step."""
    for name, value in step.writes:
        if name == "plan" and value.get("moves"):
            print(f"{step.at:7.1f} s  plan, {len(value['moves'])} to go:", flush=True)
            for number, move in enumerate(value["moves"], 1):
                print(f"{'':11}{number}. {move['object']} → {move['onto']}: {move['why']}")
        elif name in ("report", "reading") and (text := value if name == "report" else value.get("question")):
            print(f"{step.at:7.1f} s  {text}", flush=True)
    for state in step.entered:
        if state in STATES:
            print(f"{step.at:7.1f} s  {STATES[state]}", flush=True)


def _picture(world: Any, file: Path) -> None:
    picture = world.camera.picture(world.camera.moment(world.data), file.stem)
    file.write_bytes(picture.file().data)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("request", nargs="?", default="stack the cubes", help="what should be so, in free words")
    parser.add_argument("--scene", help="a file with the things on the desk; without, the seed draws them")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--pictures", type=Path, default=Path("out"), help="where before.png and after.png go (out)")
    given = parser.parse_args(arguments)
    return arrange(given.request, given.scene, given.seed, given.pictures)


if __name__ == "__main__":
    sys.exit(main())
