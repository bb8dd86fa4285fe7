# SPDX-License-Identifier: Apache-2.0
"""What a step made happen, as a person may ask for it: states entered, events, commands, answers, control, the end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rai_missions.conversation import RunEvent
from rai_missions.engine.step import Step

__all__ = ("happenings",)


def happenings(step: Step, states: Mapping[str, str], events: Mapping[str, str]) -> Iterator[RunEvent]:
    """What a step made happen, in order.

    Args:
        step: What the run did.
        states: State → the mission's sentence about it.
        events: Event → the mission's sentence about it.
    """
    event, by = step.event, str(step.event.data.get("by", ""))
    if event.kind == "event" and not step.ignored:
        yield RunEvent("event", event.name, step.at, events.get(event.name, ""))
    elif event.kind == "command" and event.name == "take_up":
        yield RunEvent("continued", "", step.at)
    elif event.kind == "command" and not step.refusal:
        yield RunEvent("command", event.name, step.at, by=by)
    elif event.kind == "control" and not step.refusal:
        yield RunEvent("control", event.name, step.at, by=by)
    for verdict in step.verdicts:
        if verdict.accepted or verdict.kind == "fallback":
            who = by if verdict.accepted and event.kind == "proposal" else ""  # the person, where one answered
            yield RunEvent("answered", verdict.option, step.at, by=who or verdict.by)
    for move in step.moves:
        for name in move.entered:
            yield RunEvent("entered", name, step.at, states.get(name, ""))
    if step.outcome:
        yield RunEvent("ended", step.outcome, step.at, step.why)
