# SPDX-License-Identifier: Apache-2.0
"""The tools that a model has in a run: those that look, over the run's own connector, as far as the profile allows.

Rule: without `tools` in the profile a model has none of the robot's, and one that acts is never among them. `recall`
looks at the robot's own documents alone, and so needs an identity and no permission.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from rai_missions.check.index import MissionIndex
from rai_missions.connectors.connector import Connector
from rai_missions.embodiment.identity import Identity
from rai_missions.errors import DefinitionError, Fault, suggestion
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.redaction import logger

if TYPE_CHECKING:
    from rai_missions.tools import RobotTool, Toolbox

__all__ = ("open_recall", "open_toolbox")

log = logger(__name__)

RECALL = "recall"
"""As in `tools.recall`, which is loaded for a mission that names it."""


def open_toolbox(
    mission: Mission, robot: Robot | None, connector: Connector | None, now: Callable[[], float]
) -> Toolbox | None:
    """The tools of a run; None where the profile allows none.

    Args:
        mission: Whose decisions name tools.
        robot: Whose profile lists what may be touched.
        connector: The run's.
        now: The run's clock.

    Raises:
        DefinitionError: A decision names a tool that there is not, or one that acts.
    """
    named = {name: place for name, place in _named(mission) if name != RECALL}
    if robot is None or robot.tools is None or connector is None:
        for name, place in named.items():
            log.warning("%s: the tool '%s' is not there: the robot's profile has no 'tools'", place, name)
        return None
    from rai_missions.tools import Allowlist, Toolbox

    rules = robot.tools
    box = Toolbox(connector, Allowlist(read=rules.read, write=rules.write, never=rules.never), now=now)
    look, every = {tool.name for tool in box.read_only}, {tool.name for tool in box.tools}
    faults = [
        Fault(place, f"the tool '{name}' acts, and a decision may only look{suggestion(name, look)}")
        if name in every
        else Fault(place, f"no tool '{name}'{suggestion(name, look)}")
        for name, place in named.items()
        if name not in look
    ]
    if faults:
        raise DefinitionError(faults)
    return box


def open_recall(mission: Mission, identity: Identity | None) -> tuple[RobotTool, ...]:
    """The tool that looks things up in the robot's documents, where a decision names it; its index is made current.

    Raises:
        DefinitionError: The identity's folder cannot be read.
        UsageError: The index cannot be written.
    """
    place = dict(_named(mission)).get(RECALL)
    if place is None:
        return ()
    if identity is None or identity.library is None:
        log.warning("%s: the tool 'recall' is not there: the robot has no 'identity' here", place)
        return ()
    from rai_missions.tools import recall_tool

    identity.library.open()
    return (recall_tool(identity.library),)


def _named(mission: Mission) -> Iterator[tuple[str, str]]:
    """The tools that decisions name, each with where it is named first."""
    seen: set[str] = set()
    for asked, place, _ in MissionIndex(mission).asked:
        for name in asked.tools:
            if name not in seen:
                seen.add(name)
                yield name, f"{place}/tools"
