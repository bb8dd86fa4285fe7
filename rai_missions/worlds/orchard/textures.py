# SPDX-License-Identifier: Apache-2.0
"""Surfaces grown from noise: grass, leaves, bark, planks, as pixels (rows, columns, red green blue).

Rule: they are only seen, so a model is compiled without them, and painted before its first picture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ("SURFACES", "paint")

Field = NDArray[np.float64]
Pixels = NDArray[np.uint8]
OCTAVES = 6
"""Scales of noise, each half as coarse as the one before."""


class Surface(NamedTuple):
    """A square picture."""

    size: int
    """Pixels of a side."""
    grow: Callable[[int], Pixels]


def grass(size: int) -> Pixels:
    """Mown grass with patches of soil; it tiles."""
    rng = np.random.default_rng(0)
    shade, blades = _noise(size, rng), rng.random((size, size))
    bare = np.clip((_noise(size, rng, persistence=0.8) - 0.55) * 5, 0, 1) * 0.5
    grown, light = 1 - bare, 0.86 + 0.28 * rng.random((size, size)) ** 3
    green = (66 + 52 * shade + 22 * blades, 96 + 62 * shade + 30 * blades, 34 + 24 * shade + 8 * blades)
    soil = (118 + 50 * shade + 22 * blades, 92 + 40 * shade + 18 * blades, 62 + 30 * shade + 12 * blades)
    return _pixels([one * light * grown + other * bare for one, other in zip(green, soil, strict=True)])


def leaves(size: int) -> Pixels:
    """Leaves over shade; the far corner is red, for fruit."""
    rng = np.random.default_rng(1)
    pixels = np.full((size, size, 3), (34, 60, 24), float)
    reach, green = np.arange(-14, 15), np.array([74, 122, 42])
    y, x = np.meshgrid(reach, reach, indexing="ij")
    for _ in range(800):
        (cx, cy), turn, length = rng.integers(size, size=2), rng.random() * np.pi, rng.uniform(6, 14)
        cos, sin = np.cos(turn), np.sin(turn)
        u, v = x * cos + y * sin, y * cos - x * sin
        inside = np.nonzero((u / length) ** 2 + (v / (length * 0.42)) ** 2 < 1)
        colour = green * rng.uniform(0.6, 1.25) + (u[inside] / length * 14)[:, None]
        pixels[(y[inside] + cy) % size, (x[inside] + cx) % size] = colour
    pixels[: size // 12, -size // 12 :] = (190, 32, 24)
    return _pixels(np.moveaxis(pixels, -1, 0))


def bark(size: int) -> Pixels:
    """Furrowed bark."""
    rng = np.random.default_rng(2)
    shade, furrow = _noise(size, rng), np.repeat(rng.random((1, size)), size, 0)
    deep = shade * furrow
    return _pixels((95 + 60 * deep + 20 * shade, 72 + 45 * deep + 15 * shade, 52 + 30 * deep))


def wood(size: int) -> Pixels:
    """Planks with dark gaps between them."""
    rng = np.random.default_rng(3)
    shade = _noise(size, rng)
    pixels = np.stack([165 + 50 * shade, 120 + 40 * shade, 72 + 30 * shade])
    for gap in range(0, size, size // 5):
        pixels[:, gap : gap + 5] *= 0.35
    pixels[..., :8] *= 0.5
    pixels[..., -8:] *= 0.5
    return _pixels(pixels)


def straw(size: int) -> Pixels:
    """Blades of grass that has gone to seed: green below, straw above."""
    rng = np.random.default_rng(4)
    high = np.linspace(0, 1, size)[:, None] * np.ones((1, size))
    shade = 0.75 + 0.4 * rng.random((size, size))
    return _pixels(((110 + 70 * high) * shade, (140 + 20 * high) * shade, (58 + 20 * high) * shade))


SURFACES: Mapping[str, Surface] = {
    "grass": Surface(512, grass),
    "leaf": Surface(256, leaves),
    "bark": Surface(128, bark),
    "wood": Surface(256, wood),
    "straw": Surface(64, straw),
}
"""Texture of the model → what is seen there."""


def paint(model: Any) -> None:
    """Give a compiled model the surfaces that its textures are named for."""
    for name, pixels in _grown().items():
        begin = int(model.texture(name).adr[0])
        model.tex_data[begin : begin + pixels.size] = pixels.ravel()


@cache
def _grown() -> Mapping[str, Pixels]:
    """Every surface, grown once a process; not to be written to."""
    grown = {name: surface.grow(surface.size) for name, surface in SURFACES.items()}
    for pixels in grown.values():
        pixels.setflags(write=False)
    return grown


def _pixels(channels: Sequence[Field] | Field) -> Pixels:
    """Red, green and blue (rows, columns), 0 to 255, next to each other."""
    pixels = np.empty((*channels[0].shape, 3), np.uint8)
    for place, channel in enumerate(channels):
        pixels[..., place] = np.clip(channel, 0, 255)
    return pixels


def _noise(size: int, rng: np.random.Generator, persistence: float = 0.55) -> Field:
    """Fractal noise, 0 to 1, that tiles."""
    total, weight = np.zeros((size, size)), 0.0
    for octave in range(OCTAVES):
        cells = min(2 ** (octave + 2), size)
        coarse = np.pad(rng.random((cells, cells)), ((0, 1), (0, 1)), mode="wrap")
        step = np.arange(size) * cells / size
        low, part = step.astype(int), (step % 1) ** 2 * (3 - 2 * (step % 1))
        rest = 1 - part
        rows = coarse[low] * rest[:, None] + coarse[low + 1] * part[:, None]
        total += persistence**octave * (np.take(rows, low, 1) * rest + np.take(rows, low + 1, 1) * part)
        weight += persistence**octave
    return total / weight
