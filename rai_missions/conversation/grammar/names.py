# SPDX-License-Identifier: Apache-2.0
"""What the words of a sentence name: a key or its field, a mission, an option that is offered."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.view import KeyView, MissionView, StatusView
from rai_missions.engine.decision import Offer
from rai_missions.planning.text.numbers import ordinal

__all__ = (
    "NamedOption",
    "called",
    "key_asked",
    "key_named",
    "key_within",
    "keys_about",
    "keys_of_whereabouts",
    "missions_named",
    "option_named",
    "option_place",
)

LONGEST_NAME = 3
"""Words of the longest name of a key that is looked for in a sentence."""
SAME = 3
"""First words of an `about` and of a question that is about the same: `how many people`."""
LEAST_ASKED = 2
"""Words with a meaning of the shortest question that asks what the `about` of a key does."""
SHORTEST = 4
"""Letters of a word that alone may mean a key by its `about`."""
MOST_ABOUT = 3
"""Keys that an answer to a question in free words has at most."""


def _names(key: KeyView, language: Language) -> Iterator[tuple[str, list[str]]]:
    """Each path of a key, with its words."""
    own = language.name_of(key.name).split()
    yield key.name, own
    yield key.name, spoken(key.name).split()
    for name in key.fields:
        field = language.name_of(name).split()
        yield f"{key.name}.{name}", [*own, *field]
        yield f"{key.name}.{name}", [*field, *own]


def key_named(words: Sequence[str], keys: Mapping[str, KeyView], language: Language, *, strict: bool = False) -> str:
    """The path of the key that the words name; empty where they name none, or several.

    An argument is named by its name alone: its `about` lists what may be ordered.

    Args:
        words: The words of the sentence's slot.
        keys: Those that there are, by name.
        language: Whose articles, units and aliases count.
        strict: Only its name counts, not the words of its `about`.
    """
    bare = language.without_articles(words)
    singular = list(map(language.singular, bare))
    alias = language.data["aliases"].get(" ".join(bare))
    for path, names in (each for key in keys.values() for each in _names(key, language)):
        if names and (list(map(language.singular, names)) == singular or path == alias):
            return path
    if strict or not any(len(word) >= SHORTEST for word in bare):
        return ""
    within = {path for key in keys.values() for path, names in _names(key, language) if set(bare) <= set(names)}
    by_name = {path.partition(".")[0] for path in within}
    if len(by_name) == 1:
        return min(within, key=len)
    reported = [key for key in keys.values() if key.source != "argument"]
    about = [key.name for key in reported if set(bare) <= set(language.normaliser.words(key.about))]
    return about[0] if not within and len(about) == 1 else ""


def key_asked(words: Sequence[str], keys: Mapping[str, KeyView], language: Language) -> str:
    """The key whose `about` asks what the words ask; empty where none does, or several.

    `how many panes are done` is of a key `how many panes are clean`, `is the pump on` of one `whether the pump is on`:
    both ask in the same way, and each word that has a meaning is in the key's `about` or its name.

    Args:
        words: The words of a question.
        keys: Those that there are, by name.
        language: Whose words without a meaning, and for what is measured, count.
    """
    meant, bare = [each for word in words if (each := language.meanings(word))], language.without_articles(words)
    found, whether = list[str](), language.data["whether"]
    openings = (words[0], whether)
    asking = (key for key in keys.values() if key.about.partition(" ")[0].lower() in openings)
    for key in (each for each in asking if each.source != "argument"):
        about = language.normaliser.words(key.about)
        is_either = about[:1] == [whether] and words[0] in (*language.data["auxiliaries"], about[-1])
        known = set(map(language.singular, (*about, *spoken(key.name).split())))
        is_in = len(meant) >= LEAST_ASKED and not any(map(known.isdisjoint, meant))
        is_same = sorted(bare) == sorted(language.without_articles(about[is_either:]))
        if (is_either or about[:1] == [words[0]]) and (is_in or is_same):
            found.append(key.name)
    return found[0] if len(found) == 1 else ""


def key_within(words: Sequence[str], keys: Mapping[str, KeyView], language: Language) -> str:
    """The path of the key that some of the words are the whole name of, the longest name first; empty without one.

    Args:
        words: The words of a sentence.
        keys: Those that there are, by name.
        language: Whose articles, units and aliases count.
    """
    for size in range(LONGEST_NAME, 0, -1):
        for at in range(len(words) - size + 1):
            if path := key_named(words[at : at + size], keys, language, strict=True):
                return path
    return ""


def keys_about(
    words: Sequence[str], keys: Mapping[str, KeyView], language: Language, *, whole: bool = False
) -> list[str]:
    """The paths of the keys that a question in free words is about: `motor_temperature_c` of `how hot is the motor`.

    They are reported by the robot, and their names share most words with the question. A word that measures, `hot`,
    is as good as what it measures. Empty where no name shares any, or too many share as many.

    Args:
        words: The words of the question.
        keys: Those that there are, by name.
        language: Whose articles, units and measures count.
        whole: The name must share each word but articles and the like.
    """
    meant = [each for word in words if (each := language.meanings(word))]
    shared = dict[str, tuple[int, int, str]]()
    for key in keys.values() if meant else ():
        for path, names in _names(key, language) if key.source == "robot" else ():
            singular = set(map(language.singular, names))
            found = (sum(not each.isdisjoint(singular) for each in meant), -len(names), path)
            shared[key.name] = max(found, shared.get(key.name, found))
    most = max((count for count, _, _ in shared.values()), default=0)
    paths = [path for count, _, path in shared.values() if count == most > 0]
    if not paths and not whole:  # `how many people swim`, of a key `how many people are in the water`
        abouts = {
            key.name: language.normaliser.words(key.about)[:SAME] for key in keys.values() if key.source == "robot"
        }
        paths = [name for name, about in abouts.items() if len(about) == SAME and about == list(words[:SAME])]
    return [] if len(paths) > MOST_ABOUT or (whole and most < len(meant)) else paths


def keys_of_whereabouts(keys: Mapping[str, KeyView], language: Language) -> list[str]:
    """The keys of the robot that are where it is, by the last word of their names: `position_m`, or else `aisle`."""
    last = {name: language.name_of(name).split()[-1:] for name, key in keys.items() if key.source == "robot"}
    found = ([name for name, words in last.items() if words == [word]] for word in language.data["whereabouts"])
    return next(filter(None, found), [])[:MOST_ABOUT]


def missions_named(words: Sequence[str], view: StatusView, language: Language) -> list[MissionView]:
    """The missions that the words name: one by its whole name, else each whose name has all of the words."""
    bare = [word for word in language.without_articles(words) if word != language.data["mission_word"]]
    whole = [each for each in view.missions if spoken(each.name).split() == bare]
    return whole or [each for each in view.missions if bare and set(bare) <= set(spoken(each.name).split())]


class NamedOption(NamedTuple):
    """An option that was named."""

    offer: Offer
    is_partial: bool
    """Only some of its words were used."""


def option_named(words: Sequence[str], options: Sequence[Offer], language: Language) -> NamedOption | None:
    """The option that the words name: by number, name, its `about`, or some of its words where no other has them.

    A pronoun behind these words, `drive over it`, is what the question is about.
    """
    bare = language.without_articles(words)
    for offer in options:
        if bare and any(bare == language.without_articles(each) for each in _ways(offer, language)):
            return NamedOption(offer, is_partial=False)
    place = ordinal(bare or list(words), language.data)
    if place is not None:
        place = len(options) if place == -1 else place
        return NamedOption(options[place - 1], is_partial=False) if 1 <= place <= len(options) else None
    bare = bare[:-1] if bare[-1:] and bare[-1] in language.data["thing_pronouns"] else bare
    if not any(len(word) >= SHORTEST for word in bare):
        return None
    having = [offer for offer in options if set(bare) <= _every_word(offer, language)]
    return NamedOption(having[0], is_partial=True) if len(having) == 1 else None


def option_place(name: str, options: Sequence[Offer]) -> int:
    """The number by which an option is offered, from 1; 0 where it is not."""
    return next((number for number, offer in enumerate(options, start=1) if offer.name == name), 0)


def _ways(offer: Offer, language: Language) -> Iterator[list[str]]:
    words = language.normaliser.words
    yield spoken(offer.name).split()
    if offer.about:
        yield words(offer.about)
        for mark in ",;:":
            yield words(offer.about.partition(mark)[0])


def _every_word(offer: Offer, language: Language) -> set[str]:
    return {*spoken(offer.name).split(), *language.normaliser.words(offer.about)}


def called(robot: str) -> tuple[str, ...]:
    """How people address a robot: `tractor1` as `tractor`, too, and `ROSbot XL, simulated` as `ROSbot`."""
    name = robot.partition(",")[0]
    first = name.split()[:1]
    return tuple(dict.fromkeys([robot, spoken(robot), name, *first, *(each.rstrip("0123456789") for each in first)]))
