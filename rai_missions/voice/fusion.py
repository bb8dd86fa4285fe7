# SPDX-License-Identifier: Apache-2.0
"""What two recognisers and a network make of one turn, as one text and what each of them reads; pure.

The evidence of both for a phrase is added, as logarithms of likelihood ratios are, and that of the letters of the free
text: "close the mission" is nearer to "pause the mission" than "open it" is. Where the first has guesses, their letters
count instead. A phrase counts where the sum is large, and larger than that of any other, and where the turn lasted as
long as the phrase can. The second agrees where it holds the phrase for one of the two most probable. What is read as
"no" and is too short for it is no word; nor is a phrase of one word that the second takes for others, but for "stop".

A phrase that a trained network holds for far more probable than none counts as well, with the second's vote added,
where the first has evidence for it. Another phrase that the two read must have less of both. The first and the network
agree on it then. One that the network holds for far less probable than none is none, but for what was read freely.

Another phrase for which both have evidence, or the first has more, may have been meant as well, and is a reading, too:
"start the mission" is nearer to "pause the mission" by some voices. So is the one that the network holds for the best,
with the odds to count. Which is meant is decided where orders are judged.

Rule: the others can vote, agree and refuse, and no more: a phrase for which the first has no evidence never counts.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from difflib import SequenceMatcher
from types import MappingProxyType
from typing import Any, NamedTuple

from rai_missions.plain_data import is_number

__all__ = (
    "LEAST",
    "LEAST_FIRST_OF_ANY",
    "LEAST_STOP",
    "FusedTurn",
    "evidence_in",
    "fused",
    "guesses_in",
    "odds_in",
    "votes_in",
)

LEAST, LEAST_ALONE = 5.5, 8.5
"""What the evidence for a phrase must come to, in nats, where the second agrees; where it does not."""
LEAST_GUESSED, LEAST_GUESSED_ALONE = 9.0, 12.0
"""What the evidence must come to, as for `LEAST`, where the first guesses what it may be otherwise."""
MORE_FOR_WORDS = 1.5
"""How much more where the free text has more words than the phrase and nothing is guessed, so that the second's vote
alone is not enough."""
LEAST_FIRST = 2.4
"""What the first recogniser's own must come to."""
LEAST_STOP, LEAST_STOP_FIRST = 2.4, 1.0
"""What the two must come to for "stop", without a lead: one syllable has little, other speech less, and none is missed.
In loud noise "pause" is often as near to it: where that is not enough and "stop" is next, the first's own counts."""
LEAST_FIRST_OF_ANY = min(LEAST_FIRST, LEAST_STOP_FIRST)
"""With less of the first's own, no phrase counts, unless the network has the odds for it."""
LEAST_ODDS_OF_TWO = -2.5
"""With less odds, a phrase that has the evidence of the two is none, unless it was read freely: what is spoken as a
phrase has seldom less than 0, other speech that is like it -4. "stop" is, which the network knows less well."""
LEAST_ODDS, LEAST_ODDS_LEAD, LEAST_FIRST_AT_ODDS = 2.75, 1.0, 0.0
"""From which odds on, with the second's vote, a phrase counts, in nats; how much more they must be than those of
another phrase that was read; what the first's own must come to then."""
SHORTEST_S, LONGEST_S = (0.18, 0.03), (0.5, 0.08)
"""How long a phrase lasts, in seconds, and so many more for each of its letters."""
LEAST_AGREED_S = 0.24
"""So short may "stop" be with evidence enough, and any phrase that both read freely."""
STOP_S, LONGER_STOP_S = (0.3, 0.4), 0.56
"""How long "stop" lasts: it needs no more evidence then. How long it may be drawn out where the second disagrees."""
LEAST_SHORT, LEAST_LONG, LEAST_DRAWN_OUT = 3.5, 3.0, 4.0
"""What the first's own evidence for "stop" must come to in a sound that is shorter, where the second agrees; longer;
drawn out. Other speech that is nearest to "stop" has seldom as much."""
PAUSE = "pause"
LIKENESS, NO_LIKENESS, NO_TEXT = 6.0, 0.5, -1.5
"""Nats for the share of letters that a free text has in common with a phrase, the share that is no evidence, and nats
where nothing was read freely."""
GUESSED_LIKENESS = 20.0
"""Nats for the share that guesses have in common with it, each as probable as it is."""
LIKELY_GUESS = 0.5
"""As probable among the guesses, a phrase may be as short and as long as where the second agrees."""
MOST_GUESSES = 16
"""More of them are left out."""
WORDS_A_MORE, MORE_WORDS_BEST = 3, 2
"""For how many words of a phrase that is meant the free text may have one more; how many it may have more where the
phrase is the second's best. For "stop" one more is never too much: it must not be missed."""
LEAST_LEAD = 0.5
"""How much more it must be than that for the next phrase."""
VOTES = 2
"""For how many phrases the second votes, however many it has evidence for."""
MOST = 30.0
STOP = "stop"
STOPS = (STOP, "halt")
"""These count as they are read, however short they are."""


class FusedTurn(NamedTuple):
    """A turn as the recognisers read it."""

    text: str
    """A phrase, or what the first recogniser reads freely; empty where there are no words."""
    readings: tuple[str, ...] = ()
    """The text by each recogniser that reads it; after a phrase the others that may be meant, twice."""


def fused(
    text: str,
    first: Mapping[str, float],
    second: Mapping[str, float],
    phrases: Sequence[str],
    spoken_s: float | None = None,
    guesses: Mapping[str, float] = MappingProxyType({}),
    odds: Mapping[str, float] = MappingProxyType({}),
) -> FusedTurn:
    """The text of a turn.

    Args:
        text: What the first recogniser reads freely.
        first: Its evidence; see `Reading.evidence`.
        second: That of the second.
        phrases: Those that are expected.
        spoken_s: From the first frame of speech to the end of the last, in seconds; None where that is unknown.
        guesses: Those of the first; see `Reading.guesses`.
        odds: Those of a network; see `Reading.odds`.
    """
    found = _of_two(text, first, second, phrases, spoken_s, guesses)
    if found.text not in (STOP, _plain(text)) and odds.get(found.text, 0.0) < LEAST_ODDS_OF_TWO:
        found = _freely(text)
    chances = {each: value + second.get(each, 0.0) for each, value in odds.items() if each in first}
    best = max(chances, key=chances.__getitem__, default="")
    if not best or chances[best] < LEAST_ODDS:
        return found
    is_other = found.text in phrases and found.text != best
    lead = chances[best] - chances.get(found.text, math.inf) if is_other else math.inf
    if first[best] >= LEAST_FIRST_AT_ODDS and lead >= LEAST_ODDS_LEAD:
        return FusedTurn(best, (best, best))
    if is_other and found.text not in STOPS and best not in found.readings:
        return found._replace(readings=(*found.readings, best, best))
    return found


def _of_two(
    text: str,
    first: Mapping[str, float],
    second: Mapping[str, float],
    phrases: Sequence[str],
    spoken_s: float | None,
    guesses: Mapping[str, float],
) -> FusedTurn:
    """The text of a turn by the two recognisers alone; see `fused`."""
    plain, shares = _plain(text), _shares(guesses)
    if plain in phrases and _is_denied(plain, second):
        return FusedTurn("")
    phrase = plain if plain in phrases else _phrase(plain, first, second, phrases, shares)
    is_agreed = phrase in second or shares.get(phrase, 0.0) >= LIKELY_GUESS
    if phrase and (
        spoken_s is None
        or _can_last(phrase, spoken_s, first.get(phrase, 0.0), is_read=phrase == plain, is_agreed=is_agreed)
    ):
        bound = first.get(phrase, MOST)
        others = tuple(each for each in first if each != phrase and first[each] > (0.0 if each in second else bound))
        return FusedTurn(phrase, (phrase,) * (2 if phrase in second else 1) + others * 2)
    return FusedTurn("") if phrase == plain else _freely(text)


def _freely(text: str) -> FusedTurn:
    """What the first recogniser reads freely, as no phrase."""
    return FusedTurn(text, (text,)) if _plain(text) else FusedTurn("")


def _is_denied(phrase: str, second: Mapping[str, float]) -> bool:
    """Whether the second takes a phrase of one word, which the first reads freely, for others alone."""
    return bool(second) and phrase not in second and phrase not in STOPS and " " not in phrase


def _can_last(phrase: str, spoken_s: float, own: float, *, is_read: bool, is_agreed: bool) -> bool:
    """Whether a turn is long enough for a phrase, and no longer unless it was read freely; `own` is the first's."""
    if phrase in STOPS and is_read:
        return True
    if phrase == STOP:
        return own >= _least_of_stop(spoken_s, is_agreed=is_agreed)
    letters = sum(each.isalpha() for each in phrase)
    least, most = (base + each * letters for base, each in (SHORTEST_S, LONGEST_S))
    if is_agreed and is_read:
        least = LEAST_AGREED_S
    return least <= spoken_s and (spoken_s <= most or is_read)


def _least_of_stop(spoken_s: float, *, is_agreed: bool) -> float:
    """What the first's own evidence must come to for a sound of that length to be "stop"."""
    shortest, longest = STOP_S
    if spoken_s < LEAST_AGREED_S:
        return math.inf
    if spoken_s < shortest:
        return LEAST_SHORT if is_agreed else LEAST
    if spoken_s <= longest:
        return LEAST_STOP_FIRST
    return LEAST_LONG if is_agreed or spoken_s <= LONGER_STOP_S else LEAST_DRAWN_OUT


def _phrase(
    plain: str,
    first: Mapping[str, float],
    second: Mapping[str, float],
    phrases: Sequence[str],
    guessed: Mapping[str, float],
) -> str:
    """The phrase for which there is evidence enough, where this was read freely; empty where there is none."""
    sums = sorted(
        (first[each] + second.get(each, 0.0) + _likeness(plain, guessed, each), each)
        for each in phrases
        if each in first
    )
    if not sums:
        return ""
    most, phrase = sums[-1]
    lead = most - sums[-2][0] if len(sums) > 1 else math.inf
    words, read = len(phrase.split()), len(plain.split())
    is_enough = (
        most >= _least(is_agreed=phrase in second, is_guessed=bool(guessed), has_more=read > words)
        and first[phrase] >= LEAST_FIRST
        and lead >= LEAST_LEAD
    )
    if phrase == STOP:
        is_enough = most >= LEAST_STOP and first[phrase] >= LEAST_STOP_FIRST
    elif phrase == PAUSE and not is_enough and len(sums) > 1 and sums[-2][1] == STOP:
        phrase, is_enough = STOP, min(first[STOP], sums[-2][0]) >= LEAST_STOP
    is_best = phrase in second and second[phrase] == max(second.values())
    more = MORE_WORDS_BEST if is_best else 1 if phrase == STOP else words // WORDS_A_MORE
    return phrase if is_enough and read <= words + more else ""


def _least(*, is_agreed: bool, is_guessed: bool, has_more: bool) -> float:
    """What the evidence for a phrase must come to; `has_more` words has the free text."""
    if is_guessed:
        return LEAST_GUESSED if is_agreed else LEAST_GUESSED_ALONE
    return LEAST + (MORE_FOR_WORDS if has_more else 0.0) if is_agreed else LEAST_ALONE


def _likeness(plain: str, guessed: Mapping[str, float], phrase: str) -> float:
    """Nats of evidence that the letters of the guesses give, or of a free text; "stop" is too short for it."""
    if phrase == STOP:
        return 0.0
    if guessed:
        likeness = sum(share * _in_common(each, phrase) for each, share in guessed.items())
        return GUESSED_LIKENESS * (likeness - NO_LIKENESS)
    return LIKENESS * (_in_common(plain, phrase) - NO_LIKENESS) if plain else NO_TEXT


def _in_common(plain: str, phrase: str) -> float:
    """The share of letters that two texts have in common."""
    return SequenceMatcher(None, plain.replace(" ", ""), phrase.replace(" ", ""), autojunk=False).ratio()


def _shares(guesses: Mapping[str, float]) -> dict[str, float]:
    """Each guess, plain and without what it repeats, and how probable it is among them."""
    chances = defaultdict[str, float](float)
    for text, log_chance in guesses.items():
        chances[_once(_plain(text))] += math.exp(log_chance)
    total = sum(chances.values())
    return {each: chance / total for each, chance in chances.items()} if total else {}


def _once(plain: str) -> str:
    """A text that is the same words twice or more as these words alone."""
    words = plain.split()
    for size in range(1, len(words) // 2 + 1):
        if all(word == words[place % size] for place, word in enumerate(words)):
            return " ".join(words[:size])
    return plain


def _plain(text: str) -> str:
    return " ".join("".join(each if each.isalnum() or each == "'" else " " for each in text.lower()).split())


def evidence_in(data: Mapping[str, Any], phrases: Sequence[str]) -> dict[str, float]:
    """The evidence in a reply of a recogniser's process; what is no number of an expected phrase is left out."""
    return _numbers_in(data, "evidence", phrases)


def votes_in(data: Mapping[str, Any], phrases: Sequence[str]) -> dict[str, float]:
    """The evidence in a reply of the second's process, of the two phrases that it holds for the most probable."""
    found = evidence_in(data, phrases)
    return {each: found[each] for each in sorted(found, key=found.__getitem__)[-VOTES:] if found[each] > 0.0}


def odds_in(data: Mapping[str, Any], phrases: Sequence[str]) -> dict[str, float]:
    """The odds in a reply of a recogniser's process; what is no number of an expected phrase is left out."""
    return _numbers_in(data, "odds", phrases)


def _numbers_in(data: Mapping[str, Any], name: str, phrases: Sequence[str]) -> dict[str, float]:
    given = data.get(name)
    if not isinstance(given, Mapping):
        return {}
    return {each: max(-MOST, min(MOST, float(value))) for each in phrases if is_number(value := given.get(each))}


def guesses_in(data: Mapping[str, Any]) -> dict[str, float]:
    """The guesses in a reply of a recogniser's process; what is no text with a number is left out."""
    given = data.get("guesses")
    found = given.items() if isinstance(given, Mapping) else ()
    numbers = [(str(text), float(value)) for text, value in found if is_number(value)]
    return {text: max(-MOST, min(0.0, value)) for text, value in numbers[:MOST_GUESSES]}
