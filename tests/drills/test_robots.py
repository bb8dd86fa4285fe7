# SPDX-License-Identifier: Apache-2.0
"""Whatever servers, topics and the way to them do: no outcome is false, no goal is forgotten, no run hangs."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import StartGoal, Step
from rai_missions.errors import UsageError
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile
from rai_missions.replay.replay import replay
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.goals import id_of_goal
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.runner import Runner
from rai_missions.testing import ChaosConnector, Rates
from tests.drills.surroundings import ANY_ROBOT, AnyAnswers, Field, PostponingWorld, quick_folder, quick_tempers
from tests.drills.yard import Yard, yard_mission, yard_robot
from tests.rigs.journals import steps_of
from tests.rigs.runs import Rig, robot
from tests.strategies import missions
from tests.tractor.conftest import TRACTOR

SEED = 5
ENDS_S = 60.0
QUIET = Rates(lose=0, delay=0, repeat=0, backdate=0, garble=0)
WORST = Rates(lose=0.15, delay=0.4, repeat=0.2, backdate=0.15, garble=0.1, silence=0.002)
CALM = Rates(lose=0.02, delay=0.1, repeat=0.1, backdate=0.02, garble=0.02, longest_s=0.5)
BETWEEN = Rates()
ENDS = {"succeeded", "failed", "aborted", "canceled"}


def unowned(running: Iterable[str], runner: Runner, steps: Sequence[Step]) -> list[str]:
    """The goals that run on although no one owns them and nothing in the journal states it."""
    notes = [note for step in steps for note in step.notes]
    started = {
        id_of_goal(runner.run_id, effect.number, effect.owner): effect.number
        for step in steps
        for effect in step.effects
        if isinstance(effect, StartGoal)
    }
    report = {
        number for number in started.values() for note in notes if f"goal {number} of" in note and "orphan" in note
    }
    return [goal_id for goal_id in running if started.get(goal_id) not in report]


def in_a_field(mission: Mission, seed: int, incoming: Rates, outgoing: Rates, folder: Path) -> list[str]:
    """Run a mission where nothing is certain; what was wrong."""
    at: list[Field] = []
    local = LocalConnector(now=lambda: at[0].at if at else 0.0)
    local.start()
    field = Field(local, seed, ENDS_S)
    at.append(field)
    world = PostponingWorld(field)
    chaos = ChaosConnector(local, seed, incoming=incoming, outgoing=outgoing, later=world.later)
    path = folder / "run.journal"
    with Journal.create(path, Header(dump(mission), dump_profile(ANY_ROBOT), {})) as journal:
        runner = field.runner = Runner(
            mission,
            robot=ANY_ROBOT,
            connector=chaos,
            clock=SimulatedClock(world),
            journal=journal,
            answerers=quick_tempers(Random(seed)),
        )
        try:
            result = runner.run()
        except UsageError as refused:
            return [] if "the robot has not reported" in str(refused) else [f"refused: {refused}"]
    again, steps = replay(path), steps_of(path)
    return [
        *([f"it ended as '{result.outcome}'"] if result.outcome not in ENDS else []),
        *([f"it took {result.duration_s} s"] if result.duration_s > ENDS_S + 45 else []),
        *(["the engine left goals open"] if runner.view.awaited_goals else []),
        *([f"its journal does not replay: {again.difference}"] if not again.holds else []),
        *([f"ran {again.outcome}, replayed {result.outcome}"] if again.outcome != result.outcome else []),
        *(f"goal {goal} runs on" for goal in unowned(field.goals, runner, steps)),
    ]


RATES = st.sampled_from([QUIET, BETWEEN, WORST])


@pytest.fixture
def _unlogged() -> Iterator[None]:
    """Thousands of services that raise, each reported with its traceback, would fill the memory of anyone who
    listens."""
    logging.disable()
    yield
    logging.disable(logging.NOTSET)


@pytest.mark.usefixtures("_unlogged")
@settings(suppress_health_check=list(HealthCheck))
@given(missions(), st.integers(0, 10**6), RATES, RATES)
def test_any_mission_in_any_surroundings_comes_to_a_true_end(
    mission: Mission, seed: int, incoming: Rates, outgoing: Rates
) -> None:
    with quick_folder() as folder:
        assert in_a_field(mission, seed, incoming, outgoing, folder) == []


def in_the_yard(seed: int, incoming: Rates, outgoing: Rates, folder: Path, counts: dict[str, int]) -> list[str]:
    """Run the yard's mission over a bad connection, with servers that may lie; what was wrong."""
    at: list[Yard] = []
    local = LocalConnector(now=lambda: at[0].at)
    local.start()
    yard = Yard(local, seed, lies=0.2, apart_m=1.5)
    at.append(yard)
    yard.open()
    world = PostponingWorld(yard)
    chaos = ChaosConnector(local, seed, incoming=incoming, outgoing=outgoing, later=world.later)
    path = folder / f"{seed}.journal"
    mission = yard_mission()
    with Journal.create(path, Header(dump(mission), dump_profile(yard_robot()), {})) as journal:
        runner = Runner(
            mission,
            robot=yard_robot(),
            connector=chaos,
            clock=SimulatedClock(world),
            journal=journal,
            answerers={"agent": AnyAnswers(Random(seed))},
        )
        try:
            result = runner.run()
        except UsageError as refused:
            return [] if "the robot has not reported" in str(refused) else [f"refused: {refused}"]
    counts[result.outcome] = counts.get(result.outcome, 0) + 1
    again, steps = replay(path), steps_of(path)
    notes = [note for step in steps for note in step.notes]
    for word in ("orphaned", "the server said succeeded, but"):
        counts[word] = counts.get(word, 0) + any(word in note or word in result.why for note in notes)
    is_orphaned = any("orphaned" in note for note in notes)
    return [
        *(["a false success"] if result.outcome == "succeeded" and not yard.is_at_end else []),
        *(["a person was driven over"] if (yard.harmed or yard.rammed) and not is_orphaned else []),
        *([f"it took {result.duration_s} s"] if result.duration_s > 300 else []),
        *([f"its journal does not replay: {again.difference}"] if not again.holds else []),
        *(f"goal {goal} runs on" for goal in unowned(yard.goals, runner, steps)),
    ]


def yard_faults(seeds: range) -> tuple[list[str], dict[str, int]]:
    counts: dict[str, int] = {}
    every = itertools.cycle([(QUIET, QUIET), (CALM, QUIET), (CALM, CALM), (BETWEEN, BETWEEN), (WORST, WORST)])
    faults: list[str] = []
    for seed, (incoming, outgoing) in zip(seeds, every, strict=False):
        with quick_folder() as folder:
            found = in_the_yard(seed, incoming, outgoing, folder, counts)
        faults += [f"seed {seed}: {fault}" for fault in found]
    return faults, counts


@pytest.mark.long
def test_over_a_bad_connection_to_servers_that_lie_no_success_is_false() -> None:
    faults, counts = yard_faults(range(50))
    assert faults == []
    assert counts["succeeded"] and counts["aborted"] and counts["orphaned"], counts


@pytest.mark.drill
@pytest.mark.parametrize("part", range(4))
def test_over_a_bad_connection_ten_thousand_times(part: int) -> None:
    assert yard_faults(range(2500 * part, 2500 * (part + 1)))[0] == []


def with_the_tractor(seed: int, incoming: Rates, outgoing: Rates) -> list[str]:
    """The shipped mission over a bad connection; what was wrong."""
    from rai_missions.mission.json_reader import parse_json
    from rai_missions.worlds.world import open_world

    profile = parse_json((TRACTOR / "robot.sim.json").read_bytes(), "robot.sim.json")
    random = Random(seed)
    obstacles = [random.choice(["none", "branch", "log", "person", "animal"])]
    world: Any = open_world("orchard", seed=seed, alleys=1, obstacles=obstacles)
    local = LocalConnector(now=lambda: world.at)
    world.open(local)
    slow = PostponingWorld(world)
    chaos = ChaosConnector(local, seed, incoming=incoming, outgoing=outgoing, later=slow.later)
    setting = RunConfig(
        TRACTOR / "mission.json",
        Robot.model_validate(profile),
        arguments={"alleys": 1},
        connector=chaos,
        clock=SimulatedClock(slow),
        answerers={"agent": AnyAnswers(random)},
    )
    try:
        with prepare(setting) as prepared:
            result = prepared.runner.run()
    except UsageError as refused:
        return [] if "the robot has not reported" in str(refused) else [f"refused: {refused}"]
    finally:
        world.close()
    return [
        *(["a person was touched"] if world.judge.touched else []),
        *(["a false success"] if result.outcome == "succeeded" and not world.counter.alleys else []),
        *([f"it ended as '{result.outcome}'"] if result.outcome not in ENDS else []),
        *([f"it took {result.duration_s} s"] if result.duration_s > 1800 else []),
        *(["goals are open"] if prepared.runner.view.awaited_goals else []),
    ]


@pytest.mark.sim
@pytest.mark.parametrize("seed", [2, 4, 6])
def test_the_tractor_over_a_bad_connection_harms_no_one_and_claims_nothing(seed: int) -> None:
    assert with_the_tractor(seed, CALM, CALM) == []


@pytest.mark.drill
@pytest.mark.sim
@pytest.mark.parametrize("part", range(6))
def test_the_tractor_over_a_bad_connection_three_hundred_times(part: int) -> None:
    rates = (CALM, BETWEEN, WORST)
    seeds = range(50 * part, 50 * (part + 1))
    faults = [(seed, with_the_tractor(seed, rates[seed % 3], rates[seed % 3])) for seed in seeds]
    assert [each for each in faults if each[1]] == []


@pytest.mark.parametrize("both", [False, True])
def test_a_topic_that_lies_within_its_type_is_believed_and_found_out_where_another_is_asked_too(both: bool) -> None:
    """The robot reports that it is there, and has not moved; its battery, which another wire reports of, is as full."""
    there: dict[str, Any] = {"key": "there", "==": True}
    achieved = {"all": [there, {"key": "battery", "<": 0.9}]} if both else there
    rig = Rig({
        "moving": {"action": "move", "timeout_s": 20, "achieved": achieved, "settle_s": 1,
                   "transitions": [{"on": "succeeded", "to": "over"}, {"on": "unverified", "to": "found_out"}]},
        "over": {"final": "aborted"}, "found_out": {"final": "failed"},
    })  # fmt: skip

    def lies() -> None:
        rig.publish("/battery", percentage=1.0)
        rig.publish("/there", data=True)

    rig.stage.each = lies
    rig.stage.play({2.0: lambda: rig.move.report("succeeded")})
    rig.run()
    assert rig.entered[-1] == ("found_out" if both else "over")


class Mute(LocalConnector):
    """A connector that answers no call, whatever it promised."""

    def call(self, service: str, type_name: str, request: Any, *, on_reply: Any, timeout_s: Any = None) -> None:
        pass


def test_an_e_stop_ends_even_if_no_one_ever_reports_that_control_is_let_go() -> None:
    profile = robot(control={"nobody": {"service": "/let_go", "type": "std_srvs/srv/Trigger"}})
    states = {"moving": {"action": "move", "timeout_s": 50, "transitions": []}}
    rig = Rig(states, robot=profile, connector=Mute())
    rig.connector._now = rig.clock.now
    rig.stage.play({1.0: rig.runner.kill})
    result = rig.run()
    assert result.outcome == "aborted" and rig.move.canceled == rig.move.goals
    assert result.duration_s < 30


def test_what_is_asked_of_a_run_just_while_it_looks_into_its_mailbox_is_not_forgotten(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig = Rig({"waiting": {"transitions": []}})
    take, asked = Mailbox.take, list[str]()

    def takes(mailbox: Mailbox) -> Any:
        event = take(mailbox)
        if event is None and rig.stage.at >= 1.0 and not asked:
            asked.append(rig.runner.control("operator"))
            return take(mailbox)
        return event

    monkeypatch.setattr(Mailbox, "take", takes)
    rig.stage.play({1.0: lambda: rig.post("stop_now"), 5.0: rig.runner.kill})
    rig.run()
    (handed,) = [step.at for step in rig.book.steps if step.event.kind == "control"]
    assert handed < 1.2
