# SPDX-License-Identifier: Apache-2.0
"""The guards of an action that is composed of services may ask how long its state has been active."""

from __future__ import annotations

from pydantic import TypeAdapter

from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.event import Event
from rai_missions.guards.guard import Guard
from rai_missions.model import AnyOf
from tests.rigs.charts import mission, ticked, transition

BOARD = {"still": {"type": "boolean", "source": "robot", "max_age_s": 60}}


def guard(written: dict[str, object]) -> Guard:
    made: Guard = TypeAdapter(AnyOf[Guard]).validate_python(written)
    return made


def test_what_was_so_before_the_start_is_no_failure_until_the_state_is_old_enough() -> None:
    robot_facts = RobotFacts(
        succeeded={"go": guard({"key": "still", "==": False})},
        failed={"go": guard({"all": [{"elapsed_s": 1}, {"key": "still", "==": True}]})},
    )
    states = {
        "drive": {"action": "go", "timeout_s": 60, "transitions": [transition("failed", "lost")]},
        "lost": {},
    }
    made = Chart(mission(states, blackboard=BOARD), robot_facts=robot_facts)
    made.write("still", True, at=0.0)
    number = made.start(2.0).effects[0].number  # type: ignore[union-attr]
    assert made.send(Event("accepted", 2.5, {}, "accepted", number)).entered == ()
    assert made.wake_at == 3.0
    assert ticked(made, 3.0).entered == ("lost",)
