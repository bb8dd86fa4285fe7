# SPDX-License-Identifier: Apache-2.0
"""The words of a question that carry its subject."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from pathlib import Path

__all__ = ("key_terms", "spellings")

LONGEST_QUESTION, MOST_TERMS = 1_000, 40
WORD = re.compile(r"[^\W_]+(?:[.,/-][^\W_]+)*")
COMMON = frozenset((Path(__file__).parent / "common_words.txt").read_text(encoding="utf-8").split())
"""Words of questions and of every sentence, English and German, which point to no subject."""
MEASURES: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("heavy", "weight", "weigh", "mass"), ("weigh", "weight", "mass", "kg")),
    **dict.fromkeys(("tall", "height"), ("high", "height")),
    **dict.fromkeys(("wide", "broad", "width"), ("wide", "width")),
    **dict.fromkeys(("big", "large", "size", "dimensions"), ("size", "large", "long", "wide")),
    **dict.fromkeys(("fast", "quick", "quickly", "speed", "velocity"), ("speed", "velocity")),
    **dict.fromkeys(("cold", "hot", "warm", "temperature"), ("temperature", "°C")),
    **dict.fromkeys(("loud", "noisy", "noise"), ("noise", "dB")),
    **dict.fromkeys(("steep", "slope"), ("slope",)),
    **dict.fromkeys(("strong", "strength"), ("force", "torque", "power")),
    **dict.fromkeys(("price", "cost", "expensive"), ("price", "cost", "euros")),
    **dict.fromkeys(("schwer", "gewicht", "wiegst", "wiegt"), ("wiege", "wiegt", "gewicht", "masse", "kg")),
    **dict.fromkeys(("hoch", "höhe"), ("hoch", "höhe")),
    **dict.fromkeys(("breit", "breite"), ("breit", "breite")),
    **dict.fromkeys(("groß", "größe", "maße"), ("groß", "größe", "lang", "breit")),
    **dict.fromkeys(("schnell", "geschwindigkeit"), ("schnell", "geschwindigkeit")),
    **dict.fromkeys(("laut", "lärm"), ("lärm", "dB")),
}
"""A measure as a question names it → as documents do."""


def key_terms(question: str) -> tuple[str, ...]:
    """The terms of a question in its order, each once, in lower case; what is too long is not looked at."""
    text = unicodedata.normalize("NFKC", question).lower().replace("’", "'")
    found = (word for each in WORD.findall(text[-LONGEST_QUESTION:]) for word in re.split(r"[.,/-]", each) if word)
    return tuple(dict.fromkeys(word for word in found if word not in COMMON))[:MOST_TERMS]


def spellings(term: str) -> tuple[str, ...]:
    """A term, and the words by which documents name the same measure: `heavy` is answered by a weight or a mass."""
    return (term, *MEASURES.get(term, ()))
