# SPDX-License-Identifier: Apache-2.0
"""What a person looks like in every world: a few meshes, whose colours the world chooses."""

from __future__ import annotations

from rai_missions.worlds.meshes import Mesh

__all__ = ("person_meshes",)


def person_meshes() -> dict[str, Mesh]:
    """A worker in a high-visibility vest, 1.78 m tall, looking along x."""
    skin = Mesh().ellipsoid((0.02, 0, 1.64), (0.1, 0.08, 0.125)).tube([[0, 0, 1.42], [0.01, 0, 1.55]], [0.06, 0.055])
    skin.ellipsoid((0.115, 0, 1.63), (0.025, 0.018, 0.025), fineness=1)
    vest = Mesh().tube(
        [[0, 0, 0.86], [0, 0, 0.95], [0, 0, 1.08], [0.01, 0, 1.25], [0.01, 0, 1.38], [0, 0, 1.45], [0, 0, 1.49]],
        [0.17, 0.175, 0.16, 0.19, 0.2, 0.14, 0.07],
        12,
        0.6,
    )
    stripes, trousers, boots = Mesh(), Mesh(), Mesh()
    for z in (1.0, 1.16):
        stripes.tube([[0.0, 0, z], [0.0, 0, z + 0.05]], [0.185, 0.185], 12, 0.62)
    for side in (-1, 1):
        hip, knee, ankle = [0, side * 0.09, 0.9], [0.02, side * 0.1, 0.5], [-0.01, side * 0.11, 0.1]
        trousers.tube(
            [hip, [0.01, side * 0.1, 0.7], knee, [0, side * 0.105, 0.3], ankle], [0.1, 0.095, 0.075, 0.07, 0.06], 8
        )
        boots.ellipsoid((0.05, side * 0.11, 0.05), (0.14, 0.055, 0.06), fineness=1)
        shoulder, elbow = [0, side * 0.19, 1.41], [-0.02, side * 0.27, 1.14]
        vest.tube([shoulder, [-0.01, side * 0.24, 1.28], elbow], [0.065, 0.06, 0.05], 7)
        hand = [0.1, side * 0.25, 0.9]
        skin.tube([elbow, [0.04, side * 0.27, 1.0], hand], [0.045, 0.04, 0.03], 6).ellipsoid(
            hand, (0.04, 0.03, 0.06), fineness=1
        )
    hair = Mesh().ellipsoid((-0.012, 0, 1.68), (0.105, 0.09, 0.105))
    return {"skin": skin, "vest": vest, "stripes": stripes, "trousers": trousers, "boots": boots, "hair": hair}
