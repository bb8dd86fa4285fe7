# SPDX-License-Identifier: Apache-2.0
"""What a delayed `raise` with an id raises makes a difference: two events may have one id."""

from __future__ import annotations

from rai_missions.mission.mission import Mission
from rai_missions.prove import prove


def test_two_events_that_come_later_under_one_id_are_two() -> None:
    """One of them comes again and again by itself, the other once."""
    again, once = ([{"raise": event, "after_s": 1, "id": "x"}] for event in ("again", "once"))
    mission = Mission.model_validate({
        "name": "m", "version": "1.0.0", "events": ["a", "b", "once", "again", "stop"], "initial": "s", "states": {
            "s": {"transitions": [{"on": "a", "to": "t", "do": once}, {"on": "b", "to": "t", "do": again}]},
            "t": {"transitions": [{"on": "once", "to": "s"}, {"on": "again", "to": "u", "do": again}]},
            "u": {"transitions": [{"on": "again", "to": "t", "do": again}]},
            "over": {"final": "aborted"},
        }, "transitions": [{"on": "stop", "to": "over"}],
    })  # fmt: skip
    found = {claim.name: claim.verdict for claim in prove(mission).claims}
    assert found["comes to rest"] == "refuted"
