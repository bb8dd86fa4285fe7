# SPDX-License-Identifier: Apache-2.0
"""What is known of a guard after a transition: Kleene logic over what is known of its parts."""

from __future__ import annotations

from functools import reduce

import pytest

from rai_missions import In
from rai_missions.guards.view import Truth

TRUTHS = (True, False, None)


def least(one: Truth, other: Truth) -> Truth:
    return False if False in (one, other) else None if None in (one, other) else True


def most(one: Truth, other: Truth) -> Truth:
    return True if True in (one, other) else None if None in (one, other) else False


@pytest.mark.parametrize("one", TRUTHS)
@pytest.mark.parametrize("other", TRUTHS)
def test_all_and_any_are_known_after_a_transition_as_far_as_their_parts_are(one: Truth, other: Truth) -> None:
    active = {"a": one, "b": other}.__getitem__
    for guard, kleene in ((In("a") & In("b"), least), (In("a") | In("b"), most)):
        assert guard.after_jump(active, restarted=False) is reduce(kleene, (one, other))
