# SPDX-License-Identifier: Apache-2.0
"""Shapes made of triangles are those that they were, however they are worked out."""

from __future__ import annotations

import numpy as np
import pytest

from rai_missions.worlds.meshes import Mesh


def one_leaf(mesh: Mesh, radii: tuple[float, float, float], rng: np.random.Generator, size: float) -> None:
    """A card of leaves, worked out alone."""
    out = rng.normal(size=3)
    out /= np.linalg.norm(out)
    face = out + rng.normal(size=3) * 0.6
    first = np.cross(face, rng.normal(size=3))
    first /= np.linalg.norm(first)
    second = np.cross(face / np.linalg.norm(face), first)
    middle = out * radii * rng.uniform(0.86, 1.04)
    first, second = first * size * rng.uniform(0.7, 1.3), second * size * rng.uniform(0.7, 1.3)
    corners = np.array([-first - second, first - second, first + second, -first + second]) + middle
    uvs = rng.random(2) * 0.5 + np.array([[0, 0], [0.3, 0], [0.3, 0.3], [0, 0.3]])
    mesh.add(corners, np.tile(out, (4, 1)), uvs, np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]]))


@pytest.mark.parametrize("count", [1, 40])
def test_leaves_made_at_once_are_those_made_one_by_one(count: int) -> None:
    radii, each, rng = (1.0, 0.9, 1.2), Mesh(), np.random.default_rng(3)
    for _ in range(count):
        one_leaf(each, radii, rng, 0.2)
    assert Mesh().leaves(radii, count, np.random.default_rng(3), 0.2).obj() == each.obj()


def test_a_flat_face_has_the_normal_of_its_corners() -> None:
    corners = np.random.default_rng(4).normal(size=(4, 3))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    wanted = "vn " + " ".join(f"{part:.3f}" for part in normal / np.linalg.norm(normal))
    lines = Mesh().flat_faces(corners, [(0, 1, 2, 3)]).obj().decode().splitlines()
    assert {line for line in lines if line.startswith("vn")} == {wanted}
