# SPDX-License-Identifier: Apache-2.0
"""A run in words, for answers and reports alike: its state, who has control of it, and what it left unfinished."""

from __future__ import annotations

from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.values import about_words
from rai_missions.conversation.view import StatusView

__all__ = ("control_text", "end_text", "goals_text", "state_of_run")


def state_of_run(view: StatusView, language: Language) -> str:
    """`the mission 'x' is paused`, or that none is running; without a full stop."""
    if not view.mode:
        return language.text("state_none")
    return language.text("state", mission=spoken(view.mission), mode=language.word("modes", view.mode))


def control_text(view: StatusView, language: Language) -> str:
    """Who has control, where the mission waits for another to have it; empty where it waits for no one's."""
    holder = language.word("holders", view.control)
    if not view.is_alive:
        return ""
    if view.held_by:
        return language.text("held", holder=holder)
    wanted = [language.word("holders", each) for each in view.wanted if each != view.control]
    return language.text("waits_control", holder=holder, wanted=language.listed(wanted)) if wanted else ""


def end_text(view: StatusView, language: Language) -> str:
    """Why a run ended so: its author's sentence, else what kind of end it was; without a full stop."""
    why = about_words(view.why)
    return language.text(f"end_{view.end}", why=why, name=spoken(view.end_name)) if view.end else why


def goals_text(view: StatusView, language: Language) -> str:
    """The actions that may still be executing, as a sentence; empty where there is none."""
    goals = language.listed([spoken(name) for name in view.open_goals])
    return language.text("open_goals", goals=goals) if goals else ""
