# SPDX-License-Identifier: Apache-2.0
"""The machine of each kind of activity; importing this module registers those of the format's own kinds."""

from rai_missions.engine import activities
from rai_missions.engine.activities.activity import Bench, machine_of
from rai_missions.kinds import load_kinds

__all__ = ("Bench", "machine_of")

load_kinds(activities.__name__, activities.__path__)
