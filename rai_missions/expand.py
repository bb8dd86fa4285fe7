# SPDX-License-Identifier: Apache-2.0
"""Missions in missions: each inclusion becomes a compound state of the mission that it names.

Rule: what comes out is an ordinary mission. Nothing that runs, checks or draws one knows that anything was included.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from rai_missions.blackboard import Key, fits
from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.faults import faults_of
from rai_missions.guards import Guard, In, Not
from rai_missions.guards.elapsed import Elapsed
from rai_missions.guards.guard import made
from rai_missions.json_text import MAX_BYTES, MAX_DEPTH, read_json
from rai_missions.mission import BUILT_IN_EVENTS, Mission
from rai_missions.renaming import Names, renamed
from rai_missions.states import Compound, Decision, Final, Include, State, Transition
from rai_missions.states.state import ANY_EVENT, OUTCOMES
from rai_missions.states.tree import DecisionLeaf, Tree, tree_paths
from rai_missions.wording import pointer, shown, suggestion

__all__ = ("MAX_INCLUSIONS", "MAX_STATES", "expanded", "read_mission")

MAX_STATES = 20_000
"""In a mission with all that it includes."""
MAX_INCLUSIONS = 16
"""Missions inside each other."""


class Chain(NamedTuple):
    """Where an inclusion stands: the files that led to it, and what all of them have brought so far."""

    files: tuple[Path, ...]
    """Outermost first."""
    total: dict[str, int]
    """States and bytes of everything included, counted as often as it is."""

    @property
    def folder(self) -> Path:
        """What may be included lies in here."""
        return self.files[0].parent

    def named(self, file: Path) -> str:
        """A file as a reader of the top mission knows it."""
        return str(file.relative_to(self.folder))


class Brought(NamedTuple):
    """What an inclusion becomes."""

    state: Compound
    keys: Mapping[str, Key]
    events: Mapping[str, Any]
    invariants: Mapping[str, Guard]


def read_mission(file: Path) -> Mission:
    """The mission in a JSON file as it stands there: inclusions are states of their own.

    Raises:
        DefinitionError: The mission is at fault.
        UsageError: There is no such file.
    """
    data = read_json(file)
    if not isinstance(data, Mapping):
        raise DefinitionError([Fault("", f"a mission is a JSON object, not {shown(data)}")], str(file))
    try:
        return Mission.model_validate(data)
    except ValidationError as error:
        raise DefinitionError(faults_of(error, Mission, data), str(file)) from None


def expanded(mission: Mission, file: Path) -> Mission:
    """A mission without inclusions.

    Args:
        mission: As it was written.
        file: Where it was written; the files that it includes are named relative to it, and lie in its folder.

    Raises:
        DefinitionError: An inclusion is at fault; its place is that of the inclusion.
    """
    if not any(isinstance(state, Include) for _, _, state in mission.walk()):
        return mission
    whole = _without_inclusions(mission, Chain((file.resolve(),), {"states": 0, "bytes": 0}), str(file))
    if (levels := _levels(whole.written())) > MAX_DEPTH:
        why = f"with all it includes it nests {levels} objects and lists, more than {MAX_DEPTH}; include less deeply"
        raise DefinitionError([Fault("", why)], str(file))
    return whole


def _without_inclusions(mission: Mission, chain: Chain, source: str) -> Mission:
    faults: list[Fault] = []
    brought: dict[str, Brought] = {}
    for place, name, state in mission.walk():
        chain.total["states"] += 1
        if isinstance(state, Include):
            try:
                brought[name] = _brought(name, state, mission, chain)
            except DefinitionError as error:
                faults += [Fault(place + fault.place, fault.sentence) for fault in error.faults]
        if chain.total["states"] > MAX_STATES:
            faults.append(Fault(place, f"more than {MAX_STATES} states with all that is included; include less"))
            break
    if faults:
        raise DefinitionError(faults, source)
    return mission.model_copy(update={
        "states": _replaced(mission.states, brought),
        "blackboard": {**mission.blackboard, **{k: key for each in brought.values() for k, key in each.keys.items()}},
        "events": {**mission.events, **{e: event for each in brought.values() for e, event in each.events.items()}},
        "invariants": {**mission.invariants, **{i: g for each in brought.values() for i, g in each.invariants.items()}},
    })  # fmt: skip


def _replaced(states: Mapping[str, State], brought: Mapping[str, Brought]) -> dict[str, State]:
    new: dict[str, State] = {}
    for name, state in states.items():
        if isinstance(state, Include):
            new[name] = brought[name].state
        elif state.children():
            new[name] = state.model_copy(update={state.child_place(): _replaced(state.children(), brought)})
        else:
            new[name] = state
    return new


def _brought(name: str, include: Include, parent: Mission, chain: Chain) -> Brought:
    """What one inclusion becomes; raises faults with places from the inclusion on."""
    file = _file(include.mission, chain)
    try:
        chain.total["bytes"] += file.stat().st_size
        if chain.total["bytes"] > MAX_BYTES:
            raise _refused(f"all that is included is larger than {MAX_BYTES // 2**20} MiB; include less")
        inner = _without_inclusions(read_mission(file), chain._replace(files=(*chain.files, file)), "")
    except UsageError as error:
        raise _refused(str(error)) from None
    except DefinitionError as error:
        if not error.source and error.faults[0].place == "/mission":
            raise
        raise DefinitionError(
            Fault("/mission", f"in {shown(include.mission)}, {fault}") for fault in error.faults
        ) from None
    faults = [*_misfits(include, inner, parent), *_unfit(include, inner, parent)]
    if faults:
        raise DefinitionError(faults)
    return _compound(name, include, inner)


def _file(written: str, chain: Chain) -> Path:
    """The file that an inclusion names, if it may be included."""
    here = chain.files[-1]
    if "\0" in written or "\\" in written or Path(written).is_absolute() or not written.endswith(".json"):
        raise _refused(f"{shown(written)} cannot be included; name a .json file relative to this one, with '/'")
    try:
        file = (here.parent / written).resolve()
        found = file.is_relative_to(chain.folder) and file.is_file()
    except (OSError, RuntimeError):  # a name too long, links in a circle
        raise _refused(f"{shown(written)} cannot be opened; name a .json file") from None
    if not file.is_relative_to(chain.folder):
        raise _refused(f"{shown(written)} lies outside the mission's folder; put it inside")
    if not found:
        near = (each.name for each in here.parent.glob("*.json") if each.name != here.name)
        raise _refused(f"there is no file {shown(written)}{suggestion(written, near)}")
    if file in chain.files:
        circle = " → ".join(chain.named(each) for each in (*chain.files[chain.files.index(file) :], file))
        raise _refused(f"a mission cannot include itself: {circle}; break the circle")
    if len(chain.files) > MAX_INCLUSIONS:
        raise _refused(f"more than {MAX_INCLUSIONS} missions inside each other; include less deeply")
    return file


def _refused(sentence: str) -> DefinitionError:
    return DefinitionError([Fault("/mission", sentence)])


def _misfits(include: Include, inner: Mission, parent: Mission) -> Iterator[Fault]:
    """What `with` says that cannot be."""
    for word, given in include.with_.items():
        place = pointer(("with", word))
        if word in inner.blackboard:
            yield from (Fault(place, why) for why in _key_misfits(inner.blackboard[word], given, parent))
        elif word in inner.events:
            if not isinstance(given, str):
                yield Fault(place, f"'{word}' is an event; give the name of one of this mission's, not {shown(given)}")
            elif given not in parent.events:
                yield Fault(place, f"no event {shown(given)}{suggestion(given, parent.events)}")
        else:
            known = suggestion(word, (*inner.blackboard, *inner.events))
            yield Fault(place, f"{shown(include.mission)} has no key or event '{word}'{known}")


def _key_misfits(key: Key, given: Any, parent: Mission) -> Iterator[str]:
    name = _shared(given)
    if name is None:
        if key.source in ("robot", "answer"):
            yield f'a key of the {key.source} takes no value; share one of this mission\'s: {{"from": key}}'
        elif why := fits(key, given):
            yield why
    elif name not in parent.blackboard:
        yield f"no key {shown(name)}{suggestion(name, parent.blackboard)}"
    elif (theirs := parent.blackboard[name].type) != key.type and (theirs, key.type) != ("integer", "number"):
        yield f"'{name}' is of type '{theirs}', not '{key.type}'; share a key of that type"


def _shared(given: Any) -> str | None:
    """The parent's key that `{"from": key}` shares."""
    if isinstance(given, Mapping) and len(given) == 1 and isinstance(given.get("from"), str):
        return str(given["from"])
    return None


def _unfit(include: Include, inner: Mission, parent: Mission) -> Iterator[Fault]:
    """What the included mission says that it cannot say as a part of another."""
    for asked in _asked(inner):
        for option in asked.options:
            if option in parent.events:
                yield Fault("/mission", f"its option '{option}' is also an event of this mission; rename one of them")
    for place, row in _rows(inner):
        if ANY_EVENT in row.on and not inner.events:
            yield Fault("/mission", f"its row {place} is for any event, and it declares none; drop the row")
    for invariant, guard in inner.invariants.items():
        if any(isinstance(each, Elapsed) for each in guard.walk()):
            why = "asks for 'elapsed_s', which would count from the start of the whole; use a row with 'after_s'"
            yield Fault("/mission", f"its invariant '{invariant}' {why}")
    for key, declared in inner.blackboard.items():
        if declared.source == "answer" and _shared(include.with_.get(key)) != key:
            why = f'keep the name: "with": {{"{key}": {{"from": "{key}"}}}}, and declare it in this mission'
            yield Fault("/mission", f"its key '{key}' is written by answers, which know it by that name; {why}")


def _rows(mission: Mission) -> Iterator[tuple[str, Transition]]:
    sources = (("", mission.transitions), *((place, state.transitions) for place, _, state in mission.walk()))
    for place, rows in sources:
        for index, row in enumerate(rows):
            yield f"{place}/transitions/{index}", row


def _asked(mission: Mission) -> Iterator[Any]:
    for _, _, state in mission.walk():
        if isinstance(state, Decision):
            yield state.decision
        elif isinstance(state, Tree):
            yield from (node.decision for _, node in tree_paths(state.tree) if isinstance(node, DecisionLeaf))


def _names(name: str, include: Include, inner: Mission) -> Names:
    """What the names of an included mission become."""
    kept = {*OUTCOMES, *BUILT_IN_EVENTS, *(option for asked in _asked(inner) for option in asked.options)}
    shared = {word: _shared(given) for word, given in include.with_.items() if word in inner.blackboard}

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


def _compound(name: str, include: Include, inner: Mission) -> Brought:
    names = _names(name, include, inner)
    here = In(state=name)
    states: dict[str, State] = {}
    for each, state in inner.states.items():
        states |= _settling(names.state(each), renamed(state, names), inner.settle_s)
    over = [In(state=each) for each, state in states.items() if isinstance(state, Final)]
    rows = [_until(over, renamed(row, names)) for row in inner.transitions]
    common = {word: getattr(include, word) for word in State.model_fields if word in include.model_fields_set}
    common["about"] = include.about or inner.about
    common["transitions"] = (*include.transitions, *rows)
    compound = Compound.model_validate(
        {**common, "initial": tuple(names.state(each) for each in inner.initial), "states": states}
    )
    keys = {
        names.key(each): key.model_copy(update={"initial": include.with_[each]}) if each in include.with_ else key
        for each, key in inner.blackboard.items()
        if _shared(include.with_.get(each)) is None
    }
    events = {names.event(each): event for each, event in inner.events.items() if each not in include.with_}
    invariants = {f"{name}/{each}": Not(guard=here) | renamed(guard, names) for each, guard in inner.invariants.items()}
    return Brought(compound, keys, events, invariants)


def _until(over: list[In], row: Transition) -> Transition:
    """A row of the whole included mission ends with it: not once one of its finals is reached."""
    if not over:
        return row
    going = [Not(guard=final) for final in over]
    return row.model_copy(update={"when": made("all", all=(*((row.when,) if row.when is not None else ()), *going))})


def _settling(name: str, state: State, settle_s: float) -> dict[str, State]:
    """A final whose `requires` may take a while waits before it is one."""
    if not isinstance(state, Final) or state.requires is None or settle_s == 0:
        return {name: state}
    end = f"{name}/settled"
    waiting = State(
        about=state.about, entry=state.entry, exit=state.exit,
        transitions=[Transition(when=state.requires, to=end), Transition(after_s=settle_s, to=end)],
    )  # fmt: skip
    return {name: waiting, end: Final(state.final, requires=state.requires)}


def _levels(value: Any) -> int:
    """How deep objects and lists stand inside each other."""
    deepest, rest = 0, [(value, 1)]
    while rest:
        item, level = rest.pop()
        if isinstance(item, dict | list):
            deepest = max(deepest, level)
            rest += [(each, level + 1) for each in (item.values() if isinstance(item, dict) else item)]
    return deepest
