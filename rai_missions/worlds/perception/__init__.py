# SPDX-License-Identifier: Apache-2.0
"""Named objects from a camera: what an open-set detector reports, where that is on the map, and how often looks agree.

Imports `connectors` and the modules of the root. It runs in a simulated world, and as a process of its own next to a
robot: `python -m rai_missions.worlds.perception`.
"""

__all__ = ()
