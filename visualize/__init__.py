# SPDX-License-Identifier: Apache-2.0
"""Pictures of missions, for review before a robot moves: of the graph, of a run's path, and of what a change changed.

Rule: reads missions, steps and journals only, and changes nothing; Graphviz is looked for when a picture needs it.

Imports `campaign`, `engine`, `guards`, `journal`, `mission`, `model` and `states`, and the modules of the root.
"""

from visualize.build import picture
from visualize.diff import Difference, difference
from visualize.files import FORMATS, check_ending, draw, draw_difference, draw_review, drawn
from visualize.model import Picture
from visualize.notebook import Drawing, show, show_missions

__all__ = (
    "FORMATS",
    "Difference",
    "Drawing",
    "Picture",
    "check_ending",
    "difference",
    "draw",
    "draw_difference",
    "draw_review",
    "drawn",
    "picture",
    "show",
)

show_missions()
