# SPDX-License-Identifier: Apache-2.0
"""Missions in missions: each inclusion becomes a compound state of the mission that it names.

Rule: what comes out is an ordinary mission. Nothing that runs, checks or draws one knows that anything was included.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.guards import Guard, In, Not
from rai_missions.guards.guard import made
from rai_missions.keys import Key
from rai_missions.mission.file_kinds import object_of
from rai_missions.mission.include_rules import Chain, included_file, inclusion_faults, questions, refused, shared_key
from rai_missions.mission.json_reader import MAX_BYTES, MAX_DEPTH, read_json
from rai_missions.mission.mission import BUILT_IN_EVENTS, Mission
from rai_missions.mission.renaming import Names, renamed
from rai_missions.model.validation_errors import validated
from rai_missions.redaction import shown
from rai_missions.states import Compound, Final, Include, State, Transition
from rai_missions.states.state import OUTCOMES
from rai_missions.states.transition import ANY_EVENT

__all__ = ("MAX_STATES", "expanded", "read_mission")

MAX_STATES = 20_000
"""In a mission with all that it includes."""


class Inclusion(NamedTuple):
    """What an inclusion becomes."""

    state: Compound
    keys: Mapping[str, Key]
    events: Mapping[str, Any]
    invariants: Mapping[str, Guard]
    uses: tuple[str, ...]


def read_mission(file: Path) -> Mission:
    """The mission in a JSON file as it is written there: inclusions are states of their own.

    Raises:
        DefinitionError: The mission is at fault.
        UsageError: There is no such file.
    """
    return validated(Mission, object_of("mission", read_json(file), str(file)), str(file))


def expanded(mission: Mission, file: Path) -> Mission:
    """A mission without inclusions, of no more states than a mission may have.

    Args:
        mission: As it was written.
        file: Where it was written; the files that it includes are named relative to it, and lie in its folder.

    Raises:
        DefinitionError: An inclusion is at fault; its place is that of the inclusion.
    """
    states = [state for _, _, state in mission.walk()]
    if len(states) <= MAX_STATES and not any(isinstance(state, Include) for state in states):
        return mission
    whole = _without_inclusions(mission, Chain((file.resolve(),), {"states": 0, "bytes": 0}, set()), str(file))
    if whole.behaviours():  # which no file has, so that none is read of it
        return whole
    if (levels := _levels(whole.written())) > MAX_DEPTH:
        why = f"with all it includes it nests {levels} objects and lists, more than {MAX_DEPTH}; include less deeply"
        raise DefinitionError([Fault("", why)], str(file))
    return whole


def _without_inclusions(mission: Mission, chain: Chain, source: str) -> Mission:
    faults: list[Fault] = []
    is_whole = True
    brought: dict[str, Inclusion] = {}
    for place, name, state in mission.walk():
        chain.total["states"] += 1
        if isinstance(state, Include):
            try:
                brought[name] = _brought(name, state, mission, chain)
            except DefinitionError as error:
                is_whole = False
                faults += [Fault(place + fault.place, fault.sentence) for fault in error.faults]
        if chain.total["states"] > MAX_STATES:
            is_whole = False
            faults.append(Fault(place, f"more than {MAX_STATES} states with all that is included; make it smaller"))
            break
    if not is_whole:  # where its only fault is that of a file which is reported already, there is none to name
        raise DefinitionError(faults, source)
    return mission.model_copy(
        update={
            "uses": tuple(dict.fromkeys((*mission.uses, *(u for each in brought.values() for u in each.uses)))),
            "states": _replaced(mission.states, brought),
            "blackboard": {
                **mission.blackboard,
                **{k: key for each in brought.values() for k, key in each.keys.items()},
            },
            "events": {**mission.events, **{e: event for each in brought.values() for e, event in each.events.items()}},
            "invariants": {
                **mission.invariants,
                **{i: g for each in brought.values() for i, g in each.invariants.items()},
            },
        }
    )


def _replaced(states: Mapping[str, State], brought: Mapping[str, Inclusion]) -> dict[str, State]:
    return {
        name: brought[name].state
        if isinstance(state, Include)
        else state.with_children(_replaced(state.children(), brought))
        for name, state in states.items()
    }


def _brought(name: str, include: Include, parent: Mission, chain: Chain) -> Inclusion:
    """What one inclusion becomes; raises faults with places from the inclusion on."""
    file = included_file(include.mission, chain)
    if file in chain.faulty:
        raise DefinitionError(())
    try:
        chain.total["bytes"] += file.stat().st_size
        if chain.total["bytes"] > MAX_BYTES:
            raise refused(f"all that is included is larger than {MAX_BYTES // 2**20} MiB; include less")
        inner = _without_inclusions(read_mission(file), chain._replace(files=(*chain.files, file)), "")
    except UsageError as error:
        raise refused(str(error)) from None
    except DefinitionError as error:
        if not error.source and error.faults and error.faults[0].place == "/mission":
            raise
        chain.faulty.add(file)
        raise DefinitionError(
            Fault("/mission", f"in {shown(include.mission)}, {fault}") for fault in error.faults
        ) from None
    if faults := tuple(inclusion_faults(include, inner, parent)):
        raise DefinitionError(faults)
    if inner.settle_s != parent.settle_s:
        states = {each: _settling(state, inner.settle_s) for each, state in inner.states.items()}
        inner = inner.model_copy(update={"states": states})
    brought = _compound(name, include, inner)
    for word in (*brought.keys, *brought.events, *brought.invariants):
        if word in parent.blackboard or word in parent.events or word in parent.invariants:
            raise refused(f"it brings '{word}', which this mission has itself; rename that")
    return brought


def _names(name: str, include: Include, inner: Mission) -> Names:
    """What the names of an included mission become."""
    kept = {*OUTCOMES, *BUILT_IN_EVENTS, *(option for asked in questions(inner) for option in asked.options)}
    shared = {word: shared_key(given) for word, given in include.with_.items() if word in inner.blackboard}

    def private(given: str) -> str:
        return f"{name}/{given}"

    def key(given: str) -> str:
        if given in ("event", "answer") and given not in inner.blackboard:
            return given
        return shared.get(given) or private(given)

    def event(given: str) -> str:
        if given in inner.events and given in include.with_ and given not in inner.blackboard:
            return str(include.with_[given])
        return given if given in BUILT_IN_EVENTS and given not in inner.events else private(given)

    def trigger(given: tuple[str, ...]) -> tuple[str, ...]:
        words = [each for word in given for each in (inner.events if word == ANY_EVENT else (word,))]
        return tuple(word if word in kept and word not in inner.events else event(word) for word in words)

    return Names(private, key, event, private, trigger)


def _compound(name: str, include: Include, inner: Mission) -> Inclusion:
    names = _names(name, include, inner)
    here = In(state=name)
    states = {names.state(each): renamed(state, names) for each, state in inner.states.items()}
    over = [In(state=each) for each, state in states.items() if isinstance(state, Final)]
    transitions = [_until(over, _within(renamed(transition, names))) for transition in inner.transitions]
    common = {word: getattr(include, word) for word in State.model_fields if word in include.model_fields_set}
    common["about"] = include.about or inner.about
    common["transitions"] = (*include.transitions, *transitions)
    compound = Compound.model_validate(
        {**common, "initial": tuple(names.state(each) for each in inner.initial), "states": states},
        context={"included_by": include},
    )
    keys = {
        names.key(each): _given(key, include.with_[each]) if each in include.with_ else key
        for each, key in inner.blackboard.items()
        if shared_key(include.with_.get(each)) is None
    }
    events = {names.event(each): event for each, event in inner.events.items() if each not in include.with_}
    invariants = {f"{name}/{each}": Not(guard=here) | renamed(guard, names) for each, guard in inner.invariants.items()}
    return Inclusion(compound, keys, events, invariants, inner.uses)


def _given(key: Key, value: Any) -> Key:
    """A key whose value the including mission gives for good: it is no argument of the run, unless it is an object."""
    if key.type == "object":  # such as a goal, of which a proof tries any
        return key.model_copy(update={"initial": value})
    limits = dict.fromkeys(("minimum", "maximum", "enum"))
    return key.model_copy(update={"initial": value, "source": "mission", **limits})


def _within(transition: Transition) -> Transition:
    """A transition of the whole included mission stays in it, as a mission is never left by its own."""
    return transition.model_copy(update={"internal": True}) if transition.to else transition


def _until(over: list[In], transition: Transition) -> Transition:
    """A transition of the whole included mission ends with it: not once one of its finals is reached."""
    if not over:
        return transition
    going = [Not(guard=final) for final in over]
    return transition.model_copy(
        update={"when": made("all", all=(*((transition.when,) if transition.when is not None else ()), *going))}
    )


def _settling(state: State, settle_s: float) -> State:
    """A state whose finals, and those inside it, have their own time for `requires`."""
    if isinstance(state, Final) and state.requires is not None and state.settle_s is None:
        return state.model_copy(update={"settle_s": settle_s})
    return state.with_children({name: _settling(each, settle_s) for name, each in state.children().items()})


def _levels(value: Any) -> int:
    """How deep objects and lists are nested."""
    deepest, rest = 0, [(value, 1)]
    while rest:
        item, level = rest.pop()
        if isinstance(item, dict | list):
            deepest = max(deepest, level)
            rest += [(each, level + 1) for each in (item.values() if isinstance(item, dict) else item)]
    return deepest
