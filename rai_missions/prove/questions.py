# SPDX-License-Identifier: Apache-2.0
"""What a mission asks of one key: the parts of its guards that read this key alone, each as a whole.

Rule: two values are alike where every such part makes the same of both, and nothing but these reads the key.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rai_missions.guards import All, Any_
from rai_missions.guards.guard import Guard, Truth, made
from rai_missions.mission.mission import Mission
from rai_missions.model import MissionModel
from rai_missions.prove.parts import inside, parts
from rai_missions.states.decision import Option
from rai_missions.states.state import Transition
from rai_missions.states.tree.decorators import EternalGuard
from rai_missions.states.tree.leaves import CheckLeaf

__all__ = ("questions",)

TRUE_OR_NOT = Transition, Option, CheckLeaf, EternalGuard
"""Of their guards it only counts whether they are true; of a mission's, the invariants, whether they are false."""


def questions(value: Any, key: str) -> list[tuple[Guard, Truth]] | None:
    """What is asked of a key; None where it is compared with another, or something else reads it.

    Args:
        value: A mission, and what else has guards.
        key: It is a scalar.

    Returns:
        Each part, and which of its values counts; None where each does.
    """
    found = list(_asked(value, key))
    is_known = all(_is_alone(guard, key) for guard, _ in found) and not any(
        _reads(part, key) for part in _others(value)
    )
    return found if is_known else None


def _asked(value: Any, key: str, counts: Truth = None) -> Iterator[tuple[Guard, Truth]]:
    """The outermost parts of guards that read a key alone; what is no part of another is one in any case."""
    if not isinstance(value, Guard):
        counts = True if isinstance(value, TRUE_OR_NOT) else False if isinstance(value, Mission) else counts
        for part in inside(value):
            yield from _asked(part, key, counts if isinstance(part, Guard) else None)
    elif _is_about(value, key):
        inner = list(value.inner())
        if _is_alone(value, key) or not inner:
            yield value, counts
        for each in _together(value, key) if not _is_alone(value, key) else ():
            yield from _asked(each, key, value.counts_inside(counts))


def _together(guard: Guard, key: str) -> Iterator[Guard]:
    """What a guard is made of; of an `all` or `any` those that read a key alone are one."""
    inner = list(guard.inner())
    alone = [each for each in inner if _is_about(each, key) and _is_alone(each, key)]
    if len(alone) > 1 and isinstance(guard, All | Any_):
        yield made(guard.word, **{guard.word: alone})
        inner = [each for each in inner if each not in alone]
    yield from inner


def _is_about(guard: Guard, key: str) -> bool:
    return any(_reads(each, key) for each in guard.walk())


def _others(value: Any) -> Iterator[MissionModel]:
    """All written things but guards, and but the mission itself, which declares its keys."""
    return (part for part in parts(value, MissionModel) if not isinstance(part, Guard | Mission))


def _reads(part: MissionModel, key: str) -> bool:
    return any(
        refers.sort in ("path", "key") and name.partition(".")[0] == key for refers, name, _ in part.references()
    )


def _is_alone(guard: Guard, key: str) -> bool:
    """Whether it is true or not by this key's value alone: by no other, by no time and by no state."""
    return all(
        not each.held_s and each.age_s is None and not each.states() and not each.predicates()
        and all(path.partition(".")[0] == key for path in each.paths())
        for each in guard.walk()
    )  # fmt: skip
