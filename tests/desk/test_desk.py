# SPDX-License-Identifier: Apache-2.0
"""The shipped missions at the desk: what they end with is so by the world's truth, whatever goes wrong."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.check import check
from rai_missions.mission.files import dump, load
from rai_missions.profile import load_profile, missing, robot_facts
from rai_missions.prove import prove
from rai_missions.prove.environment.environment import Environment
from tests.desk.episodes import DESK_MISSIONS, Episode, episode
from tests.desk.scenes import CASES, Case

MISSIONS = ["arrange", "sort", "stack", "swap"]
ROBOT = robot_facts(load_profile(DESK_MISSIONS / "robot.sim.json"))
RED, BLUE = ({"type": "cube", "colour": colour} for colour in ("red", "blue"))


def desk(*things: tuple[dict[str, Any], float, float], **world: Any) -> dict[str, Any]:
    """A world with these things: what, x and y."""
    return {"seed": 7, "scene": {"objects": [{**what, "pose": {"x": x, "y": y}} for what, x, y in things]}, **world}


TWO = desk((RED, 0.5, 0.1), (BLUE, 0.5, -0.12))


def played(case: Case) -> Episode:
    return episode(case.request, case.world)


@pytest.mark.parametrize("name", MISSIONS)
def test_the_missions_have_no_fault_and_equal_their_twins(name: str) -> None:
    mission = load(DESK_MISSIONS / f"{name}.json")
    assert list(check(mission)) == []
    for robot in ("robot.sim.json", "robot.ros2.json"):
        assert missing(mission, load_profile(DESK_MISSIONS / robot)) == ()
    assert dump(load(DESK_MISSIONS / f"{name}.py")) == dump(mission)


def test_what_distinguishes_states_while_they_work_is_little() -> None:
    """Each key more multiplies the states of a proof."""
    environment = Environment(load(DESK_MISSIONS / "arrange.json"), robot_facts=ROBOT)
    read = environment.rest.live.within([environment.chart.program.graph.nodes["looking"]])
    own = {each for each in read if each.partition(".")[0] in environment.world.own_keys}
    assert own == {"wanted", "reading.covers_all", "plan.aside", "moves", "failures"}


@pytest.mark.drill
@pytest.mark.parametrize("name", MISSIONS)
def test_they_are_proved_whole(name: str) -> None:
    proof = prove(load(DESK_MISSIONS / f"{name}.json"), robot_facts=ROBOT)
    assert [(claim.name, claim.sentence) for claim in proof.claims if claim.verdict != "proved"] == []
    assert proof.is_whole and proof.never == proof.sampled == () and proof.states < 100_000


@pytest.mark.sim
def test_a_tower_is_asked_for_and_built() -> None:
    end = episode("put the red cube on the blue cube", TWO)
    assert (end.outcome, end.is_so, end.moves) == ("succeeded", True, 1), end.why


@pytest.mark.long
@pytest.mark.sim
def test_a_swap_goes_by_a_free_spot() -> None:
    end = episode("swap the red cube and the blue cube", TWO)
    assert (end.outcome, end.is_so, end.moves) == ("succeeded", True, 3), end.why


@pytest.mark.sim
@pytest.mark.parametrize(
    "request_text",
    ["put the red cube inside the blue cube", "put the apple on the red cube", "put the red cube at x 3 y 0",
     "throw the red cube", "put the red cube on the blue cube and the blue cube on the red cube"],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_a_reason_before_anything_moves(request_text: str) -> None:
    end = episode(request_text, TWO)
    assert (end.outcome, end.moves) == ("aborted", 0)
    assert end.why and "reached" not in end.why, "the reason is a sentence"


@pytest.mark.sim
def test_a_server_that_lies_is_not_believed() -> None:
    end = episode("put the red cube on the blue cube", {**TWO, "faults": {"lie": 1.0}})
    assert not end.is_false_success, end


@pytest.mark.drill
@pytest.mark.sim
@pytest.mark.parametrize("first", range(0, 2000, 100))
def test_success_is_never_claimed_that_is_not_so(first: int) -> None:
    ends = [played(CASES["faults"](seed)) for seed in range(first, first + 100)]
    assert not [end for end in ends if end.is_false_success]


@pytest.mark.drill
@pytest.mark.sim
def test_what_must_not_be_acted_on_is_not() -> None:
    ends = [played(CASES["refused"](seed)) for seed in range(200)]
    assert {(end.outcome, end.moves) for end in ends} == {("aborted", 0)}
