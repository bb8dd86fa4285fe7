# SPDX-License-Identifier: Apache-2.0
"""The machine of a plan: the planner, once."""

from __future__ import annotations

from typing import Any

from rai_missions.engine.activities.activity import Bench, machine_of
from rai_missions.engine.activities.computing import ComputedResult, ComputingMachine
from rai_missions.errors import DefinitionError
from rai_missions.planning import Plan as Planned
from rai_missions.planning import Refusal, plan_data, planned, read_goal, read_scene
from rai_missions.planning.sentences import ENGLISH, refusal_sentence
from rai_missions.states.plan import Plan

__all__ = ()


def _planned(wanted: Any, seen: Any, asked: Any = "") -> ComputedResult:
    language = _language(str(asked))
    try:
        goal, scene = read_goal(wanted), read_scene(seen)
    except DefinitionError:
        found: Planned | Refusal = Refusal("unreadable", refusal_sentence("unreadable", language=language))
    else:
        found = goal if isinstance(goal, Refusal) else planned(goal, scene, language=language)
    value = plan_data(found)
    return ComputedResult("failed" if value["reason"] else "succeeded", value, value["about"])


def _language(asked: str) -> str:
    if not asked:
        return ENGLISH
    from rai_missions.planning.reading import language_of  # a grammar with its languages

    return language_of(asked)


@machine_of.register(Plan)
def _(definition: Plan, bench: Bench) -> ComputingMachine:
    given = (definition.plan, definition.over, *((definition.asked,) if definition.asked else ()))
    return ComputingMachine(bench.owner, bench.site(), given, definition.into, _planned)
