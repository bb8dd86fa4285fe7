# SPDX-License-Identifier: Apache-2.0
"""What a run knows: keys read and written, and predicates of the user's program asked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine.compiled.program import Program
from rai_missions.engine.state import RunState
from rai_missions.guards.guard import foreign_truth
from rai_missions.guards.view import Truth
from rai_missions.keys import Key, Stamped, stale_at, type_error

__all__ = ("ask_named", "is_other", "known", "note_news", "value_at", "write_key")


def known(program: Program, state: RunState, key: str) -> Any:
    """The value of a key; None where it is missing or stale."""
    return value_at(program.keys.get(key), state.board.get(key), state.at)


def value_at(key: Key | None, entry: Stamped | None, now: float) -> Any:
    """The value of an entry; None where there is none, or it is stale."""
    return entry.value if entry is not None and now < stale_at(key, entry) else None


def note_news(program: Program, state: RunState, key: str, before: Any, by: str = "") -> bool:
    """Whether a key that was written has another value than before; if so, trees that look at it are ticked."""
    if not is_other(before, program.keys.get(key), state.board.get(key), state.at):
        return False
    state.draft.news[key] = by
    return True


def is_other(before: Any, key: Key | None, entry: Stamped | None, now: float) -> bool:
    """Whether what is known of a key is another than before; None is unknown."""
    value = value_at(key, entry, now)
    return not (value is before or (before is not None and value == before))


def write_key(program: Program, state: RunState, key: str, value: Any, by: str = "") -> bool:
    """Write a key of the mission; a value of another type is refused, with a note.

    Rule: whatever comes from outside the mission's own text is written here or by a `write` event.

    Args:
        program: The mission.
        state: The state of the run.
        key: Its name.
        value: Its new value.
        by: The state whose activity writes it and looks at it by itself: it is not reported to that activity.

    Returns:
        Whether trees that look at the key have something to see.
    """
    why = type_error(program.keys[key], value) if key in program.keys else "the mission has no such key"
    if why:
        state.draft.notes.append(f"'{key}' was not written: {why}")
        return False
    before = known(program, state, key) if program.has_trees else None
    state.board[key] = Stamped(value, state.at)
    state.draft.written.append((key, value))
    return program.has_trees and note_news(program, state, key, before, by)


def ask_named(program: Program, state: RunState, name: str, arguments: Mapping[str, Any]) -> Truth:
    """The value of a predicate, noted so that a replay can repeat it; after a `#`, which note states what it raised."""
    predicate = program.named.get(name)
    if predicate is None:
        value = program.surroundings.predicate(state, name, arguments)
        state.draft.looked.append((f"named:{name}", value))
        return value
    keys, now = program.keys, state.at
    fresh = {key: entry.value for key, entry in state.board.items() if now < stale_at(keys.get(key), entry)}
    notes, note = state.draft.notes, len(state.draft.notes)
    value = foreign_truth(lambda: predicate(fresh, **arguments), name, notes.append)
    raised = f"#{note}" if len(notes) > note else ""
    state.draft.looked.append((f"named:{name}{raised}", value))
    return value
