# SPDX-License-Identifier: Apache-2.0
"""Small missions and charts for tests, and a robot that sends a chart what was drawn for it."""

from __future__ import annotations

from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.step import Ask, CallService, Handover, StartBehaviour, StartGoal, Step
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

__all__ = ("Drawn", "ScriptedRobot", "chart", "mission", "sent", "ticked", "transition")

Drawn = tuple[Any, ...]
"""One thing that happens, as a script has it: its kind, and the words that `ScriptedRobot.event` reads."""
UNKNOWN = 99_999
"""A number that no chart has given out."""


def mission(states: dict[str, Any], initial: Any = None, **words: Any) -> Mission:
    """A mission of these states; every word that a row has `on` is declared unless it is an outcome."""
    from rai_missions.states.state import OUTCOMES

    events = words.pop("events", None)
    if events is None:
        events = sorted(set(_events(states)) | set(_events(words)))
    start = initial if initial is not None else next(iter(states))
    options = set(_options(states))
    declared = [name for name in events if name not in OUTCOMES and name not in options and name != "*"]
    return Mission.model_validate({"name": "tried", "states": states, "initial": start, "events": declared, **words})


def chart(states: dict[str, Any], initial: Any = None, *, started: bool = True, **words: Any) -> Chart:
    """A chart of these states, started at 0 s."""
    made = Chart(mission(states, initial, **words))
    if started:
        made.start(0.0)
    return made


def transition(on: Any = None, to: Any = None, **words: Any) -> dict[str, Any]:
    """A transition as JSON has it."""
    return {key: value for key, value in {"on": on, "to": to, **words}.items() if value is not None}


def sent(made: Chart, *names: str, at: float | None = None) -> Step:
    """Send events one after the other; the last one's step."""
    steps = [made.send(Event(name, made.at if at is None else at)) for name in names]
    return steps[-1]


def ticked(made: Chart, at: float) -> Step:
    return made.send(Tick(at))


class ScriptedRobot:
    """Turns scripts into raw events, with the numbers of what the chart has started.

    A script names a goal, a call or a question by how many came after it: 0 is the last one. One that there is not
    gets a number that the chart does not know.

    Args:
        answerer: Who answers the questions.
    """

    def __init__(self, answerer: str = "rules") -> None:
        self.answerer = answerer
        self.goals: list[int] = []
        self.calls: list[int] = []
        self.questions: list[int] = []
        self.wanted: list[str] = []
        """Who was to have control, each time that the chart asked for it."""

    def follow(self, step: Step) -> Step:
        """Note what a step has started; gives the step."""
        for effect in step.effects:
            if isinstance(effect, StartGoal):
                self.goals.append(effect.number)
            elif isinstance(effect, CallService | StartBehaviour):
                self.calls.append(effect.number)
            elif isinstance(effect, Ask):
                self.questions.append(effect.question.number)
            elif isinstance(effect, Handover):
                self.wanted.append(effect.to)
        return step

    def event(self, drawn: Drawn, at: float) -> Event:
        """The event of one thing that happens.

        Args:
            drawn: `(event, name, k?)`, `(write, key, value, seconds that its stamp is off?)`, `(accepted, which)`,
                `(result, which, how, n?)`, `(proposal, which, option, parameter?)`, `(control, who or "" for the one
                that the chart wanted last, by?)`, `(command, name)`, `(doubt,)` or `(tick,)`.
            at: Its instant, in seconds.
        """
        kind, words = drawn[0], drawn[1:]
        if kind == "event":
            return Event(words[0], at, {"k": words[1]} if len(words) > 1 else {})
        if kind == "write":
            stamp = {"stamp": at + words[2]} if len(words) > 2 else {}
            return Event(words[0], at, {"value": words[1], **stamp}, "write")
        if kind in ("accepted", "result", "proposal"):
            return self._reply(kind, at, *words)
        if kind == "control" and (words[0] or self.wanted):
            by = {"by": words[1] if words[0] else "mission"} if len(words) > 1 else {}
            role = {"role": "operator"} if by.get("by") == "operator" else {}
            return Event(words[0] or self.wanted[-1], at, by | role, "control")
        if kind == "command":
            return Event(words[0], at, {}, kind)
        return Event("uncertain", at, {}, "doubt") if kind == "doubt" else Tick(at)

    def _reply(self, kind: str, at: float, which: int, what: str = "", number: int = 1) -> Event:
        """A goal's acceptance, the end of a goal or a call, or an answer."""
        if kind == "accepted":
            return Event("drive", at, {}, kind, _from_the_end(self.goals, which))
        if kind == "result":
            return Event(what, at, {"n": number}, kind, _from_the_end(sorted((*self.goals, *self.calls)), which))
        parameters = {"parameters": {"given": number}} if number > 1 else {}
        return Event(self.answerer, at, {"option": what, **parameters}, kind, _from_the_end(self.questions, which))


def _from_the_end(numbers: list[int], which: int) -> int:
    return numbers[-1 - which] if which < len(numbers) else UNKNOWN


def _events(value: Any) -> Any:
    if isinstance(value, dict):
        for key, item in value.items():
            if key in ("on", "raise"):
                yield from [item] if isinstance(item, str) else item
            else:
                yield from _events(item)
    elif isinstance(value, list):
        for item in value:
            yield from _events(item)


def _options(value: Any) -> Any:
    if isinstance(value, dict):
        for key, item in value.items():
            if key == "options":
                yield from item
            else:
                yield from _options(item)
    elif isinstance(value, list):
        for item in value:
            yield from _options(item)
