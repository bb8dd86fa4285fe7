# SPDX-License-Identifier: Apache-2.0
"""An order in words, as it is read back and reported: with all that it does."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import Any

from rai_missions.conversation.answers.spoken_starts import SpokenStarts
from rai_missions.conversation.grammar.free_answers import text_option
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.values import value_words
from rai_missions.conversation.view import KeyView, MissionView, StatusView
from rai_missions.plain_data import listed

__all__ = ("order_words",)


def order_words(sense: Sense, view: StatusView, starts: SpokenStarts, language: Language) -> str:
    """`start the mission 'x' with alleys 4`, or as the profile calls it; of several orders, one after the other."""
    each = (_order_words(order, view, starts, language) for order in sense.orders or (sense,))
    return reduce(lambda first, then: language.text("and_then", first=first, then=then), each)


def _order_words(sense: Sense, view: StatusView, starts: SpokenStarts, language: Language) -> str:
    if sense.name == "start":
        keys = (view.mission_named(sense.mission) or MissionView(sense.mission)).keys
        if called := starts.words(sense.arguments, keys):
            return called
        arguments = _argument_words(sense.arguments, keys, language)
        form = "order_start_with" if arguments else "order_start"
        return language.text(form, mission=spoken(sense.mission), arguments=arguments)
    if sense.name == "answer":
        asked = view.question(sense.question)
        question, text = ("", None) if asked is None else (asked.text, text_option([asked]))
        if text is not None and text.offer.name == sense.option and text.parameter in sense.parameters:
            return language.text("order_answer_text", text=sense.parameters[text.parameter], question=question)
        arguments = _argument_words(sense.parameters, {}, language)
        form = "order_answer_with" if arguments else "order_answer"
        return language.text(form, option=spoken(sense.option), arguments=arguments, question=question)
    return language.text(f"order_{sense.name}")


def _argument_words(values: Mapping[str, Any], keys: Mapping[str, KeyView], language: Language) -> str:
    words = list[str]()
    for name, value in values.items():
        key = keys.get(name, KeyView(name, "string"))
        shown = listed(value) if key.type in ("pose", "object", "list") else value_words(value, key, language)
        words.append(language.text("argument", name=language.name_of(key.name), value=shown))
    return language.listed(words)
