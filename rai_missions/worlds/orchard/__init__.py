# SPDX-License-Identifier: Apache-2.0
"""A tractor works the alleys of an orchard, on MuJoCo."""

from rai_missions.worlds.orchard.orchard import Orchard

__all__ = ("Orchard",)
