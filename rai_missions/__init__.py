# SPDX-License-Identifier: Apache-2.0
"""Missions for robots in which rules own the state of the mission and models only answer questions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names
from rai_missions.event import Event

# `event` is a module's name too: imported at once, it is this one, whatever is imported later.
from rai_missions.mission.references import answer, event

if TYPE_CHECKING:
    from rai_missions.connectors.python_robot import PythonRobot
    from rai_missions.engine import Chart
    from rai_missions.engine.step import Step
    from rai_missions.errors import ConnectorError, DefinitionError, Fault, MissionError, UsageError
    from rai_missions.event import Tick
    from rai_missions.guards import Elapsed, GoalIs, Guard, Held, In, Named
    from rai_missions.image import Image
    from rai_missions.keys import Key
    from rai_missions.mission.builder import After, Keys, On, When
    from rai_missions.mission.files import dump, load
    from rai_missions.mission.mission import EventSpec, Mission
    from rai_missions.mission.references import Ref
    from rai_missions.runtime.result import Result
    from rai_missions.runtime.runner import Runner
    from rai_missions.states.effects import Call as CallEffect
    from rai_missions.states.effects import Drop, Log, Publish, Raise, Say, Set

__all__ = (
    "After",
    "CallEffect",
    "Chart",
    "ConnectorError",
    "DefinitionError",
    "Drop",
    "Elapsed",
    "Event",
    "EventSpec",
    "Fault",
    "GoalIs",
    "Guard",
    "Held",
    "Image",
    "In",
    "Key",
    "Keys",
    "Log",
    "Mission",
    "MissionError",
    "Named",
    "On",
    "Publish",
    "PythonRobot",
    "Raise",
    "Ref",
    "Result",
    "Runner",
    "Say",
    "Set",
    "Step",
    "Tick",
    "UsageError",
    "When",
    "answer",
    "dump",
    "event",
    "load",
)  # fmt: skip

if not TYPE_CHECKING:  # else a type checker would take any name for one of ours
    __getattr__, __dir__ = lazy_names(
        globals(),
        {
            "connectors.python_robot": ("PythonRobot",),
            "keys": ("Key",),
            "mission.builder": ("After", "Keys", "On", "When"),
            "mission.references": ("Ref",),
            "engine": ("Chart",),
            "states.effects": ("Call as CallEffect", "Drop", "Log", "Publish", "Raise", "Say", "Set"),
            "errors": ("ConnectorError", "DefinitionError", "Fault", "MissionError", "UsageError"),
            "event": ("Tick",),
            "image": ("Image",),
            "guards": ("Elapsed", "GoalIs", "Guard", "Held", "In", "Named"),
            "mission.files": ("dump", "load"),
            "mission.mission": ("EventSpec", "Mission"),
            "runtime.result": ("Result",),
            "runtime.runner": ("Runner",),
            "engine.step": ("Step",),
        },
    )
