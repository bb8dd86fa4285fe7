# SPDX-License-Identifier: Apache-2.0
"""What a notebook shows of a mission: its picture, and where there is no Graphviz its table.

Rule: IPython is never imported here; where it runs already, it is taught how missions are shown.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable

from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from visualize.build import picture
from visualize.files import drawn
from visualize.model import Picture

__all__ = ("Drawing", "show", "show_missions")


class Drawing:
    """A picture that a notebook shows."""

    def __init__(self, given: Picture) -> None:
        self.picture = given

    def _repr_svg_(self) -> str | None:
        try:
            return drawn(self.picture, "svg").decode("utf-8")
        except UsageError:  # the notebook then takes the next form that there is
            return None

    def _repr_markdown_(self) -> str | None:
        return drawn(self.picture, "md").decode("utf-8") if self._repr_svg_() is None else None

    def __repr__(self) -> str:
        return f"<{self.picture.name}: {len(self.picture.nodes)} states, {len(self.picture.edges)} edges>"


def show(mission: Mission, steps: Iterable[Step] = ()) -> Drawing:
    """The mission as a notebook shows it: the last line of a cell, with the path of a run in bold."""
    return Drawing(picture(mission, steps))


def show_missions() -> bool:
    """Have the notebook that this runs in show every mission by its picture.

    Returns:
        Whether this runs in IPython at all.
    """
    running = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if running is None:
        return False
    formatters = running.display_formatter.formatters
    formatters["image/svg+xml"].for_type(Mission, lambda mission: show(mission)._repr_svg_())
    formatters["text/markdown"].for_type(Mission, lambda mission: show(mission)._repr_markdown_())
    return True
