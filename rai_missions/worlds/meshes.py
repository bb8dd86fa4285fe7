# SPDX-License-Identifier: Apache-2.0
"""Shapes made of triangles, grown from numbers: trees, wheels, people.

Rule: triangles are few; what a camera sees from two metres is enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ("Mesh", "icosphere", "turned")

Points = NDArray[np.float64]
FRUIT_UV = (0.97, 0.97)
"""A corner of the leaf texture is red: the fruit's colour without a material of its own."""
FRUIT_M = 0.055
"""From the middle of a fruit to its corners."""
SQUARE_UVS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TWO_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
"""A square's corners, in the order of `SQUARE_UVS`."""


class Mesh:
    """Triangles with normals and texture coordinates, gathered part by part."""

    def __init__(self) -> None:
        self._points: list[Points] = []
        self._normals: list[Points] = []
        self._uvs: list[Points] = []
        self._faces: list[NDArray[np.int64]] = []
        self._count = 0

    def add(self, points: Points, normals: Points, uvs: Points, faces: NDArray[np.int64]) -> Mesh:
        self._points.append(points)
        self._normals.append(normals)
        self._uvs.append(uvs)
        self._faces.append(faces + self._count)
        self._count += len(points)
        return self

    @property
    def points(self) -> Points:
        """All corners, (n, 3)."""
        return np.concatenate(self._points)

    def obj(self) -> bytes:
        """The mesh in the OBJ format."""
        points, normals = np.concatenate(self._points), np.concatenate(self._normals)
        uvs, faces = np.concatenate(self._uvs), np.concatenate(self._faces) + 1
        text = _lines("v %.4f %.4f %.4f\n", points) + _lines("vt %.4f %.4f\n", uvs)
        text += _lines("vn %.3f %.3f %.3f\n", normals)
        return (text + _lines("f %d/%d/%d %d/%d/%d %d/%d/%d\n", np.repeat(faces, 3, axis=1)))[:-1].encode()

    def tube(self, spine: Sequence[Sequence[float]], radii: Sequence[float], sides: int = 7, flat: float = 1.0) -> Mesh:
        """A tapered tube along a line; `flat` < 1 squeezes it along its second axis (a limb, a torso)."""
        line = np.asarray(spine, float)
        along = _unit(np.gradient(line, axis=0))
        first = _unit(_cross(along, np.array([[0.3, 0.9, 0.2] if abs(along[0, 2]) < 0.9 else [1.0, 0.0, 0.0]])))
        second = _cross(along, first)
        turn = np.linspace(0, 2 * np.pi, sides + 1)
        out = np.cos(turn)[:, None] * first[:, None] + flat * np.sin(turn)[:, None] * second[:, None]
        points = (line[:, None] + np.asarray(radii, float)[:, None, None] * out).reshape(-1, 3)
        normals = _unit(out.reshape(-1, 3))
        v, u = np.meshgrid(np.arange(len(line)) * 0.5, turn / np.pi, indexing="ij")
        return self.add(points, normals, np.stack([u.ravel(), v.ravel()], 1), _grid(len(line), sides + 1))

    def ellipsoid(
        self,
        centre: Sequence[float],
        radii: Sequence[float],
        *,
        fineness: int = 2,
        lumps: int = 0,
        rng: np.random.Generator | None = None,
    ) -> Mesh:
        """An ellipsoid, or something lumpier: a crown, a fleece."""
        points, faces = icosphere(fineness)
        scale = np.ones(len(points))
        if lumps and rng is not None:
            bumps = _unit(rng.normal(size=(lumps, 3)))
            scale = 0.74 + 0.36 * np.max(np.clip(points @ bumps.T, 0, 1) ** 6, axis=1)
            scale += rng.normal(size=len(points)) * 0.04
        uvs = np.stack([np.abs(np.arctan2(points[:, 1], points[:, 0])) / 2, points[:, 2] * 0.9], 1)  # mirrored: no seam
        placed = np.asarray(centre, float) + points * scale[:, None] * np.asarray(radii, float)
        return self.add(placed, points, uvs, faces)

    def leaves(self, radii: Sequence[float], count: int, rng: np.random.Generator, size: float = 0.22) -> Mesh:
        """Two-sided cards of leaves scattered over an ellipsoid."""
        drawn = np.array(
            [
                [
                    *rng.normal(size=9),
                    rng.uniform(0.86, 1.04),
                    rng.uniform(0.7, 1.3),
                    rng.uniform(0.7, 1.3),
                    *rng.random(2),
                ]
                for _ in range(count)
            ]
        )
        out, face = _unit(drawn[:, 0:3]), drawn[:, 3:6] * 0.6
        face += out
        first = _unit(_cross(face, drawn[:, 6:9]))
        second = _cross(_unit(face), first)
        first, second = first * size * drawn[:, 10:11], second * size * drawn[:, 11:12]
        corners = np.stack([-first - second, first - second, first + second, -first + second], 1)
        corners += (out * radii * drawn[:, 9:10])[:, None]
        uvs = drawn[:, None, 12:] * 0.5 + [[0, 0], [0.3, 0], [0.3, 0.3], [0, 0.3]]
        both = np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]])
        faces = (4 * np.arange(count)[:, None, None] + both).reshape(-1, 3)
        return self.add(corners.reshape(-1, 3), np.repeat(out, 4, 0), uvs.reshape(-1, 2), faces)

    def fruit(self, radii: Sequence[float], count: int, rng: np.random.Generator) -> Mesh:
        """Small red octahedra over an ellipsoid."""
        for _ in range(count):
            out = rng.normal(size=3)
            out[2] = -abs(out[2]) * 0.6
            out /= np.linalg.norm(out)
            corners = np.concatenate([np.eye(3), -np.eye(3)])
            faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
            self.add(out * radii + corners * FRUIT_M, corners, np.tile(FRUIT_UV, (6, 1)), faces)
        return self

    def flat_faces(self, corners: Points, quads: Sequence[Sequence[int]] | NDArray[np.int64]) -> Mesh:
        """Flat quads with hard edges (a bonnet, a mudguard); corners counter-clockwise from outside."""
        points = corners[np.asarray(quads)]
        normals = _cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        length = np.sqrt((normals * normals).sum(1, keepdims=True))
        normals /= np.where(length == 0.0, 1.0, length)
        count = len(points)
        faces = (4 * np.arange(count)[:, None, None] + TWO_TRIANGLES).reshape(-1, 3)
        return self.add(points.reshape(-1, 3), np.repeat(normals, 4, 0), np.tile(SQUARE_UVS, (count, 1)), faces)


def turned(profile: Sequence[Sequence[float]], sides: int = 24) -> Mesh:
    """A solid of revolution about y: the profile is (y, radius) pairs, from one side to the other."""
    rim = np.asarray(profile, float)
    slope = np.gradient(rim, axis=0)
    turn = np.linspace(0, 2 * np.pi, sides + 1)
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    points = np.stack([rim[:, 1] * c, np.broadcast_to(rim[:, 0], (sides + 1, len(rim))), rim[:, 1] * s], -1)
    normals = np.stack(
        [slope[:, 0] * c, np.broadcast_to(-slope[:, 1], c.shape[:1] + slope.shape[:1]), slope[:, 0] * s], -1
    )
    normals = normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-9)
    u, v = np.meshgrid(turn, np.arange(len(rim)) * 0.2, indexing="ij")
    return Mesh().add(
        points.reshape(-1, 3), normals.reshape(-1, 3), np.stack([u.ravel(), v.ravel()], 1), _grid(sides + 1, len(rim))
    )


def _cross(one: Points, other: Points) -> Points:
    """The cross products of rows, as `numpy.cross` has them to the last bit, in a third of its time."""
    a, b = one.T, other.T
    return np.stack([a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)], 1)


def _unit(vectors: Points) -> Points:
    lengths: Points = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / lengths


def _lines(line: str, values: NDArray[Any]) -> str:
    """A line for each row of values, formatted at once: that takes a third of the time of one by one."""
    return line * len(values) % tuple(values.ravel().tolist())


@cache
def icosphere(fineness: int) -> tuple[Points, NDArray[np.int64]]:
    """A sphere of radius 1 as 20 * 4**fineness triangles: (points, faces), not to be written to."""
    g = (1 + 5**0.5) / 2
    points: list[tuple[float, float, float]] = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    points += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2)]
    faces += [(10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11)]
    faces += [(6, 2, 10), (8, 6, 7), (9, 8, 1)]
    vertices = [np.array(p) / np.linalg.norm(p) for p in points]
    for _ in range(fineness):
        faces = _split(vertices, faces)
    made = np.array(vertices), np.array(faces)
    for each in made:
        each.setflags(write=False)
    return made


def _split(vertices: list[Points], faces: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    middles: dict[tuple[int, int], int] = {}

    def middle(a: int, b: int) -> int:
        edge = (min(a, b), max(a, b))
        if edge not in middles:
            point = vertices[a] + vertices[b]
            middles[edge] = len(vertices)
            vertices.append(point / np.linalg.norm(point))
        return middles[edge]

    finer = []
    for a, b, c in faces:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return finer


def _grid(rows: int, columns: int) -> NDArray[np.int64]:
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    return np.concatenate(
        [
            np.stack([first, first + 1, first + columns], 1),
            np.stack([first + 1, first + columns + 1, first + columns], 1),
        ]
    )
