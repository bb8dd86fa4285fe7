# SPDX-License-Identifier: Apache-2.0
"""What may be driven over is found out by driving."""

from __future__ import annotations

from typing import Any

import pytest


def crossed(orchard: Any) -> tuple[str, dict[str, Any]]:
    """Drive over whatever is there: how the action ended, and what the judge measured."""
    orchard.to_the_obstacle()
    orchard.send("/tractor1/cross", {}, "cross")
    assert orchard.run(lambda: len(orchard.statuses("cross")) == 2, 30.0), "the crossing did not end"
    orchard.rest(0.1)
    return orchard.statuses("cross")[-1], orchard.facts("crossing")


def test_a_branch_is_driven_over_the_wheels_lift_and_it_stays_where_it_was(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=["branch"], camera=False)
    end, facts = crossed(orchard)
    assert end == "succeeded"
    assert orchard.data("passed") is True
    assert facts["outcome"] == "passed"
    assert 0.08 < facts["lift_m"] < 0.2
    assert facts["pitch_deg"] > 1.0
    assert facts["contact_n"] > 5000
    assert facts["moved_m"] < 0.5
    assert orchard.run(lambda: orchard.data("alleys_driven") == 1, 20.0), "it drives on by itself"


def test_continue_drives_over_what_it_stopped_for_as_upstream_does(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=["branch"], camera=False)
    orchard.to_the_obstacle()
    assert orchard.call("continue")["success"]
    assert orchard.run(lambda: orchard.data("passed"), 20.0)


@pytest.mark.parametrize(
    ("kind", "why"), [("log", "pushed it"), ("fallen_tree", "pushed it"), ("crate", "struck the chassis")]
)
def test_what_is_pushed_or_strikes_the_body_was_not_driven_over(rig: Any, kind: str, why: str) -> None:
    orchard = rig(alleys=1, obstacles=[kind], camera=False)
    end, facts = crossed(orchard)
    assert end == "failed"
    assert orchard.reports[-1].why.startswith(why)
    assert facts["outcome"] == "failed"
    assert orchard.data("passed") is False
    assert orchard.state == "STOPPED"
    assert orchard.data("touched_living") is False


@pytest.mark.parametrize("kind", ["person", "animal"])
@pytest.mark.parametrize("turn_deg", [0.0, 90.0])
def test_touching_a_living_thing_is_always_a_failure(rig: Any, kind: str, turn_deg: float) -> None:
    living = {"kind": kind, "heeds_after": 99, "lingers_s": 900.0, "turn_deg": turn_deg}
    orchard = rig(alleys=1, obstacles=[living], camera=False)
    end, facts = crossed(orchard)
    assert end == "failed"
    assert orchard.reports[-1].why == "touched something alive"
    assert facts["outcome"] == "failed"
    assert orchard.data("touched_living") is True
    orchard.rest(3.0)
    assert abs(orchard.world.pose.speed) < 0.05, "it does not push on"


def test_there_is_nothing_to_cross_before_something_was_in_the_way(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=["branch"], camera=False)
    orchard.send("/tractor1/cross", {}, "early")
    assert orchard.statuses("early") == ["rejected"]
    assert "nothing to cross" in orchard.reports[-1].why


def test_a_crossing_that_is_canceled_is_short_of_the_obstacle(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=["branch"], camera=False)
    orchard.to_the_obstacle()
    orchard.send("/tractor1/cross", {}, "cross")
    orchard.rest(0.5)
    orchard.connector.cancel_goal("cross")
    orchard.rest(3.0)
    assert orchard.statuses("cross") == ["accepted", "canceled"]
    assert orchard.data("passed") is False
    assert orchard.world.judge.crossing.contact_n == 0.0


def test_a_plain_service_drives_over_and_home_where_the_types_of_nav2_are_not_known(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=["branch"], camera=False)
    refused = orchard.call("drive_over")
    assert not refused["success"]
    assert refused["message"] == "there is nothing to cross: the tractor has not stopped for an obstacle"
    orchard.to_the_obstacle()
    assert orchard.data("passed") is False
    assert orchard.call("drive_over")["success"]
    assert orchard.run(lambda: orchard.data("passed"), 20.0)
    assert orchard.call("go_home")["success"]
    assert orchard.run(lambda: orchard.data("at_home"), 120.0)


def test_a_plain_service_does_not_take_a_way_from_a_goal(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=["none"], camera=False)
    orchard.call("continue")
    orchard.rest(15.0)
    orchard.send("/navigate_to_pose", {}, "home")
    refused = orchard.call("go_home")
    assert (refused["success"], refused["message"]) == (False, "/navigate_to_pose pursues another goal")
