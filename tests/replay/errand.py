# SPDX-License-Identifier: Apache-2.0
"""A mission that does a bit of everything with a robot over ROS 2, and what must be so when it has ended.

Rule: that is read from the journal and from what the robot reports that it did, and from nothing else.
"""

from __future__ import annotations

import json
import uuid
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rai_missions.engine.step import Ask, CallService, StartGoal
from rai_missions.journal import Note, StepRow, read, verify
from rai_missions.replay.replay import replay

__all__ = ("GOALS", "STATES", "WAITS_S", "WHY", "check", "written")

GOALS = 4
WAITS_S = 1.0
WHY = "'over' was reached, and done ≥ wanted"
STATES = ("asking", "body", "both", "going", "head", "leaving", "lighting", "looked", "looking", "over", "turned",
          "turning", "waiting")  # fmt: skip
ORDERS = {"going": 30, "turning": 50, "looking": 31, "leaving": 32}
"""State → its goal's `order`: hundredths of a second, another for each."""


def _goal(state: str) -> dict[str, Any]:
    return {"action": "look" if state == "looking" else "move", "goal": {"order": ORDERS[state]}, "timeout_s": 60}


def _on(outcome: str, to: str) -> dict[str, Any]:
    return {"on": outcome, "to": to}


def written(folder: Path, robot: str) -> tuple[Path, Path]:
    """The files of the mission and of the robot's profile."""
    move = {"action": f"/{robot}/move", "type": "test_msgs/action/Fibonacci"}
    trigger = "std_srvs/srv/Trigger"
    profile = {
        "name": robot, "connector": {"kind": "ros2", "discovery_s": 30.0}, "identity": "",
        "blackboard": {"done": {"topic": f"/{robot}/done", "type": "std_msgs/msg/Int32"}},
        "actions": {"move": {**move, "uses": ["base"]}, "look": {**move, "uses": ["head"]}},
        "services": {"horn": {"service": f"/{robot}/horn", "type": trigger, "repeat": True},
                     "lamp": {"service": f"/{robot}/lamp", "type": trigger}},
        "topics": {"light": {"topic": f"/{robot}/light", "type": "std_msgs/msg/Bool"}},
    }  # fmt: skip
    body = {"turning": {**_goal("turning"), "transitions": [_on("succeeded", "turned")]},
            "turned": {"final": "succeeded"}}  # fmt: skip
    tree = {"sequence": [_goal("looking"), {"call": "horn", "timeout_s": 60}, {"wait_s": 0.4}]}
    head = {"looking": {"tree": tree, "timeout_s": 120, "transitions": [_on("succeeded", "looked")]},
            "looked": {"final": "succeeded"}}  # fmt: skip
    enough = {"key": "done", ">=": {"key": "wanted"}}
    mission = {
        "name": "errand", "format": 1, "version": "1.0.0", "initial": "going", "ready_s": 60,
        "blackboard": {"done": {"type": "integer", "source": "robot", "max_age_s": 60},
                       "wanted": {"type": "integer", "source": "argument", "initial": GOALS}},
        "states": {
            "going": {**_goal("going"), "transitions": [_on("succeeded", "asking")]},
            "asking": {"decision": {"question": "On?", "options": {"on": {"about": "on"}, "off": {"about": "off"}},
                                    "ask": ["operator"], "deadline_s": 120, "fallback": "off"},
                       "transitions": [{"on": "on", "to": "both", "do": [{"publish": "light",
                                                                          "message": {"data": True}}]},
                                       _on("off", "lost")]},
            "both": {"parallel": {"body": {"initial": "turning", "states": body},
                                  "head": {"initial": "looking", "states": head}},
                     "transitions": [_on("succeeded", "waiting")]},
            "waiting": {"transitions": [{"after_s": WAITS_S, "to": "lighting"}]},
            "lighting": {"call": "lamp", "timeout_s": 60,
                         "transitions": [_on("succeeded", "leaving"), _on("failed", "leaving")]},
            "leaving": {**_goal("leaving"), "achieved": enough, "settle_s": 20,
                        "transitions": [_on("succeeded", "over")]},
            "over": {"final": "succeeded", "requires": enough},
            "lost": {"final": "aborted"}},
    }  # fmt: skip
    paths = folder / "errand.json", folder / "robot.json"
    for path, content in zip(paths, (mission, profile), strict=True):
        path.write_text(json.dumps(content))
    return paths


def check(journal: Path, robot_reports: Sequence[Sequence[Any]]) -> None:
    """Hold a run that has ended, and the robot, to what is so without any death.

    Args:
        journal: The run's.
        robot_reports: What the robot has reported since the run began.
    """
    assert verify(journal) == ()
    again = replay(journal)
    assert again.holds, again.difference
    assert (again.outcome, again.why) == ("succeeded", WHY), "it ends as it does without deaths"
    with read(journal) as record:
        rows, run = list(record.rows()), record.header.run
    steps = [row.step for row in rows if isinstance(row, StepRow)]
    assert [step.seq for step in steps] == sorted({step.seq for step in steps}), "no step twice"
    entered = [name for step in steps for name in step.entered]
    assert sorted(entered) == sorted(STATES), "no state was entered twice, and none left out"
    _check_goals(run, steps, robot_reports)
    _check_services(rows, Counter(str(reported[0]) for reported in robot_reports))
    _check_question(steps)
    _check_timer(steps)


def _check_goals(run: str, steps: Sequence[Any], robot_reports: Sequence[Sequence[Any]]) -> None:
    starts = [each for step in steps for each in step.effects if isinstance(each, StartGoal)]
    ids = sorted(uuid.uuid5(uuid.NAMESPACE_URL, f"{run}/{each.owner}/{each.number}").hex for each in starts)
    assert len(ids) == GOALS
    for word in ("runs", "ended"):
        assert sorted(str(reported[1]) for reported in robot_reports if reported[0] == word) == ids, (
            f"each goal {word} once"
        )
    assert not [reported for reported in robot_reports if reported[0] == "canceled"], "no goal is ended that is wanted"


def _check_services(rows: Sequence[Any], done: Counter[str]) -> None:
    """What may not be done twice was done once, unless the mission was notified that no one knows."""
    steps = [row.step for row in rows if isinstance(row, StepRow)]
    published = next(at for at, row in enumerate(rows) if isinstance(row, StepRow) and "both" in row.step.entered)
    died = any(isinstance(row, Note) and row.text == "resumed" for row in rows[published:])
    unsure = {("publish", "light")} if died else set()  # what the middleware was given goes with its process
    unsure |= {(step.event.data["what"], step.event.data["name"]) for step in steps if step.event.name == "uncertain"}
    for what, name in (("call", "lamp"), ("publish", "light")):
        assert done[name] <= 1, f"'{name}' was done twice"
        assert done[name] == 1 or (what, name) in unsure, f"'{name}' was not done, and no row reports it"
    horn = next(each.number for step in steps for each in step.effects if _is_call(each, "horn"))
    since = next(at for at, row in enumerate(rows) if isinstance(row, StepRow) and _calls(row.step, horn))
    until = next(at for at, row in enumerate(rows) if isinstance(row, StepRow) and _answers(row.step, horn))
    again = sum(isinstance(row, Note) and row.text == "resumed" for row in rows[since:until])
    assert 1 <= done["horn"] <= 1 + again, "what may be done twice is done again by a new process alone"


def _is_call(effect: Any, service: str) -> bool:
    return isinstance(effect, CallService) and effect.service == service


def _calls(step: Any, number: int) -> bool:
    return any(isinstance(each, CallService) and each.number == number for each in step.effects)


def _answers(step: Any, number: int) -> bool:
    return bool(step.event.kind == "result" and step.event.number == number)


def _check_question(steps: Sequence[Any]) -> None:
    asked = [each.question for step in steps for each in step.effects if isinstance(each, Ask)]
    answers = [step.event for step in steps if step.event.kind == "proposal"]
    assert len(asked) == 1 and asked[0].asked == "operator", "a question keeps its number"
    assert [(each.number, each.data.get("option")) for each in answers] == [(asked[0].number, "on")]


def _check_timer(steps: Sequence[Any]) -> None:
    """It rings at its time on the run's clock: no step is between that and the one in which it rang."""
    began = next(at for at, step in enumerate(steps) if "waiting" in step.entered)
    rang = next(at for at, step in enumerate(steps) if "lighting" in step.entered)
    if began < rang:  # else both instants went by while the robot was being received again
        assert steps[rang - 1].at < steps[began].wake_at <= steps[rang].at, "a timer has the time that was left"
