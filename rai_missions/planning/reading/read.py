# SPDX-License-Identifier: Apache-2.0
"""Reads a request in free words over a scene, by rules alone.

Rule: a goal comes out only where every word is accounted for and one reading is left.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rai_missions.errors import DefinitionError
from rai_missions.planning.goal import FIRST_SEEN, Goal, read_goal
from rai_missions.planning.reading.arranging import left_out
from rai_missions.planning.reading.describe import described
from rai_missions.planning.reading.goal_writer import GoalWriter
from rai_missions.planning.reading.lexicon import Vocabulary, lexicon, lexicons
from rai_missions.planning.reading.neighbours import symbols
from rai_missions.planning.reading.offers import goals_of_rest, is_offered
from rai_missions.planning.reading.phrases import Clause, Phrase, Unread
from rai_missions.planning.reading.picks import Picks, tries
from rai_missions.planning.reading.reading import RequestReading
from rai_missions.planning.reading.rewrites import names_bin, put_away, rewritten, taken_out
from rai_missions.planning.reading.symbols import ENDS, LONGEST_REQUEST, MOST_WORDS, Symbol, kind_at
from rai_missions.planning.reading.things import Things
from rai_missions.planning.reading.wishes import wishes_of
from rai_missions.planning.relations import at_first_poses
from rai_missions.planning.scene import Scene
from rai_missions.planning.text.language_file import spoken
from rai_missions.redaction import clipped

__all__ = ("language_of", "read_request", "reading_of")

MOST_CANDIDATES = 6
"""Goals that a question offers."""
MOST_TRIES = 40
"""Combinations of what phrases may mean that are tried; of more, the person is asked without candidates."""
LONGEST_SENTENCE = 4_000
"""Characters of a question or a reason."""
PREFERRED = "en"
BEFORE_THING = ("put", "grasp", "swap", "stack", "relation", "the")
"""Kinds of symbols after which a thing is named."""
AFTER_THING = ("", ",", ".", "and", "with", "relation", "each_other", "stays")
"""Kinds of symbols that come after a thing."""


def read_request(request: str, scene: Scene) -> dict[str, Any]:
    """What a request asks for, as plain data, swaps and shifts rewritten to the poses that are seen now.

    `goal` (null where there is none), `question`, `candidates`, `reason`, `about` and `covers_all`, as in
    `RequestReading`.

    Args:
        request: In free words, of any language that there is.
        scene: What is seen.
    """
    found = reading_of(request, scene)
    goal = at_first_poses(found.goal, scene) if found.goal is not None else None
    candidates = tuple(at_first_poses(each, scene) for each in found.candidates)
    return reading_data(found.model_copy(update={"goal": goal, "candidates": candidates}))


def reading_data(found: RequestReading) -> dict[str, Any]:
    """A reading as plain data, with each of its words."""
    return {
        "goal": found.goal.written() if found.goal is not None else None,
        "question": found.question,
        "candidates": [goal.written() for goal in found.candidates],
        "reason": found.reason,
        "about": found.about,
        "covers_all": found.covers_all,
    }


def reading_of(request: str, scene: Scene) -> RequestReading:
    """What a request asks for.

    Args:
        request: In free words; whatever it contains, it is only read.
        scene: What is seen.

    Returns:
        A goal, a question, or a refusal. A goal names only things of the scene that words of the request mean.
    """
    codes = _languages()
    attempts = [_read(request, scene, lexicon(code)) for code in codes]
    best = min(attempts, key=lambda attempt: _unknown(attempt.found))
    goals = {goal.meaning: goal for attempt in attempts if (goal := attempt.reading.goal) is not None}
    return _with_offer(best, scene) if len(goals) < 2 else _asked([*goals.values()], lexicon(codes[0]))


def language_of(request: str) -> str:
    """The code of the language whose words a request has most of; English where two have as many."""
    text = clipped(request, LONGEST_REQUEST)
    return min(_languages(), key=lambda code: _unknown(symbols(text, lexicon(code))))


def _languages() -> list[str]:
    """The codes of the languages, the preferred one first."""
    return sorted(lexicons(), key=lambda code: code != PREFERRED)


def _unknown(found: Iterable[Symbol]) -> int:
    return sum(symbol.kind == "unknown" for symbol in found)


@dataclass(frozen=True, slots=True)
class _Attempt:
    found: Sequence[Symbol]
    words: Vocabulary
    reading: RequestReading


def _read(request: str, scene: Scene, words: Vocabulary) -> _Attempt:
    found = rewritten(request, words) if len(request) <= LONGEST_REQUEST else []
    try:
        if len(request) > LONGEST_REQUEST or len(found) > MOST_WORDS:
            raise words.unread("too_long")
        reading = _read_symbols(found, scene, words)
    except Unread as error:
        about = clipped(error.about, LONGEST_SENTENCE)
        reading = RequestReading(question="" if error.refused else about, reason=error.reason, about=about)
    return _Attempt(found, words, reading)


def _with_offer(attempt: _Attempt, scene: Scene) -> RequestReading:
    """The reading; where it asks back, with an offer of what is read of the request, if that may be offered."""
    found, words, reading = attempt.found, attempt.words, attempt.reading

    def goals_of(part: Sequence[Symbol]) -> tuple[Goal, ...]:
        try:
            read = _read_symbols([*part], scene, words)
        except Unread as error:
            if error.reason == "forbidden":
                raise
            return ()
        return (read.goal,) if read.goal is not None else read.candidates

    try:
        goals = goals_of_rest(found, words, goals_of) if is_offered(reading.reason, found, words) else ()
    except Unread:
        return reading
    if not goals:
        return reading
    offered = _asked(goals, words)
    question = clipped(f"{reading.question} {offered.question}", LONGEST_SENTENCE)
    return reading.model_copy(update={"question": question, "about": question, "candidates": offered.candidates})


def _read_symbols(found: list[Symbol], scene: Scene, words: Vocabulary) -> RequestReading:
    plain, is_sure = _plain(found, words, scene)
    ways = list(wishes_of(plain, words))
    meant = [_meant(way, wishes, scene, words) for way, wishes in ways]
    goals = dict[Hashable, Goal]()
    for goal in (goal for each in meant for goal in each.goals):
        goals.setdefault(goal.meaning, goal)
    if is_sure and len(goals) == len(ways) == 1 and meant[0].is_sure:
        (goal,) = goals.values()
        return RequestReading(goal=goal, covers_all=_covers_all(ways[0][1], goal))
    offered = _asked([*goals.values()], words)
    about = next((each.absent for each in reversed(meant) if each.absent), "")
    if not about:
        return offered
    question = clipped(f"{about} {offered.question}", LONGEST_SENTENCE)
    return offered.model_copy(update={"question": question, "about": question, "reason": "absent"})


def _plain(found: list[Symbol], words: Vocabulary, scene: Scene) -> tuple[list[Symbol], bool]:
    """The symbols without what only leads to a question, and whether there was none of that.

    Raises:
        Unread: A word of them is not read: a negation, a question, what is forbidden or unknown.
    """
    negated = (symbol for at, symbol in enumerate(found) if symbol.kind == "no" and not _is_limit(found, at))
    if (negation := next(negated, None)) is not None:
        raise words.unread("negated", negation.text)
    if asked := next((symbol for symbol in found if symbol.kind == "asked"), None):
        raise words.unread("asked", asked.text, reason="unread")
    is_open = any(symbol.kind == "toss" for symbol in found) and not names_bin(found)
    if any(symbol.kind == "toss" for symbol in found):
        found = list(put_away(found, words))
    _refuse_forbidden(found, words)
    found = taken_out(found, words)
    if unknown := next((symbol for symbol in found if symbol.kind in ("unknown", "forbidden")), None):
        raise _unknown_word(found, found.index(unknown), scene, words)
    if _is_part_of_place([symbol for symbol in found if symbol.kind not in ("the", "a")]):
        raise words.unread("coordinates")
    plain = [symbol for symbol in found if symbol.kind != "sorted"]
    return plain, len(plain) == len(found) and not is_open


class MeantGoals(NamedTuple):
    """What the wishes of one way to read a request mean."""

    goals: Sequence[Goal]
    is_sure: bool
    """Nothing of it is left open: every meaning makes a goal, all things are there, and no tower is of any order."""
    absent: str = ""
    """What is not there, as a sentence; the goals are those of the other wishes then."""


def _meant(way: Sequence[Symbol], wishes: tuple[Clause, ...], scene: Scene, words: Vocabulary) -> MeantGoals:
    """The goals of wishes, or of those of them whose things are there.

    Raises:
        Unread: They are none, or a word of arranging is left out of them.
    """
    absent = ""
    try:
        goals, is_whole = _goals(wishes, scene, words)
    except Unread as error:
        present = _present(wishes, scene, words) if error.reason == "absent" else ()
        if not 0 < len(present) < len(wishes):
            raise
        absent, (goals, is_whole) = error.about, _goals_or(error, present, scene, words)
    if word := left_out(way, goals[0]):
        raise words.unread("left_out", word, reason="unread")
    is_sure = is_whole and not absent and not any(each.kind == "towers" or each.is_open for each in wishes)
    return MeantGoals(goals, is_sure, absent)


def _present(wishes: Sequence[Clause], scene: Scene, words: Vocabulary) -> tuple[Clause, ...]:
    """The wishes about things that are seen."""
    things = Things(scene, words, [*_phrases(wishes)])
    return tuple(each for each in wishes if not any(_is_absent(phrase, things) for phrase in _phrases([each])))


def _is_absent(phrase: Phrase, things: Things) -> bool:
    try:
        if phrase.kind in ("things", "everything"):
            things.alternatives(phrase)
    except Unread as error:
        return error.reason == "absent"
    return False


def _goals_or(absent: Unread, present: tuple[Clause, ...], scene: Scene, words: Vocabulary) -> tuple[list[Goal], bool]:
    """The goals of the wishes that are left.

    Raises:
        Unread: What was absent, where these are not read without it.
    """
    try:
        return _goals(present, scene, words)
    except Unread:
        raise absent from None


def _unknown_word(found: Sequence[Symbol], at: int, scene: Scene, words: Vocabulary) -> Unread:
    """The question about the unknown word at a place of a request: `put Bob on the tray` asks which thing Bob is."""
    before, after = kind_at(found, at - 1), kind_at(found, at + 1)
    seen = words.listed([f"'{spoken(each.name)}'" for each in scene.things])
    if seen and before in BEFORE_THING and after in AFTER_THING and found[at].text.isalpha():
        return words.unread("which_thing", found[at].text, seen, reason="unknown_word")
    return words.unread("unknown_word", found[at].text)


def _is_limit(found: Sequence[Symbol], at: int) -> bool:
    """Whether a word of negation continues a limit: `what is no cube and no apple`."""
    before = [each.kind for each in found[:at]]
    while before and before[-1] in ("and", "or", ",", "a", "noun", "no"):
        if before.pop() == "noun" and before[-1:] == ["not_a"]:
            return True
    return False


def _is_part_of_place(found: Sequence[Symbol]) -> bool:
    """`in the middle of the desk`, `at the bottom of the bin`: a place without numbers, and no level of a tower."""
    return any(
        level.kind == "level" and word.kind == "with" and (where.kind == "desk" or where.is_container)
        for level, word, where in zip(found, found[1:], found[2:], strict=False)
    )


def _covers_all(wishes: Sequence[Clause], goal: Goal) -> bool:
    """Whether a thing that is seen later belongs to the goal; swaps, shifts and ranks are of what is seen first."""
    if any(True for _ in goal.of_kind(*FIRST_SEEN)) or any(each.rank for each in _phrases(wishes)):
        return False
    is_bare_tower = any(wish.kind == "stack" and not wish.subjects for wish in wishes)
    return is_bare_tower or any((each.is_many or each.is_all) and each.count is None for each in _phrases(wishes))


def _refuse_forbidden(found: Sequence[Symbol], words: Vocabulary) -> None:
    for at, symbol in enumerate(found):
        is_verb = symbol.value != "act" or {kind_at(found, at - 1), kind_at(found, at + 1)} & {"", *ENDS}
        if symbol.kind == "toss" or (symbol.kind == "forbidden" and is_verb):
            raise words.unread("forbidden", symbol.text, refused=True)


def _goals(found: tuple[Clause, ...], scene: Scene, words: Vocabulary) -> tuple[list[Goal], bool]:
    """Every goal that the clauses may mean, and whether no other meaning was left out because it makes no goal.

    Of two that ask for the same the first is one of them.

    Raises:
        Unread: Of the first meaning, where none makes a goal.
    """
    things = Things(scene, words, [*_phrases(found)])
    goals, faults = dict[Hashable, Goal](), list[Unread]()
    count = 0
    for each in tries(lambda picks: _goal(things, found, picks, words), MOST_TRIES):
        count += 1
        if isinstance(each, Goal):
            goals.setdefault(each.meaning, each)
        else:
            faults.append(each)
    if not goals:
        raise faults[0]
    if count == MOST_TRIES:
        raise words.unread(reason="ambiguous")
    return list(goals.values()), not faults


def _goal(things: Things, found: tuple[Clause, ...], picks: Picks, words: Vocabulary) -> Goal | Unread:
    try:
        predicates = GoalWriter(things, picks).predicates(found)
    except Unread as error:
        return error
    try:
        goal = read_goal({"all": predicates})
    except DefinitionError:
        return words.unread("contradiction", refused=True)
    return goal if isinstance(goal, Goal) else words.unread()


def _phrases(found: Sequence[Clause]) -> Iterator[Phrase]:
    for clause in found:
        whole = [
            *clause.subjects,
            *(phrase for phrase, _ in clause.levels),
            *([clause.target] if clause.target else []),
            *clause.ends,
        ]
        for phrase in whole:
            yield phrase
            yield from phrase.others
            yield from phrase.without


def _asked(goals: Sequence[Goal], words: Vocabulary) -> RequestReading:
    offered = tuple(goals[:MOST_CANDIDATES])
    every = words.listed([described(goal, words) for goal in offered], "or")
    question = clipped(words.text("did_you_mean", every), LONGEST_SENTENCE)
    return RequestReading(question=question, candidates=offered, reason="ambiguous", about=question)
