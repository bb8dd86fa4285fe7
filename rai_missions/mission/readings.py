# SPDX-License-Identifier: Apache-2.0
"""What is wrong with an object of which one word is unknown, whatever that word was meant to be.

Rule: a fault counts that is there without the word, and under each word that fits there.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from rai_missions.errors import Fault, nearest
from rai_missions.model import MissionModel
from rai_missions.model.validation_errors import faults_of, words_of

__all__ = ("sure_faults",)


def sure_faults(kind: type[MissionModel], given: Mapping[str, Any], unknown: str, value: Any) -> frozenset[Fault]:
    """The faults of an object, with places from it on, that do not depend on what an unknown word is meant to be.

    Args:
        kind: The model as which it is read.
        given: The object without the word.
        unknown: The word.
        value: Its value.
    """
    found = _faults(kind, given)
    free = [word for word in words_of(kind) if word not in given]
    likely = kind.meant.get(unknown) or nearest(unknown, free)
    for word in free if found else ():
        read = _faults(kind, {**given, word: value})
        if read <= found:
            found = read
        elif word == likely:
            return frozenset()  # it has other faults as that word: what is wrong next to it is not known
    return found


def _faults(kind: type[MissionModel], given: Mapping[str, Any]) -> frozenset[Fault]:
    try:
        kind.model_validate(given)
    except ValidationError as error:
        return frozenset(faults_of(error, kind, given))
    return frozenset()
