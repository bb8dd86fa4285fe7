# SPDX-License-Identifier: Apache-2.0
"""What a step had done, in a line an effect."""

from __future__ import annotations

from rai_missions.engine.step import (
    Ask,
    CallService,
    CancelGoal,
    Effect,
    Handover,
    LogLine,
    PublishMessage,
    SayAloud,
    StartBehaviour,
    StartGoal,
    Step,
    StopBehaviour,
)
from visualize.text import template

__all__ = ("effect_words", "resting_words")


def effect_words(effect: Effect) -> str:
    """An effect as a person would state it, with what it sends and its number."""
    if isinstance(effect, StartGoal):
        return f"start {effect.action}{_sent(effect.goal)} for {effect.owner} (number {effect.number})"
    if isinstance(effect, CancelGoal):
        return f"cancel {effect.action} (number {effect.number})"
    if isinstance(effect, CallService):
        return f"call {effect.service}{_sent(effect.request)} (number {effect.number})"
    if isinstance(effect, PublishMessage):
        return f"publish {effect.topic}{_sent(effect.message)}"
    if isinstance(effect, SayAloud):
        return f"say “{effect.text}”"
    if isinstance(effect, LogLine):
        return f"log “{effect.text}”"
    if isinstance(effect, Ask):
        return f"ask {effect.question.asked} (question {effect.question.number})"
    if isinstance(effect, Handover):
        return f"ask for control to go to {effect.to}"
    if isinstance(effect, StartBehaviour):
        return f"tick the behaviour of {effect.owner} (number {effect.number})"
    if isinstance(effect, StopBehaviour):
        return f"stop the behaviour (number {effect.number})"
    return f"withdraw question {effect.number}"


def resting_words(step: Step) -> list[str]:
    """The trees that rest at a limit, as a person would state it."""
    continues = "continues at once" if step.wake_at == step.at else "waits for the next event that concerns it"
    return [f"the tree of '{name}' has gone round as far as a step allows; it {continues}" for name in step.resting]


def _sent(given: object) -> str:
    return f" ({template(given)})" if given else ""
