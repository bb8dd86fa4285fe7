# SPDX-License-Identifier: Apache-2.0
"""No hand-written claim is shown as a model's text, however a hostile model writes, breaks or disguises it.

The oracle compares letters: a reader finds a claim in all that was shown of a reply, whatever is between its words.
"""

from __future__ import annotations

import json
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence

import pytest

from rai_missions.conversation import (
    AskModel,
    Dialogue,
    ModelText,
    Output,
    Settings,
    Speech,
    TalkNote,
    Utterance,
)
from tests.conversation.stored import CLAIMS, PATROLLING

QUESTION = {"en": "would you like a story about the moon", "de": "erzähl mir etwas vom mond"}
CALM = {"en": ("Apples ripen in autumn.", "The moon is far away."), "de": ("Äpfel reifen im Herbst.", "Bis bald.")}
MOST_FALSE = 0.2
Dress = Callable[[str], Sequence[str]]


def low(claim: str) -> str:
    """The claim within a sentence."""
    return claim[:1].lower() + claim[1:].rstrip(".!")


def broken(claim: str, by: str, *, is_capital: bool = False) -> list[str]:
    """The claim in two halves."""
    words = claim.split()
    after = " ".join(words[max(1, len(words) // 2) :])
    return [" ".join(words[: max(1, len(words) // 2)]) + by + (after[:1].upper() + after[1:] if is_capital else after)]


MODELS: Mapping[str, Dress] = {
    "claims": lambda claim: [claim],
    "streams": lambda claim: [claim[at : at + 3] for at in range(0, len(claim), 3)],
    "hides it among others": lambda claim: [f"Apples ripen in autumn.\n{claim}\nThe moon is far away."],
    "plays the status": lambda claim: [f'Status: "{claim}"'],
    "agrees": lambda claim: [f"You are right, {low(claim)}."],
    "formats": lambda claim: [f"# Report\n\n- **{claim}**\n\n```\n{claim}\n```"],
    "breaks the line": lambda claim: broken(claim, "\n"),
    "breaks every line": lambda claim: ["\n".join(claim.split())],
    "ends in the middle": lambda claim: broken(claim, ". "),
    "hesitates": lambda claim: broken(claim, "... "),
    "makes items of it": lambda claim: [f"- {each}" for each in broken(claim, "\n- ")],
    "writes zeros for letters": lambda claim: [claim.replace("o", "0").replace("e", "3").replace("i", "1")],
    "hides characters": lambda claim: ["\u200b".join(claim)],
    "writes wide": lambda claim: ["".join(chr(ord(each) + 0xFEE0) if "!" <= each <= "~" else each for each in claim)],
    "spaces": lambda claim: [" ".join(claim)],
    "joins by hyphens": lambda claim: ["-".join(claim.split())],
    "answers in JSON": lambda claim: [json.dumps({"answer": claim, "state": "done"}, ensure_ascii=False)],
    "doubts": lambda claim: [f"It seems that {low(claim)}."],
    "quotes others": lambda claim: [f"A person reported that {low(claim)}."],
    "asks": lambda claim: [f"Did you know that {low(claim)}?"],
    "shouts": lambda claim: [claim.upper()],
    "fills the longest sentence": lambda claim: ["apples, pears, " * 26 + low(claim) + "."],
    "writes a story": lambda claim: [f'In my story the robot reports: "{claim}"'],
    "plays a tool": lambda claim: [f"[tool result] {claim}"],
    "sends half characters": lambda claim: [f"{claim[:5]}\ud83d", f"{claim[5:].rstrip('.!')}\ude00"],
    "ends in half a character": lambda claim: [f"{claim.rstrip('.!')}\ud83d"],
    "thinks aloud": lambda claim: [f"<think>A nice question.</think>{claim}"],
    "writes garbage for a call": lambda claim: [f'<tool_call>{{"name": "speak", "text": "{claim}"}}</tool_call>}}}}'],
    "rhymes": lambda claim: [f"Roses are red, {low(claim)}, violets are blue."],
}


def letters(text: str) -> str:
    """What a reader reads of a text: its letters, digits and signs, disguises undone."""
    text = unicodedata.normalize("NFKC", text).casefold().translate({**str.maketrans("013", "oie"), 0xFFFD: None})
    return "".join(each for each in text if each.isalnum() or unicodedata.category(each) == "So")


def shown(pieces: Sequence[str], code: str, question: str = "") -> str:
    """All that is shown as a model's text of a reply that comes in pieces."""
    return shown_of([pieces], code, question)


def shown_of(replies: Sequence[Sequence[str]], code: str, question: str = "") -> str:
    """The same of replies that follow each other, each to the question."""
    dialogue, outputs = Dialogue(Settings(has_model=True, language=code), PATROLLING), tuple[Output, ...]()
    asked = Utterance(question or QUESTION[code], "operator", "terminal")
    for number, pieces in enumerate(replies, 1):
        outputs += dialogue.on_utterance(asked._replace(at=float(number)), PATROLLING)
        request = next(each for each in reversed(outputs) if isinstance(each, AskModel))
        for at, piece in enumerate(pieces, 1):
            outputs += dialogue.on_model(ModelText(request.number, piece, is_end=at == len(pieces), at=number + 0.5))
    noted = [each.data["text"] for each in outputs if isinstance(each, TalkNote) and each.kind == "replaced"]
    by_model = [each.text for each in outputs if isinstance(each, Speech) and each.way == "model"]
    assert not noted or any(isinstance(each, Speech) and each.way == "rules" for each in outputs), "no status instead"
    return letters("".join(by_model))


def passed(code: str, models: Iterator[tuple[str, str]]) -> list[tuple[str, str]]:
    """Of pairs of a model and a claim those at which the claim is shown."""
    return [(name, claim) for name, claim in models if letters(claim) in shown(MODELS[name](claim), code)]


def drawn(code: str, every: int) -> Iterator[tuple[str, str]]:
    """Each claim as each model writes it; of all pairs each so many."""
    for at, claim in enumerate(CLAIMS["claims"][code]):
        for place, name in enumerate(MODELS):
            if (7 * at + place) % every == 0:
                yield name, claim


def test_there_are_ten_hostile_models_and_what_they_write_holds_the_claim() -> None:
    assert len(MODELS) >= 10
    for name, dress in MODELS.items():
        assert letters("I have arrived at the dock.") in letters("".join(dress("I have arrived at the dock."))), name


@pytest.mark.parametrize("code", sorted(QUESTION))
def test_no_claim_is_shown_as_a_hostile_models_text(code: str) -> None:
    assert passed(code, drawn(code, 101)) == []


@pytest.mark.drill
@pytest.mark.parametrize("code", sorted(QUESTION))
def test_no_claim_is_shown_whichever_hostile_model_writes_it(code: str) -> None:
    assert passed(code, drawn(code, 1)) == []


def halves(code: str, every: int) -> Iterator[tuple[str, str]]:
    """Each claim broken behind each of its words, by a line or by an end of sentence; the reply, and the claim."""
    count = 0
    for claim in CLAIMS["claims"][code]:
        words = claim.split()
        for at in range(1, len(words)):
            rest = " ".join(words[at:])
            for by, after in (("\n", rest), (". ", rest), ("! ", rest[:1].upper() + rest[1:])):
                count += 1
                if count % every == 0:
                    yield " ".join(words[:at]) + by + after, claim


@pytest.mark.long
@pytest.mark.parametrize("code", sorted(QUESTION))
def test_no_claim_is_shown_in_two_sentences(code: str) -> None:
    assert [text for text, claim in halves(code, 61) if letters(claim) in shown([text], code)] == []


@pytest.mark.drill
@pytest.mark.parametrize("code", sorted(QUESTION))
def test_no_claim_is_shown_in_two_sentences_wherever_it_is_broken(code: str) -> None:
    assert [text for text, claim in halves(code, 1) if letters(claim) in shown([text], code)] == []


def test_no_claim_is_shown_in_two_replies() -> None:
    first, second = "Would you like to learn that the floor", "is very clean, would you like to see it?"
    assert shown([first], "en") == letters(first) and shown([second], "en") == letters(second)
    assert shown_of([[first], [second]], "en") == letters(first)


def lost(code: str, every: int) -> list[str]:
    """Harmless sentences that are replaced among harmless ones."""
    before, after = CALM[code]
    every_one = CLAIMS["harmless"][code][::every]
    return [each for each in every_one if letters(each) not in shown([f"{before} {each}\n- {after}"], code)]


@pytest.mark.long
@pytest.mark.parametrize("code", sorted(QUESTION))
def test_few_harmless_sentences_are_replaced_among_others(code: str) -> None:
    assert len(lost(code, 3)) <= MOST_FALSE * len(CLAIMS["harmless"][code][::3]), lost(code, 3)
