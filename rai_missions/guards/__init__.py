# SPDX-License-Identifier: Apache-2.0
"""Guards: conditions over what is known, one file a kind.

Imports `model` and `planning`, and the modules of the root.
"""

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names
from rai_missions.guards.boolean import All, Any_, Not
from rai_missions.guards.compare import Compare
from rai_missions.guards.elapsed import Elapsed
from rai_missions.guards.fresh import Fresh
from rai_missions.guards.goal import GoalIs
from rai_missions.guards.guard import Guard
from rai_missions.guards.held import Held
from rai_missions.guards.in_state import In
from rai_missions.guards.named import Named
from rai_missions.guards.near import Near
from rai_missions.guards.possible import Possible
from rai_missions.guards.view import Operand, Site, Test, Truth, View
from rai_missions.kinds import load_kinds

__all__ = (
    "All", "Any_", "Compare", "Elapsed", "Fresh", "GoalIs", "Guard", "Held", "In", "Named", "Near", "Not", "Operand",
    "Possible", "Site", "Test", "Truth", "View",
)  # fmt: skip

load_kinds(__name__, __path__)

if not TYPE_CHECKING:  # else a type checker would take any name for one of ours
    __getattr__, _ = lazy_names(globals(), {})  # a misspelled name is reported with the nearest
