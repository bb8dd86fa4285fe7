# SPDX-License-Identifier: Apache-2.0
"""Of a message with orders nothing is left out unnamed: a part is read back, given out, answered or named."""

from __future__ import annotations

from typing import NamedTuple

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.conversation import Dialogue, Order, Speech, StatusView, TalkNote, Utterance
from rai_missions.conversation.answers.order_words import order_words
from rai_missions.conversation.answers.spoken_starts import SpokenStarts
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language, languages
from tests.conversation.stored import settings_in
from tests.conversation.test_forms_of_orders import PHRASES, PLACES
from tests.conversation.test_order_lists import IDLE, ORDERS, RUNNING, joints

UNREAD = {
    "en": (
        "paint the fence", "start again with one alley", "sing a little song", "water the plants upstairs",
        "do not open the window", "how heavy is the box", "go to the garage", "polish the mirror",
    ),
    "de": (
        "lackier den Zaun", "fang mit einer Gasse von vorn an", "sing ein kleines Lied", "gieß die Blumen oben",
        "mach nicht das Fenster auf", "wie schwer ist die Kiste", "fahr in die Garage", "putz den Spiegel",
    ),
}  # fmt: skip
"""What no rule reads: orders, prohibitions and questions, and one whose place does not exist."""
KNOWN = ("pause", "cancel", "kitchen", "study", "cup", "home")
NOT_NOW = ("pause", "cancel")
"""What is refused with its reason while no mission runs."""


VALUES = {"en": ("kitchen", "study", "cup"), "de": ("küche", "diele", "tasse")}


class Message(NamedTuple):
    """Parts of a message, each with what is ahead of it, and the run in which it is typed."""

    view: StatusView
    parts: tuple[str, ...]
    """The names of orders, and what no rule reads."""
    joints: tuple[str, ...]


@st.composite
def messages(draw: st.DrawFn, code: str) -> Message:
    known = draw(st.lists(st.sampled_from(KNOWN), min_size=1, max_size=2, unique=True))
    parts = draw(st.permutations([*known, draw(st.sampled_from(UNREAD[code]))]))
    between = [each for each in joints(code) if each.strip()]
    signs = draw(st.lists(st.sampled_from(between), min_size=len(parts) - 1, max_size=len(parts) - 1))
    return Message(draw(st.sampled_from((IDLE, RUNNING))), tuple(parts), ("", *signs))


def words(code: str, text: str) -> str:
    """A text as a sentence is read, for what is named is in these words."""
    return " ".join(language(code).normaliser.words(text))


def called(code: str, name: str, view: StatusView) -> list[str]:
    """How an order is named: as the robot calls it, as the person typed it, or by its value, which does not fit."""
    code_words, text = language(code), ORDERS[code][name]
    phrases = StartPhrases(PHRASES[code], PLACES[code], code_words)
    (sense,) = Grammar(code_words, phrases).senses(text, view)
    starts = SpokenStarts({}, PLACES[code], code_words)
    values = [each for each in VALUES[code] if each in words(code, text)]
    return [words(code, order_words(sense, view, starts, code_words)), words(code, text), *values]


def holds(code: str, message: Message) -> None:
    text = "".join(
        f"{joint}{ORDERS[code].get(part, part)}" for joint, part in zip(message.joints, message.parts, strict=True)
    )
    dialogue = Dialogue(settings_in(code, PHRASES[code], PLACES[code]["place"]), message.view)
    outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal", at=2.0), message.view)
    spoken = words(code, " ".join(each.text for each in outputs if isinstance(each, Speech)))
    given = [each.name for each in outputs if isinstance(each, Order)]
    is_read = any(
        isinstance(each, TalkNote) and each.kind == "mapped" and each.data["mapper"] == "grammar" for each in outputs
    )
    assert spoken, text
    for part in message.parts if is_read else ():
        is_known = part in KNOWN
        named = called(code, part, message.view) if is_known else [words(code, part), words(code, part).split()[-1]]
        is_refused = part in NOT_NOW and words(code, language(code).text(f"why_not_{part}", state="")) in spoken
        assert is_refused or part in given or any(each in spoken for each in named), (text, part, spoken)


TRIED = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@TRIED
@given(st.sampled_from(languages()).flatmap(lambda code: st.tuples(st.just(code), messages(code))))
def test_no_part_of_a_message_with_orders_is_left_out_unnamed(case: tuple[str, Message]) -> None:
    holds(*case)
