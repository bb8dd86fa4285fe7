# SPDX-License-Identifier: Apache-2.0
"""How a run that was cut short continues in a mission that has changed: by an explicit map, or not at all.

Imports `engine`, `guards`, `journal`, `mission`, `model`, `profile` and `states`, and the modules of the root.
"""

from rai_missions.replay.migrate.map import Map, load_map, map_schema
from rai_missions.replay.migrate.migrate import MigratedRun, follow, migrate

__all__ = ("Map", "MigratedRun", "follow", "load_map", "map_schema", "migrate")
