# SPDX-License-Identifier: Apache-2.0
"""What a person answers to "did you mean …?": which of the goals offered, if any."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rai_missions.errors import DefinitionError
from rai_missions.planning.goal import Goal, read_goal
from rai_missions.planning.reading.lexicon import Vocabulary, lexicon, lexicons
from rai_missions.planning.reading.neighbours import symbols
from rai_missions.planning.reading.noun_phrases import Cursor, noun_phrases
from rai_missions.planning.reading.phrases import Unread
from rai_missions.planning.reading.read import read_request, reading_data, reading_of
from rai_missions.planning.reading.reading import RequestReading
from rai_missions.planning.reading.symbols import LONGEST_REQUEST, words_of
from rai_missions.planning.reading.things import Things
from rai_missions.planning.scene import Scene
from rai_missions.planning.text.numbers import ordinal

__all__ = ("chosen", "read_answer")

AROUND = (",", ".", "put", "with", "and")


def chosen(answer: str, candidates: Sequence[Goal], scene: Scene) -> Goal | None:
    """The candidate that an answer means; None where it is a no, or means none or several of them.

    A yes means the only one. `The first`, `2` and `the last` count them; `the red one` is the one that alone has such a
    thing; a whole request means the candidate that is its goal.

    Args:
        answer: In free words.
        candidates: The goals offered, in the order of the question.
        scene: What is seen.
    """
    if not candidates or len(answer) > LONGEST_REQUEST:
        return None
    for code in lexicons():
        found = _in_language(answer, candidates, scene, lexicon(code))
        if found is not None:
            return found
    goal = reading_of(answer, scene).goal
    return goal if goal in candidates else None


def read_answer(text: str, offered: Iterable[Any], scene: Scene) -> dict[str, Any]:
    """What a text asks for, as `read_request` has it: the goal of the last question that it chooses, else its own.

    Args:
        text: In free words.
        offered: The goals of the last question as plain data, in its order; what is no goal is left out.
        scene: What is seen.
    """
    goal = chosen(text, [*_goals(offered)], scene)
    if goal is None:
        return read_request(text, scene)
    return reading_data(RequestReading(goal=goal))


def _goals(offered: Iterable[Any]) -> Iterable[Goal]:
    for each in offered:
        try:
            goal = read_goal(each)
        except DefinitionError:
            continue
        if isinstance(goal, Goal):
            yield goal


def _in_language(answer: str, candidates: Sequence[Goal], scene: Scene, words: Vocabulary) -> Goal | None:
    said = [word for word in words_of(answer, words) if word.isalnum()]
    if " ".join(said) in words.data["yes"]:
        return candidates[0] if len(candidates) == 1 else None
    counted = [word for word in said if word not in words.data["counted"]]
    place = ordinal(counted, words.data)
    if place is not None and len(counted) == 1:
        return candidates[place - 1 if place > 0 else place] if -1 <= place <= len(candidates) and place else None
    return _by_thing(answer, candidates, scene, words) or _by_thing(" ".join(counted), candidates, scene, words)


def _by_thing(answer: str, candidates: Sequence[Goal], scene: Scene, words: Vocabulary) -> Goal | None:
    cursor = Cursor(symbols(answer, words))
    cursor.skip(*AROUND)
    phrases = noun_phrases(cursor)
    cursor.skip(*AROUND)
    if len(phrases) != 1 or cursor.kind():
        return None
    try:
        alternatives = Things(scene, words, phrases).alternatives(phrases[0])
    except Unread:
        return None
    fitting = [goal for goal in candidates if any(set(names) <= set(goal.things()) for names in alternatives)]
    return fitting[0] if len(fitting) == 1 else None
