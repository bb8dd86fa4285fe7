# SPDX-License-Identifier: Apache-2.0
"""The machine of each kind of activity; importing this module registers those of the format's own kinds."""

from rai_missions.engine.activities import action, behaviour, call, decision, tree
from rai_missions.engine.activities.activity import Bench, machine_of

__all__ = ("KINDS", "Bench", "machine_of")

KINDS = (action, behaviour, call, decision, tree)
"""The modules that register a machine each."""
