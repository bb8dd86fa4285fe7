# SPDX-License-Identifier: Apache-2.0
"""Facts that name a thing, for `where is the cup?`: what the camera reported of it, or a sentence that has its words.

Rule: a fact is spoken as it was received, with its age; what is put together of two facts is none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from rai_missions.conversation.language import Language, spoken
from rai_missions.conversation.named import unit_of
from rai_missions.conversation.sentences import sentences as whole_sentences
from rai_missions.conversation.values import AGED_S, capital, duration, value_words
from rai_missions.conversation.view import KeyView, StatusView
from rai_missions.redaction import cut

__all__ = ("mention_sentences",)

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
    wanted = {_single(word) for word in thing if word not in language.data["articles"]}
    keys = [key for key in view.keys.values() if key.source == "robot" or key.name in results]
    keys.sort(key=lambda key: (not key.is_fresh, key.age_s or 0.0))
    found = (Mention(key, words) for key in keys for words in _mentions(key, wanted, language)) if wanted else iter(())
    by_words = {each.words: each for each in islice(found, MOST)}
    return [_sentence(each, language) for each in by_words.values()]


def _single(word: str) -> str:
    return word.removesuffix("s")


def _has(text: Any, wanted: set[str], language: Language) -> bool:
    return isinstance(text, str) and wanted <= {_single(word) for word in language.normaliser.words(text)}


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


def _sentence(mention: Mention, language: Language) -> str:
    key = mention.key
    name, words = unit_of(key.name.rpartition("/")[2], language.data["units"])[0], mention.words.strip().rstrip(".;")
    age_s = key.age_s or 0.0
    form = "mention_aged" if age_s >= AGED_S or not key.is_fresh else "mention"
    text = language.text(form, name=name, text=cut(words, LONGEST), age=duration(age_s, language))
    return capital(text)
