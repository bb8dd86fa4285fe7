# SPDX-License-Identifier: Apache-2.0
"""A tractor works the alleys of an orchard, on MuJoCo.

Imports `connectors` and the modules of the root.
"""

from rai_missions.worlds.opengl import choose_renderer

choose_renderer()

from rai_missions.worlds.orchard.world import Orchard  # noqa: E402 - mujoco is imported here

__all__ = ("Orchard",)
