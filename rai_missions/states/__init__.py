# SPDX-License-Identifier: Apache-2.0
"""States: what a mission can be in, one file a kind; a file that is laid here is a kind of the format.

Imports `guards`, `model` and `planning`, and the modules of the root.
"""

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names
from rai_missions.kinds import load_kinds
from rai_missions.states.action import Action
from rai_missions.states.call import Call
from rai_missions.states.compound import Compound, Each, Parallel
from rai_missions.states.decision import Budget, Decision, DecisionSpec, Option, answerer_words
from rai_missions.states.final import Final
from rai_missions.states.history import Default, History
from rai_missions.states.include import Include
from rai_missions.states.plan import Plan
from rai_missions.states.read import Read
from rai_missions.states.state import State
from rai_missions.states.transition import Transition
from rai_missions.states.tree import Tree

__all__ = (
    "Action",
    "Budget",
    "Call",
    "Compound",
    "Decision",
    "DecisionSpec",
    "Default",
    "Each",
    "Final",
    "History",
    "Include",
    "Option",
    "Parallel",
    "Plan",
    "Read",
    "State",
    "Transition",
    "Tree",
    "answerer_words",
)  # fmt: skip

load_kinds(__name__, __path__)

if not TYPE_CHECKING:  # else a type checker would take any name for one of ours
    __getattr__, _ = lazy_names(globals(), {})  # a misspelled name is reported with the nearest
