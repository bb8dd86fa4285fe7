# SPDX-License-Identifier: Apache-2.0
"""A step in words and as JSON, for the terminal, the pages, the recording and the node.

Rule: this is the only place that words a step; who shows it chooses, cuts and colours.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

from rai_missions.engine.decision import Verdict
from rai_missions.engine.step import Step, control_note
from rai_missions.event import is_e_stop
from rai_missions.plain_data import plain
from rai_missions.states import answerer_words
from rai_missions.states.control import CONTROLLERS

__all__ = ("Description", "describe", "effect_word", "step_json", "way_words")

SHOWN = {control_note(holder): control_note(words) for holder, words in CONTROLLERS.items()}
SHOWN[control_note("nobody")] += ", until the operator gives it"
"""The notes on who has control, as they are stored → as people read them."""
TRUTHS = {True: "true", False: "false", None: "unknown"}


class Description(NamedTuple):
    """A step in words."""

    event: str
    """Such as `anomaly`, `drive (3)`, `answered by the model`, `time`, `time: timed_out`."""
    way: str
    """States left and entered, such as `driving → assessing`; empty where none was entered."""
    effects: tuple[str, ...]
    """What is done, in order."""
    verdicts: tuple[str, ...]
    """What became of proposals, in order."""
    remarks: tuple[str, ...]
    """What else a reader should know, trees that rest included."""
    why: str
    """Why the event was refused, or, with the outcome, how the mission ended."""
    notes: tuple[str, ...]
    """Verdicts and remarks, in the order in which they came."""


def describe(step: Step) -> Description:
    """A step in words."""
    resting = resting_words(step)
    remarks = tuple(SHOWN.get(each, each) for each in step.remarks)
    verdicts = tuple(_verdict_words(each, step.notes[each.note]) for each in step.verdicts if each.note is not None)
    return Description(
        _event_words(step),
        way_words(step.exited, step.entered),
        tuple(effect.describe() for effect in step.effects),
        verdicts,
        (*remarks, *resting),
        f"{step.outcome}: {step.why}" if step.outcome else step.why,
        (*step.notes, *resting),
    )


def _verdict_words(verdict: Verdict, note: str) -> str:
    """A verdict with its answerer in words, as every reader is shown; its note names that by the word of `ask`."""
    who = f"question {verdict.number}: {answerer_words(verdict.by)}"
    if verdict.kind == "proposal":
        result = "accepted" if verdict.accepted else f"refused, {verdict.why}"
        return f"{who} proposed '{verdict.option}': {result}"
    if verdict.kind in ("absent", "failed"):
        return f"{who} {'cannot answer' if verdict.kind == 'absent' else 'gave no answer'}: {verdict.why}"
    return f"{who} {verdict.why}" if verdict.kind == "timed_out" else note


def step_json(step: Step, *, without: Collection[str] = ()) -> dict[str, Any]:
    """A step as JSON for its readers; what brings it back exactly is `journal.encode`.

    Args:
        step: Any step.
        without: The names of fields that are left out.
    """
    event, described = step.event, describe(step)
    fields = {
        "seq": step.seq,
        "at": step.at,
        "event": {
            "name": event.name,
            "kind": event.kind,
            "at": event.at,
            "number": event.number,
            "data": plain(event.data),
        },
        "exited": list(step.exited),
        "entered": list(step.entered),
        "taken": [place for move in step.moves for place in move.taken],
        "guards": [{"place": place, "value": TRUTHS[truth]} for place, truth in step.guards],
        "verdicts": list(described.verdicts),
        "notes": list(described.remarks),
        "effects": [{"name": effect_word(type(each)), "about": each.describe()} for each in step.effects],
        "outcome": step.outcome or "",
        "why": step.why,
    }
    return {name: value for name, value in fields.items() if name not in without}


def effect_word(kind: type[Any]) -> str:
    """What a kind of effect is called in JSON: `start_goal`."""
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in kind.__name__).lstrip("_")


def _event_words(step: Step) -> str:
    """An event by its name, and the number of what it answers; the command `kill` as the e-stop that it is.

    Time comes with what it brought: an outcome, or an event that was raised before.
    """
    event = step.event
    if event.kind in ("accepted", "result"):
        return f"{event.name} ({event.number})"
    if event.kind == "proposal":
        who = answerer_words(event.name)
        return f"answered by {who}" if "option" in event.data else f"no answer: {who}"
    if is_e_stop(event):
        return "e-stop"
    if event.kind == "tick":
        brought = step.moves[0].trigger if step.moves else ""
        return "time" if brought in ("", "after_s") else f"time: {brought}"
    return "control" if event.kind == "control" else event.name


def way_words(exited: Sequence[str], entered: Sequence[str]) -> str:
    """States left and entered, outer first; empty where none was entered."""
    left = [name for name in reversed(exited) if name not in entered]
    return f"{', '.join(left)} → {', '.join(entered)}".strip() if entered else ""


def resting_words(step: Step) -> tuple[str, ...]:
    """The trees that rest at a limit."""
    continues = "continues at once" if step.wake_at == step.at else "waits for the next event that concerns it"
    return tuple(
        f"the tree of '{name}' has gone round as far as a step allows; it {continues}" for name in step.resting
    )
