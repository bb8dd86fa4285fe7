# SPDX-License-Identifier: Apache-2.0
"""What a mission asks of a key, or of a field: the parts of its guards that read it alone, each as a whole.

Rule: two values are alike where every such part makes the same of both, and nothing but these reads it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import Any

from rai_missions.guards import All, Any_
from rai_missions.guards.guard import Guard, made
from rai_missions.guards.view import Truth
from rai_missions.mission.mission import Mission
from rai_missions.model import MissionModel
from rai_missions.prove.analysis.parts import inside, parts
from rai_missions.states.decision import Option
from rai_missions.states.transition import Transition
from rai_missions.states.tree.decorators import EternalGuard
from rai_missions.states.tree.leaves import CheckLeaf

__all__ = ("only_key", "parts_about", "questions")

NONE: frozenset[str] = frozenset()
TRUE_OR_NOT = Transition, Option, CheckLeaf, EternalGuard
"""The kinds of whose guards it only counts whether they are true; of the invariants, whether they are false."""


def questions(value: Any, paths: Iterable[str]) -> dict[str, list[tuple[Guard, Truth]]]:
    """What is asked of some paths; those that are compared with others, or that something else reads, are left out.

    Args:
        value: A mission, and what else has guards.
        paths: Keys and fields of objects, each a scalar.

    Returns:
        Path → each part, and which of its values counts; None where each does.
    """
    read_otherwise = frozenset[str]().union(*map(_read, _others(value)))
    reading: dict[str, list[tuple[Guard, Truth]]] = {path: [] for path in paths if not _is_read(path, read_otherwise)}
    for guard, counts in _outermost(value):
        names = _about(guard)
        for path in reading:
            if _is_read(path, names):
                reading[path] += _asked(guard, path, counts)
    return {path: found for path, found in reading.items() if all(_is_alone(guard, path) for guard, _ in found)}


def parts_about(guard: Guard, key: str, counts: Truth, steady: frozenset[str]) -> list[tuple[Guard, Truth]] | None:
    """The parts of a guard that read one key, and otherwise only such as are steady; None where another part does.

    Args:
        guard: Of it one value counts, or each.
        key: The key.
        counts: Which value that is.
        steady: The keys that the parts may read as well.

    Returns:
        Each part, and which of its values counts.
    """
    found = [*_asked(guard, key, counts, steady)]
    return found if all(_is_alone(part, key, steady) for part, _ in found) else None


def only_key(guard: Guard) -> str:
    """The key by whose value alone a guard is true or not; empty where there is no such."""
    keys = {name.partition(".")[0] for name in _about(guard)}
    (key,) = keys if len(keys) == 1 else ("",)
    return key if key and _is_alone(guard, key) else ""


def _outermost(value: Any, counts: Truth = None) -> Iterator[tuple[Guard, Truth]]:
    """The guards that are in no other, and which of their values counts."""
    if isinstance(value, Guard):
        yield value, counts
        return
    counts = True if isinstance(value, TRUE_OR_NOT) else False if isinstance(value, Mission) else None
    for part in inside(value):
        yield from _outermost(part, counts)


def _asked(guard: Guard, key: str, counts: Truth, steady: frozenset[str] = NONE) -> Iterator[tuple[Guard, Truth]]:
    """The outermost parts of a guard that read a key alone; what is no part of another is one in any case."""
    inner = list(guard.inner())
    if _is_alone(guard, key, steady) or not inner:
        yield guard, counts
        return
    for each in _together(guard, key, steady):
        if _is_read(key, _about(each)):
            yield from _asked(each, key, guard.counts_inside(counts), steady)


def _together(guard: Guard, key: str, steady: frozenset[str]) -> Iterator[Guard]:
    """What a guard is made of; of an `all` or `any` those that read a key alone are one."""
    inner = list(guard.inner())
    alone = [each for each in inner if _is_read(key, _about(each)) and _is_alone(each, key, steady)]
    if len(alone) > 1 and isinstance(guard, All | Any_):
        yield made(guard.word, **{guard.word: alone})
        inner = [each for each in inner if each not in alone]
    yield from inner


def _about(guard: Guard) -> frozenset[str]:
    """The paths that a guard reads."""
    return frozenset[str]().union(*map(_read, guard.walk()))


def _others(value: Any) -> Iterator[MissionModel]:
    """All written things but guards, and but the mission itself, which declares its keys."""
    return (part for part in parts(value, MissionModel) if not isinstance(part, Guard | Mission))


def _read(part: MissionModel) -> frozenset[str]:
    """The paths that a written thing reads itself.

    Not what a question shows, as every answer is tried in any case; nor the key that a list writes its items to.
    """
    return frozenset(
        name
        for refers, name, place in part.references()
        if refers.sort in ("path", "key") and not place.startswith(("/evidence/", "/as"))
    )


def _is_read(path: str, names: Collection[str]) -> bool:
    """Whether one of these names is a path, leads into what it has, or has it inside."""
    return any(name == path or name.startswith(f"{path}.") or path.startswith(f"{name}.") for name in names)


def _is_alone(guard: Guard, key: str, steady: frozenset[str] = NONE) -> bool:
    """Whether it is true or not by this key's value, and by steady ones: by no other, by no time and by no state."""
    return all(
        not each.held_s
        and each.age_s is None
        and not each.states()
        and not each.predicates()
        and all(f"{path}.".startswith(f"{key}.") or path.partition(".")[0] in steady for path in each.paths())
        for each in guard.walk()
    )
