# SPDX-License-Identifier: Apache-2.0
"""The machine of a plan: the planner, once."""

from __future__ import annotations

from typing import Any

from rai_missions.engine.activities.activity import Bench, machine_of
from rai_missions.engine.activities.computing import ComputedResult, ComputingMachine
from rai_missions.errors import DefinitionError
from rai_missions.states.plan import Plan

__all__ = ()


def _planned(wanted: Any, seen: Any, *, asked: Any = "", refused: Any = False, last: Any = None) -> ComputedResult:
    from rai_missions.planning import Plan as Found  # a planner; few missions plan
    from rai_missions.planning import (
        Refusal,
        avoided_after,
        place_for_the_hand,
        plan_data,
        planned,
        read_goal,
        read_scene,
    )
    from rai_missions.planning.sentences import refusal_sentence

    language, avoided = _language(str(asked)), avoided_after(last) if refused is True else ()
    sentence, aside = "unreadable", None
    try:
        goal = read_goal(wanted)
        sentence = "unreadable_sight"
        scene = read_scene(seen)
    except DefinitionError as error:
        why = refusal_sentence(sentence, (error.faults[0],), language=language)
        found: Found | Refusal = Refusal("unreadable", why)
    else:
        found = goal if isinstance(goal, Refusal) else planned(goal, scene, language=language, avoided=avoided)
        aside = place_for_the_hand(scene)
    value = plan_data(found, avoided, aside)
    return ComputedResult("failed" if value["reason"] else "succeeded", value, value["about"])


def _language(asked: str) -> str:
    from rai_missions.planning.sentences import ENGLISH

    if not asked:
        return ENGLISH
    from rai_missions.planning.reading import language_of  # a grammar with its languages

    return language_of(asked)


@machine_of.register(Plan)
def _(definition: Plan, bench: Bench) -> ComputingMachine:
    optional = {"asked": definition.asked, "refused": definition.refused}
    more = {name: path for name, path in optional.items() if path}

    def compute(wanted: Any, seen: Any, *values: Any) -> ComputedResult:
        return _planned(wanted, seen, **dict(zip((*more, "last"), values, strict=False)))

    given = (definition.plan, definition.over, *more.values())
    return ComputingMachine(bench.owner, bench.site(), given, definition.into, compute, follows="refused" in more)
