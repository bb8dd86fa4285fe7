# SPDX-License-Identifier: Apache-2.0
"""An arm at a desk with cubes, fruit and vegetables, a tray and a bin, on MuJoCo, seen by two cameras.

Imports `connectors` and the modules of the root.
"""

from rai_missions.worlds.libraries import configure_libraries

configure_libraries()

from rai_missions.worlds.desk.world import Desk  # noqa: E402 - MuJoCo and numpy are imported here

__all__ = ("Desk",)
