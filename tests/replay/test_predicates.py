# SPDX-License-Identifier: Apache-2.0
"""A predicate is not asked again: a replay has its values as they were, and what it raised."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.mission import Mission
from rai_missions.replay.open_run import open_run
from rai_missions.replay.replay import replay

GUARD = {"any": [{"named": "is_low"}, {"named": "is_far"}]}
MISSION = Mission.model_validate({
    "name": "asking", "initial": "a", "events": ["go"],
    "blackboard": {"k": {"type": "integer", "initial": 0}},
    "states": {"a": {"transitions": [{"on": "go", "when": GUARD, "to": "b"},
                                     {"on": "go", "do": [{"set": "k", "value": 1}]}]},
               "b": {"transitions": [{"on": "go", "when": {"not": GUARD}, "to": "a"}]}},
})  # fmt: skip
ANSWERS = st.lists(st.sampled_from([True, False, None, "raises", "raises", 3]), max_size=30)


def program(answers: list[Any]) -> dict[str, Any]:
    """Predicates that answer so, one after the other, and then that they do not know."""
    left: Iterator[Any] = iter(answers)

    def asked(_board: Any) -> Any:
        answer = next(left, None)
        if answer == "raises":
            raise ValueError(f"{len(answers)} are too many")
        return answer

    return {"is_low": asked, "is_far": asked}


@given(ANSWERS)
def test_a_run_is_replayed_and_resumed_whatever_its_predicates_returned_or_raised(answers: list[Any]) -> None:
    chart = Chart(MISSION, named=program(answers))
    steps: list[Step] = [chart.start(0.0), *(chart.send(Event("go", float(at))) for at in range(1, 9))]
    assert any(each.notes for each in steps) or "raises" not in answers[: sum(len(each.guards) for each in steps)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.journal"
        with Journal.create(path, Header(json.dumps(MISSION.written()))) as journal:
            for step in steps:
                journal.write(step, since=step.at)
        again = replay(path)
        assert (again.holds, again.difference) == (True, "")
        taken = open_run(path, named=program([]))
        taken.record.close()
