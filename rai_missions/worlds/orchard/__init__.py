# SPDX-License-Identifier: Apache-2.0
"""A tractor works the alleys of an orchard, on MuJoCo.

Imports `connectors` and the modules of the root.
"""

from rai_missions.worlds.libraries import configure_libraries

configure_libraries()

from rai_missions.worlds.orchard.world import Orchard  # noqa: E402 - MuJoCo and numpy are imported here

__all__ = ("Orchard",)
