# SPDX-License-Identifier: Apache-2.0
"""What changed between two missions that use the same names, in sentences, and which of it loosens what protects.

Rule: every difference of meaning gives a sentence.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rai_missions.mission.mission import Mission
from rai_missions.model import MissionModel
from rai_missions.states import Parallel, State
from rai_missions.states.tree import TreeNode
from visualize.build import parents_of
from visualize.diff.change import Change
from visualize.diff.decisions import asked_changes, new_questions, offers
from visualize.diff.fields import FieldRef, as_words, effects_changed, fields, guards, reordered
from visualize.diff.originals import AS_THEY_ARE, Originals
from visualize.diff.reachability import Ways, new_ways
from visualize.diff.reads import Uses, otherwise, uses
from visualize.diff.transitions import ComparedTransitions, transition_changes

__all__ = ("changes",)


def changes(old: Mission, new: Mission, own: Originals = AS_THEY_ARE) -> Iterator[Change]:
    """Every change, in the order of the new mission; what was is in the old one's own words."""
    before, after, used = Ways(old), Ways(new), uses(old, new)
    whole = FieldRef("", "", "mission", own=own)
    yield from fields(old, new, whole, ("version",))
    yield from _named(whole, "key", old.blackboard, new.blackboard, "blackboard")
    yield from _named(whole, "event", old.events, new.events, "events")
    yield from _invariants(old, new, whole)
    yield from new_ways(before, after, own)
    yield from transition_changes(ComparedTransitions(old.transitions, new.transitions, whole, before, after, used))
    left = {name: (place, state) for place, name, state in old.walk()}
    around, now_around = parents_of(old), parents_of(new)
    for place, name, state in new.walk():
        if name not in left:
            yield FieldRef("", place, name, name).came("rest", "state added", "other", after=_is(state))
            yield from new_questions(state, place, name)
            yield from _does_on_the_way(state, FieldRef("", place, name, name), used)
            continue
        spot = FieldRef(left[name][0], place, name, name, own)
        if around[name] != now_around[name]:
            was, now = (
                f"in '{each}'" if each else "at the top" for each in (own.state(around[name]), now_around[name])
            )
            yield spot.changed("form", "moved", "safety", before=was, after=now)
        yield from _state(left[name][1], state, spot, (before, after, used))
    for name, (place, state) in left.items():
        if name not in now_around:
            yield FieldRef(place, "", name, name).went("rest", "state removed", "other", before=_is(own.of(state)))


def _is(state: State) -> str:
    return state.activity() or state.word or "a state that waits"


def _state(old: State, new: State, spot: FieldRef, ways: tuple[Ways, Ways, Uses]) -> Iterator[Change]:
    if type(old) is not type(new):
        yield spot.changed("form", "is something else", "safety", before=_is(spot.own.of(old)), after=_is(new))
        yield from new_questions(new, spot.new, spot.subject)
        yield from fields(old, new, spot, of=State)
    else:
        yield from fields(old, new, spot)
        if isinstance(old, Parallel) and reordered(old.children(), new.children()):
            yield spot.inside("parallel").changed("form", "regions are entered and tried in another order", "safety")
    yield from _passing(old, new, spot, ways[2])
    yield from asked_changes(old, new, spot.inside("decision"))
    if type(old) is type(new):
        yield from _trees(old, new, spot)
    before, after = frozenset(old.options), frozenset(new.options)
    yield from transition_changes(
        ComparedTransitions(old.transitions, new.transitions, spot, *ways, before - after, after - before)
    )


def _does_on_the_way(state: State, spot: FieldRef, used: Uses) -> Iterator[Change]:
    """What a state that was not there does on the way in and out, where that matters to more than a reader."""
    for word, does in (("entry", state.entry), ("exit", state.exit)):
        if why := used.matter(does):
            because = ", ".join(dict.fromkeys(why))
            yield spot.inside(word).came("effect", f"'{word}' added: {because}", "safety", after=as_words(does))


def _passing(old: State, new: State, spot: FieldRef, used: Uses) -> Iterator[Change]:
    """What is done on the way in and out."""
    for word, was, now in (("entry", old.entry, new.entry), ("exit", old.exit, new.exit)):
        if was != now:
            why = used.matter(otherwise(was, now))
            yield effects_changed(was, now, spot.inside(word), word, why)


def _trees(old: State, new: State, spot: FieldRef) -> Iterator[Change]:
    before, after = old.nodes(), new.nodes()
    for path in dict.fromkeys((*after, *before)):
        steps = path.split("/") if path else []
        here = spot.inside("tree")._replace(whose=f"{spot.whose}: tree node '{path or 'the root'}'")
        here = here._replace(old="/".join((here.old, *steps)), new="/".join((here.new, *steps)))
        if path not in before:
            yield here.came("tree", "added", "safety", after=after[path].word)
            yield from offers(after[path], here.new, here.whose, here.subject)
        elif path not in after:
            yield here.went("tree", "removed", "safety", before=before[path].word)
        elif type(before[path]) is not type(after[path]):
            yield here.changed("tree", "is something else", "safety", before=before[path].word, after=after[path].word)
            yield from offers(after[path], here.new, here.whose, here.subject)
        else:
            yield from _twig(before[path], after[path], here)


def _twig(old: TreeNode, new: TreeNode, spot: FieldRef) -> Iterator[Change]:
    inner = [pointer.partition("/")[0] for pointer, _ in new.branches()]
    yield from fields(old, new, spot, (*inner, "child", "then"))
    yield from asked_changes(old, new, spot.inside("decision"))


def _named(
    whole: FieldRef, sort: str, before: Mapping[str, MissionModel], after: Mapping[str, MissionModel], word: str
) -> Iterator[Change]:
    for name in dict.fromkeys((*after, *before)):
        spot = whole.inside(word, name, whose=f"{sort} '{name}'")
        if name not in before:
            yield spot.came("rest", "added", "other")
        elif name not in after:
            yield spot.went("rest", "removed", "other")
        else:
            yield from fields(before[name], after[name], spot)


def _invariants(old: Mission, new: Mission, whole: FieldRef) -> Iterator[Change]:
    for name in dict.fromkeys((*new.invariants, *old.invariants)):
        spot = whole.inside("invariants", name, whose=f"invariant '{name}'")
        if name not in old.invariants:
            yield spot.came("rest", "added", "other", after=new.invariants[name].words())
        elif name not in new.invariants:
            yield spot.went("proof", "removed", "safety", before=whole.own.of(old.invariants[name]).words())
        else:
            yield from guards(old.invariants[name], new.invariants[name], spot, "guard", topic="proof")
