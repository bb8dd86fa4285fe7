# SPDX-License-Identifier: Apache-2.0
"""What a viewer sees of a run at one moment, and how a step changes it.

Rule: a change names whole values, never differences; so one that comes twice, or next to a newer state, does no harm.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rai_missions.engine.decision import Question
from rai_missions.engine.known import known_from, migrated
from rai_missions.engine.step import Ask, Handover, Step, Withdraw
from rai_missions.event import is_e_stop, is_taken
from rai_missions.image import Image
from rai_missions.keys import Key
from visualize.live.as_json import bounded, line, question_data
from visualize.page.as_json import Json

__all__ = ("TAIL", "RunScene")

TAIL = 100
"""Steps of the journal's tail."""
LONGEST_LINE = 4_000
"""Characters of a line of the conversation."""
MOST_TALK = 200
"""Lines of the conversation that are kept."""


@dataclass(eq=False)
class RunScene:
    """A run as far as it has been followed; times are on the run's clock."""

    seq: int = 0
    """The last step that is in it."""
    at: float = 0.0
    """When that was."""
    mode: str = "ready"
    """As `rai_missions.runtime.lifecycle.MODES` has it."""
    paused_at: float | None = None
    """Since when it is paused; None while it is not."""
    paused_by: str = ""
    """Who paused it; empty while it is not paused, and where that is not known."""
    control: str = "autonomy"
    """Who holds control."""
    held_by: str = ""
    """Who holds the mission up: the `operator`, who has taken control, or `nobody`; empty while it is not held."""
    held_since: float | None = None
    """Since when."""
    active: set[str] = field(default_factory=set)
    """The active states."""
    board: dict[str, tuple[Any, float]] = field(default_factory=dict)
    """Key → value and stamp."""
    keys: Mapping[str, Key] = field(default_factory=dict)
    """The keys of the mission."""
    questions: dict[int, Question] = field(default_factory=dict)
    """The questions that are open, by their numbers."""
    closed: dict[str, dict[str, str]] = field(default_factory=dict)
    """Question's number, as text → option → why it would be refused if it were taken now."""
    open_goals: list[Json] = field(default_factory=list)
    """The goals that may still move the robot although nothing waits for them, as the journal has them."""
    awaited_facts: str = ""
    """The robot's keys that the run waits for, to start or to continue in another process; empty for none."""
    outcome: str = ""
    """How it ended; empty while it has not."""
    why: str = ""
    """The rule that ended it."""
    ended_at: float | None = None
    """When it ended; None while it has not."""
    e_stop_by: str = ""
    """Whose e-stop ended it; empty where none did."""
    run: str = ""
    """The run's id; empty where the page has but one."""
    where: str = ""
    """Which run it is, and where it is written down; empty where the page has but one."""
    cut: str = ""
    """How it is known that the run was cut short; empty where it was not."""
    faults: list[str] = field(default_factory=list)
    """What keeps the page from showing all of the run."""
    tail: deque[Json] = field(default_factory=lambda: deque(maxlen=TAIL))
    """The last steps that did something."""
    talk: dict[int, Json] = field(default_factory=dict)
    """The last lines of the conversation with the robot, by their numbers."""
    _asked_for: str = field(default="", init=False)
    """Who was asked to take control last."""
    _answered: set[int] = field(default_factory=set, init=False)
    """The questions whose answers came while the run was paused or held."""
    _fields: set[str] = field(default_factory=set, init=False)
    """What has changed since it was last reported: fields by name, keys, steps, and lines of the conversation."""
    _written: set[str] = field(default_factory=set, init=False)
    _lines: list[Json] = field(default_factory=list, init=False)
    _spoken: list[Json] = field(default_factory=list, init=False)

    # -- following ------------------------------------------------------------------------------------------------

    def take(self, step: Step, before: Iterable[tuple[str, Any, float]] = ()) -> None:
        """Follow a step; one that is in it already changes nothing."""
        for key, value, stamp in before:
            self._write(key, value, stamp)
        if step.seq <= self.seq:
            return
        self.seq, self.at = step.seq, max(self.at, step.at)
        for key, value, stamp in known_from(step, self.keys):
            self._write(key, value, stamp)
        self._move(step)
        self._command(step)
        if (was := migrated(step)) is not None:
            self._migrate(was)
        self._ask(step)
        if step.outcome:
            self._end(step)
        if (text := line(step)) is not None:
            self.tail.append(text)
            self._lines.append(text)

    def recall(self, steps: Iterable[Step]) -> None:
        """Put steps into the tail that are in the scene already."""
        self.tail.extend(text for step in steps if (text := line(step)) is not None)

    def recall_order(self, step: Step) -> None:
        """Put in who gave the pause or the e-stop that is in the scene already."""
        by = str(step.event.data.get("by", ""))
        if self.mode == "paused" and step.mode == "paused":
            self.paused_by = by or self.paused_by  # of the process before, where it is resumed
        if self.outcome and step.outcome:
            self.ended_at, self.e_stop_by = step.at, by if is_e_stop(step.event) else ""

    def add_talk(self, spoken: Mapping[str, Any]) -> None:
        """A line of the conversation; one of the same number is replaced."""
        text = bounded(dict(spoken)) | {"text": str(spoken.get("text", ""))[:LONGEST_LINE]}
        number = text["number"] if isinstance(text.get("number"), int) else len(self.talk) + 1
        self.talk[number] = text | {"number": number}
        while len(self.talk) > MOST_TALK:
            del self.talk[next(iter(self.talk))]
        self._spoken.append(self.talk[number])

    def fault(self, sentence: str) -> None:
        """State what is wrong, once."""
        if sentence not in self.faults:
            self.faults.append(sentence)
            self._fields.add("faults")

    def cut_short(self, sentence: str) -> None:
        """State how it is known that nothing more comes; empty where the run continues."""
        if sentence != self.cut:
            self.cut = sentence
            self._fields.add("cut")

    def set_open_goals(self, goals: list[Json]) -> None:
        """State which goals may still move the robot although nothing waits for them."""
        if goals != self.open_goals:
            self.open_goals = goals
            self._fields.add("open_goals")

    def set_awaited_facts(self, words: str) -> None:
        """State which facts of the robot the run waits for."""
        if words != self.awaited_facts:
            self.awaited_facts = words
            self._fields.add("awaited_facts")

    def set_closed_options(self, options: Mapping[int, Mapping[str, str]]) -> None:
        """State which options would be refused now, and why."""
        closed = {str(number): dict(each) for number, each in options.items()}
        if closed != self.closed:
            self.closed = closed
            self._fields.add("closed")

    def _write(self, key: str, value: Any, stamp: float) -> None:
        entry = self.board.get(key)
        if value is None:
            self.board.pop(key, None)
            self._written.add(key)
        elif entry is None or entry[1] <= stamp:
            self.board[key] = (value, stamp)
            self._written.add(key)

    def _move(self, step: Step) -> None:
        for move in step.moves:
            self.active.difference_update(move.exited)
            self.active.update(move.entered)
            self._fields.add("active")

    def _command(self, step: Step) -> None:
        event, holder, mode = step.event, _holder(step), _mode(step)
        if event.kind == "control" and not step.refusal and holder is not None:
            taken = is_taken(event, holder=self.control, taken=self.held_by == "operator", asked=self._asked_for)
            self._set_held("operator" if taken else holder if holder == "nobody" else "", step.at)
        if holder is not None and holder != self.control:
            self._set_control(holder)
        for effect in step.effects:
            if isinstance(effect, Handover):
                self._asked_for = effect.to
        if mode is None or mode == self.mode or step.outcome:
            return
        was = self.mode
        self._set_mode(mode)
        if mode == "paused":
            self.paused_at, self.paused_by = step.at, str(event.data.get("by", ""))
        elif was == "paused":
            self.paused_by = ""
            self._shift(step.at)

    def _migrate(self, was: Mapping[str, Any]) -> None:
        """The pause or the hold of a run that is migrated began in the run that it was."""
        holds = was["holder"] == "nobody" or (was["holder"] == "operator" and was["taken"])
        self._set_held(was["holder"] if holds else "", was["_held_since"])
        self._asked_for = was["_asked"]
        if self.mode == "paused":
            self.paused_at = was["_paused_at"]

    def _end(self, step: Step) -> None:
        if not self.outcome:
            self.outcome, self.why = str(step.outcome), step.why
            self.recall_order(step)
            self._fields |= {"outcome", "why", "e_stop_by", "ended_at"}
        if self.mode != step.outcome:
            self._set_mode(str(step.outcome))

    def _set_mode(self, mode: str) -> None:
        self.mode = mode
        self._fields |= {"mode", "paused_at", "paused_by"}

    def _set_control(self, control: str) -> None:
        self.control = control
        self._fields.add("control")

    def _set_held(self, by: str, at: float) -> None:
        if by != self.held_by:
            self.held_by, self.held_since = by, at if by else None
            self._fields |= {"held_by", "held_since"}

    def _shift(self, at: float) -> None:
        """Questions have the time left that they had when the run was paused."""
        by_s = at - self.paused_at if self.paused_at is not None else 0.0
        self.questions = {
            number: each._replace(until=each.until + by_s) if each.at <= at - by_s else each
            for number, each in self.questions.items()
        }
        self.paused_at = None
        self._fields.add("questions")

    def _ask(self, step: Step) -> None:
        before = tuple(self.questions)
        if step.event.kind == "proposal":
            self._answered.add(step.event.number)
        is_kept = step.kept or self.mode == "paused" or (self.held_by and not (step.moves or step.effects))
        if not is_kept:  # then an answer waits until the run continues
            for number in self._answered:
                self.questions.pop(number, None)
            self._answered.clear()
        for effect in step.effects:
            if isinstance(effect, Ask):
                self.questions[effect.question.number] = effect.question
            elif isinstance(effect, Withdraw):
                self.questions.pop(effect.number, None)
        if step.outcome:
            self.questions.clear()
        if before != tuple(self.questions):
            self._fields.add("questions")

    # -- reporting --------------------------------------------------------------------------------------------------

    @property
    def written(self) -> bool:
        """Values have changed that were not reported."""
        return bool(self._written)

    def change(self, *, board: bool = True) -> Json:
        """What has changed since it was reported last.

        Args:
            board: Whether the blackboard is reported too.
        """
        fields = {name: self._field(name) for name in sorted(self._fields)}
        if self._lines:
            fields["steps"] = self._lines
        if self._spoken:
            fields["talk"] = self._spoken
        if board and self._written:
            fields["board"] = {key: self._entry(key) for key in sorted(self._written)}
            self._written = set()
        self._fields, self._lines, self._spoken = set(), [], []
        return fields

    def whole(self) -> Json:
        """All of it."""
        names = ("mode", "control", "active", "questions", "outcome", "why", "closed", "paused_at", "cut", "faults",
                 "open_goals", "held_by", "held_since", "paused_by", "e_stop_by", "ended_at", "where",
                 "run", "awaited_facts")  # fmt: skip
        board = {key: self._entry(key) for key in sorted(self.board)}
        return {name: self._field(name) for name in names} | {
            "board": board,
            "steps": list(self.tail),
            "talk": list(self.talk.values()),
        }

    def picture(self, key: str, question: int = 0) -> Image | None:
        """The newest picture under a key, or the one that a question shows."""
        if question:
            asked = self.questions.get(question)
            shown = next((each.value for each in asked.evidence if each.key == key), None) if asked else None
        else:
            shown = self.board.get(key, (None, 0.0))[0]
        return shown if isinstance(shown, Image) else None

    def _entry(self, key: str) -> list[Any] | None:
        """Value and stamp of a key; None where it is no longer known."""
        if key not in self.board:
            return None
        value, stamp = self.board[key]
        return [bounded(value), round(stamp, 3)]

    def _field(self, name: str) -> Any:
        if name == "questions":
            return [question_data(each) for each in self.questions.values()]
        value = getattr(self, name)
        return sorted(value) if name == "active" else bounded(value) if name in ("closed", "open_goals") else value


def _mode(step: Step) -> str | None:
    """The run's mode after a step; None where a row of an earlier version does not hold it."""
    if step.mode is None and step.event.kind == "command" and not step.why:
        return {"start": "running", "pause": "paused", "resume": "running", "cancel": "canceling"}.get(step.event.name)
    return step.mode


def _holder(step: Step) -> str | None:
    """Who holds control after a step; None where a row of an earlier version does not hold it."""
    event = step.event
    if step.mode is None and event.kind == "control" and not step.why:
        return event.name
    if step.mode is None and is_e_stop(event) and step.outcome:
        return "nobody"
    return step.holder
