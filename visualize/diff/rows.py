# SPDX-License-Identifier: Apache-2.0
"""What changed in the rows of a state, or of the mission.

Rule: a row that gives up (it leads to where the mission can no longer succeed) protects: to narrow it, to lead it
elsewhere or to drop it is `safety`. A row that continues is one that must be earned: to add or to widen it is, and to
narrow it too unless it waits for a success or an answer that no other row receives. What a row does counts where
more than a reader sees it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rai_missions.states import Decision, Transition
from rai_missions.states.state import ANY_EVENT
from visualize.diff.align import paired
from visualize.diff.change import Change, Severity
from visualize.diff.fields import FieldRef, as_words, effects_changed, guards, severity_if
from visualize.diff.reachability import Ways
from visualize.diff.reads import Uses, otherwise
from visualize.text import effects, trigger

__all__ = ("Rows", "row_changes")


class Rows(NamedTuple):
    """The rows of one state, in both missions."""

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
    """Those that were not there; that they are offered is reported for itself, with where they lead."""


def row_changes(rows: Rows) -> Iterator[Change]:
    """What came, what went, what is otherwise, and in which order they are tried."""
    pairs = paired(rows.old, rows.new)
    kept = [(before, after) for before, after in pairs if before is not None and after is not None]
    for before, after in pairs:
        if before is None and after is not None:
            yield _added(rows, after, shadows=any(_meet(rows.new[after], row) for row in _later(rows, after, kept)))
        elif after is None and before is not None:
            yield _removed(rows, before)
        elif before is not None and after is not None and rows.old[before] != rows.new[after]:
            yield from _changed(rows, before, after)
    if [before for before, _ in kept] != sorted(before for before, _ in kept):
        yield rows.spot.inside("transitions").changed("row", "rows are tried in another order", "safety")


def _later(rows: Rows, added: int, kept: Sequence[tuple[int, int]]) -> Iterator[Transition]:
    """The rows that are tried after a new one: those below it that were there, and those of the states around."""
    yield from (rows.new[index] for _, index in kept if index > added)
    if rows.spot.subject:
        for around in (*rows.after.roads.above(rows.spot.subject), ""):
            yield from (row for _, row in rows.after.roads.rows[around])


def _added(rows: Rows, index: int, *, shadows: bool) -> Change:
    row = rows.new[index]
    spot = rows.spot.inside("transitions", str(index))
    if rows.after.ends.intersection(row.to):
        return spot.came("success", f"a new row to '{', '.join(row.to)}'", "safety", after=_row(row))
    why = rows.used.matter(row.do)
    answers = bool(row.on) and rows.come.issuperset(row.on)
    continues = bool(row.to) and not answers
    severity = severity_if(bool(why) or ((shadows or continues) and not rows.after.gives_up(row.to)))
    text = "row added, tried before one that it may keep from firing" if shadows else "row added"
    return spot.came("row" if severity == "safety" else "rest", text, severity, after=_row(row))


def _removed(rows: Rows, index: int) -> Change:
    row = rows.old[index]
    severity = severity_if(rows.before.gives_up(row.to) or not row.on or not rows.gone.issuperset(row.on))
    spot = rows.spot.inside("transitions", str(index))
    return spot.went(
        "row" if severity == "safety" else "rest", "row removed", severity, before=_row(rows.spot.own.of(row))
    )


def _changed(rows: Rows, before: int, after: int) -> Iterator[Change]:
    old, new = rows.old[before], rows.new[after]
    name = trigger(new) or "as soon as"
    places = f"{rows.spot.old}/transitions/{before}", f"{rows.spot.new}/transitions/{after}"
    spot = rows.spot._replace(old=places[0], new=places[1], whose=f"{rows.spot.whose}: row '{name}'")
    if old.do != new.do:
        yield effects_changed(old.do, new.do, spot.inside("do"), "do", rows.used.matter(otherwise(old.do, new.do)))
    for field in ("on", "of", "after_s", "to", "internal", "about"):
        was, now = getattr(old, field), getattr(new, field)
        if was != now and not (field == "on" and set(was) == set(now)):
            topic, severity = _weighed(rows, field, old, new)
            own, here = getattr(spot.own.of(old), field), spot.inside(field)
            yield here.changed(topic, f"'{field}' changed", severity, before=as_words(own), after=as_words(now))
    if old.when != new.when:
        widened, narrowed = ("weakened", "changed"), ("strengthened", "changed")
        shields = rows.before.gives_up(old.to)
        both = () if shields or _only_earned(rows, after) else ("strengthened",)
        yield from guards(
            old.when, new.when, spot.inside("when"), "guard", topic="row" if shields else "guard",
            grave_if=narrowed if shields else (*widened, *both),
        )  # fmt: skip


def _only_earned(rows: Rows, index: int) -> bool:
    """Whether a row only continues from a success or an answer, and no other is tried in its stead."""
    row, state = rows.new[index], rows.after.roads.states.get(rows.spot.subject)
    earned = {"succeeded", *(state.options if isinstance(state, Decision) else ())}
    rivals = _later(rows, index, [(0, number) for number in range(len(rows.new))])
    return bool(row.on) and earned.issuperset(row.on) and not any(_meet(row, other) for other in rivals)


def _weighed(rows: Rows, field: str, old: Transition, new: Transition) -> tuple[str, Severity]:
    """What a change of a row's field is about, and whether it is for a reviewer to judge."""
    if field == "about":
        return "words", "other"
    if field == "internal":
        return "row", "safety"
    if field == "to" and rows.after.ends.intersection(set(new.to) - set(old.to)):
        return "success", "safety"
    gave_up, gives_up = rows.before.gives_up(old.to), rows.after.gives_up(new.to)
    if field == "to":
        return "row", severity_if(gave_up or not gives_up)
    if field == "after_s" and gave_up and old.after_s is not None and new.after_s is not None:
        return "limit", severity_if(new.after_s > old.after_s)
    more = field == "on" and set(old.on) <= set(new.on)
    return "row", severity_if(not (gives_up and gave_up and more))


def _meet(one: Transition, other: Transition) -> bool:
    """Whether one event may find both."""
    if one.eventless or other.eventless:
        return one.eventless and other.eventless
    return bool(set(one.on) & set(other.on)) or ANY_EVENT in (*one.on, *other.on)


def _row(row: Transition) -> str:
    to = f" → {', '.join(row.to)}" if row.to else ", stays"
    do = f", does {'; '.join(effects(row.do))}" if row.do else ""
    return f"{row.words() or 'as soon as'}{to}{do}"
