# SPDX-License-Identifier: Apache-2.0
"""Facts that name a thing, for `where is the cup?`: what the camera reported of it, or a sentence that has its words.

Rule: a fact is spoken as it was received, with its age; what is put together of two facts is none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.values import AGED_S, capital, duration, value_words
from rai_missions.conversation.sentences import sentences as whole_sentences
from rai_missions.conversation.view import KeyView, StatusView
from rai_missions.redaction import cut

__all__ = ("count_sentence", "mention_sentences")

MOST, LONGEST = 3, 300
"""Facts that are spoken; characters of one."""
MOST_PARTS = 400
"""Parts of a value that are looked at: records of a list, and their fields."""
NAME_WORDS = 3
"""Words of the longest field that is a name; a longer one is a sentence."""


class Mention(NamedTuple):
    """A fact that names a thing."""

    key: KeyView
    words: str


def mention_sentences(
    thing: Sequence[str], view: StatusView, language: Language, results: Collection[str] = ()
) -> list[str]:
    """What is known of a thing, each fact with its key and its age, the newest first; empty where no fact names it.

    Args:
        thing: Its words.
        view: The run.
        language: Whose articles and templates count.
        results: The keys of the mission's own that count too; others of its may hold a person's words.
    """
    wanted = _wanted(thing, language)
    keys = _keys(view, results)
    found = (Mention(key, words) for key in keys for words in _mentions(key, wanted, language)) if wanted else iter(())
    by_words = {each.words: each for each in islice(found, MOST)}
    texts = [(each.key, cut(each.words.strip().rstrip(".;"), LONGEST)) for each in by_words.values()]
    return [_sentence(key, language, "mention", text=text) for key, text in texts]


def count_sentence(thing: Sequence[str], view: StatusView, language: Language, results: Collection[str] = ()) -> str:
    """How many entries of the newest list that has any name a thing; empty where no list does.

    Args:
        thing: Its words.
        view: The run.
        language: Whose articles and templates count.
        results: The keys of the mission's own that count too.
    """
    wanted = _wanted(thing, language)
    for key in _keys(view, results) if wanted else ():
        counts = (_naming(name, entries, wanted, language) for name, entries in _lists(key))
        count = max(counts, default=0)
        if count:
            return _sentence(key, language, "counted", count=count, thing=" ".join(language.without_articles(thing)))
    return ""


def _lists(key: KeyView) -> Iterator[tuple[str, list[Any]]]:
    """The value, and its fields, that are lists, each with its name."""
    fields = key.value.items() if isinstance(key.value, Mapping) else ()
    for name, each in [(key.name, key.value), *fields]:
        if isinstance(each, list | tuple):
            yield str(name), [*each[:MOST_PARTS]]


def _naming(name: str, entries: Sequence[Any], wanted: set[str], language: Language) -> int:
    """The entries that name a thing; all of them, where the list is called so."""
    if set(map(language.singular, spoken(name).split())) == wanted:
        return len(entries)
    parts = [[*each.values()] if isinstance(each, Mapping) else [each] for each in entries]
    return sum(any(_has(text, wanted, language) for text in texts) for texts in parts)


def _wanted(thing: Sequence[str], language: Language) -> set[str]:
    return set(map(language.singular, language.without_articles(thing)))


def _keys(view: StatusView, results: Collection[str]) -> list[KeyView]:
    """The keys that are facts, the newest first."""
    keys = [key for key in view.keys.values() if key.source == "robot" or key.name in results]
    return sorted(keys, key=lambda key: (not key.is_fresh, key.age_s or 0.0))


def _has(text: Any, wanted: set[str], language: Language) -> bool:
    return isinstance(text, str) and wanted <= set(map(language.singular, language.normaliser.words(text)))


def _mentions(key: KeyView, wanted: set[str], language: Language) -> Iterator[str]:
    """Each part of a value that names the thing, in words: its own sentence on it, else its fields."""
    left = [key.value]
    for _ in range(MOST_PARTS):
        if not left:
            return
        part = left.pop(0)
        texts = list(part.values()) if isinstance(part, Mapping) else [part]
        naming = [text for text in texts if _has(text, wanted, language)]
        wordings = [each for text in naming for each in _wordings(text, wanted, language, is_whole=text is not part)]
        if wordings:
            yield wordings[0]
        elif naming and isinstance(part, Mapping):
            yield value_words(_spoken(part), key._replace(type="object"), language)
        else:
            left += part[:MOST_PARTS] if isinstance(part, list | tuple) else texts if isinstance(part, Mapping) else []


def _spoken(record: Mapping[Any, Any]) -> dict[Any, Any]:
    """A record without its empty texts, and its names in words: `red cube` for `red_cube`."""
    filled = {name: value for name, value in record.items() if value != ""}
    return {name: spoken(value) if isinstance(value, str) else value for name, value in filled.items()}


def _wordings(text: str, wanted: set[str], language: Language, *, is_whole: bool) -> Iterator[str]:
    """What a text has of the thing: its sentences with the words, or all of it; none where it is but a name.

    Args:
        text: It has the words.
        wanted: The words.
        language: Whose sentences they are.
        is_whole: It is of a record, whose certainty may be in another part of it.
    """
    if len(text.split()) > NAME_WORDS:
        yield from [text] if is_whole else filter(lambda part: _has(part, wanted, language), _parts(text))


def _parts(text: str) -> list[str]:
    whole, rest = whole_sentences(text)
    return [*whole, *([rest] if rest.strip() else [])]


def _sentence(key: KeyView, language: Language, form: str, **values: object) -> str:
    """A sentence by a key, with its age where that is worth a word."""
    name, age_s = language.name_of(key.name.rpartition("/")[2]), key.age_s or 0.0
    form = f"{form}_aged" if age_s >= AGED_S or not key.is_fresh else form
    return capital(language.text(form, name=name, age=duration(age_s, language), **values))
