# SPDX-License-Identifier: Apache-2.0
"""The simulated detector: gives what is seen a class, misses some of it, and takes some of it for something else.

Rule: each look errs for itself: what is missed or swapped in one look follows from the seed, the look and the thing,
and from nothing in the looks before.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from rai_missions.worlds.desk.catalogue import lookalikes
from rai_missions.worlds.desk.look import SeenBody
from rai_missions.worlds.open_set_detector import ObjectClass
from rai_missions.worlds.options import check_detector_options, is_down

__all__ = ("ClassifiedBody", "LookClassifier", "LookErrors")

MOST_ERRORS = 0.1
"""What a thing's class is taken from holds up to so many errors a look."""


class ClassifiedBody(NamedTuple):
    """One thing in one look."""

    thing: ObjectClass
    seen: SeenBody


@dataclass(frozen=True)
class LookErrors:
    """How the detector errs, a thing and a look."""

    miss: float = 0.02
    """How often a thing in sight is not reported, 0 to 0.1."""
    swap: float = 0.02
    """How often a thing is taken for one that looks like it, 0 to 0.1."""
    persistent: float = 0.0
    """How often a thing is taken for another one in every look, 0 to 1: no look reveals this."""
    down: tuple[float, float] | None = None
    """Seconds since the start, from and until: no look is answered."""

    @classmethod
    def of(cls, options: Mapping[str, Any] | None) -> LookErrors:
        """From plain data; a `UsageError` names what does not exist or is out of range."""
        check_detector_options(options or {}, {"miss": MOST_ERRORS, "swap": MOST_ERRORS, "persistent": 1.0})
        return cls(**(options or {}))


class LookClassifier:
    """Gives the bodies of a look their classes.

    Args:
        things: Body of the model → what it is.
        errors: How it errs.
        seed: Where its errors come from.
    """

    def __init__(self, things: Mapping[int, ObjectClass], errors: LookErrors, seed: int) -> None:
        self._errors, self._seed = errors, seed
        self._taken_for = {
            body: self._other(thing, random.Random(f"{seed} always {body}"), errors.persistent)
            for body, thing in things.items()
        }

    def is_down(self, since_s: float) -> bool:
        return is_down(self._errors.down, since_s)

    def sightings(self, bodies: Iterable[SeenBody], number: int) -> list[ClassifiedBody]:
        """What the detector reports of a look's bodies.

        Args:
            bodies: Those in sight.
            number: The number of the look.
        """
        found = []
        for seen in bodies:
            rng = random.Random(f"{self._seed} {number} {seen.body}")
            is_missed = rng.random() < self._errors.miss
            thing = self._other(self._taken_for[seen.body], rng, self._errors.swap)
            if not is_missed:
                found.append(ClassifiedBody(thing, seen))
        return found

    def _other(self, thing: ObjectClass, rng: random.Random, share: float) -> ObjectClass:
        return rng.choice(lookalikes(thing)) if rng.random() < share else thing
