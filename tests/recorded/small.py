# SPDX-License-Identifier: Apache-2.0
"""Runs of small missions, recorded: each about one thing, whole and killed; included, migrated, and in doubt."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.replay.migrate import Map, migrate
from tests.replay import test_held as held
from tests.replay.farm import FARMER
from tests.replay.mortal import Fate, Land, live
from tests.replay.test_kills import CALLING, MISSION, ROBOT, WAITING, land, lived
from tests.replay.test_kinds import KINDS, farm
from tests.rigs.runs import ReplyingAnswerer

__all__ = ("Run", "small")

Run = tuple[str, Callable[[Path], object]]
"""A run's name, and what records it in a file that is not there yet."""


def small() -> Iterator[Run]:
    """All of them."""
    for name, kind in KINDS.items():
        if not kind.mission.behaviours():  # a run of one with behaviours in Python is replayed with its file alone
            yield f"kinds/{name}", of_kind(name, Fate(9, is_done=True), Fate(6))
    yield "killed/whole", killed(MISSION)
    yield "killed/twice", killed(MISSION, Fate(5), Fate(12, is_done=True))
    yield "killed/not-resumed", unfinished
    yield "killed/while-a-timer-runs", killed(WAITING, Fate(4, is_done=True), Fate(7), dead_s=3.0)
    for what in ("call", "send_goal", "ask", "publish"):
        for word, is_done in (("before", False), ("after", True)):
            mission = CALLING if what == "call" else MISSION
            yield f"killed/{word}-{what}", killed(mission, Fate(0, what=what, is_done=is_done), dead_s=60.0)
    yield "held/whole", holding()
    yield "held/killed", holding(Fate(12), Fate(8))
    yield "held/until-it-was-migrated", migrated("before")
    yield "held/migrated", migrated("after")
    yield "corners/orphaned", orphaned
    yield "corners/rows-and-nodes", corners
    for seconds, name in ((1.0, "succeeded"), (9.0, "timed-out")):
        yield f"included/{name}", included(seconds, "succeeded")
    yield "included/failed", included(1.0, "failed")


def of_kind(name: str, *fates: Fate) -> Callable[[Path], object]:
    kind, who = KINDS[name], {"someone": ReplyingAnswerer("on")}
    return lambda path: lived(path, farm(kind), list(fates), kind.mission, FARMER, 0.0, who, kind.named)


def killed(mission: Mission, *fates: Fate, dead_s: float = 0.0) -> Callable[[Path], object]:
    return lambda path: lived(path, land(), list(fates), mission, ROBOT, dead_s)


def unfinished(path: Path) -> None:
    live(path, land(), MISSION, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate(30))


def holding(*fates: Fate) -> Callable[[Path], object]:
    """The operator takes control and gives it back."""
    return lambda path: lived(path, held.farm(), list(fates), held.MISSION, held.ROBOT, 0.0, {})


def migrated(which: str) -> Callable[[Path], object]:
    """A run that is migrated to another mission: its journal `before`, or the one in which it continues."""

    def record(path: Path) -> None:
        there, now = held.farm(), held.changed(over={"final": "aborted"})
        with tempfile.TemporaryDirectory() as folder:
            before, after = Path(folder) / "before.journal", Path(folder) / "after.journal"
            live(before, there, held.MISSION, held.ROBOT, {}, Fate(3, what="wait"))
            migrate(before, now, Map(), to=after)
            live(after, there, now, held.ROBOT, {}, Fate())
            shutil.copyfile(before if which == "before" else after, path)

    return record


ORPHANS = Mission.model_validate({
    "name": "orphans", "initial": "moving",
    "states": {"moving": {"action": "move", "timeout_s": 2, "cancel_s": 3,
                          "transitions": [{"on": "timed_out", "to": "gone"}]},
               "gone": {"transitions": [{"on": "orphaned", "to": "alone"}]},
               "alone": {"transitions": [{"after_s": 8, "to": "over"}]}, "over": {"final": "canceled"}},
})  # fmt: skip


def orphaned(path: Path) -> None:
    """A goal that is accepted long after it was given up."""
    there = land()
    there.accepts_s = 10.0
    live(path, there, ORPHANS, ROBOT, {}, Fate())


CORNERS = Mission.model_validate({
    "name": "corners", "initial": "both", "events": {"go": {}, "again": {}},
    "blackboard": {"rounds": {"type": "integer", "source": "mission", "initial": 0},
                   "speed": {"type": "number", "source": "mission", "initial": 0}},
    "states": {
        "both": {
            "parallel": {
                "body": {"initial": "moving", "states": {
                    "moving": {"action": "move", "timeout_s": 9, "transitions": [{"on": "succeeded", "to": "asking"}]},
                    "asking": {"decision": {
                        "question": "How fast?", "ask": ["someone"], "attempts": 3, "deadline_s": 9,
                        "fallback": "stay",
                        "options": {"stay": {"about": "stay"}, "leave": {"about": "leave", "parameters": {
                            "type": "object", "properties": {"speed": {"type": "number"}}, "required": ["speed"]}}}},
                        "transitions": [
                            {"on": "leave", "to": "left", "do": [{"set": "speed", "from": "answer.speed"}]},
                            {"on": "stay", "to": "left"}]},
                    "left": {"final": "succeeded"}}},
                "head": {"initial": "growing", "states": {
                    "growing": {"timeout_s": 9, "tree": {"sequence": [
                        {"pass_through": {"call": "horn", "timeout_s": 2}},
                        {"running_is_success": {"wait_s": 1}},
                        {"failure_is_success": {"success_is_failure": {"set": "rounds", "add": 1}}},
                        {"inverter": {"running_is_failure": {"wait_s": 1}}},
                        {"memory": True, "selector": [
                            {"timeout": 1, "child": {"success_is_running": {"set": "rounds", "add": 1}}},
                            {"timeout": 1, "child": {"failure_is_running": {"check": {"key": "rounds", "<": 0}}}},
                            {"publish": "light", "message": {"data": True}}]}]}},
                    "grown": {"final": "succeeded"}},
                    "transitions": [{"on": "go", "to": "growing", "internal": True},
                                    {"on": "succeeded", "of": "growing", "to": "grown", "internal": True}]}},
            "entry": [{"raise": "go", "after_s": 0.7}, {"raise": "again", "after_s": 1.2}],
            "transitions": [{"on": "*", "do": [{"log": "heard"}]},
                            {"on": "succeeded", "to": "over"}]},
        "over": {"final": "canceled"},
    },
})  # fmt: skip


def exact() -> ReplyingAnswerer:
    """Answers with a parameter, after two answers that are refused."""
    parameters = iter(({}, {"speed": "fast"}, {"speed": 1.5}))
    return ReplyingAnswerer(lambda question: {"option": "leave", "parameters": next(parameters), "why": "scripted"})


def corners(path: Path) -> None:
    live(path, land(), CORNERS, ROBOT, {"someone": exact()}, Fate())


LOOK: dict[str, Any] = {
    "name": "look", "blackboard": {"limit": {"type": "integer", "source": "argument", "initial": 1},
                                   "looks": {"type": "integer", "source": "mission", "initial": 0}},
    "events": {"seen": {}}, "initial": "looking",
    "states": {
        "looking": {"action": "look", "timeout_s": 5, "entry": [{"set": "looks", "add": 1}],
                    "transitions": [{"on": "succeeded", "to": "resting", "do": [{"raise": "seen", "after_s": 1}]},
                                    {"on": ["failed", "timed_out"], "to": "unseen"}]},
        "resting": {"transitions": [{"on": "seen", "when": {"key": "looks", "<": {"key": "limit"}}, "to": "looking"},
                                    {"on": "seen", "to": "well"}]},
        "well": {"final": "succeeded"}, "unseen": {"final": "failed"},
    },
}  # fmt: skip
TWICE: dict[str, Any] = {
    "name": "twice", "initial": "here", "blackboard": {"most": {"type": "integer", "source": "argument", "initial": 2}},
    "states": {
        "here": {"mission": "look.json", "with": {"limit": {"from": "most"}},
                 "transitions": [{"on": "succeeded", "to": "turning"}, {"on": "failed", "to": "there"}]},
        "turning": {"action": "turn", "timeout_s": 20, "transitions": [{"on": "succeeded", "to": "there"}]},
        "there": {"mission": "look.json", "timeout_s": 8,
                  "transitions": [{"on": "succeeded", "to": "over"}, {"on": ["failed", "timed_out"], "to": "lost"}]},
        "over": {"final": "canceled"}, "lost": {"final": "aborted"},
    },
}  # fmt: skip


def included(looks_s: float, ends: str) -> Callable[[Path], object]:
    """A mission that includes another in two places."""

    def record(path: Path) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for document in (LOOK, TWICE):
                (Path(folder) / f"{document['name']}.json").write_text(json.dumps(document))
            mission = load(Path(folder) / "twice.json")
        live(path, Land([], {"turn": 1.0, "look": looks_s}, {"look": ends}), mission, ROBOT, {}, Fate())

    return record
