# SPDX-License-Identifier: Apache-2.0
"""`make talk`, shortened: a scripted person talks with a real simulated mission, and each of the three ways is seen."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).parents[3] / "scripts" / "talk.py"


def script() -> ModuleType:
    found = importlib.util.spec_from_file_location("talk_demo", SCRIPT)
    assert found is not None and found.loader is not None
    made = importlib.util.module_from_spec(found)
    found.loader.exec_module(made)
    return made


@pytest.mark.sim
@pytest.mark.parametrize("name", ["tractor", "rosbot"])
def test_the_scripted_person_is_answered_in_three_ways_and_its_orders_are_carried_out(name: str) -> None:
    talk, lines = script(), list[str]()
    short = talk.sentences(
        (0.4, "what are you doing?"),
        (0.8, "is the moon made of cheese?"),
        (1.4, "please make up a song"),
        (2.0, "stop"),
        (2.4, "why did you stop?"),
        (2.8, "resume"),
        (3.2, "cancel the mission"),
        (3.6, "yes"),
    )
    scene = talk.SCENES[name]._replace(sentences=short, speed=2.0)
    result = talk.play(scene, lines.append)
    shown = "\n".join(lines)
    assert result.outcome == "canceled", shown
    for way in ("by rule", "by a model", "knows no answer"):
        assert f"robot, {way}" in shown, shown
    assert "paused by operator" in shown and shown.count("was canceled") == 1
