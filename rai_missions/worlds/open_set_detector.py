# SPDX-License-Identifier: Apache-2.0
"""The simulated open-set detector: boxes around what the camera shows, and masks, with errors.

Rule: what has no pixels in the picture is not detected, and what is detected follows from the picture, the seed and
the picture's moment alone: the same picture gives the same answer, however often and in whatever order it is asked.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.camera import Frame
from rai_missions.worlds.options import check_detector_options, is_down
from rai_missions.worlds.perception.detections import Box2D, ObjectDetection

__all__ = ("DetectorErrors", "ObjectClass", "OpenSetDetector")

FEWEST_PIXELS = 40
SURE_PIXELS = 1500
"""From so many on, size takes nothing from the score."""
SYNONYMS = {"mug": "cup", "flower": "plant", "seat": "chair", "human": "person", "man": "person", "woman": "person"}


class ObjectClass(NamedTuple):
    """What a body of the model is, or is taken for."""

    kind: str
    colour: str
    """Empty for a kind that has one colour."""


@dataclass(frozen=True)
class DetectorErrors:
    """How the detector errs."""

    noise: float = 0.04
    """Standard deviation of a box's edges, as a share of its size."""
    miss: float = 0.05
    """How often a thing in sight is not reported, 0 to 1, a picture."""
    misclassify: float = 0.04
    """How often a thing is taken for one that looks like it, 0 to 1, a picture."""
    false_alarm: float = 0.0
    """How often something is reported where nothing is, 0 to 1, a picture."""
    range_m: float = 5.0
    """What is farther away is not reported."""
    down: tuple[float, float] | None = None
    """Seconds since the start, from and until: the detector does not answer."""

    @classmethod
    def of(cls, options: Mapping[str, Any] | None) -> DetectorErrors:
        """From plain data; a `UsageError` names what does not exist or is out of range."""
        check_detector_options(
            options or {}, {"noise": 100.0, "miss": 1.0, "misclassify": 1.0, "false_alarm": 1.0, "range_m": 100.0}
        )
        return cls(**(options or {}))


class OpenSetDetector:
    """Reads frames of depth and segmentation.

    Args:
        things: Body of the model → what it is.
        errors: How it errs.
        seed: Where its errors come from.
        lookalikes: What a thing is taken for when it is taken for something else.
        colours: Words that name a colour.
    """

    def __init__(
        self,
        things: Mapping[int, ObjectClass],
        errors: DetectorErrors,
        seed: int,
        lookalikes: Callable[[ObjectClass], Sequence[ObjectClass]],
        colours: Collection[str],
    ) -> None:
        self._things, self._errors, self._seed = things, errors, seed
        self._lookalikes, self._colours = lookalikes, frozenset(colours)

    def is_down(self, since_s: float) -> bool:
        return is_down(self._errors.down, since_s)

    def detect(self, frame: Frame, moment_ms: int, names: Sequence[str], threshold: float) -> list[ObjectDetection]:
        """What of the names is in a picture, the highest score first.

        Args:
            frame: The picture, in depth and bodies.
            moment_ms: When it was taken.
            names: Classes in free words: a kind, or a colour and a kind.
            threshold: The least score.
        """
        found = [one for body in self._things for one in self._one(body, frame, moment_ms, names)]
        found += self._imagined(frame, moment_ms, names)
        return sorted((one for one in found if one.score >= threshold), key=lambda one: (-one.score, one.name, one.box))

    def mask(self, frame: Frame, box: Box2D) -> NDArray[np.uint8]:
        """The thing that fills most of a box: 255 where it is, 0 elsewhere."""
        mask = np.zeros(frame.body.shape, np.uint8)
        left, top, right, bottom = (round(edge) for edge in box)
        inside = frame.body[max(0, top) : max(0, bottom) + 1, max(0, left) : max(0, right) + 1]
        counts = {body: int(np.count_nonzero(inside == body)) for body in self._things}
        body = max(counts, key=lambda each: counts[each], default=-1)
        if counts.get(body):
            area = mask[max(0, top) : max(0, bottom) + 1, max(0, left) : max(0, right) + 1]
            area[inside == body] = 255
        return mask

    def _one(self, body: int, frame: Frame, moment_ms: int, names: Sequence[str]) -> list[ObjectDetection]:
        lines, columns = np.nonzero(frame.body == body)
        if len(lines) < FEWEST_PIXELS or float(np.median(frame.depth_m[lines, columns])) > self._errors.range_m:
            return []
        rng = random.Random(f"{self._seed} {moment_ms} {body}")
        thing = self._taken_for(self._things[body], rng)
        is_missed = rng.random() < self._errors.miss
        score = min(0.97, max(0.05, 0.5 + 0.35 * _size(len(lines)) + rng.gauss(0, 0.06)))
        box = self._blurred(columns, lines, frame.body.shape, rng)
        name = next((name for name in names if self._means(name, thing)), "")
        return [ObjectDetection(name, round(score, 3), box)] if name and not is_missed else []

    def _taken_for(self, thing: ObjectClass, rng: random.Random) -> ObjectClass:
        is_wrong, other = rng.random() < self._errors.misclassify, rng.choice(self._lookalikes(thing))
        return other if is_wrong else thing

    def _blurred(self, columns: NDArray[Any], lines: NDArray[Any], shape: tuple[int, ...], rng: random.Random) -> Box2D:
        edges = [float(columns.min()), float(lines.min()), float(columns.max()) + 1, float(lines.max()) + 1]
        wide, high = edges[2] - edges[0], edges[3] - edges[1]
        sizes, limits = (wide, high, wide, high), (shape[1], shape[0], shape[1], shape[0])
        noise = self._errors.noise
        moved = [edge + rng.gauss(0, noise) * size for edge, size in zip(edges, sizes, strict=True)]
        left, top, right, bottom = (
            round(min(max(edge, 0.0), float(most)), 2) for edge, most in zip(moved, limits, strict=True)
        )
        return Box2D(left, top, max(right, left + 1), max(bottom, top + 1))

    def _imagined(self, frame: Frame, moment_ms: int, names: Sequence[str]) -> list[ObjectDetection]:
        rng = random.Random(f"{self._seed} {moment_ms} nothing")
        if not names or rng.random() >= self._errors.false_alarm:
            return []
        height, width = frame.body.shape
        x, y, size = rng.uniform(0, width * 0.9), rng.uniform(0, height * 0.9), rng.uniform(0.05, 0.1) * width
        return [
            ObjectDetection(rng.choice(list(names)), round(rng.uniform(0.4, 0.8), 3), Box2D(x, y, x + size, y + size))
        ]

    def _means(self, name: str, thing: ObjectClass) -> bool:
        """Whether free words may mean a thing: they name its kind, and no other colour."""
        words = {SYNONYMS.get(word, word) for word in name.lower().replace("_", " ").split()}
        return thing.kind in words and not (words & self._colours) - {thing.colour}


def _size(pixels: int) -> float:
    """0 at the fewest pixels, 1 from the sure ones on."""
    return min(1.0, math.log(pixels / FEWEST_PIXELS) / math.log(SURE_PIXELS / FEWEST_PIXELS))
