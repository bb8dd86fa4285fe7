# SPDX-License-Identifier: Apache-2.0
"""Activities of another package have all that our own have: one with a machine of its own, one that makes a tree."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import pytest

from rai_missions.check import check
from rai_missions.engine.activities.activity import Outcome, Turn, remembered
from rai_missions.engine.contract import MOST
from rai_missions.keys import Key
from rai_missions.mission.mission import Mission
from rai_missions.model import Seconds, Text
from rai_missions.profile import Robot, missing
from rai_missions.prove import prove
from rai_missions.states import Action, Call, Decision, State
from rai_missions.testing import check_activity
from rai_missions.trees import PyTrees
from tests.replay.mortal import Fate, live
from tests.replay.test_kills import ROBOT, entered, holds, land, lived
from tests.rigs.runs import ReplyingAnswerer
from visualize import difference, drawn, picture

INSTALLED = Path(__file__).parent / "installed"
DOCUMENT: dict[str, Any] = {
    "name": "ringing", "uses": ["orchard_kinds>=1.2"], "initial": "striking",
    "states": {
        "striking": {"strikes": 3, "service": "horn", "every_s": 2, "timeout_s": 60, "transitions": [
            {"on": "succeeded", "to": "inspecting"}, {"on": ["failed", "timed_out"], "to": "given_up"}]},
        "inspecting": {"inspect": "horn", "settle_s": 2, "timeout_s": 60, "transitions": [
            {"on": "succeeded", "to": "done"}, {"on": ["failed", "timed_out"], "to": "given_up"}]},
        "done": {"final": "canceled"}, "given_up": {"final": "aborted"}},
}  # fmt: skip


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(INSTALLED))


def ringing(**changes: Any) -> Mission:
    inspecting = {word: given for word, given in {**DOCUMENT["states"]["inspecting"], **changes}.items() if given}
    if "timeout_s" not in inspecting:
        inspecting["transitions"] = [{"on": "succeeded", "to": "done"}, {"on": "failed", "to": "given_up"}]
    states = {**DOCUMENT["states"], "inspecting": inspecting}
    return Mission.model_validate({**DOCUMENT, "states": states})


def test_a_tree_that_a_kind_makes_is_checked_covered_drawn_compared_and_proved() -> None:
    mission = ringing()
    assert check(mission) == ()
    assert check(ringing(timeout_s=None)) == (), "the calls of its tree have an end"
    other = ringing(inspect="gong")
    lacks = [fault.place for fault in missing(other, ROBOT)]
    assert lacks == ["/services/gong"], "the profile is held to what a field of the kind names"
    assert "• again, fallback" in drawn(picture(mission), "dot").decode()
    assert any("'inspect' changed" in str(change) for change in difference(mission, other).changes)
    proof = prove(mission, PyTrees())
    assert {claim.name: claim.verdict for claim in proof.claims}["options"] == "proved"
    assert [claim.name for claim in proof.claims if claim.verdict != "proved"] == []


def test_a_service_that_a_kind_names_is_asked_for_in_a_profile() -> None:
    assert "/services/horn" in [fault.place for fault in missing(ringing(), Robot(name="bare"))]


@pytest.mark.parametrize("every", [6, pytest.param(1, marks=pytest.mark.drill)])
def test_killed_after_any_row_it_ends_as_if_it_had_not_been(tmp_path: Path, every: int) -> None:
    def answerers() -> dict[str, Any]:
        return {"someone": ReplyingAnswerer("again")}

    whole, fate = tmp_path / "whole.journal", Fate()
    result = live(whole, land(), ringing(), ROBOT, answerers(), fate)
    assert result is not None and result.outcome == "canceled"
    for at in range(0, fate.count, every):
        path, there = tmp_path / f"{at}.journal", land()
        ended = lived(path, there, [Fate(at, is_done=True)], ringing(), answerers=answerers())
        assert (ended.outcome, entered(path)) == (result.outcome, entered(whole)), f"killed after {at}"
        holds(path, there, ringing())


# -- the contract ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("most", [80, pytest.param(MOST, marks=pytest.mark.drill)])
def test_foreign_activities_and_ours_keep_the_contract(most: int) -> None:
    states = ringing().states
    keys = {"done": Key(bool, source="robot"), "value": Key(float, source="mission")}
    for state in (
        states["striking"],
        states["inspecting"],
        Call("horn", result={"value": "level"}, timeout_s=5),
        Action("move", achieved={"key": "done", "==": True}, settle_s=2),
        Decision("On?", options={"on": {}}),
    ):
        check_activity(state, keys, [{"done": True}, {"done": False}], ticker=PyTrees(), most=most)


@remembered("tests/Odd")
class Odd(NamedTuple):
    until: float


class OddMachine:
    """Waits; the way in which it is odd is the state's."""

    count: ClassVar = [0]

    def __init__(self, way: str, owner: str) -> None:
        self.way, self.owner, self.here = way, owner, 0

    def begin(self, host: Any) -> Turn:
        self.here += 1
        return Turn(Odd(host.begins_at + self.here))

    def receive(self, state: Odd, event: Any, host: Any) -> Turn | None:
        if event.kind != "tick":
            return None
        if self.way == "undeclared":
            return Turn(None, outcome=Outcome("rejected"))
        if self.way == "writes":
            return Turn(None, outcome=Outcome("succeeded"), writes=(("value", 1.0),))
        self.count[0] += 1
        return Turn(Odd(host.begins_at + self.count[0]))

    def leave(self, state: Odd, host: Any) -> Turn:
        return Turn(None)

    def wake_at(self, state: Odd, view: Any) -> float:
        return state.until

    def reads(self, state: Odd) -> frozenset[str]:
        return frozenset()

    def awaits(self, state: Odd) -> frozenset[int]:
        return frozenset()

    def shift(self, state: Odd, by_s: float) -> Odd:
        return state._replace(until=state.until + by_s)


class Oddity(Call, word=None):
    """A state whose machine breaks a promise; it is a kind of no package, and read from no file."""

    way: Text = "counts"
    every_s: Seconds = 1.0

    def outcomes(self) -> frozenset[str]:
        return frozenset({"succeeded"})


def odd_machine(state: Oddity, bench: Any) -> OddMachine:
    return OddMachine(state.way, bench.owner)


@pytest.mark.parametrize(
    ("way", "named"),
    [("counts", "once it was stored"), ("undeclared", "does not declare"), ("writes", "none of its fields names")],
)
def test_an_activity_that_breaks_a_promise_is_named(way: str, named: str) -> None:
    from rai_missions.engine.activities.activity import machine_of

    machine_of.register(Oddity, odd_machine)
    with pytest.raises(AssertionError, match=named):
        check_activity(Oddity("horn", way=way), {"value": Key(float, source="mission")})


def test_a_state_of_no_kind_keeps_the_contract_of_one_that_only_waits() -> None:
    with pytest.raises(AssertionError, match="no words"):
        check_activity(State(), {})
