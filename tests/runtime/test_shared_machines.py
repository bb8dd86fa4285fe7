# SPDX-License-Identifier: Apache-2.0
"""The machines of modes and of control are those of the process; where each run is in them is its own."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.runtime.lifecycle import Control
from rai_missions.states.control import HOLDERS

HANDOVERS = st.lists(st.tuples(st.booleans(), st.sampled_from(HOLDERS)), max_size=30)


def handed(control: Control, to: str) -> tuple[str, str]:
    """What comes of a handover, and who has control then."""
    try:
        control.acknowledge(to)
    except UsageError as error:
        return str(error), control.holder
    return "", control.holder


@given(HANDOVERS)
def test_two_runs_next_to_each_other_go_where_each_goes_alone(moves: list[tuple[bool, str]]) -> None:
    both = {True: Control(), False: Control()}
    seen = {True: [("", "autonomy")], False: [("", "autonomy")]}
    for which, to in moves:
        seen[which].append(handed(both[which], to))
        assert both[not which].holder == seen[not which][-1][1], "the other stays where it was"
    for run, found in seen.items():
        alone = Control()
        assert found[1:] == [handed(alone, to) for which, to in moves if which is run]
