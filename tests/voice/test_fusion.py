# SPDX-License-Identifier: Apache-2.0
"""What two recognisers make of a turn, over any evidence."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from rai_missions.voice.fusion import (
    LEAST,
    LEAST_FIRST_AT_ODDS,
    LEAST_ODDS,
    LEAST_ODDS_LEAD,
    LEAST_ODDS_OF_TWO,
    LEAST_STOP,
    evidence_in,
    fused,
    guesses_in,
    odds_in,
    votes_in,
)

PHRASES = ("stop", "yes", "cancel the mission", "resume the mission")
numbers = st.floats(-20, 20)
evidence = st.dictionaries(st.sampled_from(PHRASES), numbers)
guesses = st.dictionaries(st.sampled_from(["Stop.", "Cancel the mission.", "yes", "the panel", ""]), st.floats(-9, 0))
votes = st.dictionaries(st.sampled_from(PHRASES), st.sampled_from([1.0, 2.0]), max_size=2)


@given(st.sampled_from(["", "the panel", "Yes.", "stop it"]), evidence, votes)
def test_a_phrase_is_read_freely_or_has_evidence_and_the_second_alone_makes_none(
    text: str, first: dict[str, float], second: dict[str, float]
) -> None:
    found = fused(text, first, second, PHRASES)
    if found.text in PHRASES and text != "Yes.":
        assert first[found.text] >= (1.0 if found.text == "stop" else 2.4)
        least = LEAST_STOP if found.text == "stop" else LEAST
        assert first[found.text] + second.get(found.text, 0.0) >= least - 3.0, "letters give three nats at most"
    same = found.readings.count(found.text)
    assert same == (0 if not found.text else 2 if found.text in second else 1)
    assert found.readings == (found.text,) * same + found.readings[same:]
    assert fused(text, {}, second, PHRASES).text in (text, "yes" if "yes" in second or not second else "")


@given(evidence, votes)
def test_another_phrase_for_which_both_have_evidence_or_the_first_has_more_is_read_as_well(
    first: dict[str, float], second: dict[str, float]
) -> None:
    found = fused("", first, second, PHRASES)
    others = set[str]()
    if found.text:
        others = {each for each in first if first[each] > (0.0 if each in second else first[found.text])} - {found.text}
    assert {each: found.readings.count(each) for each in found.readings if each != found.text} == dict.fromkeys(
        others, 2
    )


@given(evidence, votes, st.sampled_from(PHRASES))
def test_more_evidence_for_a_phrase_never_takes_it_away(
    first: dict[str, float], second: dict[str, float], phrase: str
) -> None:
    if fused("", first, second, PHRASES).text == phrase:
        assert fused("", {**first, phrase: first[phrase] + 1.0}, second, PHRASES).text == phrase


@given(st.sampled_from(["", "the panel", "Yes.", "stop it"]), evidence, votes, st.floats(0.0, 20.0))
def test_the_length_of_a_turn_can_only_take_a_phrase_away(
    text: str, first: dict[str, float], second: dict[str, float], spoken_s: float
) -> None:
    whole, found = fused(text, first, second, PHRASES), fused(text, first, second, PHRASES, spoken_s)
    is_too_short_for_yes = text == "Yes." and spoken_s < 0.27 and found.text == ""
    assert found == whole or is_too_short_for_yes or (found.text == text and whole.text in PHRASES and text != "Yes.")


def test_a_turn_that_is_too_short_or_too_long_for_a_phrase_is_none() -> None:
    def read(phrase: str, spoken_s: float) -> str:
        return fused("", {phrase: 12.0}, {phrase: 2.0}, PHRASES, spoken_s).text

    assert [read("stop", each) for each in (0.2, 0.25, 0.8, 2.0)] == ["", "stop", "stop", "stop"], "it may be drawn out"
    assert [read("yes", each) for each in (0.2, 0.4, 0.8)] == ["", "yes", ""]
    assert [read("cancel the mission", each) for each in (0.5, 0.7, 1.7, 1.8)] == ["", *["cancel the mission"] * 2, ""]
    assert fused("Stop.", {"stop": 20.0}, {}, PHRASES, 0.1).text == "stop", "what is read freely counts"
    assert fused("Yes.", {"yes": 20.0}, {"yes": 2.0}, PHRASES, 0.2).text == "", "but for a syllable"
    for second, text in (({"resume": 1.0}, "resume"), ({}, "")):
        quick = fused("Resume.", {"resume": 20.0}, second, (*PHRASES, "resume"), 0.3).text
        assert quick == text, "a person may be quick where both read it"
    alone = [
        fused("", {"stop": own}, {}, PHRASES, spoken_s).text
        for own, spoken_s in ((4.5, 0.26), (4.5, 0.31), (6.5, 0.29), (6.5, 0.2))
    ]
    assert alone == ["", "stop", "stop", ""], "longer where the second disagrees and the first is less sure"


def test_a_sound_that_is_shorter_or_longer_than_stop_needs_more_evidence_for_it() -> None:
    agreed = {"stop": 1.0}
    cases = (
        (0.26, 3.2, agreed, False), (0.26, 4.2, agreed, True), (0.26, 4.2, {}, False), (0.35, 2.7, {}, True),
        (0.5, 2.7, agreed, False), (0.5, 3.2, {}, True), (0.6, 3.2, {}, False), (0.6, 3.2, agreed, True),
        (0.6, 4.2, {}, True), (0.384, 2.6, agreed, True),
    )  # fmt: skip
    for spoken_s, own, second, is_stop in cases:
        found = fused("Just have", {"stop": own}, second, PHRASES, spoken_s).text
        assert found == ("stop" if is_stop else "Just have"), (spoken_s, own, second)


def test_a_short_stop_that_the_second_disagrees_on_counts_where_it_is_the_likely_guess() -> None:
    for guessed, is_stop in (({"Stop.": -1.9, "No.": -4.3}, True), ({"Stop.": -2.5, "Go.": -1.9}, False), ({}, False)):
        found = fused("Just go.", {"stop": 5.2}, {"yes": 2.0}, PHRASES, 0.26, guessed)
        assert found.text == ("stop" if is_stop else "Just go."), guessed
        assert found.readings == (found.text,), "the second has not read it"


def test_one_word_that_the_second_takes_for_others_is_no_phrase_but_stop_is() -> None:
    others, phrases = {"no": 2.0, "resume the mission": 1.0}, (*PHRASES, "wait")
    assert fused("Wait.", {"wait": 20.0}, others, phrases) == ("", ())
    assert fused("Wait.", {"wait": 20.0}, {}, phrases) == ("wait", ("wait",)), "it may have found nothing, or be none"
    assert fused("Wait.", {"wait": 20.0}, {**others, "wait": 1.0}, phrases).text == "wait"
    assert fused("Stop.", {"stop": 20.0}, others, phrases).text == "stop"
    assert fused("Cancel the mission.", {"cancel the mission": 20.0}, others, phrases).text == "cancel the mission"


def test_two_phrases_that_are_as_probable_are_none() -> None:
    assert fused("", {"yes": 9.1, "cancel the mission": 9.2}, {}, PHRASES).text == ""
    found = fused("", {"yes": 9.1, "cancel the mission": 9.2}, {"yes": 2.0}, PHRASES)
    assert found == ("yes", ("yes", "yes", "cancel the mission", "cancel the mission")), "the second decides, in doubt"


def test_a_phrase_that_the_second_does_not_agree_on_needs_more_evidence() -> None:
    assert fused("", {"yes": 7.0}, {"stop": 2.0}, PHRASES).text == ""
    assert fused("", {"yes": 7.0}, {"yes": 1.0}, PHRASES).text == "yes"
    assert fused("", {"stop": 3.0, "yes": 1.0}, {}, PHRASES) == ("stop", ("stop",))


def test_stop_counts_where_pause_is_nearer_and_not_enough() -> None:
    phrases = (*PHRASES, "pause")
    assert fused("", {"pause": 5.5, "stop": 3.8}, {"pause": 1.0}, phrases).text == "stop"
    assert fused("", {"pause": 5.5, "stop": 2.3}, {"pause": 1.0}, phrases).text == ""
    assert fused("", {"pause": 9.0, "stop": 3.8}, {"pause": 1.0}, phrases).text == "pause"
    assert fused("", {"pause": 6.0, "yes": 5.6, "stop": 3.8}, {}, phrases).text == ""


def test_letters_of_the_free_text_decide_what_is_near() -> None:
    first, second = {"cancel the mission": 4.5}, {"cancel the mission": 1.0}
    assert fused("Can sell the mission.", first, second, PHRASES).text == "cancel the mission"
    assert fused("Open it, Meg.", first, second, PHRASES).text == "Open it, Meg."


def test_letters_of_what_is_guessed_decide_instead_of_those_of_the_free_text() -> None:
    first, second = {"cancel the mission": 7.0}, {"cancel the mission": 2.0}
    near = {"Council the mission.": -1.5, "Until the mission.": -2.0}
    far = {"Open it, Meg.": -0.5, "Council the mission.": -4.0}
    assert fused("And seldom mission", first, second, PHRASES, None, near).text == "cancel the mission"
    assert fused("Can sell the mission.", first, second, PHRASES, None, far).text == "Can sell the mission."
    assert fused("Can sell the mission.", first, second, PHRASES).text == "cancel the mission"


@given(evidence, votes, guesses)
@example({"cancel the mission": 2.0}, {"cancel the mission": 2.0}, {"Cancel the mission.": -0.5})
def test_guesses_alone_make_no_phrase(
    first: dict[str, float], second: dict[str, float], guessed: dict[str, float]
) -> None:
    found = fused("the panel", first, second, PHRASES, None, guessed).text
    assert found == "the panel" or first[found] >= (1.0 if found == "stop" else 2.4)


@given(evidence, votes, guesses, st.sampled_from(["{0}!", "{0} {0}", "{0}. {0}. {0}."]))
def test_a_guess_counts_the_same_however_it_is_written_and_repeated(
    first: dict[str, float], second: dict[str, float], guessed: dict[str, float], form: str
) -> None:
    again = {form.format(text.rstrip(".")): value for text, value in guessed.items()}
    one, other = (fused("", first, second, PHRASES, None, each) for each in (guessed, again))
    assert one == other


@given(evidence, votes, guesses)
def test_a_guess_that_is_the_phrase_never_takes_it_away(
    first: dict[str, float], second: dict[str, float], guessed: dict[str, float]
) -> None:
    phrase = "cancel the mission"
    if guessed and fused("", first, second, PHRASES, None, guessed).text == phrase:
        assert fused("", first, second, PHRASES, None, {"Cancel the mission.": -1.0}).text == phrase


def test_a_sentence_with_many_more_words_is_no_phrase() -> None:
    read = "receive the message of the newest mission"
    assert fused(read, {"resume the mission": 12.0}, {"resume the mission": 2.0}, PHRASES) == (read, (read,))


@given(st.sampled_from(PHRASES[1:]), st.integers(0, 4), st.sampled_from([None, 1.0, 2.0]))
def test_a_free_text_of_more_words_is_a_phrase_only_if_it_is_the_second_s_best(
    phrase: str, more: int, vote: float | None
) -> None:
    other = {"pause": 2.0 if vote == 1.0 else 1.0}
    read = " ".join(["those"] * (len(phrase.split()) + more))
    found = fused(read, {phrase: 15.0}, other | ({phrase: vote} if vote else {}), (*PHRASES, "pause"))
    assert (found.text == phrase) == (more <= (2 if vote == 2.0 else len(phrase.split()) // 3))


def test_a_free_text_of_more_words_asks_for_more_evidence() -> None:
    phrases = (*PHRASES, "wait")
    read = [fused(text, {"wait": own}, {"wait": 2.0}, phrases).text for text in ("Way", "Why it") for own in (3.5, 6.0)]
    assert read == ["wait", "wait", "Why it", "wait"]
    assert fused("This one.", {"stop": 2.4}, {"stop": 1.0}, phrases).text == "stop", "but for a stop"


def test_stop_may_be_one_word_of_two() -> None:
    read = [fused(text, {"stop": 9.0}, {"yes": 2.0}, PHRASES).text for text in ("It's fine.", "That is fine.")]
    assert read == ["stop", "That is fine."]


def test_what_a_recogniser_sends_as_evidence_is_numbers_of_expected_phrases() -> None:
    sent = {"yes": 1, "stop": float("nan"), "go": 9.0, "cancel the mission": "9", "resume the mission": 1e9}
    assert evidence_in({"evidence": sent}, PHRASES) == {"yes": 1.0, "resume the mission": 30.0}
    assert evidence_in({"evidence": ["yes"]}, PHRASES) == {}
    assert evidence_in({}, PHRASES) == {}


def test_what_a_recogniser_sends_as_guesses_is_texts_with_their_log_probability() -> None:
    sent = {"yes": -1, "stop": float("nan"), "go": 9.0, "no": "9", "far": -1e9}
    assert guesses_in({"guesses": sent}) == {"yes": -1.0, "go": 0.0, "far": -30.0}
    assert len(guesses_in({"guesses": {str(each): -1.0 for each in range(99)}})) == 16
    assert guesses_in({"guesses": ["yes"]}) == guesses_in({}) == {}


TURNS = st.tuples(st.sampled_from(["", "the panel", "Yes.", "stop it"]), evidence, votes)


def refusals(odds: dict[str, float]) -> dict[str, float]:
    """Odds that can refuse a phrase and make none."""
    return {each: min(0.0, value) for each, value in odds.items()}


@given(TURNS, st.floats(-20.0, LEAST_ODDS_OF_TWO, exclude_max=True))
def test_a_phrase_that_the_network_refuses_counts_only_where_it_is_stop_or_read_freely(
    turn: tuple[str, dict[str, float], dict[str, float]], odds: float
) -> None:
    alone, found = fused(*turn, PHRASES), fused(*turn, PHRASES, None, {}, dict.fromkeys(PHRASES, odds))
    text = turn[0]
    is_refused = alone.text in ("cancel the mission", "resume the mission") or (alone.text == "yes" and text != "Yes.")
    assert found == ((text, (text,) * bool(text)) if is_refused else alone)


@given(TURNS, evidence, st.none() | st.floats(0.0, 4.0))
def test_the_odds_of_a_network_and_the_votes_make_a_phrase_of_what_the_first_has_evidence_for(
    turn: tuple[str, dict[str, float], dict[str, float]], odds: dict[str, float], spoken_s: float | None
) -> None:
    alone = fused(*turn, PHRASES, spoken_s, {}, refusals(odds))
    found = fused(*turn, PHRASES, spoken_s, {}, odds)
    _, first, second = turn
    chances = {each: odds[each] + second.get(each, 0.0) for each in odds if each in first}
    best = max(chances, key=lambda each: chances[each], default="")
    is_other = alone.text in PHRASES and alone.text != best
    leads = alone.text in chances and chances[best] - chances[alone.text] >= LEAST_ODDS_LEAD
    if not best or chances[best] < LEAST_ODDS:
        assert found == alone
    elif first[best] >= LEAST_FIRST_AT_ODDS and (leads or not is_other):
        assert found == (best, (best, best)), "the first and the network agree"
    elif is_other and alone.text != "stop" and best not in alone.readings:
        assert found == (alone.text, (*alone.readings, best, best)), "which of the two is meant is asked"
    else:
        assert found == alone, "what has no evidence of the first is no phrase"


@given(TURNS, evidence, st.sampled_from(PHRASES))
def test_the_odds_alone_make_no_phrase_for_which_the_first_has_no_evidence(
    turn: tuple[str, dict[str, float], dict[str, float]], odds: dict[str, float], phrase: str
) -> None:
    text, first, second = turn
    first = {each: value for each, value in first.items() if each != phrase} | {phrase: -1.0}
    alone = fused(text, first, second, PHRASES, None, {}, refusals(odds) | {phrase: 0.0})
    if alone.text != phrase:
        found = fused(text, first, second, PHRASES, None, {}, odds | {phrase: 29.0})
        assert found.text == alone.text
        assert found.readings[: len(alone.readings)] == alone.readings


@given(TURNS, st.dictionaries(st.sampled_from(PHRASES), st.floats(LEAST_ODDS_OF_TWO, LEAST_ODDS, exclude_max=True)))
def test_small_odds_change_nothing(
    turn: tuple[str, dict[str, float], dict[str, float]], odds: dict[str, float]
) -> None:
    text, first, _ = turn
    assert fused(text, first, {}, PHRASES, None, {}, odds) == fused(text, first, {}, PHRASES)


def test_what_a_recogniser_sends_as_odds_is_numbers_of_expected_phrases() -> None:
    sent = {"yes": 1, "stop": float("nan"), "open": 9.0, "resume the mission": 1e9, "cancel the mission": "9"}
    assert odds_in({"odds": sent}, PHRASES) == {"yes": 1.0, "resume the mission": 30.0}
    assert odds_in({"odds": [9.0]}, PHRASES) == odds_in({}, PHRASES) == {}


@given(evidence)
def test_the_second_votes_for_two_phrases_however_many_it_has_evidence_for(found: dict[str, float]) -> None:
    votes, others = votes_in({"evidence": found}, PHRASES), sorted(found.values())[:-2]
    assert votes.items() <= found.items() and len(votes) == min(2, sum(each > 0 for each in found.values()))
    assert min(votes.values(), default=20.0) >= max(others, default=-20.0)
