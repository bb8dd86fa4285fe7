# SPDX-License-Identifier: Apache-2.0
"""How alike two things are that go by other names, and which of them are one thing renamed.

Rule: a score is Dice's coefficient, 2·|common| / (|one| + |other|), over the facts of both: what is written in them,
who holds them, and who leads to or uses them, with the names that only one mission has hidden. It is a rename where the
score is at least `ENOUGH` and beats every rival of either by `CLEARLY`; what is the same in all but names comes first.
Source of the measure: L. R. Dice, "Measures of the amount of ecologic association between species", Ecology 26 (1945).
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.mission.renaming import Names, renamed
from rai_missions.states import State

__all__ = ("ComparedMissions", "alike_keys", "alike_options", "alike_states")

ENOUGH, CLEARLY = 0.6, 0.05
MOST = 40_000
"""More pairs than these are not compared; only what is the same in all but names is found then."""
Scores = dict[tuple[str, str], float]
Facts = Counter[tuple[str, str]]


class ComparedMissions(NamedTuple):
    """Two missions, and the parents of their states."""

    old: Mission
    new: Mission
    before: Mapping[str, str]
    after: Mapping[str, str]


def alike_states(known: ComparedMissions) -> Scores:
    """Old and new name of the states that are called otherwise → how alike they are."""
    gone, come = known.before.keys() - known.after.keys(), known.after.keys() - known.before.keys()
    if not gone or not come:
        return {}
    hidden = frozenset(gone | come)
    found: Scores = {}
    texts = [_written(mission, hidden) for mission in (known.old, known.new)]
    while True:
        names = dict(found.keys())
        left = _same(texts[0], gone - names.keys(), {name: names.get(at, at) for name, at in known.before.items()})
        right = _same(texts[1], come - set(names.values()), known.after)
        more = {(left[key][0], right[key][0]): 1.0 for key in left if len(left[key]) == len(right.get(key, ())) == 1}
        if not more:
            break
        found |= more
    names = dict(found.keys())
    if names.keys() >= gone or set(names.values()) >= come:
        return found
    facts = [_facts(mission, texts[side], hidden) for side, mission in enumerate((known.old, known.new))]
    return found | _best(
        {name: facts[0][name] for name in sorted(gone - names.keys())},
        {name: facts[1][name] for name in sorted(come - set(names.values()))},
    )


def _written(mission: Mission, hidden: frozenset[str]) -> dict[str, Any]:
    """State → what is written in it, without what is inside and without the names that only one mission has."""
    names = Names.by(states=dict.fromkeys(hidden, "?"))
    found: dict[str, Any] = {}
    for _, name, state in mission.walk():
        own = renamed(state.with_children({}), names)
        found[name] = {"kind": state.word, "inside": len(state.children()), **_document(own)}
    return found


def _document(state: State) -> dict[str, Any]:
    try:
        return state.written()
    except UsageError:
        return {"program": state.program(), "transitions": [transition.written() for transition in state.transitions]}


def _same(written: Mapping[str, Any], wanted: set[str], within: Mapping[str, str]) -> dict[tuple[str, str], list[str]]:
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name in written:
        if name in wanted:
            found[within[name], json.dumps(written[name], sort_keys=True, default=str)].append(name)
    return found


def _facts(mission: Mission, written: Mapping[str, Any], hidden: frozenset[str]) -> dict[str, Facts]:
    """State → what is known of it."""
    found = {name: Counter(_leaves(own)) for name, own in written.items()}
    nowhere: Facts = Counter()  # a mission that no check has passed may lead to states that it has not
    for _, name, state in mission.walk():
        own = "?" if name in hidden else name
        for child in state.children():
            found[child]["within", own] += 1
            found[name]["around", "?" if child in hidden else child] += 1
        for transition in state.transitions:
            for target in transition.to:
                found.get(target, nowhere)["from", f"{own} {transition.on} {transition.after_s}"] += 1
    for transition in mission.transitions:
        for target in transition.to:
            found.get(target, nowhere)["from", f"/ {transition.on} {transition.after_s}"] += 1
    for name in mission.initial:
        found.get(name, nowhere)["begins", ""] += 1
    return found


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """What is written, each with the words above it; where in a list it is does not count."""
    if isinstance(value, Mapping) and value:
        for word, item in value.items():
            yield from _leaves(item, f"{path}/{word}")
    elif isinstance(value, list | tuple) and value:
        for item in value:
            yield from _leaves(item, path)
    else:
        yield path, json.dumps(value, sort_keys=True, default=str)


def _best(left: Mapping[str, Facts], right: Mapping[str, Facts]) -> Scores:
    """The pairs that are alike enough and have no rival."""
    if len(left) * len(right) > MOST:
        return {}
    scores: Scores = {}
    for one, facts in left.items():
        for other, others in right.items():
            score = _dice(facts, others)
            if score >= ENOUGH - CLEARLY:
                scores[one, other] = score
    return {
        (one, other): round(score, 3)
        for (one, other), score in scores.items()
        if score >= ENOUGH
        and all(
            score - rival >= CLEARLY for (here, there), rival in scores.items() if (here == one) is not (there == other)
        )
    }


def _dice(one: Facts, other: Facts) -> float:
    total = one.total() + other.total()
    return 2 * (one & other).total() / total if total else 0.0


def alike_keys(old: Mission, new: Mission, of: str) -> Scores:
    """How alike keys (`blackboard`) or events (`events`) are: of one type and source, used in the same places."""
    before, after = getattr(old, of), getattr(new, of)
    gone, come = before.keys() - after.keys(), after.keys() - before.keys()
    if not gone or not come:
        return {}
    uses = [_uses(mission, names) for mission, names in ((old, gone), (new, come))]
    left = {name: uses[0][name] + Counter({("is", _sort(before[name])): 1}) for name in sorted(gone)}
    right = {name: uses[1][name] + Counter({("is", _sort(after[name])): 1}) for name in sorted(come)}
    return {
        (was, now): score
        for (was, now), score in _best(left, right).items()
        if _sort(before[was]) == _sort(after[now]) and (uses[0][was] or before[was] == after[now])
    }


def _sort(declared: Any) -> str:
    return f"{getattr(declared, 'type', 'event')} {getattr(declared, 'source', '')}"


def _uses(mission: Mission, names: set[str]) -> Mapping[str, Facts]:
    """Name → where it is written in the mission's states, transitions and invariants."""
    found: dict[str, Facts] = defaultdict(Counter)

    def look(value: Any, path: str) -> None:
        if isinstance(value, Mapping):
            for word, item in value.items():
                if word in names:
                    found[word][path, "word"] += 1
                look(item, f"{path}/{'?' if word in names else word}")
        elif isinstance(value, list | tuple):
            for item in value:
                look(item, path)
        elif isinstance(value, str) and (head := value.partition("."))[0] in names:
            found[head[0]][path, head[2]] += 1

    for _, _, state in mission.walk():
        look(_document(state.with_children({})), state.word)
    look([transition.written() for transition in mission.transitions], "transitions")
    look([guard.written() for guard in mission.invariants.values()], "invariants")
    return found


def alike_options(old: State, new: State) -> dict[str, str]:
    """Old and new name of the options that mean the same, are offered under the same guard and lead to the same."""
    before, after, asked = old.options, new.options, (old.question(), new.question())
    gone = [name for name in before if name not in after]
    come = [name for name in after if name not in before]

    def same(was: str, now: str) -> bool:
        leads = _leads(old, was)
        falls, last = (asks is not None and name == asks.fallback for asks, name in zip(asked, (was, now), strict=True))
        return bool(leads) and leads == _leads(new, now) and before[was] == after[now] and falls is last

    found = {was: [now for now in come if same(was, now)] for was in gone}
    return {
        was: now[0]
        for was, now in found.items()
        if len(now) == 1 and sum(now[0] in others for others in found.values()) == 1
    }


def _leads(state: State, option: str) -> list[tuple[Any, ...]]:
    """Where an answer leads, and what it does on the way."""
    return [
        (transition.to, transition.when, transition.do, transition.internal, len(transition.on), index)
        for index, transition in enumerate(state.transitions)
        if option in transition.on and transition.of is None
    ]
