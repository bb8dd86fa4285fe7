# SPDX-License-Identifier: Apache-2.0
"""Places with names: in which one a position is, or which is the nearest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.conversation.language.language import Language
from rai_missions.conversation.view import KeyView
from rai_missions.plain_data import is_number
from rai_missions.profile.conversation import NamedPlace

__all__ = ("place_named", "place_sentence", "place_words")


def _is_position(pose: Any) -> bool:
    return isinstance(pose, Mapping) and is_number(pose.get("x")) and is_number(pose.get("y"))


def place_words(pose: Any, frame: str, places: Mapping[str, NamedPlace], language: Language) -> str:
    """In which place a pose is, or which one is the nearest, as a sentence; empty where none is on its map."""
    if not _is_position(pose):
        return ""
    known = [(each.distance_m(pose["x"], pose["y"]), name) for name, each in places.items() if each.frame == frame]
    if not known:
        return ""
    distance, name = min(known)
    if distance == 0:
        return language.text("in_place", place=name)
    return language.text("near_place", place=name, distance=language.decimals(f"{distance:.1f}"))


def place_named(words: Sequence[str], places: Mapping[str, NamedPlace], language: Language) -> str | None:
    """The place that the words name; None where they name none."""
    bare = language.without_articles(words)
    return next((name for name in places if language.normaliser.words(name) == bare), None)


def place_sentence(name: str, place: NamedPlace, pose: KeyView | None, language: Language) -> str:
    """Where a place is, and how far from a pose that is on its map."""
    middle = {axis: language.decimals(f"{sum(each) / 2:.1f}") for axis, each in (("x", place.x), ("y", place.y))}
    text = language.text("place_at", place=name, frame=place.frame, **middle)
    if pose is None or pose.frame != place.frame or not _is_position(pose.value):
        return text
    distance = place.distance_m(pose.value["x"], pose.value["y"])
    if distance == 0:
        return f"{text} {language.text('place_here')}"
    return f"{text} {language.text('place_away', distance=language.decimals(f'{distance:.1f}'))}"
