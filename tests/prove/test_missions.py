# SPDX-License-Identifier: Apache-2.0
"""The shipped missions are proved; a mission with a flaw is refuted, with the right claim and a shortest run."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rai_missions.journal import Header
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import load_profile, robot_facts
from rai_missions.prove import Proof, prove, record
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Space
from rai_missions.replay.replay import replay
from tests.prove.explored import ROOT, document

Json = dict[str, Any]
TRACTOR = "tests/data/tractor_design.json"
SHIPPED = sorted(path.parent.name for path in ROOT.glob("missions/*/mission.json"))


def proof_of(mission: Mission) -> Proof:
    return prove(mission)


STATES = {"tractor": 2049, "rosbot": 15552}
"""Those of each at 6240387, when no operator took control and gave it back in every state."""


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=[pytest.mark.long] * (each == "rosbot")) for each in SHIPPED]
)
def test_the_shipped_missions_are_proved(name: str) -> None:
    mission = document(f"missions/{name}/mission.json")
    robot = load_profile(ROOT / "missions" / name / "robot.sim.json")
    proof = prove(mission, robot_facts=robot_facts(robot))
    assert [(claim.name, claim.sentence) for claim in proof.claims if claim.verdict != "proved"] == []
    assert proof.never == () and proof.sampled == ()
    assert proof.states <= 2 * STATES[name], "holds cost no more than as many states again"
    guide = (ROOT / "docs/guide/proofs.md").read_text(encoding="utf-8")
    assert f"({proof.states:,} states)" in guide
    if f"{mission.name} {mission.version}: " in guide:
        assert f"{mission.name} {mission.version}: {proof.states} states, {proof.steps} steps, " in guide


def test_the_design_s_mission_is_proved_without_a_profile() -> None:
    proof = proof_of(document(TRACTOR))
    assert proof.verdict == "proved" and proof.in_pause == ("nobody_is_driven_over",)


# -- flaws -----------------------------------------------------------------------------------------------------------


def over_people(given: Json) -> None:
    """The guard of the option is gone, and the transition that would stop it."""
    given["states"]["assessing"]["decision"]["options"]["drive_over"].pop("when")
    transitions = given["states"]["crossing"]["transitions"]
    given["states"]["crossing"]["transitions"] = [transition for transition in transitions if "on" in transition]


def no_way_out(given: Json) -> None:
    given["states"]["returning"] = {"about": "waits there"}


def by_answer(given: Json) -> None:
    """A final that requires nothing, reached by an option."""
    given["states"]["finished"] = {"final": "succeeded"}
    given["states"]["assessing"]["transitions"][3]["to"] = "finished"


def round_and_round(given: Json) -> None:
    """Two timers that lead to each other."""
    given["states"]["returning"] = {"transitions": [{"after_s": 5, "to": "waiting"}]}
    given["states"]["waiting"] = {"transitions": [{"after_s": 5, "to": "returning"}]}
    given["transitions"][0]["when"]["all"][0] = {"not": {"any": [{"in": "returning"}, {"in": "waiting"}]}}


def round_at_home(given: Json) -> None:
    """A timer that leads to where it began."""
    given["states"]["returning"] = {"transitions": [{"after_s": 5, "to": "returning"}]}


def never_offered(given: Json) -> None:
    """An option that asks for two things that exclude each other."""
    option = given["states"]["assessing"]["decision"]["options"]["drive_over"]
    option["when"] = {"all": [{"key": "obstacle.living", "==": True}, {"key": "obstacle.living", "==": False}]}


def always_offered(given: Json) -> None:
    given["states"]["assessing"]["decision"]["options"]["drive_over"]["when"] = {"in": "assessing"}


FLAWS: list[tuple[Callable[[Json], None], str, int]] = [
    (over_people, "invariants", 4), (no_way_out, "ends", 1), (by_answer, "answers", 4),
    (round_and_round, "comes to rest", 1), (round_at_home, "comes to rest", 1),
    (never_offered, "options", 0), (always_offered, "rules", 0),
]  # fmt: skip


@pytest.mark.parametrize(("change", "claim", "steps"), FLAWS, ids=[change.__name__ for change, _, _ in FLAWS])
def test_a_flaw_is_found_and_shown(change: Callable[[Json], None], claim: str, steps: int, tmp_path: Path) -> None:
    mission = document(TRACTOR, change)
    proof = proof_of(mission)
    refuted = {each.name for each in proof.claims if each.verdict == "refuted"}
    assert claim in refuted and refuted.isdisjoint({"stop", "cancel", "stopped"})
    assert len(proof.ways.get(claim, ())) == steps
    if not steps:
        return
    path = tmp_path / "refutation.journal"
    reported = proof.ways[claim]
    assert record(path, Header(dump(mission)), mission, reported)
    again = replay(path)
    assert again.holds and again.outcome == reported[-1].outcome


# -- bounds and order ------------------------------------------------------------------------------------------------


def counting(many: int, *, shared: bool = False) -> Mission:
    """Regions that count by themselves, so that their states multiply; or the first lights a lamp for the others."""
    regions: dict[str, Any] = {
        f"region{number}": {
            "initial": f"a{number}",
            "states": {
                f"a{number}": {"transitions": [{"on": f"e{number}", "to": f"b{number}"}]},
                f"b{number}": {"transitions": [{"on": f"e{number}", "to": f"c{number}"}]},
                f"c{number}": {"transitions": [{"on": f"e{number}", "to": f"a{number}"}]},
            },
        }
        for number in range(many)
    }
    if shared:
        regions["region0"]["states"]["a0"]["transitions"][0]["do"] = [{"set": "lit", "value": True}]
        regions["region1"]["states"]["a1"]["transitions"][0]["when"] = {"key": "lit", "==": True}
    return Mission.model_validate(
        {
            "blackboard": {"lit": {"type": "boolean", "initial": False}} if shared else {},
            "format": 1,
            "name": "regions",
            "version": "1.0.0",
            "initial": "all",
            "events": {**{f"e{number}": {} for number in range(many)}, "stop": {}},
            "states": {"all": {"parallel": regions}, "over": {"final": "aborted"}},
            "transitions": [{"on": "stop", "to": "over"}],
        }
    )


@pytest.mark.parametrize("many", [1, 2, 3])
def test_independent_regions_multiply(many: int) -> None:
    assert proof_of(counting(many)).states == 3**many + 2  # `over`, and canceled


@pytest.mark.parametrize(("mission", "most"), [(counting(4, shared=True), 20), (counting(4), 5)])
def test_a_bound_is_kept_and_nothing_beyond_it_is_called_proved(mission: Mission, most: int) -> None:
    proof = prove(mission, most=most)
    assert proof.states == most and not proof.is_whole and proof.never == ()
    assert {claim.verdict for claim in proof.claims} == {"explored"} and proof.verdict == "explored"


def test_a_flaw_within_the_bound_is_a_flaw() -> None:
    mission = document(TRACTOR, over_people)
    proof = prove(mission, most=40)
    assert "invariants" in proof.ways and not proof.is_whole


def test_the_same_mission_gives_the_same_proof() -> None:
    mission = document(TRACTOR, over_people)
    first, second = proof_of(mission), proof_of(mission)
    assert first._replace(seconds=0.0) == second._replace(seconds=0.0)


def test_no_shorter_run_leads_to_a_state_than_the_one_that_is_reported() -> None:
    steps: dict[int, set[int]] = {}

    class Joining(Space):
        def join(self, source: int, target: int, *rest: Any) -> None:
            super().join(source, target, *rest)
            steps.setdefault(source, set()).add(target)

    space = Joining(Environment(document(TRACTOR)), 10_000)
    space.explore()
    starts = [number for number in range(space.states) if len(space.path(number)) == 1]
    far, waiting = dict.fromkeys(starts, 1), deque(starts)
    while waiting:
        number = waiting.popleft()
        for target in steps.get(number, ()):
            if target not in far:
                far[target] = far[number] + 1
                waiting.append(target)
    assert all(len(space.path(number)) == far[number] for number in range(space.states))


def test_what_cannot_be_distinguished_whole_is_not_called_proved() -> None:
    """A counter that is compared with an argument: some arguments are tried, not every one."""
    mission = Mission.model_validate({
        "format": 1, "name": "tries", "version": "1.0.0",
        "blackboard": {"most": {"type": "integer", "source": "argument", "initial": 3},
                       "tries": {"type": "integer", "initial": 0}},
        "events": {"again": {}, "stop": {}}, "initial": "trying",
        "states": {
            "trying": {"transitions": [
                {"on": "again", "when": {"key": "tries", "<": {"key": "most"}}, "do": [{"set": "tries", "add": 1}]},
                {"on": ["again", "stop"], "to": "over"},
            ]},
            "over": {"final": "aborted"},
        },
    })  # fmt: skip
    proof = prove(mission)
    assert proof.is_whole and proof.sampled == ("most", "tries") and proof.verdict == "explored"
