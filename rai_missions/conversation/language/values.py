# SPDX-License-Identifier: Apache-2.0
"""Values as they are spoken: with their unit, in the language's decimals; missing and stale ones are named as such."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.view import KeyView
from rai_missions.image import Image
from rai_missions.plain_data import at_path, is_number, rounded
from rai_missions.redaction import cut

__all__ = (
    "AGED_S",
    "about_words",
    "capital",
    "duration",
    "is_known",
    "key_sentence",
    "result_sentences",
    "value_sentence",
    "value_words",
)

AGED_S = 2.0
"""From this age on, the age of a value is spoken as well."""
MOST_ITEMS = 5
"""Fields of an object that are spoken."""
MOST_NAMES, LONGEST_NAME = 20, 60
"""Names of a list that are spoken, and characters of one."""
LONGEST_TEXT, LONGEST_RESULT = 200, 2_000


def duration(seconds: float, language: Language) -> str:
    """`45 s`, `3 min`."""
    if not math.isfinite(seconds):
        return language.text("nothing")
    if seconds < 120:
        return language.text("seconds", n=language.decimals(rounded(round(max(seconds, 0.0), 1), "_s")))
    return language.text("minutes", n=round(seconds / 60))


def about_words(about: str) -> str:
    """A mission's sentence, to be put inside another one."""
    return cut(about, LONGEST_TEXT).strip().rstrip(".!")


def value_words(value: Any, key: KeyView, language: Language, *, field: str = "", longest: int = LONGEST_TEXT) -> str:
    """A value in words.

    Args:
        value: The value of the key, or of its field.
        key: Whose it is.
        field: The field, where only that is spoken.
        longest: Characters of a text that are spoken.
    """
    unit = language.unit_of(field or key.name)
    if key.type == "pose" and isinstance(value, Mapping):
        return _pose(value, key, language)
    if isinstance(value, bool) or value is None:
        return language.text({True: "true", False: "false", None: "missing"}[value])
    if is_number(value):
        return _number(float(value), unit, language) + (f" {unit}" if unit else "")
    if isinstance(value, Mapping):
        parts = [_field(str(name), each, key, language) for name, each in list(value.items())[:MOST_ITEMS]]
        return language.listed(parts) or language.text("empty")
    if isinstance(value, list | tuple):
        return _names(value, language) or language.text("items" if value else "nothing", count=len(value))
    return cut(str(value), longest) or language.text("empty")


def _number(value: float, unit: str, language: Language) -> str:
    """As precise as a person needs it: metres to the centimetre, from a decimetre on."""
    is_long = unit == "m" and abs(value) >= 0.1
    return language.decimals(rounded(round(value, 2) if is_long else value, unit and f"_{unit}"))


def _names(items: Sequence[Any], language: Language) -> str:
    """The texts of a list, or the names of its objects; empty where an item has none, or there are too many."""
    names = [item.get("name") if isinstance(item, Mapping) else item for item in items]
    if len(names) > MOST_NAMES or not all(name and isinstance(name, str) for name in names):
        return ""
    return language.listed([spoken(cut(name, LONGEST_NAME)) for name in names])


def _field(name: str, value: Any, key: KeyView, language: Language) -> str:
    return language.text("field", name=language.name_of(name), value=value_words(value, key, language, field=name))


def _pose(value: Mapping[str, Any], key: KeyView, language: Language) -> str:
    x, y = (_number(float(value.get(axis, 0.0)), "m", language) for axis in ("x", "y"))
    yaw = value.get("yaw")
    if is_number(yaw):
        text = language.text("pose_yaw", x=x, y=y, yaw=round(math.degrees(yaw)))
    else:
        text = language.text("pose", x=x, y=y)
    return f"{text}, {language.text('frame', frame=key.frame)}" if key.frame else text


def _found(path: str, keys: Mapping[str, KeyView]) -> tuple[KeyView, str, Any]:
    """The key of a path, the field, and the value of either."""
    name, _, field = path.partition(".")
    key = keys[name]
    return key, field, at_path(key.value, field)


def is_known(path: str, keys: Mapping[str, KeyView]) -> bool:
    """Whether a key, or a field of one, has a value now that can be put in words."""
    key, _, value = _found(path, keys)
    return key.is_fresh and value is not None and value != "" and not isinstance(value, Image)


def value_sentence(path: str, keys: Mapping[str, KeyView], language: Language) -> str:
    """The bare value of a key, or of a field of one, as a sentence; that it is unknown, and what it would be."""
    key, field, value = _found(path, keys)
    if is_known(path, keys):
        return _sentence(value_words(value, key, language, field=field, longest=LONGEST_RESULT))
    return language.text("value_unknown", about=about_words(key.about) or spoken(key.name))


def result_sentences(names: Iterable[str], keys: Mapping[str, KeyView], language: Language) -> list[str]:
    """A mission's results, each as a sentence: a text alone, any other value by its name; none without a value."""
    given = [keys[name] for name in names if name in keys]
    return [_result(key, language) for key in given if key.value is not None and key.value != ""]


def _result(key: KeyView, language: Language) -> str:
    if isinstance(key.value, str):
        return _sentence(key.value)
    name, value = capital(language.name_of(key.name)), value_words(key.value, key, language)
    return language.text("key", name=name, value=value)


def capital(words: str) -> str:
    """The words with a capital letter at their beginning; the others stay."""
    return f"{words[:1].upper()}{words[1:]}"


def _sentence(words: str) -> str:
    return f"{capital(words).rstrip('.')}."


def key_sentence(path: str, keys: Mapping[str, KeyView], language: Language) -> str:
    """A key, or a field of one, with its value, its `about` and its age, or that it is unknown."""
    key, field, value = _found(path, keys)
    words = capital(" ".join(map(language.name_of, (key.name, field) if field else (key.name,))))
    if key.age_s is None and key.value is None:
        return language.text("key_never", name=words)
    age = duration(key.age_s or 0.0, language)
    if not key.is_fresh:
        return language.text("key_stale", name=words, age=age)
    if isinstance(value, Image) or key.type == "image":
        return language.text("key_picture", name=words, age=age)
    shown = value_words(value, key, language, field=field)
    shown += language.text("age", age=age) if (key.age_s or 0.0) >= AGED_S and key.source == "robot" else ""
    if key.about and not field:
        return language.text("key_about", name=words, value=shown, about=about_words(key.about))
    return language.text("key", name=words, value=shown)
