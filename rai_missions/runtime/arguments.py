# SPDX-License-Identifier: Apache-2.0
"""The arguments of a run: what a mission takes, and whether what it is given fits."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

from rai_missions.errors import DefinitionError, Fault, suggestion
from rai_missions.keys import pose_slip, type_error
from rai_missions.mission.mission import Mission
from rai_missions.mission.start_fault import StartFault
from rai_missions.states.compound import Each

__all__ = ("accepted", "argument_faults", "not_taken")

WRITTEN: Mapping[str, str] = {"list": '["a", "b"]', "object": '{"a": 1}', "pose": '{"x": 1.5, "y": 2}'}
"""Type that a shell takes for text unless it is quoted → a value of it, as JSON."""


def accepted(mission: Mission, arguments: Mapping[str, Any], *, whole: bool = True) -> Mapping[str, Any]:
    """The arguments of a run, if the mission takes them.

    Args:
        mission: Whose arguments they are.
        arguments: Argument key → value.
        whole: None may be missing; else the missing ones are given with the command to start.

    Raises:
        DefinitionError: One that it does not take, does not fit, or is missing.
    """
    if faults := argument_faults(mission, arguments, whole=whole):
        raise DefinitionError([Fault(f"/blackboard/{each.argument}", each.sentence) for each in faults], mission.name)
    return arguments


def argument_faults(mission: Mission, arguments: Mapping[str, Any], *, whole: bool = True) -> list[StartFault]:
    """What is wrong with the arguments of a run; the arguments are as for `accepted`."""
    needed = mission.needed_arguments()
    takes = mission.keys_of("argument")
    faults = [StartFault("foreign", not_taken(mission, name), name) for name in arguments if name not in takes]
    for name, key in takes.items():
        example = WRITTEN.get(key.type) if isinstance(arguments.get(name), str) else None
        if name in arguments and (why := _unfit(mission, name, arguments[name], written=example is None)):
            remedy = f"; on a command line, quote JSON: --set '{name}={example}'" if example is not None else ""
            faults.append(StartFault("unfit", f"the argument does not fit: {why}{remedy}", name))
        if whole and name not in arguments and name in needed:
            needs = f"the mission needs the argument '{name}'; on a command line, give --set {name}=…"
            faults.append(StartFault("missing", needs, name))
    return faults


def not_taken(mission: Mission, name: str) -> str:
    """Why a name is no argument of a mission: a key that something else writes, or none; and what the mission takes."""
    takes = mission.keys_of("argument")
    key = mission.blackboard.get(name)
    why = f": the source of that key is '{key.source}'" if key is not None else ""
    # a key that is there is no slip of another's name
    others = suggestion("" if why else name, takes) or "; it takes none"
    return f"the mission takes no argument '{name}'{why}{others}"


def _unfit(mission: Mission, name: str, value: Any, *, written: bool) -> str:
    """Why a value is none of an argument's, with the items of a list that an `each` goes over; empty where it is."""
    key = mission.blackboard[name]
    if why := type_error(key, value, written=written) or pose_slip(key, value):
        return why
    rounds = (state for _, _, state in mission.walk() if isinstance(state, Each) and state.each == name)
    items = [mission.blackboard[each.item] for each in rounds if key.type == "list" and each.item in mission.blackboard]
    for item_key, (number, item) in product(items, enumerate(value if items else ())):
        if why := type_error(item_key, item, written=written) or pose_slip(item_key, item):
            return f"item {number}: {why}"
    return ""
