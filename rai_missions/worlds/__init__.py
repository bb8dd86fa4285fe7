# SPDX-License-Identifier: Apache-2.0
"""Simulated robots and their surroundings, each opened by its name.

Imports `connectors` and the modules of the root.
"""

from rai_missions.worlds.world import WORLDS, World, open_world

__all__ = ("WORLDS", "World", "open_world")
