# SPDX-License-Identifier: Apache-2.0
"""The texts of an order that a model proposes: those that are its own words.

Rule: a text is the mission's where that lists it, and a person's where one of their sentences has it in one piece.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import Language
from rai_missions.conversation.view import StatusView

__all__ = ("own_texts",)


def own_texts(sense: Sense, sentences: Iterable[str], view: StatusView, language: Language) -> list[str]:
    """The texts in an order that neither its mission nor a person has; where there are several, all in one, too.

    Args:
        sense: The order.
        sentences: Those of persons.
        view: The run.
        language: The dialogue's.
    """
    given = [_spaced(each, language) for each in sentences]
    own = [
        each for each in _proposed(sense, view) if not any(_spaced(each, language) in sentence for sentence in given)
    ]
    return [*own, " ".join(own)] if own[1:] else own


def _proposed(sense: Sense, view: StatusView) -> Iterator[str]:
    """The texts of an order that its mission does not list."""
    mission, offer = view.mission_named(sense.mission), view.offer(sense.question, sense.option)
    enums = {name: key.enum or () for name, key in mission.keys.items()} if mission is not None else {}
    for name, value in sense.arguments.items():
        yield from (each for each in _texts(value) if each not in enums[name])
    listed = frozenset(_texts(offer.parameters)) if offer is not None else frozenset()
    yield from (each for value in sense.parameters.values() for each in _texts(value) if each not in listed)


def _texts(value: Any) -> Iterator[str]:
    """The texts of a value, names of fields among them."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        yield from (text for pair in value.items() for each in pair for text in _texts(each))
    elif isinstance(value, list | tuple):
        yield from (text for each in value for text in _texts(each))


def _spaced(text: str, language: Language) -> str:
    """The words of a text, each between spaces."""
    return f" {' '.join(language.normaliser.words(text))} "
