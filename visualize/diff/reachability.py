# SPDX-License-Identifier: Apache-2.0
"""Where a mission can go by its transitions, as far as it matters to a reviewer: which ways lead to `succeeded`.

Rule: guards are taken as if they could always hold. A way that counts as new has a transition that was not there;
a state that counts as avoidable was on every such way before. A final at the top leads nowhere.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet

from rai_missions.mission.mission import Mission
from rai_missions.states import Each, Final, Transition
from visualize.diff.change import Change
from visualize.diff.originals import Originals
from visualize.page.reachability import Roads

__all__ = ("Ways", "new_ways")

COMPOUNDS = 200


class Ways:
    """A mission as a graph: which state may be entered when another is active."""

    def __init__(self, mission: Mission) -> None:
        self.roads = Roads(mission)
        self.places = {name: place for place, name, _ in mission.walk()}
        self.ends = frozenset(name for name, state in self.roads.finals.items() if state.final == "succeeded")
        """The states in which the whole mission has succeeded."""
        self.initial = mission.initial
        self.onward = {name: frozenset(self._next(name)) for name in self.places}
        self.hopeful = self._before(self.ends)
        """The states from which it may still succeed."""

    def _next(self, name: str) -> Iterator[str]:
        if name in self.roads.finals:
            return
        yield from self.roads.inside(name)
        chain = (name, *self.roads.above(name))
        for around in (*chain, ""):
            if around and around != name and self.roads.states[around].word == "parallel":
                yield from (region for region in self.roads.states[around].children() if region not in chain)
            for _, transition in self.roads.transitions[around]:
                if self._is_waited_for(name, around, transition):
                    yield from transition.to

    def _is_waited_for(self, name: str, around: str, transition: Transition) -> bool:
        """Whether a transition may fire while a state is active: that one which holds it succeeded, its ends state."""
        holds = bool(around) and bool(self.roads.states[around].children())
        if not holds or transition.of is not None or set(transition.on) != {"succeeded"}:
            return True
        state = self.roads.states[name]
        return (isinstance(state, Each) and name == around) or (isinstance(state, Final) and state.final == "succeeded")

    def _before(self, targets: Iterable[str]) -> frozenset[str]:
        sources: dict[str, set[str]] = defaultdict(set)
        for name, after in self.onward.items():
            for each in after:
                sources[each].add(name)
        found, waiting = set[str](), list(targets)
        while waiting:
            if (name := waiting.pop()) not in found:
                found.add(name)
                waiting += sources[name]
        return frozenset(found)

    def gives_up(self, targets: Iterable[str]) -> bool:
        """Whether a transition to these ends the mission sooner or later, and never as succeeded."""
        given = tuple(targets)
        return bool(given) and not any(target in self.hopeful for target in given)

    def ways(self, without: str = "") -> dict[str, str]:
        """Every state that can be entered from the start → the one before it on a shortest way there.

        Args:
            without: A state that is kept clear of, with all that is inside it.
        """
        came = {name: "" for name in self.initial if not self._lies_in(name, without)}
        waiting = list(came)
        for name in waiting:
            for each in sorted(self.onward.get(name, ())):
                if each not in came and not self._lies_in(each, without):
                    came[each] = name
                    waiting.append(each)
        return came

    def _lies_in(self, name: str, around: str) -> bool:
        return bool(around) and (name == around or around in self.roads.above(name))

    def passed(self, end: str) -> set[str]:
        """The states that every way to an end goes through, or through something inside them.

        Of states that hold others, the first `COMPOUNDS` on a way are tried.
        """
        road = way(self.ways(), end)
        around = dict.fromkeys(each for name in road[:-1] for each in self.roads.above(name))
        found = {each for each in list(around)[:COMPOUNDS] if end not in self.ways(without=each)}
        return found | self._bottlenecks(road)

    def _bottlenecks(self, road: list[str]) -> set[str]:
        """The states of a way to its end that no other way there goes around."""
        places = {name: index for index, name in enumerate(road)}
        found: set[str] = set()
        seen: set[str] = set()
        furthest = max((places.get(name, 0) for name in self._spread(self.initial, places, seen)), default=0)
        for index, name in enumerate(road[:-1]):
            if furthest <= index:
                found.add(name)
            ahead = self._spread(self.onward[name], places, seen)
            furthest = max(furthest, *(places[each] for each in ahead), 0)
        return found

    def _spread(self, begin: Iterable[str], road: Mapping[str, int], seen: set[str]) -> set[str]:
        """The states of a road that can be entered next, by any detour that was not seen yet."""
        found: set[str] = set()
        waiting = list(begin)
        while waiting:
            name = waiting.pop()
            if name in road:
                found.add(name)
            elif name not in seen:
                seen.add(name)
                waiting += self.onward.get(name, ())
        return found


def way(came: Mapping[str, str], end: str) -> list[str]:
    """From the start to a state, both included; empty where there is no way."""
    found, here = list[str](), end if end in came else ""
    while here:
        found.append(here)
        here = came[here]
    return found[::-1]


def new_ways(old: Ways, new: Ways, own: Originals) -> Iterator[Change]:
    """How the mission can succeed that it could not before."""
    if (old.onward, old.ends, old.initial) == (new.onward, new.ends, new.initial):
        return
    was, now = old.ways(), new.ways()
    for end in sorted(new.ends & now.keys()):
        place = new.places[end]
        if end not in old.ends or end not in was:
            sentence = f"{end}: the mission can succeed here now"
            yield Change("+", "success", sentence, None, place, "", _road(way(now, end)), "safety", end)
            continue
        yield from _around(old, new, end, own)
    yield from _hope(old, new, was.keys(), now.keys())


def _around(old: Ways, new: Ways, end: str, own: Originals) -> Iterator[Change]:
    """States that every way to an end went through; of those inside each other the outermost."""
    avoided = {name for name in old.passed(end) - new.passed(end) if name in new.places}
    for name in (name for name in new.places if name in avoided and not avoided.intersection(new.roads.above(name))):
        around = way(new.ways(without=name), end)
        if around:
            sentence = f"{end}: can be reached without passing '{name}' now"
            before = f"every way went through '{own.state(name)}'"
            yield Change(
                "~", "success", sentence, old.places.get(end), new.places.get(end), before, _road(around), "safety", end
            )


def _hope(old: Ways, new: Ways, was: AbstractSet[str], now: AbstractSet[str]) -> Iterator[Change]:
    """States from which nothing led to succeeded, and now something does; and new ones that lead there at once."""
    for name, place in new.places.items():
        known = name in was and name in old.places
        if known and name in now and name in new.hopeful - old.hopeful - new.ends:
            sentence = f"{name}: the mission can still succeed from here now"
            yield Change("~", "success", sentence, old.places[name], place, "it could not", "", "safety", name)
        for target in sorted(new.ends & _targets(new, name)) if name in now and name not in old.places else ():
            sentence = f"{name}: a new state that leads to '{target}'"
            yield Change("+", "success", sentence, None, place, "", "", "safety", name)


def _targets(ways: Ways, name: str) -> set[str]:
    if name in ways.roads.finals:
        return set()
    return {target for _, transition in ways.roads.transitions[name] for target in transition.to}


def _road(names: list[str]) -> str:
    """A way in words; of a long one its begin and its end."""
    return " → ".join(names if len(names) <= 9 else [*names[:4], "…", *names[-4:]])
