# SPDX-License-Identifier: Apache-2.0
"""A goal in words, for the person who is asked whether it is meant."""

from __future__ import annotations

from rai_missions.planning.goal import AtPlace, Beyond, Goal, OnTop, Predicate, Shifted
from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.scene import DESK
from rai_missions.planning.text.language_file import spoken

__all__ = ("described",)


def described(goal: Goal, lexicon: Vocabulary) -> str:
    """The goal as part of a sentence: `'red cube' on 'blue cube' and 'apple' in 'tray'`."""
    parts = [_predicate(each, lexicon) for each in goal.all if not _is_foot(each, goal)]
    return lexicon.listed(parts)


def _is_foot(each: Predicate, goal: Goal) -> bool:
    """Whether it is only the lowest of a tower on the desk."""
    if not isinstance(each, OnTop) or each.on[1] != DESK:
        return False
    return any(other.on[1] == each.on[0] for other in goal.of_kind(OnTop))


def _predicate(each: Predicate, lexicon: Vocabulary) -> str:
    names = [lexicon.text("thing", spoken(name)) for name in each.things()]
    if isinstance(each, AtPlace):
        return lexicon.text("at", names[0], f"{each.x:g}", f"{each.y:g}")
    if isinstance(each, Beyond) and each.gap_m is not None:
        return lexicon.text(f"{each.word}_gap", *names, f"{each.gap_m:g}")
    if isinstance(each, Shifted):
        is_moved = bool(each.dx or each.dy)
        return lexicon.text("shifted" if is_moved else "stays", names[0], f"{each.dx:g}", f"{each.dy:g}")
    if each.word in ("grouped", "apart"):
        return lexicon.text(each.word, lexicon.listed(names))
    return lexicon.text(each.word, *names)
