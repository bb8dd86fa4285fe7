# SPDX-License-Identifier: Apache-2.0
"""What changed in the transitions of a state, or of the mission.

Rule: a transition that gives up (it leads to where the mission can no longer succeed) protects: to narrow it, to lead
it elsewhere or to drop it is `safety`. A transition that continues must be earned: to add or to widen it is `safety`,
and to narrow it too, unless it waits for a success or an answer that no other transition receives. What a transition
does counts where more than a reader sees it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rai_missions.states import Transition
from rai_missions.states.transition import ANY_EVENT
from visualize.diff.align import paired
from visualize.diff.change import Change, Severity
from visualize.diff.fields import FieldRef, as_words, effects_changed, guards, severity_if
from visualize.diff.reachability import Ways
from visualize.diff.reads import Uses, otherwise
from visualize.text import effects, trigger

__all__ = ("ComparedTransitions", "transition_changes")


class ComparedTransitions(NamedTuple):
    """The transitions of one state, in both missions."""

    old: Sequence[Transition]
    new: Sequence[Transition]
    spot: FieldRef
    """Of the state."""
    before: Ways
    after: Ways
    used: Uses
    """What either mission reads and receives."""
    gone: frozenset[str] = frozenset()
    """The options of the state's own decision that are no more."""
    come: frozenset[str] = frozenset()
    """The options that were not there; that they are offered is a change of its own, with where they lead."""


def transition_changes(transitions: ComparedTransitions) -> Iterator[Change]:
    """What came, what went, what is otherwise, and in which order they are tried."""
    pairs = paired(transitions.old, transitions.new)
    kept = [(before, after) for before, after in pairs if before is not None and after is not None]
    for before, after in pairs:
        if before is None and after is not None:
            later = _later(transitions, after, kept)
            yield _added(transitions, after, shadows=any(_meet(transitions.new[after], each) for each in later))
        elif after is None and before is not None:
            yield _removed(transitions, before)
        elif before is not None and after is not None and transitions.old[before] != transitions.new[after]:
            yield from _changed(transitions, before, after)
    if [before for before, _ in kept] != sorted(before for before, _ in kept):
        yield transitions.spot.inside("transitions").changed(
            "transition", "transitions are tried in another order", "safety"
        )


def _later(transitions: ComparedTransitions, added: int, kept: Sequence[tuple[int, int]]) -> Iterator[Transition]:
    """What is tried after a new transition: those below it that were there, and those of the states around."""
    yield from (transitions.new[index] for _, index in kept if index > added)
    if transitions.spot.subject:
        for around in (*transitions.after.roads.above(transitions.spot.subject), ""):
            yield from (transition for _, transition in transitions.after.roads.transitions[around])


def _added(transitions: ComparedTransitions, index: int, *, shadows: bool) -> Change:
    transition = transitions.new[index]
    spot = transitions.spot.inside("transitions", str(index))
    if transitions.after.ends.intersection(transition.to):
        return spot.came(
            "success", f"a new transition to '{', '.join(transition.to)}'", "safety", after=_transition(transition)
        )
    why = transitions.used.matter(transition.do)
    answers = bool(transition.on) and transitions.come.issuperset(transition.on)
    continues = bool(transition.to) and not answers
    severity = severity_if(bool(why) or ((shadows or continues) and not transitions.after.gives_up(transition.to)))
    text = "transition added, tried before one that it may keep from firing" if shadows else "transition added"
    return spot.came("transition" if severity == "safety" else "rest", text, severity, after=_transition(transition))


def _removed(transitions: ComparedTransitions, index: int) -> Change:
    transition = transitions.old[index]
    severity = severity_if(
        transitions.before.gives_up(transition.to)
        or not transition.on
        or not transitions.gone.issuperset(transition.on)
    )
    spot = transitions.spot.inside("transitions", str(index))
    return spot.went(
        "transition" if severity == "safety" else "rest",
        "transition removed",
        severity,
        before=_transition(transitions.spot.own.of(transition)),
    )


def _changed(transitions: ComparedTransitions, before: int, after: int) -> Iterator[Change]:
    old, new = transitions.old[before], transitions.new[after]
    name = trigger(new) or "as soon as"
    places = f"{transitions.spot.old}/transitions/{before}", f"{transitions.spot.new}/transitions/{after}"
    spot = transitions.spot._replace(
        old=places[0], new=places[1], whose=f"{transitions.spot.whose}: transition '{name}'"
    )
    if old.do != new.do:
        yield effects_changed(
            old.do, new.do, spot.inside("do"), "do", transitions.used.matter(otherwise(old.do, new.do))
        )
    for field in ("on", "of", "after_s", "to", "internal", "about"):
        was, now = getattr(old, field), getattr(new, field)
        if was != now and not (field == "on" and set(was) == set(now)):
            topic, severity = _weighed(transitions, field, old, new)
            own, here = getattr(spot.own.of(old), field), spot.inside(field)
            yield here.changed(topic, f"'{field}' changed", severity, before=as_words(own), after=as_words(now))
    if old.when != new.when:
        widened, narrowed = ("weakened", "changed"), ("strengthened", "changed")
        shields = transitions.before.gives_up(old.to)
        both = () if shields or _only_earned(transitions, after) else ("strengthened",)
        yield from guards(
            old.when,
            new.when,
            spot.inside("when"),
            "guard",
            topic="transition" if shields else "guard",
            grave_if=narrowed if shields else (*widened, *both),
        )


def _only_earned(transitions: ComparedTransitions, index: int) -> bool:
    """Whether a transition only continues from a success or an answer, and no other is tried in its stead."""
    transition, state = transitions.new[index], transitions.after.roads.states.get(transitions.spot.subject)
    earned = {"succeeded", *(state.options if state is not None else ())}
    rivals = _later(transitions, index, [(0, number) for number in range(len(transitions.new))])
    return (
        bool(transition.on)
        and earned.issuperset(transition.on)
        and not any(_meet(transition, other) for other in rivals)
    )


def _weighed(transitions: ComparedTransitions, field: str, old: Transition, new: Transition) -> tuple[str, Severity]:
    """What a change of a transition's field is about, and whether it is for a reviewer to judge."""
    if field == "about":
        return "words", "other"
    if field == "internal":
        return "transition", "safety"
    if field == "to" and transitions.after.ends.intersection(set(new.to) - set(old.to)):
        return "success", "safety"
    gave_up, gives_up = transitions.before.gives_up(old.to), transitions.after.gives_up(new.to)
    if field == "to":
        return "transition", severity_if(gave_up or not gives_up)
    if field == "after_s" and gave_up and old.after_s is not None and new.after_s is not None:
        return "limit", severity_if(new.after_s > old.after_s)
    more = field == "on" and set(old.on) <= set(new.on)
    return "transition", severity_if(not (gives_up and gave_up and more))


def _meet(one: Transition, other: Transition) -> bool:
    """Whether one event may find both."""
    if one.eventless or other.eventless:
        return one.eventless and other.eventless
    return bool(set(one.on) & set(other.on)) or ANY_EVENT in (*one.on, *other.on)


def _transition(transition: Transition) -> str:
    to = f" → {', '.join(transition.to)}" if transition.to else ", stays"
    do = f", does {'; '.join(effects(transition.do))}" if transition.do else ""
    return f"{transition.words() or 'as soon as'}{to}{do}"
