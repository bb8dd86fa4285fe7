# SPDX-License-Identifier: Apache-2.0
"""Keys and events: unknown, written by no one, used by no one, or written by someone who may not."""

from __future__ import annotations

from rai_missions.check.finding import Found
from rai_missions.check.index import KeyWrite, MissionIndex
from rai_missions.check.name_table import NameTable
from rai_missions.check.paths import key_of, meaning, parameter_types
from rai_missions.check.pointers import pointer
from rai_missions.states.effects import Raise
from rai_missions.states.transition import ANY_EVENT

__all__ = ("forbidden_writes", "unknown_keys", "unknown_payload", "unused_events", "unused_keys", "unwritten_keys")


def unknown_keys(index: MissionIndex) -> Found:
    """What is read or written is a key of the blackboard, a field of one, or what the transition's trigger brings."""
    for read in index.reads:
        if fault := meaning(index, read).fault:
            yield read.place, fault
    for write in index.writes:
        if write.key not in index.keys:
            order = " ('result' has key → field of the result)" if write.by == "result" else ""
            yield _place(write), index.keys.missing(write.key) + order


def _place(write: KeyWrite) -> str:
    """Where the key itself is named."""
    return f"{write.place}/set" if write.by in ("set", "add", "from") else write.place


def unknown_payload(index: MissionIndex) -> Found:
    """What a `raise` brings along is what its event declares."""
    for effect, place, _ in index.effects:
        event = index.mission.events.get(effect.event) if isinstance(effect, Raise) else None
        if event is None or not event.fields or not isinstance(effect, Raise):
            continue
        fields = NameTable(f"field of event '{effect.event}'", event.fields)
        for name in effect.data:
            if name not in fields:
                yield pointer(place, "data", name), fields.missing(name)


def forbidden_writes(index: MissionIndex) -> Found:
    """Only keys of the source `mission` are set."""
    whose = {
        "robot": "the robot profile alone writes it",
        "argument": "it is given at the start",
        "answer": "an option's parameter writes it",
    }
    for write in index.writes:
        key = index.mission.blackboard.get(write.key)
        if key is not None and key.source != "mission":
            yield (
                _place(write),
                f"'{write.key}' has the source '{key.source}': {whose[key.source]}; "
                "write another key, of the source 'mission'",
            )


def unwritten_keys(index: MissionIndex) -> Found:
    """A key that is read has an `initial`, or is written somewhere."""
    written = {index.keys.meant(write.key) for write in index.writes}
    brought = _parameters(index)
    read = {key_of(index, read.path) for read in index.reads}
    for name, key in index.mission.blackboard.items():
        if name not in read or name in written or key.initial is not None:
            continue
        if key.source == "mission":
            sentence = f"'{name}' is read but never written; give it an 'initial', set it, or take it from a 'result'"
            yield pointer("/blackboard", name), sentence
        elif key.source == "answer" and brought is not None and name not in brought:
            sentence = (
                f"'{name}' is read but no option has a parameter of that name; add it to an option's 'parameters'"
            )
            yield pointer("/blackboard", name), sentence


def _parameters(index: MissionIndex) -> set[str] | None:
    """The names of all options' parameters; None where some option takes any."""
    names: set[str] = set()
    for asked, _, _ in index.asked:
        for option in asked.options.values():
            own = parameter_types(option)
            if own is None:
                return None
            names.update(own)
    return names


def unused_keys(index: MissionIndex) -> Found:
    """Every key is read, or is a key of the mission that is written."""
    used = {key_of(index, read.path) for read in index.reads} | {index.keys.meant(write.key) for write in index.writes}
    unused = [name for name in index.mission.blackboard if name not in used]
    if not unused or any(part.predicates() for _, part, _ in index.parts) or index.mission.behaviours():
        return  # what is in the program may read any key
    for name in unused:
        yield pointer("/blackboard", name), f"nothing uses '{name}'; take it away, unless the robot profile reads it"


def unused_events(index: MissionIndex) -> Found:
    """Every declared event fires a transition."""
    words = {word for transition in index.transitions for word in transition.definition.on}
    if ANY_EVENT in words:
        return
    used = {index.events.meant(word) for word in words}
    for name in index.mission.events:
        if name not in used:
            yield (
                pointer("/events", name),
                f'no transition waits for \'{name}\'; add a transition {{"on": "{name}", …}}, or take the event away',
            )
