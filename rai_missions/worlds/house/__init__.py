# SPDX-License-Identifier: Apache-2.0
"""A robot with wheels and a lidar among the rooms of a house, on MuJoCo, with a navigation shaped like Nav2's.

Imports `connectors` and the modules of the root.
"""

from rai_missions.worlds.libraries import configure_libraries

configure_libraries()

from rai_missions.worlds.house.world import House  # noqa: E402 - MuJoCo and numpy are imported here

__all__ = ("House",)
