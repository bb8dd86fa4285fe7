# SPDX-License-Identifier: Apache-2.0
"""What the node reports of its mission: one value with a revision, as JSON and as the fields of `MissionStatus`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.decision import Question
from rai_missions.engine.description import step_json
from rai_missions.engine.step import Step
from rai_missions.journal.codec import encode
from rai_missions.redaction import cut
from rai_missions.states.control import Holder

__all__ = ("OpenQuestion", "StatusMessage", "step_fields", "step_text", "text_of")

CUT = 2_000
"""Characters of a text that a status quotes."""
JSON_ALONE = frozenset(("instance", "waits", "fault", "at"))
"""Words of a status that `MissionStatus` has no field for; `at` is its stamp."""


class OpenQuestion(NamedTuple):
    """A question that waits for its answer."""

    question: Question
    left_s: float
    """Seconds until its time is over, when the status was written."""

    def fields(self) -> dict[str, Any]:
        """As `rai_missions_msgs/msg/Question`."""
        question = self.question
        options = [
            {
                "name": option.name,
                "about": option.about,
                "parameters": text_of(option.parameters) if option.parameters is not None else "",
            }
            for option in question.options
        ]
        return {
            "number": question.number,
            "state": question.state,
            "asked": question.asked,
            "text": question.text,
            "options": options,
            "left_s": self.left_s,
        }

    def data(self) -> dict[str, Any]:
        """As JSON has it."""
        options = [
            {"name": option.name, "about": option.about, "parameters": option.parameters}
            for option in self.question.options
        ]
        return self.fields() | {"options": options, "left_s": round(self.left_s, 3)}


class StatusMessage(NamedTuple):
    """What a node's mission is doing."""

    revision: int
    node: str
    instance: str
    """Which process reports it; another one under the same name is a stranger."""
    lifecycle: str
    mission: str
    version: str
    run: str
    mode: str
    """`idle` before the first run; then one of `lifecycle.MODES`."""
    control: Holder
    active: tuple[str, ...] = ()
    questions: tuple[OpenQuestion, ...] = ()
    outcome: str = ""
    """Set once the run is over, every goal's end included: another may be begun."""
    why: str = ""
    waits: str = ""
    """What the mission waits for: facts of the robot, or someone to have control."""
    open_goals: tuple[OpenGoal, ...] = ()
    """The goals that may still be executing although nothing waits for them: the robot may still move."""
    held_by: str = ""
    """Who holds the mission up: the `operator`, who has taken control, or `nobody`; empty while it is not held."""
    held_since: float = 0.0
    """Since when, in seconds on the run's clock; 0 while it is not held."""
    fault: str = ""
    """Why the node's last transition failed."""
    at: float = 0.0
    """Wall time, in seconds since 1970."""

    def data(self) -> dict[str, Any]:
        """As JSON has it."""
        questions = [each.data() for each in self.questions]
        open_goals = [goal.data() for goal in self.open_goals]
        written = self._asdict() | {"active": list(self.active), "questions": questions, "open_goals": open_goals}
        return written | {"question": questions[0] if questions else None, "why": cut(self.why, CUT)}

    def fields(self) -> dict[str, Any]:
        """As `rai_missions_msgs/msg/MissionStatus`."""
        typed = {word: value for word, value in self._asdict().items() if word not in JSON_ALONE}
        return typed | {
            "stamp": self.at,
            "active": list(self.active),
            "questions": [each.fields() for each in self.questions],
            "why": cut(self.why, CUT),
            "open_goals": [goal.data() for goal in self.open_goals],
        }


def step_text(step: Step, run: str) -> str:
    """A step as one line of JSON, with the run that it belongs to."""
    return text_of({"run": run, **encode(step)})


def step_fields(step: Step, run: str, text: str) -> dict[str, Any]:
    """A step as `rai_missions_msgs/msg/Step`."""
    fields = step_json(step, without=("event", "taken", "guards", "effects", "verdicts", "notes"))
    verdicts = [each._asdict() | {"why": cut(each.why, CUT)} for each in step.verdicts]
    for verdict in verdicts:
        del verdict["note"]  # which of the step's notes has it in words: those are not sent
    return fields | {
        "run": run,
        "event": step.event.name,
        "kind": step.event.kind,
        "mode": step.mode or "",
        "holder": step.holder or "",
        "verdicts": verdicts,
        "refusal": step.refusal,
        "kept": step.kept,
        "remarks": list(step.remarks),
        "json": text,
    }


def text_of(data: Mapping[str, Any]) -> str:
    """Data as JSON in one line; half a surrogate pair is written as its escape."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), default=str)
    return text.encode("utf-8", "backslashreplace").decode()
